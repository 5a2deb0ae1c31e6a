//! The SIMDop paper's comparison: binary DOP trees, scalar, auto-vectorised and hand-vectorised, against 1vs16 and
//! 4vs4; and an ablation of the library: the gain from SIMD, arity, storage and splitter, beside the paper's figure for
//! each.
//!
//! ```sh
//! cargo bench --bench ablation                     # cow, armadillo, hand, bunny75k and a generated torus; a minute
//! cargo bench --bench ablation -- cow              # these only; `torus` needs no files
//! cargo bench --bench ablation -- --test           # the torus, small, at a few poses
//! ```
//!
//! A mesh against itself, k = 18, one triangle per leaf, first hit. Every system uses the same triangles, predicate and
//! poses (those of `support/suites.rs`). Before timing, it must give the library's verdict at every pose, and at poses
//! that barely touch. Times are medians over the poses of the minimum over [`PASSES`] passes; the systems take turns,
//! [`BLOCK`] poses each. Counts are means over the poses at the distance 0 %.
//!
//! The binary trees realign A's DOPs by the library's own inequality and pads (`src/realign.rs`), and are traversed as
//! in the library (`ablation/traverse.rs`). They are split by full sweeps (`ablation/split.rs`).

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/distances.rs"]
mod distances;
mod ablation {
    #[cfg(target_arch = "x86_64")]
    pub(crate) mod avx2;
    pub(crate) mod bytes;
    pub(crate) mod orientations;
    pub(crate) mod plain;
    pub(crate) mod split;
    pub(crate) mod systems;
    pub(crate) mod traverse;
    pub(crate) mod tree;
    #[cfg(target_arch = "x86_64")]
    pub(crate) mod wide;
}
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "../tests/support/shapes.rs"]
mod shapes;
#[path = "support/suites.rs"]
mod suites;
#[expect(dead_code, reason = "the kernels' variants and their clock are for benches/kernel.rs")]
mod support;

use ablation::systems::{Entrant, entrants};
use ablation::traverse::Work;
use data::{MeshData, Suite, directory};
use distances::{PerDistance, poses};
use page::show;
use shapes::wavy_torus;
use simdop::isa::Isa;
use simdop::pose::Pose;
use std::time::{Duration, Instant};
use suites::DISTANCES;
use support::short::{count, is_short};

const MODELS: [&str; 4] = ["cow", "armadillo", "hand", "bunny75k"];
const TORUS: &str = "torus";
/// At each distance.
const POSES: usize = 100;
/// Poses that a system gets in a row before the next system's turn, as in `benches/peers`: a planner queries one
/// library many times.
const BLOCK: usize = 10;
const PASSES: usize = 5;
/// Index into [`DISTANCES`] of the distance that counts are for: the paper's.
const TOUCHING: usize = 1;

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    page::begin(
        "SIMD, arity, planes and splitter",
        "Medians, in microseconds a query: a mesh against itself until the first hit, k = 18, one triangle a \
         leaf. Counts are means over the poses at 0 %. First checks that every system gives the library's verdict at \
         every pose.",
    );
    let mut all = Vec::new();
    for (name, mesh) in meshes() {
        if asked.is_empty() || asked.iter().any(|asked| asked == name) {
            all.push(report(name, &mesh));
        }
    }
    summary(&all);
    page::write();
}

/// The gain from an idea: the systems without and with it, and the paper's figure. In their names `best` stands for the
/// best instruction set of the machine.
struct Idea {
    what: &'static str,
    without: &'static str,
    with: &'static str,
    paper: &'static str,
}

const IDEAS: [Idea; 13] = [
    Idea {
        what: "all ideas together, over a binary tree in scalar code",
        without: "binary, scalar, early exit",
        with: "1vs16, best",
        paper: "8 to 13, growing with the mesh (V, figure 9)",
    },
    Idea {
        what: "a binary tree in SIMD by hand, over the compiler's",
        without: "binary, compiler for avx2",
        with: "binary, by hand, avx2",
        paper: "very similar times (V, figure 9)",
    },
    Idea {
        what: "SIMD in 1vs16, over its scalar code",
        without: "1vs16, scalar",
        with: "1vs16, best",
        paper: "about 2 (V, figure 11)",
    },
    Idea {
        what: "SIMD in 4vs4, over its scalar code",
        without: "4vs4, scalar",
        with: "4vs4, best",
        paper: "about 2 (V, figure 11)",
    },
    Idea {
        what: "AVX-512 over AVX2, 1vs16",
        without: "1vs16, avx2",
        with: "1vs16, avx512",
        paper: "2 (V, figure 10)",
    },
    Idea {
        what: "4vs4 instead of 1vs16",
        without: "1vs16, best",
        with: "4vs4, best",
        paper: "4vs4 performs best (V, figure 9)",
    },
    Idea {
        what: "arity 16, over a binary tree by hand in AVX2 with the same keys",
        without: "binary, by hand, avx2, keys",
        with: "1vs16, avx2, this traversal, keys",
        paper: "9.6 at most, by instructions of a compare (IV-C)",
    },
    Idea {
        what: "planes in 16-bit keys, over halves that each test converts",
        without: "1vs16, avx2, this traversal, paper's halves",
        with: "1vs16, avx2, this traversal, keys",
        paper: "halves: half the memory, converted without overhead (IV-C)",
    },
    Idea {
        what: "planes in 16-bit keys, over floats",
        without: "1vs16, avx2, this traversal, floats",
        with: "1vs16, avx2, this traversal, keys",
        paper: "none",
    },
    Idea {
        what: "planes in 16-bit keys, over 8-bit planes relative to the node",
        without: "1vs16, avx2, this traversal, 8-bit planes",
        with: "1vs16, avx2, this traversal, keys",
        paper: "none",
    },
    Idea {
        what: "Batch Neural Gas, over the longest axis",
        without: "1vs16, best, longest axis",
        with: "1vs16, best, neural gas",
        paper: "outperforms it significantly, more so with more branches (V, figure 6)",
    },
    Idea {
        what: "Batch Neural Gas, over the extended longest axis",
        without: "1vs16, best, extended longest axis",
        with: "1vs16, best, neural gas",
        paper: "outperforms it significantly (V, figure 6)",
    },
    Idea {
        what: "mean width, over Batch Neural Gas",
        without: "1vs16, best, neural gas",
        with: "1vs16, best",
        paper: "none",
    },
];

/// Prints times relative to the first system's, and the gain from each idea: geometric means over the meshes.
fn summary(meshes: &[Vec<Timed>]) {
    let Some(first) = meshes.first() else { return };
    let row = |first: &str, [over, under]: [usize; 2]| {
        let mean = |distance: usize| {
            let ratio = |mesh: &Vec<Timed>| mesh[over].medians[distance] / mesh[under].medians[distance];
            (meshes.iter().map(|mesh| ratio(mesh).ln()).sum::<f64>() / meshes.len() as f64).exp()
        };
        let columns: PerDistance<String> = core::array::from_fn(|distance| format!("{:.2}", mean(distance)));
        format!("| {first} | {} |", columns.join(" | "))
    };
    let distances = DISTANCES.map(|(name, _)| name).join(" | ");
    let rules = "---|".repeat(DISTANCES.len());
    show!("## Times relative to the first system's, geometric means of {} meshes\n", meshes.len());
    show!("| system | {distances} |\n|---|{rules}");
    for (i, Timed { name, .. }) in first.iter().enumerate() {
        show!("{}", row(name, [i, 0]));
    }
    show!("\n## Gain from each idea: time without it / with it, and the SIMDop paper's figure\n");
    show!("| idea | {distances} | the paper |\n|---|{rules}---|");
    for Idea { what, without, with, paper } in IDEAS {
        let place = |name: &str| {
            let name = name.replace("best", Isa::detect().name());
            first.iter().position(|timed| timed.name == name)
        };
        match (place(without), place(with)) {
            (Some(over), Some(under)) => show!("{} {paper} |", row(what, [over, under])),
            _ => show!("| {what} | {}{paper} |", "not on this machine | ".repeat(DISTANCES.len())),
        }
    }
}

/// A system's times on a mesh.
struct Timed {
    name: String,
    /// Microseconds.
    medians: PerDistance<f64>,
}

fn meshes() -> impl Iterator<Item = (&'static str, MeshData)> {
    let read = |data: std::path::PathBuf| {
        MODELS.map(|name| (name, MeshData::obj(&data.join("meshes").join(name).with_extension("obj"))))
    };
    let data = if is_short() { None } else { directory() };
    data.map(read).into_iter().flatten().chain([(TORUS, wavy_torus(count(20_000, 1152) as u32))])
}

fn report(name: &str, mesh: &MeshData) -> Vec<Timed> {
    let poses = poses(mesh, count(POSES, 8));
    let entrants = entrants(mesh);
    check(&entrants, poses.iter().flatten());
    check(&entrants, &grazing(mesh, &entrants[0]));
    let medians = poses.each_ref().map(|poses| medians(&entrants, poses));
    show!("## {name}, {} triangles\n", mesh.triangles.len());
    let distances = DISTANCES.map(|(name, _)| format!("{name}, us")).join(" | ");
    show!(
        "| system | bytes of nodes a triangle | {distances} | visits | DOP pairs | slabs a pair | triangle pairs |"
    );
    show!("|---|---|{}---|---|---|---|", "---|".repeat(DISTANCES.len()));
    for (i, entrant) in entrants.iter().enumerate() {
        let times = medians.each_ref().map(|of| format!("{:.2}", of[i])).join(" | ");
        let works: Vec<Work> = poses[TOUCHING].iter().map(|pose| (entrant.collide)(pose).1).collect();
        let sum = |of: fn(&Work) -> u64| works.iter().map(of).sum::<u64>() as f64;
        let mean = |of| format!("{:.1}", sum(of) / works.len() as f64);
        show!(
            "| {} | {:.0} | {times} | {} | {} | {:.2} | {} |",
            entrant.name,
            entrant.bytes as f64 / mesh.triangles.len() as f64,
            mean(|w| w.visits),
            mean(|w| w.tests),
            sum(|w| w.slabs) / sum(|w| w.tests),
            mean(|w| w.primitive_pairs),
        );
    }
    show!("");
    ablation::orientations::report(mesh, &poses[TOUCHING]);
    let timed = |(i, entrant): (usize, Entrant)| Timed {
        name: entrant.name,
        medians: medians.each_ref().map(|of| of[i]),
    };
    entrants.into_iter().enumerate().map(timed).collect()
}

/// # Panics
/// If a verdict differs from that of the first system, the library's.
fn check<'p>(entrants: &[Entrant], poses: impl IntoIterator<Item = &'p Pose>) {
    for pose in poses {
        let (expected, _) = (entrants[0].collide)(pose);
        for Entrant { name, collide, .. } in entrants {
            assert_eq!(collide(pose).0, expected, "{name} is wrong at {pose:?}");
        }
    }
}

/// Poses down to 1e-8 of the diagonal on either side of contact, where a bound that is too tight shows.
fn grazing(mesh: &MeshData, entrant: &Entrant) -> Vec<Pose> {
    let suite = Suite { name: "ablation", a: mesh.clone(), b: mesh.clone() };
    let pose = |rows: &_| Pose::from_rows(*rows).unwrap();
    suite.poses(count(1, 8), |rows| (entrant.collide)(&pose(rows)).0).iter().map(pose).collect()
}

/// Median time of each entrant, in microseconds.
fn medians(entrants: &[Entrant], poses: &[Pose]) -> Vec<f64> {
    let mut best = vec![vec![Duration::MAX; poses.len()]; entrants.len()];
    for (turn, first) in (0..poses.len()).step_by(BLOCK).enumerate() {
        let block = first..poses.len().min(first + BLOCK);
        for i in 0..entrants.len() {
            let which = (turn + i) % entrants.len();
            for _ in 0..count(PASSES, 1) {
                for pose in block.clone() {
                    let start = Instant::now();
                    std::hint::black_box((entrants[which].collide)(&poses[pose]));
                    best[which][pose] = best[which][pose].min(start.elapsed());
                }
            }
        }
    }
    best.into_iter()
        .map(|mut times| {
            times.sort_unstable();
            1e6 * times[times.len() / 2].as_secs_f64()
        })
        .collect()
}
