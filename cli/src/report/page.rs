//! The page: plots, tables and a recommendation in one self-contained file.
//!
//! Well-formed XML as well as HTML, so that tests can parse it.

use super::approach::{DISTANCES, PerDistance};
use super::clock::ROUNDS;
use super::front::SAME_TIME;
use super::html::letter;
use super::packings::Packings;
use super::plot::{self, COLOURS, Label, Mark, Panel, Rank, Shape};
use super::results::{Measured, Results, Subject, short};
use super::setting::Setting;
use super::tables;
use crate::SplitterName;
use crate::markup::escaped;
use core::fmt::Write;
use simdop::low_level::key::StorageKind;

const STYLE: &str = include_str!("page.css");

/// The distances, in words.
pub(super) const TITLES: PerDistance<&str> = ["1 % deep", "0 %: almost touching", "1 % apart", "5 % apart"];

/// A quantity to plot: label of the axis, label of the table, and its value at a distance.
type Quantity = (&'static str, &'static str, fn(&Measured, usize) -> f64);

const QUANTITIES: [Quantity; 5] = [
    ("False positives", "false positives a pose, pairs of leaves", |one, i| one.at[i].false_positives),
    ("Greatest overestimate", "greatest overestimate, mesh's unit", |one, _| one.overestimate_greatest),
    ("Mean overestimate", "mean overestimate, mesh's unit", |one, _| one.overestimate_mean),
    (BYTES, "bytes a triangle", |one, _| one.bytes_per_triangle),
    (BUILD, "build, ms", |one, _| one.build_milliseconds),
];
/// A quantity that peers have, too.
const BYTES: &str = "Bytes a triangle";
const BUILD: &str = "Build time";

/// The complete file.
pub(super) fn html(results: &Results, digest: &str, command: &str) -> String {
    let names: Vec<&str> = results.subjects.iter().map(|subject| subject.name.as_str()).collect();
    let title = format!("simdop report: {}", names.join(" against "));
    let mut page = String::new();
    // Writing to a string does not fail.
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width\"/>\n<meta name=\"color-scheme\" content=\"light \
         dark\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"recommendation\"><strong>Recommended.</strong> {}{}</p>\n",
        escaped(&results.recommendation()),
        build_command(results),
        title = escaped(&title),
    );
    facts(&mut page, results, digest, command);
    legend(&mut page, results);
    for quantity in &QUANTITIES {
        quantity_plots(&mut page, results, quantity);
    }
    packings(&mut page, results);
    tables::settings(&mut page, results);
    tables::covers(&mut page, results);
    tables::packings(&mut page, results);
    tables::peers(&mut page, results);
    definitions(&mut page, results);
    page.push_str("</body>\n</html>\n");
    page
}

/// The command that builds the recommended tree.
fn build_command(results: &Results) -> String {
    let Some(best) = results.recommended.map(|index| &results.settings[index].setting) else {
        return String::new();
    };
    format!("<br/><code>simdop build MESH -o TREE {}</code>", escaped(&best.arguments()))
}

fn facts(page: &mut String, results: &Results, digest: &str, command: &str) {
    let body = |subject: &Subject| {
        let (name, diagonal) = (escaped(&subject.name), short(subject.diagonal));
        format!("{name}, {} triangles, diagonal {diagonal}", subject.triangles)
    };
    let bodies: Vec<String> = results.subjects.iter().map(body).collect();
    let against = if bodies.len() == 1 { ", against itself" } else { "" };
    let _ = write!(
        page,
        "<p>{}{against}; {} poses at each distance, seed {}; {}, one thread; simdop {}; <code>{}</code>.\n\
         Digest of the reproducible results: <code class=\"digest\">{digest}</code>.</p>\n",
        bodies.join("; "),
        results.poses,
        results.seed,
        results.isa,
        env!("CARGO_PKG_VERSION"),
        escaped(command),
    );
}

fn legend(page: &mut String, results: &Results) {
    page.push_str("<div class=\"legend\"><span class=\"key\">Colour is k:</span>");
    for (k, colour) in ks(results).into_iter().zip(COLOURS) {
        let _ = write!(page, "<span>{}{k}</span>", swatch(&disc(&rgb(colour))));
    }
    page.push_str("<span class=\"key\">Shape:</span>");
    let square = "<rect x=\"4\" y=\"4\" width=\"10\" height=\"10\" fill=\"currentColor\"/>";
    let path = |outline: &str| format!("<path d=\"{outline}\" fill=\"currentColor\"/>");
    for (kind, drawing, text) in [
        (Shape::Disc, disc("currentColor").as_str(), "fixed point, arity 16"),
        (Shape::Triangle, &path("M9 3l6.5 11h-13z"), "fixed point, arity 4"),
        (Shape::Lozenge, &path("M9 1l5 8-5 8-5-8z"), "half floats"),
        (Shape::Square, square, "another splitter than mean-width"),
        (Shape::Cross, &path("M7 3h4v4h4v4h-4v4h-4v-4h-4v-4h4z"), "half floats, another splitter"),
    ] {
        if results.settings.iter().any(|one| shape(&one.setting) == kind) {
            let _ = write!(page, "<span>{}{text}</span>", swatch(drawing));
        }
    }
    page.push_str("<span class=\"key\">Larger:</span><span>more triangles a leaf (1, 2, 4, 8)</span>");
    let hollow =
        "<circle cx=\"9\" cy=\"9\" r=\"5\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"2\"/>";
    let ring = format!(
        "<circle cx=\"9\" cy=\"9\" r=\"5\" fill=\"{}\" stroke=\"currentColor\" stroke-width=\"1.5\"/>",
        rgb(COLOURS[2])
    );
    let halo = format!("{ring}<circle cx=\"9\" cy=\"9\" r=\"8\" fill=\"none\" stroke=\"currentColor\"/>");
    for (shape, text) in
        [(hollow, "without normal slabs"), (&ring, "on the Pareto front"), (&halo, "recommended")]
    {
        let _ = write!(page, "<span>{}{text}</span>", swatch(shape));
    }
    if !results.peers.is_empty() {
        page.push_str("<span class=\"key\">Letters:</span><span>other libraries, as in their table</span>");
    }
    page.push_str("</div>\n");
}

fn swatch(shape: &str) -> String {
    format!("<svg class=\"swatch\" width=\"18\" height=\"18\" viewBox=\"0 0 18 18\">{shape}</svg>")
}

fn disc(fill: &str) -> String {
    format!("<circle cx=\"9\" cy=\"9\" r=\"5\" fill=\"{fill}\"/>")
}

fn rgb(plotters::style::RGBColor(r, g, b): plotters::style::RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Each k of the settings, in ascending order.
fn ks(results: &Results) -> Vec<usize> {
    let mut ks: Vec<usize> = results.settings.iter().map(|one| one.setting.node.k).collect();
    ks.sort_unstable();
    ks.dedup();
    ks
}

/// Half floats exist at arity 16 only.
fn shape(setting: &Setting) -> Shape {
    let is_usual = setting.splitter == SplitterName::MeanWidth;
    match (setting.node.storage, is_usual, setting.node.arity) {
        (StorageKind::Fixed, true, 16) => Shape::Disc,
        (StorageKind::Fixed, true, _) => Shape::Triangle,
        (StorageKind::Fixed, false, _) => Shape::Square,
        (StorageKind::Half, true, _) => Shape::Lozenge,
        (StorageKind::Half, false, _) => Shape::Cross,
    }
}

fn quantity_plots(page: &mut String, results: &Results, (title, axis, value): &Quantity) {
    let ks = ks(results);
    let mark = |index: usize, distance: usize| {
        let one = &results.settings[index];
        let setting = &one.setting;
        Mark {
            x: value(one, distance),
            y: one.at[distance].median_microseconds,
            colour: ks.iter().position(|k| *k == setting.node.k).unwrap_or_default(),
            shape: shape(setting),
            radius: 4 + setting.leaf_size.ilog2(),
            is_filled: setting.has_normal_slabs,
            rank: match (results.recommended == Some(index), one.is_on_front) {
                (true, _) => Rank::Recommended,
                (false, true) => Rank::Front,
                (false, false) => Rank::Other,
            },
        }
    };
    let label = |index: usize, distance: usize| {
        let peer = &results.peers[index];
        let x = match *title {
            BYTES => peer.bytes_per_triangle,
            BUILD => Some(peer.build_milliseconds),
            _ => None,
        };
        Some(Label { x: x?, y: peer.median_microseconds[distance]?, text: letter(index) })
    };
    let panel = |distance: usize| Panel {
        title: TITLES[distance].to_owned(),
        x_axis: (*axis).to_owned(),
        y_axis: "median time, µs".to_owned(),
        marks: (0..results.settings.len()).map(|index| mark(index, distance)).collect(),
        labels: (0..results.peers.len()).filter_map(|index| label(index, distance)).collect(),
        has_line: false,
    };
    let panels: Vec<Panel> = (0..DISTANCES.len()).map(panel).collect();
    let _ = write!(page, "<h2>{title}, and the time of a query</h2>\n{}\n", plot::row(&panels));
}

fn packings(page: &mut String, results: &Results) {
    match &results.packings {
        Packings::None => {}
        Packings::Impossible(reason) => {
            let _ = write!(page, "<h2>Packings</h2>\n<p>There are none: {}.</p>\n", escaped(reason));
        }
        Packings::Of(packed) => {
            let panel = |distance: usize| Panel {
                title: TITLES[distance].to_owned(),
                x_axis: "volume not covered, %".to_owned(),
                y_axis: "median time, µs".to_owned(),
                labels: packed
                    .iter()
                    .map(|one| Label {
                        x: 100.0 * one.volume_error,
                        y: one.at[distance].median_microseconds,
                        text: one.spheres.to_string(),
                    })
                    .collect(),
                has_line: true,
                ..Panel::default()
            };
            let panels: Vec<Panel> = (0..DISTANCES.len()).map(panel).collect();
            let _ = write!(
                page,
                "<h2>Packings: volume error, and the time of a penetration volume</h2>\n\
                 <p>Each point is labelled with its number of spheres in a body.</p>\n{}\n",
                plot::row(&panels)
            );
        }
    }
}

fn definitions(page: &mut String, results: &Results) {
    let like = (100.0 * (SAME_TIME - 1.0)).round();
    let unit = if results.subjects.len() == 1 { "the tree" } else { "both trees" };
    let _ = write!(
        page,
        "<h2>Definitions</h2>\n<dl>\n\
         <dt>Distance</dt><dd>Relative to the diagonal of A's box. “0 %” is a gap of 2e-5. At “1 % deep” A has \
         moved on by 1 % from there; thin parts may have come out on the other side.</dd>\n\
         <dt>Time</dt><dd>Of a query for the first pair of triangles that meet: the median over the poses of the \
         minimum over {ROUNDS} rounds, in which all settings take turns. Verdicts are exact, and the same for \
         every setting.</dd>\n\
         <dt>False positives</dt><dd>Pairs of a leaf of A and a leaf of B whose k-DOPs meet although none of \
         their triangles do: the mean over the poses, of all pairs, not only those before the first hit. A leaf \
         of eight triangles counts once.</dd>\n\
         <dt>Overestimate</dt><dd>How far a leaf's k-DOP, after realignment, extends beyond its triangles in a \
         direction, in the mesh's unit: mean and maximum over all leaves and 96 directions.</dd>\n\
         <dt>Storage</dt><dd>Planes take 16 bits: in fixed point they are equally precise everywhere, and as \
         half floats more precise near the body's centre than far from it.</dd>\n\
         <dt>Bytes</dt><dd>Of {unit} with vertices and triangles, as stored in flash.</dd>\n\
         <dt>Pareto front</dt><dd>Settings that no other setting dominates. The costs are time (geometric mean \
         over the distances), greatest overestimate and bytes.</dd>\n\
         <dt>Recommended</dt><dd>Among the settings within the limits that are at most {like} % slower than the \
         fastest of them, the one with the fewest bytes. The options --error and --flash set the limits.</dd>\n\
         <dt>Left out</dt><dd>Planes as f32, which the library does not build: <code>cargo bench --bench \
         ablation</code> compares them, in a traversal of its own.</dd>\n</dl>\n"
    );
}
