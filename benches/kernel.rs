//! The overlap kernels on the calls of real queries: cow and armadillo against themselves, free, 1e-2 to 1e-8 of the
//! diagonal apart.
//!
//! ```sh
//! cargo bench --bench kernel                        # criterion: kernel/1v16/k18/L1/avx2 ..
//! SIMDOP_SUMMARY=1 cargo bench --bench kernel       # tables: all variants in turn, medians
//! SIMDOP_PAGES=1 cargo bench --bench kernel         # the same, as a page of benches/results
//! cargo bench --bench kernel -- --test              # everything once, on a small shape
//! ```
//!
//! Before timing, every variant must give the scalar kernel's mask on every call. "L1" and "L2" data are in that cache
//! when the clock starts, and the branch predictor has not seen the masks: each call happens once in a pass, in the
//! order of the traversal.
//!
//! Rows at k = 18 have both storages of planes. `realign` rotates nodes of the same trees, 32 at a time, four times
//! each. Last come spheres, capsules and cuboids, one against sixteen.

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "../tests/support/shapes.rs"]
mod shapes;
#[path = "support/solids.rs"]
mod solids;
mod support;

use core::marker::PhantomData;
use core::ops::Range;
use criterion::{Criterion, Throughput};
use page::show;
use simdop::isa::{Isa, Scalar, on_isa};
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::low_level::realign::Realignment;
use simdop::node::{Node4, Node16};
use simdop::query::Lanes;
use std::hint::black_box;
use std::rc::Rc;
use std::time::{Duration, Instant};
use support::bodies::scenes;
#[cfg(target_arch = "x86_64")]
use support::papers::{Papers, Papers4, float_query, halves_4, halves_16, mask};
use support::record::{LEVELS, Level, Recording, record};
use support::variants::{Ours, Ours4, Variant, Vectorised, check, time};

/// A variant on a recording. `time` makes one pass over all calls.
struct Bench {
    name: String,
    calls: usize,
    time: Box<dyn Fn() -> Duration>,
}

/// All variants of one kernel, k and level.
struct Row {
    kernel: &'static str,
    k: usize,
    level: &'static str,
    calls: usize,
    /// Share of the calls whose mask is zero.
    separated: f64,
    /// Planes of a node.
    bytes: usize,
    benches: Vec<Bench>,
}

/// A recording, its windows, and whether they are loaded before timing.
struct Timed<Q, N> {
    recording: Rc<Recording<Q, N>>,
    windows: Rc<[Range<usize>]>,
    warm: bool,
}

impl<Q: 'static, N: Clone + 'static> Timed<Q, N> {
    fn new(recording: Recording<Q, N>, windows: &Rc<[Range<usize>]>, level: Level) -> Self {
        Self { recording: recording.into(), windows: windows.clone(), warm: level != Level::Memory }
    }

    fn bench<V>(&self, name: &str, variant: V) -> Bench
    where
        V: Variant<Query = Q, Node = N> + 'static,
    {
        check(variant, &self.recording, name);
        let (recording, windows, warm) = (self.recording.clone(), self.windows.clone(), self.warm);
        let calls = recording.calls.len();
        Bench { name: name.into(), calls, time: Box::new(move || time(variant, &recording, &windows, warm)) }
    }
}

fn at<Q: Clone, N: Clone>(recording: Recording<Q, N>, level: Level) -> (Recording<Q, N>, Rc<[Range<usize>]>) {
    let recording =
        if level == Level::Memory { recording.scattered(&mut rng::Rng::new(7)) } else { recording };
    let windows = recording.windows(level).into();
    (recording, windows)
}

fn row_16<const K: usize>((level, level_name): (Level, &'static str)) -> Row
where
    Node16<K>: Lanes,
{
    let (recording, windows) = at(record::<Node16<K>>(&scenes()), level);
    let mut row =
        Row::new("1v16", K, level_name, &recording.calls.iter().map(|c| c.mask).collect::<Vec<_>>(), 32);
    #[cfg(target_arch = "x86_64")]
    let papers =
        Timed::new(recording.map(float_query::<16, K, Fixed>, halves_16).answered(mask), &windows, level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        on_isa!(isa, token => {
            row.benches.push(ours.bench(isa.name(), Ours(token, PhantomData::<Fixed>)));
            row.benches.push(ours.bench(&format!("vectorised-{isa}"), Vectorised(token)));
        });
    }
    #[cfg(target_arch = "x86_64")]
    for isa in Isa::available() {
        let names = [format!("papers-{isa}"), format!("papers-no-exit-{isa}")];
        match isa {
            Isa::Avx2(token) => row.benches.extend([
                papers.bench(&names[0], Papers::<_, K, true>(token)),
                papers.bench(&names[1], Papers::<_, K, false>(token)),
            ]),
            Isa::Avx512(token) => row.benches.extend([
                papers.bench(&names[0], Papers::<_, K, true>(token)),
                papers.bench(&names[1], Papers::<_, K, false>(token)),
            ]),
            _ => {}
        }
    }
    row
}

fn row_4<const K: usize>((level, level_name): (Level, &'static str)) -> Row
where
    Node4<K>: Lanes,
{
    let (recording, windows) = at(record::<Node4<K>>(&scenes()), level);
    let mut row =
        Row::new("4v4", K, level_name, &recording.calls.iter().map(|c| c.mask).collect::<Vec<_>>(), 8);
    #[cfg(target_arch = "x86_64")]
    let papers =
        Timed::new(recording.map(float_query::<4, K, Fixed>, halves_4).answered(mask), &windows, level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        on_isa!(isa, token => row.benches.push(ours.bench(isa.name(), Ours4(token, PhantomData::<Fixed>))));
    }
    #[cfg(target_arch = "x86_64")]
    for isa in Isa::available() {
        let name = format!("papers-{isa}");
        match isa {
            Isa::Avx2(token) => row.benches.push(papers.bench(&name, Papers4::<_, K>(token))),
            Isa::Avx512(token) => row.benches.push(papers.bench(&name, Papers4::<_, K>(token))),
            _ => {}
        }
    }
    row
}

/// Adds the kernels on half floats to a row of arity 16.
fn with_halves_16(mut row: Row, level: Level) -> Row {
    let (recording, windows) = at(record::<Node16<18, Half>>(&scenes()), level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        let name = format!("{isa}, half");
        on_isa!(isa, token => row.benches.push(ours.bench(&name, Ours(token, PhantomData::<Half>))));
    }
    row
}

/// Adds the kernels on half floats to a row of arity 4.
fn with_halves_4(mut row: Row, level: Level) -> Row {
    let (recording, windows) = at(record::<Node4<18, Half>>(&scenes()), level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        let name = format!("{isa}, half");
        on_isa!(isa, token => row.benches.push(ours.bench(&name, Ours4(token, PhantomData::<Half>))));
    }
    row
}

/// Nodes whose planes fit into the first-level cache, rotated or not.
const NODES: usize = 32;
const TIMES: usize = 4;

/// Adds re-alignment in one storage, by `$method` of the kernels, on each instruction set.
macro_rules! realign {
    ($function:ident, $node:ident, $method:ident, $arity:literal) => {
        fn $function<const K: usize, S: Storage>(row: &mut Row, suffix: &str)
        where
            $node<K, S>: Lanes,
        {
            let scenes = scenes::<$node<K, S>>();
            let scene = &scenes[0];
            let tree = scene.tree.view();
            let map = Realignment::<K, S>::new(&scene.poses[0], &tree.extent(), &tree.frame());
            let nodes: Rc<[$node<K, S>]> = tree.nodes().into();
            for isa in Isa::available() {
                on_isa!(isa, token => {
                    let rotated = |node: &$node<K, S>| {
                        let (mut query, mut expected) = ([[0; $arity]; K], [[0; $arity]; K]);
                        token.$method(&map, node, &mut query);
                        Scalar::new().$method(&map, node, &mut expected);
                        query == expected
                    };
                    assert!(nodes.iter().all(rotated), "{isa} differs from the scalar kernel");
                    let nodes = nodes.clone();
                    let calls = TIMES * nodes.len();
                    let time = move || nodes.chunks(NODES).map(|nodes| {
                        let pass = || token.run(
                            #[inline(always)]
                            || for node in nodes {
                                let mut query = [[0; $arity]; K];
                                token.$method(&map, node, &mut query);
                                black_box(&query);
                            },
                        );
                        pass();
                        let start = Instant::now();
                        (0..TIMES).for_each(|_| pass());
                        start.elapsed()
                    }).sum();
                    row.benches.push(Bench { name: format!("{isa}{suffix}"), calls, time: Box::new(time) });
                });
            }
        }
    };
}

realign!(realign_16, Node16, realign_16, 16);
realign!(realign_4, Node4, realign_4, 4);

/// Rotation of all planes of a node, in both storages.
fn realignments() -> [Row; 2] {
    let mut rows =
        [("realign_16", 32), ("realign_4", 8)].map(|(name, bytes)| Row::new(name, 18, "L1", &[], bytes));
    realign_16::<18, Fixed>(&mut rows[0], "");
    realign_16::<18, Half>(&mut rows[0], ", half");
    realign_4::<18, Fixed>(&mut rows[1], "");
    realign_4::<18, Half>(&mut rows[1], ", half");
    for row in &mut rows {
        row.calls = row.benches[0].calls;
    }
    rows
}

/// Nanoseconds per call of each variant: medians over rounds in which they take turns, so that other load on the
/// machine affects all of them.
fn medians(benches: &[Bench], rounds: usize) -> Vec<f64> {
    let mut times = vec![Vec::new(); benches.len()];
    for _ in 0..rounds {
        for (times, bench) in times.iter_mut().zip(benches) {
            times.push((bench.time)().as_secs_f64() * 1e9 / bench.calls as f64);
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    times.into_iter().map(median).collect()
}

impl Row {
    fn new(kernel: &'static str, k: usize, level: &'static str, masks: &[u16], plane_bytes: usize) -> Self {
        let calls = masks.len();
        let separated = masks.iter().filter(|mask| **mask == 0).count() as f64 / calls.max(1) as f64;
        Self { kernel, k, level, calls, separated, bytes: plane_bytes * k, benches: Vec::new() }
    }

    fn print_summary(&self) {
        let medians = medians(&self.benches, 15);
        let percent = 100.0 * self.separated;
        let is_overlap = !self.kernel.starts_with("realign");
        let empty = if is_overlap { format!(", {percent:.0} % of the masks empty") } else { String::new() };
        show!(
            "\n{} k = {}, {}: {} calls{empty}\n\n\
             | variant | ns a node | GB/s | x scalar | x papers' | x fixed point |\n\
             |---|---|---|---|---|---|",
            self.kernel,
            self.k,
            self.level,
            self.calls
        );
        let of = |name: &str| self.benches.iter().position(|bench| bench.name == name).map(|i| medians[i]);
        for (bench, ns) in self.benches.iter().zip(&medians) {
            let ratio = |base: Option<f64>| base.map_or("-".into(), |base| format!("{:.2}", base / ns));
            let (scalar, papers) = (ratio(of("scalar")), ratio(of("papers-avx2")));
            let fixed = ratio(bench.name.strip_suffix(", half").and_then(of));
            let bandwidth = self.bytes as f64 / ns;
            show!("| {} | {ns:.2} | {bandwidth:.1} | {scalar} | {papers} | {fixed} |", bench.name);
        }
    }
}

/// Every kernel and k at one level, one after the other: their data do not fit into memory together.
fn for_each_row(mut visit: impl FnMut(Row)) {
    for level in LEVELS {
        visit(row_16::<14>(level));
        visit(with_halves_16(row_16::<18>(level), level.0));
        visit(row_16::<32>(level));
        visit(row_4::<14>(level));
        visit(with_halves_4(row_4::<18>(level), level.0));
        visit(row_4::<32>(level));
    }
    realignments().into_iter().for_each(visit);
}

fn main() {
    if std::env::var_os("SIMDOP_SUMMARY").is_some() || page::is_wanted() {
        page::begin(
            "Kernels",
            "Median nanoseconds of a call of an overlap kernel, on the calls of real queries (cow and armadillo \
             against themselves, almost touching), and of the rotation of a node's planes. *Papers*: the kernels of \
             the SIMDop paper. *Half*: planes in half floats. First checks that every variant gives the scalar \
             kernel's bits, and that no decision about shapes differs from `is_within`.",
        );
        for_each_row(|row| row.print_summary());
        solids::print_summary();
        page::write();
        return;
    }
    let short = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    let mut criterion = short.configure_from_args();
    let mut measure = |group: String, benches: &[Bench]| {
        let mut group = criterion.benchmark_group(group);
        for bench in benches {
            group.throughput(Throughput::Elements(bench.calls as u64));
            group.bench_function(&bench.name, |b| {
                b.iter_custom(|passes| (0..passes).map(|_| (bench.time)()).sum());
            });
        }
    };
    for_each_row(|row| measure(format!("kernel/{}/k{}/{}", row.kernel, row.k, row.level), &row.benches));
    for row in solids::all() {
        measure(format!("kernel/{}", row.name), &row.benches);
    }
    criterion.final_summary();
}
