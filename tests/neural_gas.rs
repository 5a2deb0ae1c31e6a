//! Batch Neural Gas: the same bytes on any number of threads and on any machine; clusters as good as those of a
//! slow clustering in floating point; and a build that terminates for every mesh.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod support;

use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Magnification, Mesh, Progress, Splitter};
use simdop::hierarchy::{Bvh, BvhRef, MAX_DEPTH};
use simdop::node::{Link, Node4, Node16};
use simdop::query::Lanes;
use std::time::Instant;
use support::data::{MeshData, by_suite, directory, suite_step};
use support::digest::digest_of_tree;
use support::rng::Rng;
use support::shapes;

const MAGNIFICATIONS: [Magnification; 2] = [Magnification::None, Magnification::Area];

fn builder(magnification: Magnification, seed: u32) -> Builder {
    Builder::new().splitter(Splitter::BatchNeuralGas { magnification, seed })
}

fn mesh_of(mesh: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }
}

// ---- The same bytes everywhere ----------------------------------------------------------------------------

/// With 16 lanes and no magnification control, and with 4 lanes, magnification control and 3 triangles per
/// leaf.
fn digests(mesh: &MeshData) -> [u64; 2] {
    let wide: Bvh<Node16<18>> = builder(Magnification::None, 0).build_as(&mesh_of(mesh)).unwrap();
    let narrow: Bvh<Node4<14>> =
        builder(Magnification::Area, 7).leaf_size(3).build_as(&mesh_of(mesh)).unwrap();
    [digest_of_tree(wide.as_bytes()), digest_of_tree(narrow.as_bytes())]
}

type Golden<'a> = (&'a str, [u64; 2]);

fn generated() -> Vec<(&'static str, MeshData)> {
    let mut rng = Rng::new(11);
    vec![
        ("torus", shapes::torus(60, 40)),
        ("flat grid", shapes::flat_grid(40)),
        ("collinear", shapes::collinear(3000)),
        ("coincident", shapes::coincident(3000)),
        ("soup", shapes::soup(&mut rng, 5000, 0.01)),
        ("huge among tiny", shapes::huge_among_tiny(&mut rng, 2000)),
        ("ever smaller", ever_smaller(2000)),
    ]
}

#[rustfmt::skip]
const GENERATED: [Golden<'_>; 7] = [
    ("torus", [0xe9e0_1a77_bbae_abf5, 0x5565_662a_5d20_b678]),
    ("flat grid", [0x2ec4_eaf1_5051_58f0, 0x8e65_bd13_133f_ebb9]),
    ("collinear", [0xbdfc_4a6f_8d38_f48a, 0x519d_d222_cdda_041c]),
    ("coincident", [0x993d_606c_f887_7bbd, 0x6cb3_e3a5_d1a7_1356]),
    ("soup", [0xeb07_b014_b284_98f4, 0x64a3_7e0d_4dd4_7928]),
    ("huge among tiny", [0x5708_91f5_ac6c_f1c5, 0x5761_8786_7bd9_e725]),
    ("ever smaller", [0x36c4_de58_bf01_d91d, 0xcedc_242d_b8fd_12a4]),
];

#[rustfmt::skip]
const DATA: [Golden<'_>; 14] = [
    ("planning/unc_rob", [0x42d4_7706_2f5c_f248, 0xf926_4a4b_c326_3989]),
    ("planning/unc_env", [0x478d_527b_70be_ec54, 0xb5bd_301e_a5b8_3146]),
    ("meshes/hand", [0x34fc_1ebb_386e_aaf5, 0x7bf3_5285_4c95_06f9]),
    ("meshes/pinion", [0x9f42_8085_9f0f_3fa3, 0x7e9d_f009_f6bf_bf4f]),
    ("meshes/cow", [0x0538_1f03_265c_279e, 0x320d_1337_d164_756f]),
    ("meshes/bull", [0xc4b8_ea78_08df_abbf, 0x7e30_58d1_842c_8482]),
    ("meshes/turbine", [0x69d7_1473_90dd_a4ac, 0x5784_1529_eb33_d362]),
    ("meshes/cheese", [0xaedf_ea30_d008_7736, 0x9ea1_d2d4_f6e7_543c]),
    ("meshes/camel", [0x0199_6bbd_20b3_97eb, 0x10b5_9780_d30c_4f48]),
    ("meshes/mannequin-devil", [0xe61e_d930_91bf_75ec, 0xb5cf_40fd_9e1b_e12d]),
    ("meshes/fandisk_large", [0x313f_520d_9535_f356, 0x4bbf_a9f9_6a47_7438]),
    ("meshes/man", [0xf5da_3979_9fd4_dd1b, 0xb9ce_c726_f516_ca99]),
    ("meshes/armadillo", [0xdfc3_15a2_01df_2968, 0x604a_4026_ce55_9d05]),
    ("meshes/bunny75k", [0x7b44_7202_ccb7_84ac, 0x5737_1a10_2b9b_854d]),
];

/// Prints the rows that differ from the recorded ones, and fails if there are any.
fn compare(got: &[Golden<'_>], want: &[Golden<'_>]) {
    let changed: Vec<_> = got.iter().zip(want).filter(|(got, want)| got != want).collect();
    for ((name, [x, y]), _) in &changed {
        println!("    (\"{name}\", [{x:#018x}, {y:#018x}]),");
    }
    assert!(changed.is_empty(), "digests are not the ones written here, but those above");
}

/// A change of these digests changes the trees: mention it in CHANGELOG.md.
#[test]
fn golden_bytes_of_generated_meshes() {
    let got: Vec<_> = generated().iter().map(|(name, mesh)| (*name, digests(mesh))).collect();
    compare(&got, &GENERATED);
}

#[test]
fn golden_bytes_of_real_meshes() {
    let Some(data) = directory() else { return };
    // The first are the smallest, and enough for an emulator.
    let some = if suite_step() == 1 { DATA.len() } else { 5 };
    let digests = |name: &str| digests(&MeshData::obj(&data.join(format!("{name}.obj"))));
    let got: Vec<_> = DATA[..some].iter().map(|(name, _)| (*name, digests(name))).collect();
    compare(&got, &DATA);
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_builds_the_same_bytes() {
    // Enough triangles to split the sums of the root, and of each level, between threads.
    let mesh = shapes::torus(200, 100);
    for splitter in [
        Splitter::LongestAxis,
        Splitter::ExtendedLongestAxis,
        Splitter::MeanWidth,
        Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 3 },
        Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 3 },
    ] {
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let builder = Builder::new().splitter(splitter);
            let tree: Bvh<Node16<14>> = pool.install(|| builder.build_as(&mesh_of(&mesh)).unwrap());
            tree.as_bytes().to_vec()
        };
        let want = build(1);
        for threads in [2, 4] {
            assert!(build(threads) == want, "{splitter:?} with {threads} threads");
        }
    }
}

#[test]
fn the_seed_is_all_there_is_of_chance() {
    let mesh = shapes::torus(30, 20);
    let tree = |seed: u32| -> Bvh<Node16<18>> {
        builder(Magnification::None, seed).build_as(&mesh_of(&mesh)).unwrap()
    };
    assert_eq!(tree(1).as_bytes(), tree(1).as_bytes());
    assert_ne!(tree(1).as_bytes(), tree(2).as_bytes());
}

// ---- Every build ends -------------------------------------------------------------------------------------

/// Triangles at 2^-1, 2^-2, and so on, repeatedly: the most unbalanced clusters.
fn ever_smaller(n: u32) -> MeshData {
    let triangle = |i: u32| {
        let at = f64::from_bits(u64::from(1023 - i % 240) << 52);
        [[at, 0.0, 0.0], [at, at * 0.5, 0.0], [at, 0.0, at * 0.25]]
    };
    shapes::separate((0..n).map(triangle))
}

/// Every triangle is in exactly one leaf of a valid tree.
fn check<N: Lanes>(name: &str, mesh: &MeshData, magnification: Magnification, leaf_size: u32) {
    let tree: Bvh<N> = builder(magnification, 5).leaf_size(leaf_size).build_as(&mesh_of(mesh)).unwrap();
    let view: BvhRef<'_, N> = tree.view();
    view.validate().unwrap();
    view.verify().unwrap();
    let mut sources: Vec<u32> = (0..view.len() as u32).map(|i| view.source(i)).collect();
    sources.sort_unstable();
    assert!(sources.iter().copied().eq(0..mesh.triangles.len() as u32), "{name}: each triangle once");
    let stats = view.stats();
    assert!(stats.depth <= MAX_DEPTH);
    // Full nodes have arity - 1 leaves each. Clusters do not fill leaves of several triangles as well.
    let full = stats.primitives.div_ceil(leaf_size as usize).div_ceil(N::ARITY - 1).max(1);
    let most = if leaf_size == 1 { full + full / 8 } else { 2 * full } + 2;
    let nodes = view.header().node_count as usize;
    assert!(nodes <= most, "{name}: {stats:?}, {full} full nodes would do");
}

#[test]
fn awkward_meshes_are_built() {
    let mut rng = Rng::new(12);
    let many = 100_000 / suite_step().pow(2);
    let mut meshes = generated();
    for (name, count) in [("empty", 0), ("one", 1), ("two", 2), ("sixteen", 16), ("seventeen", 17)] {
        meshes.push((name, shapes::soup(&mut rng, count, 0.1)));
    }
    meshes.push(("points", shapes::separate((0..300).map(|i| [[f64::from(i % 7); 3]; 3]))));
    // An emulator need not repeat all of them: the trees are the same, bit for bit.
    let leaf_sizes: &[u32] = if suite_step() > 1 { &[5] } else { &[1, 5, 16] };
    for (name, mesh) in &meshes {
        for magnification in MAGNIFICATIONS {
            for &leaf_size in leaf_sizes {
                check::<Node16<6>>(name, mesh, magnification, leaf_size);
                check::<Node4<6>>(name, mesh, magnification, leaf_size);
            }
        }
    }
    check::<Node16<6>>("many coincident", &shapes::coincident(many), Magnification::None, 1);
    let tiny = shapes::huge_among_tiny(&mut rng, many);
    check::<Node16<6>>("many tiny, one huge", &tiny, Magnification::None, 1);
    check::<Node4<6>>("many tiny, one huge", &tiny, Magnification::Area, 16);
}

#[test]
fn largest_and_smallest_coordinates_are_clustered() {
    use simdop::range::{MAX_COORDINATE, MIN_COORDINATE};
    let unit = shapes::torus(20, 20);
    let mut roots = Vec::new();
    for factor in [1.0, MAX_COORDINATE * 0.5, MIN_COORDINATE * MIN_COORDINATE.recip().sqrt(), 1e-60] {
        let scale = f64::from_bits(factor.to_bits() >> 52 << 52);
        let mut mesh = unit.clone();
        mesh.vertices.iter_mut().flatten().for_each(|x| *x *= scale);
        for magnification in MAGNIFICATIONS {
            let tree: Bvh<Node16<18>> = builder(magnification, 0).build_as(&mesh_of(&mesh)).unwrap();
            tree.view().verify().unwrap();
            let sources: Vec<u32> = (0..tree.view().len() as u32).map(|i| tree.view().source(i)).collect();
            roots.push((magnification, sources));
        }
    }
    for (magnification, sources) in &roots[2..] {
        let same = &roots.iter().find(|(m, _)| m == magnification).unwrap().1;
        assert!(sources == same, "a power of two changes no cluster");
    }
}

#[test]
fn an_observer_sees_progress_and_can_stop() {
    let mesh = shapes::torus(50, 50);
    let mut seen = Vec::new();
    let tree: Result<Bvh<Node16<18>>, _> =
        builder(Magnification::None, 0).build_with(&mesh_of(&mesh), &mut |progress: Progress| {
            seen.push(progress);
            ControlFlow::Continue(())
        });
    assert_eq!(seen.len(), tree.unwrap().view().stats().depth);
    assert!(seen.iter().all(|p| p.total == 5000) && seen.is_sorted_by_key(|p| p.placed));
    assert_eq!(seen.last().unwrap().placed, 5000);

    let mut calls = 0;
    let stopped = Builder::new().build_with::<Node4<6>>(&mesh_of(&mesh), &mut |_| {
        calls += 1;
        if calls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!((stopped.unwrap_err(), calls), (BuildError::Cancelled, 2));
}

/// Sixteen million triangles in a strip along a random walk. Takes gigabytes and minutes: run it with
/// `--ignored`.
#[test]
#[ignore = "memory and time"]
fn sixteen_million() {
    const COUNT: u32 = 1 << 24;
    let mut rng = Rng::new(16);
    let mut at = [0.0; 3];
    let step = |_| {
        at = at.map(|x: f64| x + rng.range(-1.0, 1.0));
        at
    };
    let vertices: Vec<[f64; 3]> = (0..COUNT + 2).map(step).collect();
    let mesh = MeshData { vertices, triangles: (0..COUNT).map(|i| [i, i + 1, i + 2]).collect() };
    let start = Instant::now();
    // With weights, the sums are as large as possible.
    let tree: Bvh<Node16<6>> = builder(Magnification::Area, 0).build_as(&mesh_of(&mesh)).unwrap();
    println!("{:.1?}, {:?}", start.elapsed(), tree.view().stats());
    tree.view().validate().unwrap();
}

// ---- Clusters as good as the paper's ----------------------------------------------------------------------

/// The paper's algorithm in floating point, exactly as published: 100 steps, no early stop, prototypes that
/// start at random places.
struct Oracle<'a> {
    points: &'a [[f64; 3]],
    weights: &'a [f64],
    lanes: usize,
}

fn square_distance(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    (0..3).map(|i| (p[i] - q[i]).powi(2)).sum()
}

impl Oracle<'_> {
    fn cluster(&self, rng: &mut Rng) -> Vec<usize> {
        const STEPS: i32 = 100;
        let low: [f64; 3] =
            core::array::from_fn(|i| self.points.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min));
        let high: [f64; 3] =
            core::array::from_fn(|i| self.points.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max));
        let mut prototypes: Vec<[f64; 3]> = (0..self.lanes)
            .map(|_| core::array::from_fn(|i| rng.range(low[i], high[i] + f64::MIN_POSITIVE)))
            .collect();
        let first = self.lanes as f64 / 2.0;
        for step in 0..STEPS {
            let lambda = first * (0.01 / first).powf(f64::from(step) / f64::from(STEPS));
            let mut sums = vec![[0.0; 4]; self.lanes];
            for (p, v) in self.points.iter().zip(self.weights) {
                for (rank, lane) in self.ranking(&prototypes, p).into_iter().enumerate() {
                    let pull = v * (-(rank as f64) / lambda).exp();
                    (0..3).for_each(|i| sums[lane][i] += pull * p[i]);
                    sums[lane][3] += pull;
                }
            }
            for (prototype, sums) in prototypes.iter_mut().zip(&sums).filter(|(_, sums)| sums[3] > 0.0) {
                *prototype = core::array::from_fn(|i| sums[i] / sums[3]);
            }
        }
        self.points.iter().map(|p| self.ranking(&prototypes, p)[0]).collect()
    }

    /// The lanes, nearest first.
    fn ranking(&self, prototypes: &[[f64; 3]], p: &[f64; 3]) -> Vec<usize> {
        let mut lanes: Vec<usize> = (0..self.lanes).collect();
        lanes.sort_by(|&a, &b| {
            square_distance(&prototypes[a], p).total_cmp(&square_distance(&prototypes[b], p))
        });
        lanes
    }

    /// The weighted mean square distance of the points from the mean of their cluster.
    fn error(&self, cluster_of: &[usize]) -> f64 {
        let mut sums = vec![[0.0; 4]; self.lanes];
        for ((p, v), &lane) in self.points.iter().zip(self.weights).zip(cluster_of) {
            (0..3).for_each(|i| sums[lane][i] += v * p[i]);
            sums[lane][3] += v;
        }
        let means: Vec<[f64; 3]> = sums.iter().map(|s| core::array::from_fn(|i| s[i] / s[3])).collect();
        let error = |((p, v), &lane): ((&[f64; 3], &f64), &usize)| v * square_distance(p, &means[lane]);
        let total: f64 = self.points.iter().zip(self.weights).zip(cluster_of).map(error).sum();
        total / self.weights.iter().sum::<f64>()
    }
}

/// The lane of the root that holds each triangle of the mesh.
fn root_lanes<N: Lanes>(tree: BvhRef<'_, N>) -> Vec<usize> {
    let mut lanes = vec![usize::MAX; tree.len()];
    for (lane, child) in tree.nodes()[0].children().iter().enumerate() {
        let mut open = vec![child.link()];
        while let Some(link) = open.pop() {
            match link {
                Link::Empty => {}
                Link::Leaf { first, count } => {
                    (first..first + count).for_each(|i| lanes[tree.source(i) as usize] = lane);
                }
                Link::Inner(node) => {
                    open.extend(tree.nodes()[node as usize].children().iter().map(|c| c.link()));
                }
            }
        }
    }
    lanes
}

fn box_centre(t: &[[f64; 3]; 3]) -> [f64; 3] {
    core::array::from_fn(|i| {
        0.5 * (t.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min)
            + t.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max))
    })
}

fn area([p, q, r]: &[[f64; 3]; 3]) -> f64 {
    let edge = |a: &[f64; 3]| -> [f64; 3] { core::array::from_fn(|i| a[i] - p[i]) };
    let (u, v) = (edge(q), edge(r));
    (0..3)
        .map(|i| (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// The mean error of several seeds, and by how much the largest exceeds it, as a fraction.
fn mean_and_spread(errors: &[f64]) -> (f64, f64) {
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (mean, errors.iter().copied().fold(0.0, f64::max) / mean - 1.0)
}

fn compare_with_oracle<N: Lanes>(name: &str, mesh: &MeshData, magnification: Magnification) {
    let corners = mesh.corners();
    let points: Vec<[f64; 3]> = corners.iter().map(box_centre).collect();
    let weights: Vec<f64> = match magnification {
        Magnification::Area => corners.iter().map(area).collect(),
        _ => vec![1.0; points.len()],
    };
    let oracle = Oracle { points: &points, weights: &weights, lanes: N::ARITY };
    let mut rng = Rng::new(99);
    let (want, _) = mean_and_spread(&[(); 3].map(|()| oracle.error(&oracle.cluster(&mut rng))));
    let seeds = by_suite(20, 2);
    let errors: Vec<f64> = (0..seeds)
        .map(|seed| {
            let tree: Bvh<N> = builder(magnification, seed).build_as(&mesh_of(mesh)).unwrap();
            oracle.error(&root_lanes(tree.view()))
        })
        .collect();
    let (mean, spread) = mean_and_spread(&errors);
    println!(
        "{name:10} arity {:2} {magnification:?}: error {:.4} of the oracle's; \
         worst of {seeds} seeds {:.2} % above the mean",
        N::ARITY,
        mean / want,
        spread * 100.0
    );
    assert!(mean < 1.06 * want, "{name}: {mean} is far from {want}");
    // With four prototypes the algorithm itself has suboptimal fixed points, which the oracle finds as often.
    assert!(spread < if N::ARITY == 4 { 0.25 } else { 0.1 }, "{name}: {errors:?}");
}

#[test]
fn clusters_are_as_good_as_in_floating_point_whatever_the_seed() {
    // An emulator takes a small torus and no others: the trees are the same, bit for bit.
    let [around, along] = if cfg!(target_arch = "aarch64") { [24, 16] } else { [60, 40] };
    as_good("torus", &shapes::torus(around, along));
    if suite_step() == 1 {
        as_good("soup", &shapes::soup(&mut Rng::new(13), 3000, 0.05));
    }
}

#[test]
#[ignore = "seconds, or minutes in an emulator"]
fn clusters_of_the_cow_are_as_good() {
    of_a_file_as_good("cow");
}

#[test]
#[ignore = "seconds, or minutes in an emulator"]
fn clusters_of_the_hand_are_as_good() {
    of_a_file_as_good("hand");
}

fn of_a_file_as_good(name: &str) {
    let Some(data) = directory() else { return };
    as_good(name, &MeshData::obj(&data.join(format!("meshes/{name}.obj"))));
}

fn as_good(name: &str, mesh: &MeshData) {
    for magnification in MAGNIFICATIONS {
        compare_with_oracle::<Node16<6>>(name, mesh, magnification);
        compare_with_oracle::<Node4<6>>(name, mesh, magnification);
    }
}
