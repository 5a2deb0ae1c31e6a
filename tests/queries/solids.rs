//! Penetration volumes of packings against the common volume of the solids that the packings represent: never
//! above it, and not farther below it than the volume that the packings leave uncovered.

use crate::columns::Columns;
use crate::lens::lens;
use crate::support::data::{MeshData, directory, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::{cuboid, torus, wavy_torus};
use crate::support::turns::pose;
use core::ops::ControlFlow;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::packing::Packer;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::Query;
use std::f64::consts::PI;

type Triangle = [[f64; 3]; 3];

/// The number of grid lines in each direction.
const SIDE: usize = 100;

/// The error of a grid of so many lines, over the volume of the smaller solid. For known volumes the error is
/// less than half of this: see [`columns_measure_what_formulas_know`].
const GRAIN: f64 = 0.0015;

fn bounds(points: impl Iterator<Item = [f64; 3]> + Clone) -> ([f64; 3], [f64; 3]) {
    let fold = |f: fn(f64, f64) -> f64, start: f64| {
        core::array::from_fn(|i| points.clone().fold(start, |m, p| f(m, p[i])))
    };
    (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
}

fn bounds_of(triangles: &[Triangle]) -> ([f64; 3], [f64; 3]) {
    bounds(triangles.iter().flatten().copied())
}

/// The volume of the intersection of two closed surfaces.
fn shared(a: &[Triangle], b: &[Triangle]) -> f64 {
    let Some(columns) = Columns::through([bounds_of(a), bounds_of(b)], SIDE) else { return 0.0 };
    columns.common(&columns.of_surface(a), &columns.of_surface(b))
}

/// The sum of signed tetrahedra.
fn enclosed(triangles: &[Triangle]) -> f64 {
    let volume = |t: &Triangle| {
        let [p, q, r] = t.map(glam::DVec3::from_array);
        p.dot(q.cross(r)) / 6.0
    };
    triangles.iter().map(volume).sum::<f64>().abs()
}

fn placed(mesh: &MeshData, turn: &[[f64; 3]; 3], t: [f64; 3]) -> Vec<Triangle> {
    mesh.placed(&core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]]))
}

#[test]
fn columns_measure_what_formulas_know() {
    let mut rng = Rng::new(1);
    let is_close = |got: f64, want: f64, of: f64| {
        assert!((got - want).abs() <= 0.5 * GRAIN * of, "{got} is not {want}");
    };
    // Two squares of edge 2, one of them rotated by 45 degrees, share an octagon.
    let (cube, root) = (cuboid([-1.0; 3], [1.0; 3], false), 0.5_f64.sqrt());
    let eighth = [[root, -root, 0.0], [root, root, 0.0], [0.0, 0.0, 1.0]];
    let waves = wavy_torus(800);
    for _ in 0..40 / suite_step() {
        let turn = rng.rotation();
        let t = [(); 3].map(|()| rng.range(-3.0, 3.0));
        let product = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..3).map(|k| turn[i][k] * eighth[k][j]).sum())
        });
        let up: [f64; 3] = core::array::from_fn(|i| t[i] + 0.75 * turn[i][2]);
        let octagon = 8.0 * (2.0_f64.sqrt() - 1.0);
        is_close(shared(&placed(&cube, &turn, t), &placed(&cube, &product, up)), octagon * 1.25, 8.0);
        let ring = placed(&waves, &turn, t);
        is_close(shared(&ring, &ring), enclosed(&ring), enclosed(&ring));

        let balls = [1.0, rng.range(0.5, 1.0)].map(|radius| Sphere { centre: [0.0; 3], radius });
        let d = rng.range(0.0, 1.0);
        let [a, b] = [balls[0], Sphere { centre: turn[0].map(|x| d * x), ..balls[1] }];
        let boxes = [a, b]
            .map(|s| bounds([s.centre.map(|x| x - s.radius), s.centre.map(|x| x + s.radius)].into_iter()));
        let columns = Columns::through(boxes, SIDE).unwrap();
        let found = columns.common(&columns.of_spheres(&[a]), &columns.of_spheres(&[b]));
        is_close(found, lens(a.radius, b.radius, d), 4.0 / 3.0 * PI * b.radius.powi(3));
    }
}

/// A solid with spheres in it.
struct Filled {
    mesh: MeshData,
    volume: f64,
    spheres: Vec<Sphere>,
    tree: Bvh<Node16<18>, Spheres>,
}

impl Filled {
    fn new(mesh: &MeshData, count: usize) -> Self {
        let borrowed = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        let spheres = Packer::new().spheres(count).pack(&borrowed).unwrap().spheres;
        let tree = Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        // Not the sum of tetrahedra, which counts overlapping parts of a mesh more than once.
        let corners = mesh.corners();
        Self { mesh: mesh.clone(), volume: shared(&corners, &corners), spheres, tree }
    }

    /// The volume that its spheres do not cover.
    fn uncovered(&self) -> f64 {
        let balls = self.spheres.iter().map(|s| s.radius.powi(3));
        self.volume - 4.0 / 3.0 * PI * balls.sum::<f64>()
    }
}

/// At poses from one body inside the other to far apart. Returns the greatest deficit of a volume over the
/// volume that both packings leave uncovered.
fn check(a: &Filled, b: &Filled, seed: u64, count: usize) -> f64 {
    let deficit = a.uncovered() + b.uncovered();
    let slack = GRAIN * a.volume.min(b.volume);
    assert!(a.uncovered() > 0.0 && b.uncovered() > 0.0);
    let (query, mut rng) = (Query::new(Isa::detect()), Rng::new(seed));
    let still = b.mesh.corners();
    let (mut missing, mut meet) = (0.0_f64, 0);
    for step in 0..count {
        let (turn, towards) = (rng.rotation(), rng.rotation()[0]);
        let way = 0.6 * b.mesh.diagonal() * step as f64 / count as f64;
        let (from, to) = (a.mesh.centre(), b.mesh.centre());
        let t: [f64; 3] = core::array::from_fn(|i| {
            to[i] + way * towards[i] - (0..3).map(|k| turn[i][k] * from[k]).sum::<f64>()
        });
        let pose = pose(&turn, t);
        let whole = query.penetration(&a.tree, &b.tree, &pose);
        let moved = placed(&a.mesh, &turn, t);
        let Some(columns) = Columns::through([bounds_of(&moved), bounds_of(&still)], SIDE) else {
            assert_eq!(whole.volume, 0.0);
            continue;
        };
        let truth = columns.common(&columns.of_surface(&moved), &columns.of_surface(&still));
        let what = format!("{truth} of {} and {}, {deficit}, {whole:?}", a.volume, b.volume);
        assert!(whole.volume <= truth + slack, "{what}");
        assert!(truth <= whole.volume + deficit + slack, "{what}");
        // The packings alone, measured likewise.
        let spheres: Vec<Sphere> =
            a.spheres.iter().map(|s| Sphere { centre: pose.apply(s.centre), ..*s }).collect();
        let of_spheres = columns.common(&columns.of_spheres(&spheres), &columns.of_spheres(&b.spheres));
        assert!((of_spheres - whole.volume).abs() <= slack, "{of_spheres} {what}");
        // A part of the search gives valid bounds, too.
        let visits = whole.stats.visits;
        for budget in [0, visits / 10, visits / 2] {
            let part = query.with_budget(budget).penetration(&a.tree, &b.tree, &pose);
            assert!(part.volume <= truth + slack && truth <= part.upper + deficit + slack, "{part:?} {what}");
        }
        missing = missing.max((truth - whole.volume) / deficit);
        meet += usize::from(whole.volume > 0.0);
    }
    assert!(2 * meet > count, "{meet} of {count} poses share a volume");
    missing
}

#[test]
fn volumes_are_within_their_deficit_of_what_solids_share() {
    let step = suite_step();
    let of = |mesh: &MeshData, count: usize| Filled::new(mesh, count / step);
    let (waves, ring) = (wavy_torus(800), torus(24, 12));
    let (coarse, fine) = (of(&waves, 100), of(&waves, 1000));
    let (boxed, ring) = (of(&cuboid([-1.0, -0.7, -0.5], [1.0, 0.7, 0.5], false), 300), of(&ring, 300));
    let mut most = 0.0_f64;
    for (seed, a, b) in [(1, &boxed, &fine), (2, &ring, &boxed), (3, &fine, &ring), (4, &coarse, &fine)] {
        most = most.max(check(a, b, seed, 60 / step));
    }
    // Two packings of one solid at the same place leave nearly the same volume uncovered, which counts twice.
    assert!(most > 0.2 && most <= 1.0, "{most}");
}

#[test]
fn volumes_of_real_solids() {
    let Some(data) = directory() else { return };
    let [cow, hand] = ["cow", "hand"].map(|name| {
        let mesh = MeshData::obj(&data.join(format!("meshes/{name}.obj")));
        Filled::new(&mesh, 1000 / suite_step())
    });
    for filled in [&cow, &hand] {
        let all = enclosed(&filled.mesh.corners());
        assert!((filled.volume - all).abs() < 0.02 * all, "{} {all}", filled.volume);
    }
    let most = check(&cow, &hand, 5, 60 / suite_step());
    assert!(most > 0.1 && most <= 1.0, "{most}");
}
