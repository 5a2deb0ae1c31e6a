//! Pictures as PNG files.

use super::parts::{Outline, Part, rim};
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Stroke, Transform};

pub(super) fn image(parts: &[Part], size: [f64; 2]) -> Vec<u8> {
    // Neither side is zero; each is at most the longer side plus two margins.
    let [width, height] = size.map(|pixels| pixels.round() as u32);
    let mut image = Pixmap::new(width, height).expect("a size that memory has room for");
    image.fill(Color::WHITE);
    let mut paint = Paint { anti_alias: false, ..Paint::default() };
    let still = Transform::identity();
    for Part { outline, colour: [r, g, b], .. } in parts {
        paint.set_color_rgba8(*r, *g, *b, u8::MAX);
        match outline {
            Outline::Triangle(corners) => {
                let [p, q, s] = corners.map(|corner| corner.map(|x| x as f32));
                let mut path = PathBuilder::new();
                path.move_to(p[0], p[1]);
                path.line_to(q[0], q[1]);
                path.line_to(s[0], s[1]);
                path.close();
                // A triangle seen edge-on has no outline.
                if let Some(path) = path.finish() {
                    image.fill_path(&path, &paint, FillRule::Winding, still, None);
                }
            }
            Outline::Disc { centre: [x, y], radius } => {
                // A point has no outline either.
                if let Some(path) = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32) {
                    image.fill_path(&path, &paint, FillRule::Winding, still, None);
                    let [r, g, b] = rim([*r, *g, *b]);
                    paint.set_color_rgba8(r, g, b, u8::MAX);
                    image.stroke_path(&path, &paint, &Stroke::default(), still, None);
                }
            }
        }
    }
    image.encode_png().expect("an image in memory can be encoded")
}
