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

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "../tests/support/shapes.rs"]
mod shapes;
mod support;

use core::ops::Range;
use criterion::{Criterion, Throughput};
use page::show;
use simdop::isa::{Isa, on_isa};
use simdop::node::{Node4, Node16};
use simdop::query::Lanes;
use std::rc::Rc;
use std::time::Duration;
use support::bodies::scenes;
#[cfg(target_arch = "x86_64")]
use support::papers::{Papers, Papers4, float_query, halves_4, halves_16, mask};
use support::record::{LEVELS, Level, Recording, record};
use support::variants::{Ours, Ours4, Variant, Vectorised, check, time};

/// A variant on a recording. `time` makes one pass over all calls.
struct Bench {
    name: String,
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
        Bench { name: name.into(), time: Box::new(move || time(variant, &recording, &windows, warm)) }
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
    let papers = Timed::new(recording.map(float_query, halves_16).answered(mask), &windows, level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        on_isa!(isa, token => {
            row.benches.push(ours.bench(isa.name(), Ours(token)));
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
    let papers = Timed::new(recording.map(float_query, halves_4).answered(mask), &windows, level);
    let ours = Timed::new(recording, &windows, level);
    for isa in Isa::available() {
        on_isa!(isa, token => row.benches.push(ours.bench(isa.name(), Ours4(token))));
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

impl Row {
    fn new(kernel: &'static str, k: usize, level: &'static str, masks: &[u16], plane_bytes: usize) -> Self {
        let calls = masks.len();
        let separated = masks.iter().filter(|mask| **mask == 0).count() as f64 / calls as f64;
        Self { kernel, k, level, calls, separated, bytes: plane_bytes * k, benches: Vec::new() }
    }

    /// Nanoseconds per call of each variant: medians over rounds in which they take turns, so that other load on the
    /// machine affects all of them.
    fn medians(&self, rounds: usize) -> Vec<f64> {
        let mut times = vec![Vec::new(); self.benches.len()];
        for _ in 0..rounds {
            for (times, bench) in times.iter_mut().zip(&self.benches) {
                times.push((bench.time)().as_secs_f64() * 1e9 / self.calls as f64);
            }
        }
        let median = |mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        };
        times.into_iter().map(median).collect()
    }

    fn print_summary(&self) {
        let medians = self.medians(15);
        let percent = 100.0 * self.separated;
        show!(
            "\n{} k = {}, {}: {} calls, {percent:.0} % of the masks empty\n\n| variant | ns a node | GB/s | x scalar | x papers' |\n|---|---|---|---|---|",
            self.kernel,
            self.k,
            self.level,
            self.calls
        );
        let of = |name: &str| self.benches.iter().position(|bench| bench.name == name).map(|i| medians[i]);
        for (bench, ns) in self.benches.iter().zip(&medians) {
            let ratio = |base: Option<f64>| base.map_or("-".into(), |base| format!("{:.2}", base / ns));
            let (scalar, papers) = (ratio(of("scalar")), ratio(of("papers-avx2")));
            show!("| {} | {ns:.2} | {:.1} | {scalar} | {papers} |", bench.name, self.bytes as f64 / ns);
        }
    }
}

/// Every kernel and k at one level, one after the other: their data do not fit into memory together.
fn for_each_row(mut visit: impl FnMut(Row)) {
    for level in LEVELS {
        visit(row_16::<14>(level));
        visit(row_16::<18>(level));
        visit(row_16::<32>(level));
        visit(row_4::<14>(level));
        visit(row_4::<18>(level));
        visit(row_4::<32>(level));
    }
}

fn main() {
    if std::env::var_os("SIMDOP_SUMMARY").is_some() || page::is_wanted() {
        page::begin(
            "Kernels",
            "Nanoseconds a call of an overlap kernel, medians, on the calls of real queries: cow and armadillo \
             against themselves, almost touching. *Papers*: the kernels of the SIMDop paper. Every variant gives \
             the scalar kernel's masks, which is checked first.",
        );
        for_each_row(|row| row.print_summary());
        page::write();
        return;
    }
    let short = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    let mut criterion = short.configure_from_args();
    for_each_row(|row| {
        let mut group = criterion.benchmark_group(format!("kernel/{}/k{}/{}", row.kernel, row.k, row.level));
        group.throughput(Throughput::Elements(row.calls as u64));
        for bench in &row.benches {
            group.bench_function(&bench.name, |b| {
                b.iter_custom(|passes| (0..passes).map(|_| (bench.time)()).sum());
            });
        }
    });
    criterion.final_summary();
}
