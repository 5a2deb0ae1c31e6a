//! Pictures as SVG files.

use super::parts::{Outline, Part, rim};
use crate::markup::escaped;
use core::fmt::Write;

pub(super) fn image(parts: &[Part], [width, height]: [f64; 2], title: &str) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write!(
        text,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         shape-rendering=\"crispEdges\">\n<title>{}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        escaped(title)
    );
    for Part { outline, colour: [r, g, b], .. } in parts {
        let _ = match outline {
            Outline::Triangle([[ax, ay], [bx, by], [cx, cy]]) => writeln!(
                text,
                "<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"M{ax:.1} {ay:.1}L{bx:.1} {by:.1}L{cx:.1} {cy:.1}z\"/>"
            ),
            Outline::Disc { centre: [x, y], radius } => {
                let [s, t, u] = rim([*r, *g, *b]);
                writeln!(
                    text,
                    "<circle fill=\"#{r:02x}{g:02x}{b:02x}\" stroke=\"#{s:02x}{t:02x}{u:02x}\" cx=\"{x:.1}\" \
                     cy=\"{y:.1}\" r=\"{radius:.1}\"/>"
                )
            }
        };
    }
    text + "</svg>\n"
}
