//! The BNG paper's figures 7 and 8: time of construction against the number of spheres.

use super::makers::{Made, Makers};
use super::models::Model;
use crate::short::count;
use crate::warm::warm_up;
use simdop::construct::{Builder, Magnification, Splitter};
use simdop::node::{Dop, Node4, Node16};
use std::fmt::Write;
use std::time::Duration;

/// One model, number of spheres and arity. Times in milliseconds.
pub(crate) struct Row {
    model: &'static str,
    spheres: usize,
    /// Share of the mesh's volume.
    covered: f64,
    arity: usize,
    /// Batch Neural Gas by volume.
    one_thread: f64,
    all_threads: Option<f64>,
    device: Option<f64>,
    /// The library's default, on one thread.
    mean_width: f64,
}

pub(crate) fn measure(models: &[Model], sizes: &[usize], makers: &Makers) -> Vec<Row> {
    let mut rows = Vec::new();
    for model in models {
        for &size in sizes {
            eprintln!("{}, {size} spheres: construction", model.name);
            rows.push(row::<Node4<18>>(model, size, makers));
            rows.push(row::<Node16<18>>(model, size, makers));
        }
    }
    rows
}

/// Checks that all ways to build give the same bytes.
fn row<N: Dop>(model: &Model, size: usize, makers: &Makers) -> Row {
    let spheres = &model.spheres[..size];
    let gas = Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 };
    let builder = Builder::new().splitter(gas);
    let repeats = count(if size > 20_000 { 3 } else { 7 }, 1);
    // The first tree on a GPU compiles the kernels.
    let _ = makers.on_device::<N>(&builder, &spheres[..size.min(100)]);
    let (want, _) = makers.on_one_thread::<N>(&builder, spheres);
    let check = |made: Made<N>| {
        assert!(made.0.as_bytes() == want.as_bytes(), "{}, {size}: not the same tree", model.name);
        made.1
    };
    let mut times: [Vec<Duration>; 4] = Default::default();
    for _ in 0..repeats {
        times[0].push(check(makers.on_one_thread(&builder, spheres)));
        times[1].extend(makers.on_all_threads(&builder, spheres).map(check));
        times[3].push(makers.on_one_thread::<N>(&Builder::new(), spheres).1);
    }
    if makers.on_device::<N>(&builder, spheres).is_some() {
        warm_up(|| makers.on_device::<N>(&builder, spheres));
    }
    times[2].extend((0..repeats).filter_map(|_| makers.on_device(&builder, spheres)).map(check));
    let [one_thread, all_threads, device, mean_width] = times.map(median);
    Row {
        model: model.name,
        spheres: size,
        covered: model.shares[size - 1],
        arity: N::ARITY,
        one_thread: one_thread.expect("there is a thread"),
        all_threads,
        device,
        mean_width: mean_width.expect("there is a thread"),
    }
}

/// In milliseconds.
fn median(mut times: Vec<Duration>) -> Option<f64> {
    times.sort_unstable();
    Some(times.get(times.len() / 2)?.as_secs_f64() * 1e3)
}

pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| model | spheres | of its volume | arity | neural gas, one thread, ms | all threads | device | mean width, \
         one thread |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        let Row { model, spheres, covered, arity, one_thread, mean_width, .. } = row;
        let [all, device] =
            [row.all_threads, row.device].map(|time| time.map_or("".into(), |ms| format!("{ms:.1}")));
        writeln!(
            text,
            "| {model} | {spheres} | {:.1} % | {arity} | {one_thread:.1} | {all} | {device} | {mean_width:.1} |",
            100.0 * covered
        )
        .unwrap();
    }
    text
}

pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "model,spheres,covered,arity,one_thread_milliseconds,all_threads_milliseconds,device_milliseconds,\
         mean_width_milliseconds\n",
    );
    for row in rows {
        let Row { model, spheres, covered, arity, one_thread, mean_width, .. } = row;
        let [all, device] =
            [row.all_threads, row.device].map(|time| time.map_or("".into(), |ms| format!("{ms:.3}")));
        writeln!(
            text,
            "{model},{spheres},{covered:.4},{arity},{one_thread:.3},{all},{device},{mean_width:.3}"
        )
        .unwrap();
    }
    text
}
