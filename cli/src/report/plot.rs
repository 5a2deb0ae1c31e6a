//! Plots: a row of panels, one for each distance, as SVG for the page.
//!
//! Drawn at twice the displayed size, since coordinates are integers. The page's style sheet replaces black and one
//! grey by the colours of text and grid for the light or dark scheme; the other colours are fixed.

use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;

/// Width of a row, in displayed pixels.
pub(super) const WIDTH: u32 = 1200;
pub(super) const HEIGHT: u32 = 300;
const SCALE: u32 = 2;

/// Distinguishable without red and green (Okabe and Ito 2008), and visible on white and on black.
pub(super) const COLOURS: [RGBColor; 5] = [
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];
const INK: RGBColor = BLACK;
const GRID: RGBColor = RGBColor(208, 208, 208);

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    Disc,
    Triangle,
    Square,
    Lozenge,
    /// With upright arms.
    Cross,
}

/// The importance of a mark.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Rank {
    Other,
    Front,
    Recommended,
}

/// A setting in a panel.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Index into [`COLOURS`].
    pub(super) colour: usize,
    pub(super) shape: Shape,
    /// Radius in displayed pixels.
    pub(super) radius: u32,
    pub(super) is_filled: bool,
    pub(super) rank: Rank,
}

/// A labelled point.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Label {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) text: String,
}

/// Both axes are logarithmic. Marks with x = 0 are at the left border.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) x_axis: String,
    pub(super) y_axis: String,
    pub(super) marks: Vec<Mark>,
    pub(super) labels: Vec<Label>,
    /// Whether a line joins the labels.
    pub(super) has_line: bool,
}

/// Font of text of this displayed height: plotters draws text 1.24 times as high as the font's size.
fn text(pixels: u32) -> (&'static str, f64) {
    ("sans-serif", 1.24 * f64::from(SCALE * pixels))
}

/// A rectangle in pixels of the drawing.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
struct Rectangle {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
}

impl Rectangle {
    const fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    /// Its upper left corner, relative to that of an area.
    fn corner(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> (i32, i32) {
        let (left, top) = area.get_base_pixel();
        (self.left - left, self.top - top)
    }
}

/// Radius of the dot of a labelled point.
const DOT: u32 = SCALE * 3;

fn dot((x, y): (i32, i32)) -> Rectangle {
    let r = DOT as i32;
    Rectangle { left: x - r, top: y - r, right: x + r, bottom: y + r }
}

/// Candidate places for a label of this length: right or left of the dot, above or below it.
fn places(x: i32, y: i32, letters: i32) -> [Rectangle; 4] {
    let (width, height, gap) = (SCALE as i32 * 7 * letters, SCALE as i32 * 12, SCALE as i32 * 4);
    [(gap, -height), (gap, 0), (-gap - width, -height), (-gap - width, 0)].map(|(right, down)| {
        let (left, top) = (x + right, y + down);
        Rectangle { left, top, right: left + width, bottom: top + height }
    })
}

type Problem = DrawingAreaErrorKind<std::io::Error>;

/// The panels, side by side.
pub(super) fn row(panels: &[Panel]) -> String {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (SCALE * WIDTH, SCALE * HEIGHT)).into_drawing_area();
        for (panel, area) in panels.iter().zip(area.split_evenly((1, panels.len()))) {
            // Drawing into memory does not fail.
            let _ = draw(panel, &area);
        }
        let _ = area.present();
    }
    svg
}

fn draw(panel: &Panel, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Problem> {
    let points = || {
        let marks = panel.marks.iter().map(|mark| (mark.x, mark.y));
        marks.chain(panel.labels.iter().map(|label| (label.x, label.y)))
    };
    let (x_axis, y_axis) = (Axis::of(points().map(|(x, _)| x)), Axis::of(points().map(|(_, y)| y)));
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, text(15))
        .margin(SCALE * 6)
        .margin_right(SCALE * 20)
        .x_label_area_size(SCALE * 44)
        .y_label_area_size(SCALE * 58)
        .build_cartesian_2d(
            (x_axis.low..x_axis.high).log_scale().with_key_points(x_axis.ticks.clone()),
            (y_axis.low..y_axis.high).log_scale().with_key_points(y_axis.ticks.clone()),
        )?;
    chart
        .configure_mesh()
        .x_desc(&panel.x_axis)
        .y_desc(&panel.y_axis)
        .x_label_formatter(&|x| x_axis.label(*x))
        .y_label_formatter(&|y| y_axis.label(*y))
        .bold_line_style(GRID.stroke_width(SCALE))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.stroke_width(SCALE))
        .label_style(text(12).into_font().color(&INK))
        .axis_desc_style(text(13).into_font().color(&INK))
        .draw()?;
    if panel.has_line {
        let line = panel.labels.iter().map(|label| (x_axis.shown(label.x), label.y));
        chart.draw_series(std::iter::once(PathElement::new(
            line.collect::<Vec<_>>(),
            INK.stroke_width(SCALE),
        )))?;
    }
    // More important marks are drawn later.
    for rank in [Rank::Other, Rank::Front, Rank::Recommended] {
        for mark in panel.marks.iter().filter(|mark| mark.rank == rank) {
            chart.plotting_area().draw(&element(mark, x_axis.shown(mark.x)))?;
        }
    }
    let plotted = chart.plotting_area();
    let at = |label: &Label| (x_axis.shown(label.x), label.y);
    let place = |label: &Label| plotted.map_coordinate(&at(label));
    let mut taken: Vec<Rectangle> = panel.labels.iter().map(|label| dot(place(label))).collect();
    for label in &panel.labels {
        plotted.draw(&Circle::new(at(label), DOT, INK.filled()))?;
        let (x, y) = place(label);
        let places = places(x, y, label.text.chars().count() as i32);
        // If no place is free, only the dot is drawn; the table has its figures.
        let is_free = |place: &Rectangle| taken.iter().all(|other| !place.overlaps(other));
        if let Some(place) = places.into_iter().find(is_free) {
            area.draw(&Text::new(label.text.clone(), place.corner(area), text(11).into_font().color(&INK)))?;
            taken.push(place);
        }
    }
    Ok(())
}

type Point = (f64, f64);

/// The drawing of a mark: faint if it is not on the front, with a ring if it is, and with a second ring if it is
/// recommended.
fn element<'s>(mark: &Mark, x: f64) -> DynElement<'s, SVGBackend<'s>, Point> {
    let is_front = mark.rank != Rank::Other;
    let colour = COLOURS[mark.colour % COLOURS.len()].mix(if is_front { 1.0 } else { 0.5 });
    let style = if mark.is_filled { colour.filled() } else { colour.stroke_width(2 * SCALE) };
    let line =
        |is_seen: bool| if is_seen { INK.stroke_width(SCALE + 1) } else { TRANSPARENT.stroke_width(0) };
    let (ring, halo) = (line(is_front), line(mark.rank == Rank::Recommended));
    // Makes a square look as large as a disc.
    let r = (SCALE * mark.radius) as i32 * if mark.shape == Shape::Square { 7 } else { 8 } / 8;
    // Hollow marks get a larger outer ring, so that their colour is visible.
    let outer = if mark.is_filled { r } else { r + SCALE as i32 + 1 };
    let at = EmptyElement::at((x, mark.y));
    let halo = Circle::new((0, 0), r + (SCALE * 5) as i32, halo);
    match (mark.shape, mark.is_filled) {
        (Shape::Disc, _) => {
            (at + Circle::new((0, 0), r, style) + Circle::new((0, 0), outer, ring) + halo).into_dyn()
        }
        (shape, true) => {
            let corners = corners(shape, r);
            (at + Polygon::new(corners.clone(), style) + PathElement::new(corners, ring) + halo).into_dyn()
        }
        (shape, false) => {
            let inner = PathElement::new(corners(shape, r), style);
            (at + inner + PathElement::new(corners(shape, outer), ring) + halo).into_dyn()
        }
    }
}

/// Corners of any shape except a disc, with the first repeated at the end.
fn corners(shape: Shape, r: i32) -> Vec<(i32, i32)> {
    match shape {
        Shape::Lozenge => {
            let (wide, high) = (r * 7 / 8, r * 3 / 2);
            vec![(0, -high), (wide, 0), (0, high), (-wide, 0), (0, -high)]
        }
        Shape::Cross => {
            let (arm, half) = (r * 5 / 4, r * 3 / 8);
            vec![
                (-half, -arm),
                (half, -arm),
                (half, -half),
                (arm, -half),
                (arm, half),
                (half, half),
                (half, arm),
                (-half, arm),
                (-half, half),
                (-arm, half),
                (-arm, -half),
                (-half, -half),
                (-half, -arm),
            ]
        }
        Shape::Triangle => {
            vec![(0, -r - r / 4), (r + r / 8, r * 3 / 4), (-r - r / 8, r * 3 / 4), (0, -r - r / 4)]
        }
        _ => vec![(-r, -r), (r, -r), (r, r), (-r, r), (-r, -r)],
    }
}

/// A logarithmic axis.
#[derive(Clone, PartialEq, Debug)]
struct Axis {
    low: f64,
    high: f64,
    ticks: Vec<f64>,
    /// The position of zero, if any value is zero.
    zero: Option<f64>,
}

/// Ticks within a decade, the fewest first.
const MANTISSAS: [&[f64]; 5] = [
    &[1.0],
    &[1.0, 3.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0],
    &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0, 9.0],
];

impl Axis {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let positive = || values.clone().filter(|value| *value > 0.0 && value.is_finite());
        let (least, greatest) = (positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max));
        let (least, greatest) = if greatest > 0.0 { (least, greatest) } else { (1.0, 1.0) };
        let has_zero = values.clone().any(|value| value == 0.0);
        // Margins at both ends, and a minimum range.
        let room = (greatest / least).powf(0.08).max(1.25);
        let zero = has_zero.then(|| least / (room * room * room));
        let (low, high) = (zero.unwrap_or(least) / room, greatest * room);
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let within = |mantissas: &&[f64]| -> Vec<f64> {
            let all = decades.clone().flat_map(|d| mantissas.iter().map(move |m| m * 10_f64.powi(d)));
            all.filter(|tick| (least / room..=high).contains(tick)).collect()
        };
        let mut ticks =
            MANTISSAS.iter().map(within).find(|ticks| ticks.len() >= 3).unwrap_or_else(|| vec![least]);
        if ticks.len() > 5 {
            ticks = ticks.into_iter().step_by(2).collect();
        }
        ticks.splice(0..0, zero);
        Self { low, high, ticks, zero }
    }

    fn shown(&self, value: f64) -> f64 {
        if value > 0.0 { value } else { self.zero.unwrap_or(self.low) }
    }

    fn label(&self, tick: f64) -> String {
        if self.zero == Some(tick) {
            return "0".to_owned();
        }
        if !(0.000_99..1e5).contains(&tick) {
            return format!("{tick:.1e}").replace(".0e", "e");
        }
        // Hides rounding errors in powers of ten.
        let text = format!("{tick:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_values_and_have_few_ticks() {
        for values in
            [&[1.0][..], &[0.0], &[0.0, 3.0], &[0.31, 0.35], &[2.0, 7e6], &[1e-9, 1e9], &[5e-5, 7e-5]]
        {
            let axis = Axis::of(values.iter().copied());
            for &value in values {
                assert!(
                    axis.low < axis.shown(value) && axis.shown(value) < axis.high,
                    "{values:?}: {axis:?}"
                );
            }
            assert!((1..=12).contains(&axis.ticks.len()), "{values:?}: {axis:?}");
            assert!(axis.ticks.is_sorted() && axis.ticks.iter().all(|t| (axis.low..=axis.high).contains(t)));
        }
        let axis = Axis::of([0.0, 10.0, 1000.0].into_iter());
        assert_eq!(axis.ticks.iter().map(|t| axis.label(*t)).collect::<Vec<_>>(), ["0", "10", "100", "1000"]);
    }

    #[test]
    fn places_about_a_dot_do_not_overlap() {
        let places = places(100, 50, 3);
        for (i, place) in places.iter().enumerate() {
            assert!(!place.overlaps(&dot((100, 50))) && place.overlaps(&dot((place.left, place.top))));
            assert!(place.left < place.right && place.top < place.bottom && place.overlaps(place));
            assert!(places[..i].iter().all(|other| !place.overlaps(other)));
        }
    }

    #[test]
    fn a_row_has_its_titles_and_marks() {
        let mark = |rank, shape| Mark { x: 1.0, y: 2.0, colour: 1, shape, radius: 4, is_filled: true, rank };
        let marks = vec![mark(Rank::Other, Shape::Disc), mark(Rank::Recommended, Shape::Triangle)];
        let panel = |title: &str| Panel {
            title: title.into(),
            x_axis: "bytes".into(),
            marks: marks.clone(),
            ..Panel::default()
        };
        let svg = row(&[panel("near"), panel("far")]);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let count = |tag: &str| {
            document
                .descendants()
                .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", tag)))
                .count()
        };
        assert!(svg.contains("near") && svg.contains("far") && svg.contains("bytes"));
        assert_eq!(count("polygon"), 2);
        assert!(count("circle") >= 4, "{svg}");
    }
}
