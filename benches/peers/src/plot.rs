//! Median time against distance, one panel per mesh.

use crate::summary::Summary;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

type Fault = Box<dyn core::error::Error>;
type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const PANEL: (u32, u32) = (560, 380);
const COLUMNS: usize = 3;
const LEGEND: u32 = 60;

/// Ours dark and thick; related libraries in shades of one colour.
fn style(library: &str) -> ShapeStyle {
    let (color, width) = match library {
        "simdop k 18" => (RGBColor(0, 0, 0), 3),
        "simdop k 14" => (RGBColor(120, 120, 120), 3),
        "OPCODE" => (RGBColor(213, 94, 0), 2),
        "ODE" => (RGBColor(240, 170, 110), 2),
        "PhysX" => (RGBColor(150, 150, 0), 2),
        "FCL OBB" => (RGBColor(0, 90, 170), 2),
        "FCL native" => (RGBColor(60, 60, 220), 2),
        "FCL OBBRSS" => (RGBColor(110, 180, 235), 2),
        "Coal OBB" => (RGBColor(0, 120, 80), 2),
        "Coal OBBRSS" => (RGBColor(110, 200, 150), 2),
        "Embree" => (RGBColor(190, 30, 60), 2),
        "parry f32" => (RGBColor(200, 140, 220), 2),
        _ => (RGBColor(120, 40, 150), 2),
    };
    color.stroke_width(width)
}

pub(crate) fn draw(path: &Path, all: &Summary<'_>) -> Result<(), Fault> {
    let lines = all.meshes.len().div_ceil(COLUMNS);
    let columns = all.meshes.len().min(COLUMNS);
    let size = (PANEL.0 * columns.max(2) as u32, PANEL.1 * lines as u32 + LEGEND);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let (top, panels) = root.split_vertically(LEGEND);
    legend(&top, all)?;
    for (mesh, area) in all.meshes.iter().zip(panels.split_evenly((lines, columns))) {
        panel(&area, all, mesh)?;
    }
    root.present()?;
    Ok(())
}

fn legend(area: &Panel<'_>, all: &Summary<'_>) -> Result<(), Fault> {
    let per_line = all.libraries.len().div_ceil(2);
    let step = (area.dim_in_pixel().0 as usize - 40) / per_line;
    for (i, library) in all.libraries.iter().enumerate() {
        let (x, y) = ((20 + i % per_line * step) as i32, (16 + i / per_line * 24) as i32);
        area.draw(&PathElement::new([(x, y), (x + 28, y)], style(library)))?;
        area.draw(&Text::new(*library, (x + 36, y - 8), ("sans-serif", 16)))?;
    }
    Ok(())
}

fn panel(area: &Panel<'_>, all: &Summary<'_>, mesh: &str) -> Result<(), Fault> {
    let series = |library: &str| -> Vec<(f64, f64)> {
        let point = |(i, distance): (usize, &&str)| {
            Some((i as f64, all.value(mesh, distance, library, |row| row.median_us)?))
        };
        all.distances.iter().enumerate().filter_map(point).collect()
    };
    let times = || all.libraries.iter().flat_map(|library| series(library)).map(|(_, time)| time);
    let decade = |time: f64, round: fn(f64) -> f64| 10_f64.powf(round(time.log10()));
    let low = decade(times().fold(f64::INFINITY, f64::min), f64::floor);
    let high = decade(times().fold(0.0, f64::max), f64::ceil);
    let triangles = all.libraries.first().and_then(|library| all.rows(mesh, "", library).next());
    let caption = triangles.map_or_else(String::new, |row| {
        format!("{mesh}: {} against {} triangles", row.triangles_a, row.triangles_b)
    });
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(-0.3..all.distances.len() as f64 - 0.7, (low..high).log_scale())?;
    let name = |x: &f64| {
        let is_label = (x - x.round()).abs() < 1e-6;
        all.distances
            .get(x.round() as usize)
            .filter(|_| is_label)
            .map_or_else(String::new, |d| (*d).to_owned())
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(all.distances.len())
        .x_label_formatter(&name)
        .y_label_formatter(&|y| format!("{y}"))
        .y_desc("median of a query, µs")
        .label_style(("sans-serif", 14))
        .light_line_style(RGBColor(240, 240, 240))
        .draw()?;
    for library in all.libraries.iter().rev() {
        let points = series(library);
        chart.draw_series(LineSeries::new(points.iter().copied(), style(library)))?;
        chart.draw_series(points.iter().map(|point| Circle::new(*point, 3, style(library).filled())))?;
    }
    Ok(())
}
