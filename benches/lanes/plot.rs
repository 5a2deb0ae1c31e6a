//! A plot of time against wrong verdicts.

use plotters::prelude::*;
use std::path::Path;

/// The result of a checker on a robot.
pub(crate) struct Mark {
    pub(crate) robot: usize,
    pub(crate) text: String,
    /// Microseconds a configuration.
    pub(crate) time: f64,
    /// Wrong verdicts, in percent of all.
    pub(crate) wrong: f64,
}

/// Distinguishable without red and green (Okabe and Ito 2008).
const COLOURS: [RGBColor; 2] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0)];

/// Writes an SVG, on white in every colour scheme.
pub(crate) fn plot(file: &Path, marks: &[Mark]) {
    let times = || marks.iter().map(|mark| mark.time);
    let low = 0.5 * times().fold(f64::INFINITY, f64::min);
    let high = 4.0 * times().fold(0.0, f64::max);
    let top = 1.25 * marks.iter().map(|mark| mark.wrong).fold(1.0, f64::max);
    let area = SVGBackend::new(file, (800, 420)).into_drawing_area();
    area.fill(&WHITE).unwrap();
    let mut chart = ChartBuilder::on(&area)
        .caption("Time against wrong verdicts", ("sans-serif", 24))
        .margin(12)
        .x_label_area_size(52)
        .y_label_area_size(76)
        .build_cartesian_2d((low..high).log_scale(), -0.06 * top..top)
        .unwrap();
    chart
        .configure_mesh()
        .x_desc("µs a configuration, one core")
        .y_desc("wrong verdicts, %")
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 18))
        .axis_desc_style(("sans-serif", 20))
        .draw()
        .unwrap();
    for (i, mark) in marks.iter().enumerate() {
        let colour = COLOURS[mark.robot % COLOURS.len()];
        let at = (mark.time, mark.wrong);
        chart.draw_series([Circle::new(at, 6, colour.filled())]).unwrap();
        // Exact checkers are close together at the bottom, so their labels are staggered.
        let up = -14 - 20 * (i as i32 % 3);
        let label = EmptyElement::at(at)
            + PathElement::new([(0, -6), (6, up + 8)], colour.stroke_width(1))
            + Text::new(mark.text.clone(), (9, up), ("sans-serif", 17).into_font().color(&colour));
        chart.draw_series([label]).unwrap();
    }
    area.present().unwrap();
}
