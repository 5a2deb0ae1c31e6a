//! One plot: curves over the number of polygons.

use plotters::prelude::*;
use std::path::Path;

/// A curve of a plot: numbers of polygons and values.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// Distinguishable without red and green: eight of Okabe & Ito (2008), and four greys and browns.
const COLOURS: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(240, 228, 66),
    RGBColor(120, 120, 120),
    RGBColor(140, 80, 30),
    RGBColor(190, 190, 190),
    RGBColor(90, 40, 130),
];

/// Writes an SVG.
pub(crate) fn plot(file: &Path, title: &str, what: &str, curves: &[Curve]) {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let right = points().map(|p| p.0).fold(0.0, f64::max) * 1.03;
    let top = points().map(|p| p.1).fold(0.0, f64::max) * 1.05;
    let area = SVGBackend::new(file, (800, 540)).into_drawing_area();
    area.fill(&WHITE).unwrap();
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 26))
        .margin(12)
        .x_label_area_size(52)
        .y_label_area_size(92)
        .build_cartesian_2d(0.0..right, 0.0..top)
        .unwrap();
    chart
        .configure_mesh()
        .x_desc("polygons")
        .y_desc(what)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 20))
        .axis_desc_style(("sans-serif", 22))
        .draw()
        .unwrap();
    for (curve, colour) in curves.iter().zip(COLOURS.iter().cycle()) {
        let style = colour.stroke_width(2);
        chart
            .draw_series(LineSeries::new(curve.points.iter().copied(), style).point_size(3))
            .unwrap()
            .label(curve.name.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .label_font(("sans-serif", 15))
        .draw()
        .unwrap();
    area.present().unwrap();
}
