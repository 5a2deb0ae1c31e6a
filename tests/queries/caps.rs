//! Solids whose holes are capped. The oracle counts winding numbers of the triangles and the caps together, along rays
//! parallel to the z axis, with exact signs; the library's rays are parallel to the x axis.

use crate::support::data::{MeshData, directory, suite_step};
use crate::support::dyadic::sign_of_determinant;
use crate::support::exact::meshes_meet;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate, torus, wavy_torus};
use crate::support::turns::{pose, rotation};
use crate::{aligned, mesh_of};
use alloc::collections::{BTreeMap, BTreeSet};
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::cloud::{PointCloud, RangeSearch};
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::{AnyBvh, Bvh, BvhRef, CapStats, FormatError, Header, NodeType};
use simdop::isa::Isa;
use simdop::low_level::key::{Half, StorageKind};
use simdop::motion::{CarriedBall, Joint, JointKind, Kinematics, LinkBody, Motion};
use simdop::node::{Node4, Node16};
use simdop::packing::{PackError, Packer};
use simdop::pose::{Pose, PoseError};
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Lanes, Query, Verdict};
use simdop::range::Point;
use simdop::scene::{Body, MotionHit, MotionMemory, MotionVerdict, PairClass, Scene};
use std::path::Path;

type Tree = Bvh<Node16<18>>;
type Triangle = [Point; 3];

// ---- The oracle -------------------------------------------------------------------------------------------

const Z: [&Point; 2] = [&[0.0, 0.0, 1.0], &[0.0; 3]];

/// The side of the line through p and q, seen along z, that r is on.
fn turn(p: &Point, q: &Point, r: &Point) -> i32 {
    let product = |i: usize, j: usize| (p[i] - r[i]) * (q[j] - r[j]);
    let (one, other) = (product(0, 1), product(1, 0));
    if (one - other).abs() > 8.0 * f64::EPSILON * (one.abs() + other.abs()) && one - other != 0.0 {
        return if one > other { 1 } else { -1 };
    }
    sign_of_determinant(r, p, q, Z)
}

/// The side of a triangle's plane that a point is on: 1 where its normal points away from the point.
fn side([a, b, c]: &Triangle, p: &Point) -> i32 {
    let [u, v, w] = [a, b, c].map(|q| [q[0] - p[0], q[1] - p[1], q[2] - p[2]]);
    let mut size = 0.0;
    let minor = |i: usize, j: usize| {
        let (one, other) = (v[i] * w[j], v[j] * w[i]);
        (one - other, one.abs() + other.abs())
    };
    let mut sum = 0.0;
    for (x, (value, magnitude)) in [(u[0], minor(1, 2)), (u[1], minor(2, 0)), (u[2], minor(0, 1))] {
        sum += x * value;
        size += x.abs() * magnitude;
    }
    if sum.abs() > 64.0 * f64::EPSILON * size && sum != 0.0 {
        return if sum > 0.0 { 1 } else { -1 };
    }
    sign_of_determinant(p, a, b, [c, p])
}

/// Where a point is.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Place {
    OnSurface,
    Around(i32),
}

impl Place {
    /// A point on a triangle or a cap is in the body, like one inside.
    fn is_in(self) -> bool {
        self != Self::Around(0)
    }
}

/// Closed triangles, by the cells of a grid that they cover, seen along z.
struct Oracle {
    triangles: Vec<Triangle>,
    low: [f64; 2],
    cell: [f64; 2],
    cells: Vec<Vec<u32>>,
}

const CELLS: usize = 64;

impl Oracle {
    fn new(triangles: Vec<Triangle>) -> Self {
        let all = || triangles.iter().flatten();
        let low = [0, 1].map(|i| all().fold(f64::INFINITY, |low, p| low.min(p[i])));
        let high = [0, 1].map(|i| all().fold(f64::NEG_INFINITY, |high, p| high.max(p[i])));
        let cell = [0, 1].map(|i| (high[i] - low[i]) / CELLS as f64);
        let mut oracle = Self { triangles: Vec::new(), low, cell, cells: vec![Vec::new(); CELLS * CELLS] };
        for (index, t) in (0..).zip(&triangles) {
            let ends = [0, 1].map(|i| {
                let ends = [t[0][i], t[1][i], t[2][i]];
                [f64::min, f64::max].map(|f| oracle.column(i, ends.into_iter().reduce(f).unwrap()))
            });
            for x in ends[0][0]..=ends[0][1] {
                for y in ends[1][0]..=ends[1][1] {
                    oracle.cells[x * CELLS + y].push(index);
                }
            }
        }
        oracle.triangles = triangles;
        oracle
    }

    /// Monotone, so that a point is in a column between those of a triangle that it is below or above.
    fn column(&self, i: usize, x: f64) -> usize {
        (((x - self.low[i]) / self.cell[i]) as usize).min(CELLS - 1)
    }

    fn place(&self, p: &Point, rng: &mut Rng) -> Place {
        let mut winding = 0;
        for &index in &self.cells[self.column(0, p[0]) * CELLS + self.column(1, p[1])] {
            let t = &self.triangles[index as usize];
            let turns = [0, 1, 2].map(|i| turn(&t[i], &t[(i + 1) % 3], p));
            match turns {
                [1, 1, 1] | [-1, -1, -1] => match side(t, p) {
                    0 => return Place::OnSurface,
                    side => winding += if side == turns[0] { side } else { 0 },
                },
                _ if turns.contains(&1) && turns.contains(&-1) => {}
                _ => return self.place_by_others(p, rng),
            }
        }
        Place::Around(winding)
    }

    /// Along rays in random directions, if the one along z passes an edge.
    fn place_by_others(&self, p: &Point, rng: &mut Rng) -> Place {
        let is_on = |t: &Triangle| meshes_meet(&[[*p; 3]], &[*t]);
        if self.triangles.iter().any(is_on) {
            return Place::OnSurface;
        }
        let crossed = |t: &Triangle, d: &Point| -> Option<i32> {
            let [a, b, c] = t;
            let sides = [[a, b], [b, c], [c, a]].map(|[q, r]| sign_of_determinant(p, q, r, [d, &[0.0; 3]]));
            match sides {
                [1, 1, 1] | [-1, -1, -1] => {
                    let ahead = sign_of_determinant(a, b, c, [a, p]);
                    Some(if ahead == sides[0] { ahead } else { 0 })
                }
                _ if sides.contains(&1) && sides.contains(&-1) => Some(0),
                _ => Some(0).filter(|_| has_no_area(t)),
            }
        };
        for _ in 0..100 {
            let d = [(); 3].map(|()| rng.int(-1_000_000, 1_000_000) as f64);
            if let Some(sum) = self.triangles.iter().map(|t| crossed(t, &d)).sum::<Option<i32>>() {
                return Place::Around(sum);
            }
        }
        panic!("no ray misses all edges");
    }
}

fn has_no_area([a, b, c]: &Triangle) -> bool {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    axes.iter().all(|axis| sign_of_determinant(a, b, c, [axis, &[0.0; 3]]) == 0)
}

/// Whether as many triangles run along each edge in one direction as in the other.
fn is_closed(triangles: &[Triangle]) -> bool {
    let key = |p: &Point| p.map(|x| (x + 0.0).to_bits());
    let mut edges = BTreeMap::<_, i32>::new();
    for t in triangles {
        for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (key(&t[i]), key(&t[j]))) {
            *edges.entry([p.min(q), p.max(q)]).or_default() += (p < q) as i32 - (q < p) as i32;
        }
    }
    edges.values().all(|sum| *sum == 0)
}

/// The caps of a tree.
fn caps_of<N: Lanes>(tree: &Bvh<N>) -> Vec<Triangle> {
    tree.view().caps().map_or_else(Vec::new, |caps| (0..caps.len() as u32).map(|i| caps.primitive(i)).collect())
}

// ---- Meshes with holes ------------------------------------------------------------------------------------

/// A closed surface of a cube, with n x n squares on each face, projected to a sphere if `round`.
fn ball(n: u32, round: bool) -> MeshData {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for (end, (i, j)) in (0..2 * n * n).map(|k| (k / (n * n), (k % n, k / n % n))) {
            let corner = |x: u32, y: u32| {
                let mut p = [0.0; 3];
                p[axis] = f64::from(2 * end) - 1.0;
                p[(axis + 1) % 3] = f64::from(2 * (i + x)) / f64::from(n) - 1.0;
                p[(axis + 2) % 3] = f64::from(2 * (j + y)) / f64::from(n) - 1.0;
                let length = if round { (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt() } else { 1.0 };
                p.map(|x| x / length)
            };
            let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let [a, b] = [[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|i| quad[i]));
            triangles.extend([a, b].map(|t| if end == 0 { [t[0], t[2], t[1]] } else { t }));
        }
    }
    joined(triangles)
}

/// A mesh whose triangles share the vertices that they have in common.
fn joined(triangles: impl IntoIterator<Item = Triangle>) -> MeshData {
    let (mut mesh, mut known) = (MeshData { vertices: Vec::new(), triangles: Vec::new() }, BTreeMap::new());
    for t in triangles {
        let index = t.map(|p| {
            *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                mesh.vertices.push(p);
                mesh.vertices.len() as u32 - 1
            })
        });
        mesh.triangles.push(index);
    }
    mesh
}

fn stl(path: &Path) -> MeshData {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let number = |at: &[u8]| f64::from(f32::from_le_bytes(at.try_into().unwrap()));
    let corner = |t: &[u8], at: usize| [0, 4, 8].map(|i| number(&t[at + i..at + i + 4]));
    joined(bytes[84..].chunks_exact(50).map(|t| [12, 24, 36].map(|at| corner(t, at))))
}

/// Cuts a few holes of up to `most` triangles, or damages the mesh otherwise.
fn cut(mesh: &MeshData, most: u64, rng: &mut Rng) -> MeshData {
    let mut mesh = mesh.clone();
    for _ in 0..1 + rng.below(4) {
        let first = rng.below(mesh.triangles.len() as u64) as usize;
        let seed = mesh.triangles[first];
        match rng.below(8) {
            // Turned the wrong way, doubled, and a wall inside: edges of two, three and more triangles.
            0 => mesh.triangles[first].swap(0, 1),
            1 => mesh.triangles.push(seed),
            2 => {
                let other = rng.pick(&mesh.triangles)[rng.below(3) as usize];
                mesh.triangles.push([seed[0], seed[1], other]);
            }
            // Two triangles with one common vertex: two holes that touch.
            3 => {
                let is_opposite = |t: &&[u32; 3]| t.iter().filter(|v| seed.contains(v)).count() == 1;
                let other = mesh.triangles.iter().find(is_opposite).copied();
                mesh.triangles.retain(|t| *t != seed && Some(*t) != other);
            }
            // A patch that grows from a triangle.
            _ => {
                let mut gone = BTreeSet::from([seed]);
                let size = 1 + rng.below(most) as usize;
                while gone.len() < size {
                    let rim: BTreeSet<u32> = gone.iter().flatten().copied().collect();
                    let is_next = |t: &&[u32; 3]| t.iter().any(|v| rim.contains(v)) && !gone.contains(*t);
                    let Some(&next) = mesh.triangles.iter().find(is_next) else { break };
                    gone.insert(next);
                }
                mesh.triangles.retain(|t| !gone.contains(t));
            }
        }
    }
    if rng.below(4) == 0 { separate(mesh.corners()) } else { mesh }
}

/// The names and meshes of the data sets: closed ones, and those that have holes.
fn real_meshes() -> [Vec<(String, MeshData)>; 2] {
    let Some(data) = directory() else { return [Vec::new(), Vec::new()] };
    let read = |name: &&str| {
        let path = data.join(name);
        let mesh = if name.ends_with(".stl") { stl(&path) } else { MeshData::obj(&path) };
        ((*name).to_string(), mesh)
    };
    let closed = [
        "meshes/hand.obj",
        "meshes/cow.obj",
        "meshes/pinion.obj",
        "meshes/bull.obj",
        "meshes/turbine.obj",
        "meshes/cheese.obj",
        "robots/panda/meshes/link5.obj",
        "robots/solo12/meshes/solo_12_base.stl",
        "robots/ur5/meshes/forearm.stl",
    ];
    let open = [
        "meshes/mannequin-devil.obj",
        "robots/panda/meshes/link6.obj",
        "robots/panda/meshes/visual_link3.obj",
        "robots/solo12/meshes/solo_foot.stl",
        "robots/solo12/meshes/solo_lower_leg_left_side.stl",
        "robots/solo12/meshes/solo_upper_leg_right_side.stl",
        "robots/talos/meshes/arm_7.stl",
        "robots/talos/meshes/gripper_base_link.stl",
        "robots/talos/meshes/head_2.stl",
        "robots/talos/meshes/knee_lo_res.stl",
        "robots/ur5/meshes/inner_finger_fine.stl",
    ];
    [closed.iter().map(read).collect(), open.iter().map(read).collect()]
}

fn made() -> Vec<MeshData> {
    let mut two = ball(3, false);
    append(&mut two, &scaled(&ball(4, true), 0.5, [0.1, 0.0, 0.2]));
    let mut hollow = ball(4, true);
    append(&mut hollow, &cuboid([-0.3; 3], [0.3; 3], true));
    vec![ball(2, false), ball(5, true), torus(12, 8), wavy_torus(800), ball(6, false), two, hollow]
}

fn capped<N: Lanes>(mesh: &MeshData) -> Bvh<N> {
    let tree = Builder::new().solid_with_caps(f64::INFINITY).build_as::<N>(&mesh_of(mesh)).unwrap();
    let view = tree.view();
    view.verify().unwrap();
    let again = Bvh::<N>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!((again.view().cap_stats(), view.is_solid()), (view.cap_stats(), true));
    tree
}

/// The triangles of the mesh and the caps of its tree, which close it.
fn closed_by_caps<N: Lanes>(mesh: &MeshData, tree: &Bvh<N>) -> Vec<Triangle> {
    let (mut all, caps) = (mesh.corners(), caps_of(tree));
    all.extend(&caps);
    assert!(is_closed(&all));
    let stats = tree.view().cap_stats();
    let of_mesh = mesh_of(mesh).caps(f64::INFINITY).unwrap();
    assert_eq!((stats.holes, stats.triangles), (of_mesh.stats.holes, of_mesh.stats.triangles));
    let (wide, want) = (stats.width, of_mesh.stats.width);
    assert!(want <= wide && wide <= want * (1.0 + 1e-6), "{wide} {want}");
    let mut listed: Vec<_> = of_mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize])).collect();
    let mut found = caps;
    let bits = |t: &Triangle| t.map(|p| p.map(|x| (x + 0.0).to_bits()));
    listed.sort_by_key(bits);
    found.sort_by_key(bits);
    assert_eq!(listed, found);
    all
}

// ---- Points -----------------------------------------------------------------------------------------------

/// Points in the box of the mesh, near its vertices, and near and on caps.
fn points(mesh: &MeshData, caps: &[Triangle], count: usize, rng: &mut Rng) -> Vec<Point> {
    let ((low, high), size) = (mesh.bounds(), mesh.diagonal());
    let near = |p: Point, rng: &mut Rng| {
        let reach = size * 10_f64.powi(-(1 + rng.below(14) as i32));
        p.map(|x| x + rng.range(-reach, reach))
    };
    let on_cap = |rng: &mut Rng| -> Point {
        let [a, b, c] = *rng.pick(caps);
        let (u, v) = (rng.unit(), rng.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        core::array::from_fn(|i| a[i] + u * (b[i] - a[i]) + v * (c[i] - a[i]))
    };
    let point = |rng: &mut Rng| -> Point {
        match rng.below(10) {
            0 => near(*rng.pick(&mesh.vertices), rng),
            1 => on_cap(rng),
            2..6 => near(on_cap(rng), rng),
            _ => core::array::from_fn(|i| rng.range(low[i], high[i])),
        }
    };
    (0..count).map(|_| point(rng)).collect()
}

fn at(t: Point) -> Pose {
    pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], t)
}

#[derive(Default, Debug)]
struct Seen {
    inside: usize,
    outside: usize,
    on: usize,
}

/// Compares what a point, a sphere without radius and a point of a cloud find with the oracle.
fn check_points<N: Lanes>(mesh: &MeshData, count: usize, rng: &mut Rng, seen: &mut Seen) {
    let tree = capped::<N>(mesh);
    let oracle = Oracle::new(closed_by_caps(mesh, &tree));
    let dot: Bvh<N> = Builder::new().build_as(&mesh_of(&separate([[[0.0; 3]; 3]]))).unwrap();
    let ball = [Sphere { centre: [0.0; 3], radius: 0.0 }];
    let ball: Bvh<N, Spheres> = Builder::new()
        .build_geometry(&SphereSet { spheres: &ball }, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let (query, scalar) = (Query::new(Isa::detect()), Query::new(Isa::SCALAR));
    for (i, p) in points(mesh, &caps_of(&tree), count, rng).into_iter().enumerate() {
        // In single precision, for the cloud.
        let p = if i % 16 == 0 { p.map(|x| f64::from(x as f32)) } else { p };
        let place = oracle.place(&p, rng);
        *(match place {
            Place::OnSurface => &mut seen.on,
            Place::Around(0) => &mut seen.outside,
            Place::Around(_) => &mut seen.inside,
        }) += 1;
        let found = query.collide(&dot, &tree, &at(p));
        assert_eq!(!found.is_free(), place.is_in(), "{p:?} {place:?}");
        if i % 16 == 0 {
            assert_eq!(scalar.collide(&dot, &tree, &at(p)), found);
            assert_eq!(!query.collide(&ball, &tree, &at(p)).is_free(), place.is_in(), "{p:?}");
            assert_eq!(query.within(&dot, &tree, &at(p), 0.0).unwrap(), found);
            let far = query.distance(&dot, &tree, &at(p), 0.0).unwrap();
            assert_eq!(far.upper == 0.0, place.is_in(), "{p:?} {place:?} {far:?}");
            let cloud = PointCloud::new(&[p.map(|x| x as f32)]).unwrap();
            let search = RangeSearch::new(Isa::detect());
            if place != Place::OnSurface {
                let near = search.body_within(&cloud.view(), &tree, &Pose::IDENTITY, 0.0).unwrap();
                assert_eq!(near.is_some(), place.is_in(), "{p:?}");
            }
        }
        if i % 64 == 0 {
            // The solid is the first body, and moved.
            let back = query.collide(&tree, &dot, &at(p.map(|x| -x)));
            let moved: Vec<Triangle> =
                oracle.triangles.iter().map(|t| t.map(|q| at(p.map(|x| -x)).apply(q))).collect();
            if i % 1024 == 0 {
                let is_in = Oracle::new(moved).place(&[0.0; 3], rng).is_in();
                assert_eq!(!back.is_free(), is_in, "{p:?}");
            }
        }
    }
}

fn random_points(count: usize, seed: u64) {
    let (mut rng, mut seen) = (Rng::new(seed), Seen::default());
    let [closed, open] = real_meshes();
    let made = made();
    let rounds = made.len() * 2 + closed.len() + open.len();
    let each = count / rounds;
    for mesh in made.iter().chain(&made) {
        check_points::<Node16<18>>(&cut(mesh, 12, &mut rng), each, &mut rng, &mut seen);
    }
    for (name, mesh) in &closed {
        println!("{name}");
        check_points::<Node16<18>>(&cut(mesh, 40, &mut rng), each, &mut rng, &mut seen);
    }
    for (name, mesh) in &open {
        println!("{name}");
        check_points::<Node16<18>>(mesh, each, &mut rng, &mut seen);
    }
    println!("{seen:?}");
    if count > 10_000 {
        assert!(seen.inside > count / 8 && seen.outside > count / 8 && seen.on > 0, "{seen:?}");
    }
}

#[test]
fn points_are_inside_by_the_winding_number_of_triangles_and_caps() {
    random_points(if cfg!(miri) { 60 } else { 100_000 / suite_step() }, 1);
}

#[test]
#[ignore = "minutes"]
fn a_million_points() {
    random_points(1_000_000, 2);
}

#[test]
fn so_it_is_for_other_node_types() {
    let (mut rng, mut seen) = (Rng::new(3), Seen::default());
    for mesh in made() {
        let (count, mesh) = (if cfg!(miri) { 4 } else { 400 }, cut(&mesh, 12, &mut rng));
        check_points::<Node4<14>>(&mesh, count, &mut rng, &mut seen);
        check_points::<Node16<26, Half>>(&mesh, count, &mut rng, &mut seen);
    }
}
