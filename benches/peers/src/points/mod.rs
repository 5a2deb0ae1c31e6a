//! Points instead of meshes: all neighbours within a radius of every point of a cloud, compared with kiddo, nanoflann
//! and a uniform grid; single queries and nearest points, compared with the same; whether any point is within a sphere,
//! compared with capt.

mod any;
mod batches;
mod entrants;
mod grid;
mod nanoflann;
mod page;
mod scenes;
mod single;

use crate::{Options, save};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// One run of `--points`. The measurements of a table are written once it is complete, and read again with `--resume`.
pub(crate) fn run(options: &Options) -> Result<(), String> {
    let parts = options.out.join("parts");
    std::fs::create_dir_all(&parts).map_err(|e| format!("{}: {e}", parts.display()))?;
    let mut batches = Vec::new();
    for table in batches::TABLES.into_iter().filter(|table| wanted(options, table)) {
        batches.extend(kept(options, &parts, table, || batches::measure(table, options))?);
    }
    write(&options.out.join("points.csv"), &batches)?;
    let mut singles = Vec::new();
    if wanted(options, "single") {
        singles.extend(kept(options, &parts, "single", || single::measure(options))?);
    }
    if wanted(options, "any") {
        singles.extend(kept(options, &parts, "any", || any::measure(options))?);
    }
    write(&options.out.join("points-single.csv"), &singles)?;
    save(&options.out.join("POINTS.md"), &page::page(&batches, &singles, options))
}

fn kept<T: Serialize + DeserializeOwned>(
    options: &Options,
    parts: &Path,
    table: &str,
    measure: impl FnOnce() -> Result<Vec<T>, String>,
) -> Result<Vec<T>, String> {
    let part = parts.join(format!("points-{table}.csv"));
    if options.resume && part.exists() {
        let read = || csv::Reader::from_path(&part)?.deserialize().collect::<Result<_, csv::Error>>();
        return read().map_err(|e| format!("{}: {e}", part.display()));
    }
    let rows = measure()?;
    write(&part, &rows)?;
    Ok(rows)
}

fn write<T: Serialize>(path: &Path, rows: &[T]) -> Result<(), String> {
    let write = || -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_path(path)?;
        rows.iter().try_for_each(|row| writer.serialize(row))?;
        Ok(writer.flush()?)
    };
    write().map_err(|e| format!("{}: {e}", path.display()))
}

/// Whether the table is requested.
fn wanted(options: &Options, table: &str) -> bool {
    options.meshes.is_empty() || options.meshes.iter().any(|name| name == table)
}

/// Processor time, which excludes other programs. This process has one thread.
fn milliseconds(work: impl FnOnce()) -> f64 {
    let started = processor_time();
    work();
    processor_time() - started
}

/// Processor time of this process, in milliseconds.
fn processor_time() -> f64 {
    #[repr(C)]
    struct Timespec {
        seconds: i64,
        nanoseconds: i64,
    }
    const CLOCK_PROCESS_CPUTIME_ID: i32 = 2;
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Timespec) -> i32;
    }
    let mut time = Timespec { seconds: 0, nanoseconds: 0 };
    // SAFETY: Linux's function, which writes the time to the given place; both fields have 64 bits on all its 64-bit
    // machines.
    let failed = unsafe { clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
    assert_eq!(failed, 0, "every Linux has this clock");
    time.seconds as f64 * 1e3 + time.nanoseconds as f64 * 1e-6
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The squared distance, as simdop's documentation defines it.
fn square([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> f32 {
    let [x, y, z] = [ax - bx, ay - by, az - bz];
    (x * x + y * y) + z * z
}

/// Bytes allocated from the C library, by Rust and C++ alike. Only one thread of this process allocates.
fn lent() -> usize {
    #[repr(C)]
    struct Mallinfo2 {
        arena: usize,
        ordblks: usize,
        smblks: usize,
        hblks: usize,
        hblkhd: usize,
        usmblks: usize,
        fsmblks: usize,
        uordblks: usize,
        fordblks: usize,
        keepcost: usize,
    }
    unsafe extern "C" {
        fn mallinfo2() -> Mallinfo2;
    }
    // SAFETY: glibc's function; it takes nothing and returns ten numbers.
    let info = unsafe { mallinfo2() };
    info.uordblks + info.hblkhd
}
