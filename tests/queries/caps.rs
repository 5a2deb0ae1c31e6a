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
use simdop::motion::{Joint, JointKind, JointMotion, Kinematics, LinkBody, LinkFrame};
use simdop::node::{Node4, Node16};
use simdop::packing::{PackError, Packer};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Lanes, Query, Verdict};
use simdop::range::Point;
use simdop::scene::{Body, BodyId, MotionHit, MotionMemory, MotionVerdict, PairClass, Scene};
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
            *edges.entry([p.min(q), p.max(q)]).or_default() += i32::from(p < q) - i32::from(q < p);
        }
    }
    edges.values().all(|sum| *sum == 0)
}

/// The caps of a tree.
fn caps_of<N: Lanes>(tree: &Bvh<N>) -> Vec<Triangle> {
    tree.view()
        .caps()
        .map_or_else(Vec::new, |caps| (0..caps.len() as u32).map(|i| caps.primitive(i)).collect())
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
            // Damage may cancel: a triangle without area that is pushed, or one that is turned twice.
            _ if caps.is_empty() => core::array::from_fn(|i| rng.range(low[i], high[i])),
            0 => near(*rng.pick(&mesh.vertices), rng),
            1 => on_cap(rng),
            2..6 => near(on_cap(rng), rng),
            _ => core::array::from_fn(|i| rng.range(low[i], high[i])),
        }
    };
    (0..count).map(|_| point(rng)).collect()
}

/// A point, wherever a pose places it that does not rotate: one corner is off by less than the rounding of the
/// translation. The planes of a body of one point would be coarse.
fn dot<N: Lanes>() -> Bvh<N> {
    let off = [2.0_f64.powi(-200), 0.0, 0.0];
    Builder::new().build_as(&mesh_of(&separate([[[0.0; 3], [0.0; 3], off]]))).unwrap()
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
    let dot = dot::<N>();
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
        if i % 512 == 0 {
            // The solid is the first body, and moved.
            let back = at(p.map(|x| -x));
            let moved = oracle.triangles.iter().map(|t| t.map(|q| back.apply(q))).collect();
            let is_in = Oracle::new(moved).place(&[0.0; 3], rng).is_in();
            assert_eq!(!query.collide(&tree, &dot, &back).is_free(), is_in, "{p:?}");
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

// ---- Holes of known meshes --------------------------------------------------------------------------------

/// Far from the holes, and everywhere if these are flat, the inside is that of the mesh before they were cut.
#[test]
fn what_was_inside_still_is() {
    let mut rng = Rng::new(4);
    for (mesh, is_flat) in [(ball(6, false), true), (ball(8, true), false), (wavy_torus(3000), false)] {
        for _ in 0..8 {
            let mut open = mesh.clone();
            let middle = mesh.triangles[rng.below(mesh.triangles.len() as u64) as usize][0];
            let normal_axis = |t: &[u32; 3]| {
                (0..3).find(|&i| {
                    t.iter().all(|&v| mesh.vertices[v as usize][i] == mesh.vertices[t[0] as usize][i])
                })
            };
            let face = mesh.triangles.iter().find(|t| t.contains(&middle)).and_then(normal_axis);
            open.triangles.retain(|t| !t.contains(&middle) || is_flat && normal_axis(t) != face);
            let tree = capped::<Node16<18>>(&open);
            let (caps, width) = (caps_of(&tree), tree.view().cap_stats().width);
            assert_eq!(tree.view().cap_stats().holes, 1);
            assert!(caps.len() >= if is_flat { 1 } else { 4 });
            let dot = dot::<Node16<18>>();
            let (whole, query) = (Oracle::new(mesh.corners()), Query::new(Isa::detect()));
            let centre = mesh.vertices[middle as usize];
            for p in points(&open, &caps, 2000, &mut rng) {
                let is_far = (0..3).map(|i| (p[i] - centre[i]).powi(2)).sum::<f64>().sqrt() > width;
                if is_far || is_flat {
                    let is_in = whole.place(&p, &mut rng).is_in();
                    assert_eq!(!query.collide(&dot, &tree, &at(p)).is_free(), is_in, "{p:?}");
                }
            }
        }
    }
}

fn area([a, b, c]: &Triangle) -> f64 {
    let [u, v] = [b, c].map(|q| glam::DVec3::from_array(*q) - glam::DVec3::from_array(*a));
    u.cross(v).length()
}

/// Each hole has a cap with the area of its least fan.
#[test]
fn caps_are_the_least_fans() {
    let mut rng = Rng::new(5);
    for _ in 0..60 {
        let (low, count) = ([-1.0, -2.0, 0.5], 3 + rng.below(9) as usize);
        // A cone over a random polygon, without its base.
        let mut rim: Vec<Point> = (0..count)
            .map(|i| {
                let t = core::f64::consts::TAU * i as f64 / count as f64;
                let r = rng.range(0.4, 1.0);
                [low[0] + r * t.cos(), low[1] + r * t.sin(), low[2] + rng.range(-0.3, 0.3)]
            })
            .collect();
        let fan = |rim: &[Point], apex: usize| -> Vec<Triangle> {
            let at = |i: usize| rim[(apex + i) % rim.len()];
            (1..rim.len() - 1).map(|i| [at(0), at(i), at(i + 1)]).collect()
        };
        let total = |fan: &[Triangle]| fan.iter().map(area).sum::<f64>();
        let tip = [low[0], low[1], low[2] + 2.0];
        let sides = (0..count).map(|i| [rim[i], rim[(i + 1) % count], tip]).collect::<Vec<_>>();
        let tree = capped::<Node16<18>>(&separate(sides));
        let stats = tree.view().cap_stats();
        assert_eq!((stats.holes, stats.triangles), (1, count - 2));
        rim.reverse();
        let least = (0..count).map(|apex| total(&fan(&rim, apex))).fold(f64::INFINITY, f64::min);
        let found = total(&caps_of(&tree));
        assert!((found - least).abs() <= 1e-12 * least, "{found} {least}");
        let wide = rim
            .iter()
            .flat_map(|p| rim.iter().map(move |q| glam::DVec3::from_array(*p).distance((*q).into())));
        let wide = wide.fold(0.0, f64::max);
        assert!((stats.width - wide).abs() < 1e-6 * wide, "{} {wide}", stats.width);
    }
}

fn open_cube() -> MeshData {
    let mut open = cuboid([-1.0; 3], [1.0; 3], false);
    // Without the side at x = 1.
    open.triangles.truncate(10);
    open
}

#[test]
fn holes_are_counted_and_measured() {
    let (limit, root) = (f64::INFINITY, 2.0_f64.sqrt());
    let stats = |mesh: &MeshData| mesh_of(mesh).caps(limit).unwrap().stats;
    let of = |holes, triangles, width| CapStats { holes, triangles, width };
    let closed = cuboid([-1.0; 3], [1.0; 3], false);
    assert_eq!(stats(&closed), CapStats::default());
    let (solid, same) = (Builder::new().solid(), Builder::new().solid_with_caps(0.0));
    let bytes =
        |builder: Builder, mesh: &MeshData| builder.build(&mesh_of(mesh)).unwrap().as_bytes().to_vec();
    assert!(bytes(solid, &closed) == bytes(same, &closed));

    assert_eq!(stats(&open_cube()), of(1, 2, 2.0 * root));
    assert_eq!(stats(&separate(open_cube().corners())), of(1, 2, 2.0 * root));
    // A triangle that is turned the wrong way is cancelled by one cap and replaced by another.
    let mut turned = closed.clone();
    turned.triangles[3].swap(0, 1);
    assert_eq!(stats(&turned), of(2, 2, 2.0 * root));
    // A doubled triangle, with edges of three.
    let mut double = closed.clone();
    double.triangles.push(double.triangles[5]);
    assert_eq!(stats(&double), of(1, 1, 2.0 * root));
    // A wall inside.
    let mut walled = closed.clone();
    walled.triangles.extend([[0, 1, 7], [0, 7, 6]]);
    assert_eq!(stats(&walled), of(1, 2, 12.0_f64.sqrt()));
    // Two holes that share a corner: a figure eight.
    let mut eight = ball(2, false);
    let corner = eight.triangles[0];
    let other = eight.triangles.iter().rposition(|t| t.iter().filter(|v| corner.contains(v)).count() == 1);
    eight.triangles.remove(other.unwrap());
    eight.triangles.remove(0);
    assert_eq!(stats(&eight), of(2, 2, root));
    // Vertices that no triangle uses at the places of those that are.
    let mut unused = MeshData { vertices: closed.vertices.clone(), triangles: Vec::new() };
    append(&mut unused, &open_cube());
    assert_eq!(stats(&unused), of(1, 2, 2.0 * root));
    for mesh in [turned, double, walled, eight, unused] {
        let tree = capped::<Node16<18>>(&mesh);
        let _ = closed_by_caps(&mesh, &tree);
        let dot = dot::<Node16<18>>();
        let query = Query::new(Isa::detect());
        assert!(!query.collide(&dot, &tree, &at([0.1, 0.2, 0.3])).is_free());
        assert!(query.collide(&dot, &tree, &at([0.1, 0.2, 1.3])).is_free());
    }
}

#[test]
fn holes_that_are_too_wide_are_named() {
    let (open, root) = (open_cube(), 8.0_f64.sqrt());
    for mesh in [open.clone(), separate(open.corners())] {
        for limit in [0.0, 1.0, root.next_down(), -1.0, f64::NAN] {
            let error = Builder::new().solid_with_caps(limit).build(&mesh_of(&mesh)).unwrap_err();
            let BuildError::Hole { edge: [a, b], corners, width, limit: said } = error else {
                panic!("{error}")
            };
            assert_eq!((width, said.to_bits()), (root, limit.to_bits()));
            assert_eq!(corners, [a, b].map(|v| mesh.vertices[v as usize]));
            assert!(a < b && corners.iter().all(|p| p[0] == 1.0), "an edge of the missing side: {corners:?}");
            let text = error.to_string();
            assert!(text.contains("hole 2.828") && text.contains(&format!("vertices {a} and {b}")), "{text}");
        }
        assert!(Builder::new().solid_with_caps(root).build(&mesh_of(&mesh)).is_ok());
    }
    // The widest of several.
    let mut two = ball(8, false);
    let wide = two.triangles[9][0];
    two.triangles.retain(|t| !t.contains(&wide));
    two.triangles.pop();
    let error = mesh_of(&two).caps(0.4).unwrap_err();
    let BuildError::Hole { width, .. } = error else { panic!("{error}") };
    assert!(width > 0.5, "{width}");
    // Too many.
    let soup = separate((0..16_385).map(|i| [0.0, 0.25, 0.5].map(|x| [f64::from(i) + x, x * x, 0.0])));
    let error = mesh_of(&soup).caps(f64::INFINITY).unwrap_err();
    assert_eq!(
        error,
        BuildError::TooManyCaps { count: 16_385, edge: [0, 2], corners: [[0.0; 3], [0.5, 0.25, 0.0]] }
    );
    let few = MeshData { triangles: soup.triangles[1..].to_vec(), ..soup };
    assert_eq!(mesh_of(&few).caps(1.0).unwrap().stats.holes, 16_384);
    let tree = Builder::new().solid_with_caps(1.0).build_as::<Node4<32>>(&mesh_of(&few)).unwrap();
    assert_eq!(tree.view().cap_stats().holes, 16_384);
    // Invalid meshes.
    let bad = Mesh { vertices: &[[f64::NAN; 3]], triangles: &[] };
    assert_eq!(bad.caps(1.0), Err(BuildError::Vertex { index: 0 }));
    let bad = Mesh { vertices: &[[0.0; 3]], triangles: &[[0, 0, 1]] };
    assert_eq!(bad.caps(1.0), Err(BuildError::Primitive { index: 0 }));
}

/// In any unit.
#[test]
fn units_do_not_matter() {
    for exponent in [-240, -60, 0, 60, 290] {
        let unit = 2.0_f64.powi(exponent);
        let mesh = scaled(&open_cube(), unit, [0.0; 3]);
        let tree = capped::<Node16<18>>(&mesh);
        let width = tree.view().cap_stats().width / unit;
        assert!((width - 8.0_f64.sqrt()).abs() < 1e-6);
        let dot = dot::<Node16<18>>();
        let query = Query::new(Isa::detect());
        assert!(!query.collide(&dot, &tree, &at([0.9 * unit, 0.0, 0.0])).is_free());
        assert!(query.collide(&dot, &tree, &at([1.1 * unit, 0.0, 0.0])).is_free());
    }
}

// ---- Bodies -----------------------------------------------------------------------------------------------

/// A pose of a small body near a mesh, often near one of its holes.
fn placement(mesh: &MeshData, caps: &[Triangle], size: f64, rng: &mut Rng) -> Pose {
    let around = points(mesh, caps, 1, rng)[0];
    let shift = around.map(|x| x + rng.range(-size, size));
    pose(&rotation(rng), shift)
}

/// Every answer follows from that of the surface, and from what is inside or on a cap.
fn check_bodies<N: Lanes>(mesh: &MeshData, count: usize, rng: &mut Rng, seen: &mut [usize; 4]) {
    let (tree, surface) = (capped::<N>(mesh), Builder::new().build_as::<N>(&mesh_of(mesh)).unwrap());
    let oracle = Oracle::new(closed_by_caps(mesh, &tree));
    let caps = caps_of(&tree);
    let size = mesh.diagonal() * *rng.pick(&[1e-3, 1e-2, 0.05]);
    let body = match rng.below(3) {
        0 => cuboid([-0.5 * size; 3], [0.5 * size; 3], false),
        1 => scaled(&torus(6, 4), 0.3 * size, [0.0; 3]),
        // A rod, and a flag.
        _ => separate([
            [[-4.0 * size, 0.0, 0.0], [4.0 * size, 0.0, 0.0], [4.0 * size, 0.0, 0.0]],
            [[9.0 * size, 0.0, 0.0], [10.0 * size, 0.0, size], [10.0 * size, size, 0.0]],
        ]),
    };
    let small: Bvh<N> = Builder::new().build_as(&mesh_of(&body)).unwrap();
    let (query, scalar) = (Query::new(Isa::detect()), Query::new(Isa::SCALAR));
    for _ in 0..count {
        let pose = placement(mesh, &caps, size, rng);
        let (bare, found) = (query.collide(&small, &surface, &pose), query.collide(&small, &tree, &pose));
        assert_eq!(scalar.collide(&small, &tree, &pose), found);
        let bare_far = query.distance(&small, &surface, &pose, 0.0).unwrap();
        let far = query.distance(&small, &tree, &pose, 0.0).unwrap();
        let near = 0.5 * bare_far.lower;
        if bare.hit().is_some() {
            seen[0] += 1;
            assert_eq!((found, far), (bare, bare_far), "contacts do not depend on caps");
            continue;
        }
        let moved: Vec<Triangle> = body.corners().iter().map(|t| t.map(|p| pose.apply(p))).collect();
        let is_in = moved.iter().flatten().any(|p| oracle.place(p, rng).is_in());
        let is_on = meshes_meet(&moved, &caps);
        assert_eq!(found.hit().is_some(), is_in || is_on, "{pose:?} {is_in} {is_on}");
        assert_eq!(found.is_free(), found.hit().is_none());
        let within = query.within(&small, &tree, &pose, near).unwrap();
        if let Some(pair) = found.hit() {
            seen[if is_on { 2 } else { 1 }] += 1;
            assert!((pair.a as usize) < body.triangles.len() && (pair.b as usize) < mesh.triangles.len());
            assert_eq!((far.lower, far.upper), (0.0, 0.0));
            let witness = far.witness.unwrap();
            assert!((witness.pair.b as usize) < mesh.triangles.len());
            let apart = glam::DVec3::from_array(witness.a).distance(witness.b.into());
            assert!(apart <= 1e-9 * mesh.diagonal());
            assert!(within.hit().is_some());
        } else {
            seen[3] += 1;
            let numbers = |d: &simdop::query::Distance| (d.lower, d.upper, d.witness, d.completion, d.hint);
            assert_eq!(numbers(&far), numbers(&bare_far), "distances do not depend on caps");
            assert!(within.is_free());
        }
        let more = query.within(&small, &tree, &pose, 2.0 * bare_far.upper).unwrap();
        assert!(more.hit().is_some());
        // Never falsely free within a budget.
        let budget = rng.below(found.stats.visits + 1);
        let few = query.with_budget(budget);
        let (part, part_far) =
            (few.collide(&small, &tree, &pose), few.distance(&small, &tree, &pose, 0.0).unwrap());
        assert!(part.stats.visits <= budget && part_far.stats.visits <= budget);
        assert!(part.verdict == found.verdict || matches!(part.verdict, Verdict::Unknown { .. }));
        assert!(found.is_free() || part_far.lower == 0.0);
    }
}

#[test]
fn bodies_are_hits_inside_and_on_caps() {
    let (mut rng, mut seen) = (Rng::new(6), [0; 4]);
    let [closed, open] = real_meshes();
    let count = if cfg!(miri) { 2 } else { 800 / suite_step() };
    for mesh in made().iter().chain(&made()) {
        check_bodies::<Node16<18>>(&cut(mesh, 12, &mut rng), count, &mut rng, &mut seen);
    }
    for mesh in made() {
        check_bodies::<Node4<14>>(&cut(&mesh, 12, &mut rng), count / 4, &mut rng, &mut seen);
    }
    for (name, mesh) in
        closed.iter().take(3).map(|(name, mesh)| (name, cut(mesh, 40, &mut rng))).collect::<Vec<_>>()
    {
        println!("{name}");
        check_bodies::<Node16<18>>(&mesh, count, &mut rng, &mut seen);
    }
    for (name, mesh) in &open[3..] {
        println!("{name}");
        check_bodies::<Node16<18>>(mesh, count, &mut rng, &mut seen);
    }
    // The solid is the first body, and moved.
    let dice = cuboid([-0.25; 3], [0.25; 3], false);
    let small: Tree = Builder::new().build_as(&mesh_of(&dice)).unwrap();
    let mut moved_seen = [0; 3];
    let (ball, torus) = (cut(&ball(2, false), 6, &mut rng), cut(&torus(8, 6), 6, &mut rng));
    // The cube's opening is wide enough for the dice.
    for mesh in [ball, torus, open_cube()] {
        let tree = capped::<Node16<18>>(&mesh);
        for _ in 0..count / 4 {
            let pose = pose(&rotation(&mut rng), [(); 3].map(|()| rng.range(-1.6, 1.6)));
            let place = |all: &[Triangle]| all.iter().map(|t| t.map(|p| pose.apply(p))).collect::<Vec<_>>();
            let found = Query::new(Isa::detect()).collide(&tree, &small, &pose);
            let far = Query::new(Isa::detect()).distance(&tree, &small, &pose, 0.0).unwrap();
            let is_touching = meshes_meet(&place(&mesh.corners()), &dice.corners());
            let is_on = meshes_meet(&place(&caps_of(&tree)), &dice.corners());
            let around = Oracle::new(place(&closed_by_caps(&mesh, &tree)));
            let is_in = dice.vertices.iter().any(|p| around.place(p, &mut rng).is_in());
            let is_hit = is_touching || is_on || is_in;
            assert_eq!(found.hit().is_some(), is_hit, "{pose:?}");
            assert_eq!((far.upper == 0.0, far.lower == 0.0), (is_hit, is_hit), "{pose:?}");
            if let Some(pair) = found.hit() {
                assert!((pair.a as usize) < mesh.triangles.len() && pair.b < 12);
                moved_seen[if is_touching { 0 } else { 1 + usize::from(is_on) }] += 1;
            }
        }
    }
    println!("{moved_seen:?} {seen:?} touching, inside, on a cap, free");
    assert!(count < 100 || moved_seen.iter().all(|&n| n > 0), "{moved_seen:?}");
    assert!(count < 100 || seen.iter().all(|&n| n > 2 * count), "{seen:?}");
}

/// Of the triangles that the ray crosses, and of those at the hole of a cap that it crosses, the first is named.
#[test]
fn what_is_beside_a_cap_is_named() {
    let query = Query::new(Isa::detect());
    for shift in 0..10 {
        let mut mesh = open_cube();
        mesh.triangles.rotate_left(shift);
        let tree = capped::<Node16<18>>(&mesh);
        let is_at_hole = |index: u32| {
            let at = |&&v: &&u32| mesh.vertices[v as usize][0] == 1.0;
            mesh.triangles[index as usize].iter().filter(at).count() == 2
        };
        let dot = dot::<Node16<18>>();
        // The ray along x leaves through one cap or the other.
        for t in [[0.0, 0.5, 0.1], [0.0, 0.1, 0.5], [0.0, -0.5, 0.1], [0.0, 0.1, -0.5]] {
            let pair = query.collide(&dot, &tree, &at(t)).hit().unwrap();
            assert!(is_at_hole(pair.b), "{pair:?}");
            assert_eq!(query.distance(&dot, &tree, &at(t), 0.0).unwrap().witness.unwrap().pair, pair);
        }
        for x in [1.0, 1.05] {
            let flag = separate([[[0.0, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.0, 0.1]]]);
            let flag: Tree = Builder::new().build_as(&mesh_of(&flag)).unwrap();
            let pair = query.collide(&flag, &tree, &at([x, 0.2, 0.3])).hit().unwrap();
            assert!(is_at_hole(pair.b), "{pair:?}");
            let witness = query.distance(&flag, &tree, &at([x, 0.2, 0.3]), 0.0).unwrap().witness.unwrap();
            assert!(is_at_hole(witness.pair.b), "{witness:?}");
        }
    }
}

/// A cube wholly inside of a link with holes is a hit if these are capped, and free of the surface.
#[test]
fn cubes_in_links_are_hits() {
    let (mut rng, query) = (Rng::new(7), Query::new(Isa::detect()));
    let [_, open] = real_meshes();
    for (name, mesh) in &open {
        let surface: Tree = Builder::new().build_as(&mesh_of(mesh)).unwrap();
        let tree = capped::<Node16<18>>(mesh);
        let oracle = Oracle::new(closed_by_caps(mesh, &tree));
        let half = 1e-3 * mesh.diagonal();
        let cube = cuboid([-half; 3], [half; 3], false);
        let body: Tree = Builder::new().solid().build_as(&mesh_of(&cube)).unwrap();
        let mut found = 0;
        for p in points(mesh, &[], 4000, &mut rng) {
            let corners = || cube.vertices.iter().map(|q| core::array::from_fn(|i| p[i] + q[i]));
            if query.collide(&body, &surface, &at(p)).is_free()
                && corners().all(|q| oracle.place(&q, &mut rng).is_in())
            {
                found += 1;
                assert!(query.collide(&body, &tree, &at(p)).hit().is_some(), "{name} {p:?}");
                assert!(query.collide(&tree, &body, &at(p.map(|x| -x))).hit().is_some(), "{name} {p:?}");
            }
        }
        println!("{name}: {found} cubes, {:?}", tree.view().cap_stats());
        assert!(found > 10, "{name}");
    }
}

// ---- Motions ----------------------------------------------------------------------------------------------

/// Without its sides at x = -1 and x = 1.
fn tunnel() -> MeshData {
    let mut open = open_cube();
    open.triangles.retain(|t| !t.iter().all(|&v| open.vertices[v as usize][0] == -1.0));
    open
}

/// A joint that slides body 1 along x.
struct Slide {
    joints: [Joint; 1],
    bodies: [LinkBody; 1],
    limits: [[f64; 2]; 1],
}

impl Slide {
    fn new(limits: [f64; 2], y: f64) -> Self {
        let joint = Joint::new(JointKind::Prismatic, 0, at([0.0, y, 0.0]), [1.0, 0.0, 0.0], 0).unwrap();
        Self { joints: [joint], bodies: [LinkBody { link: 1, at: Pose::IDENTITY }], limits: [limits] }
    }

    fn robot(&self) -> Kinematics<'_> {
        Kinematics::new(&self.joints, &self.bodies, &self.limits).unwrap()
    }
}

/// A motion along the whole slide.
fn check_motion(scene: &mut Scene<'_, Node16<18>>, id: BodyId, slide: &Slide) -> MotionVerdict {
    let (ends, mut now) = (slide.limits[0].map(|x| [x]), [0.0]);
    let mut links = vec![LinkFrame::EMPTY; 2];
    let mut motion = JointMotion::new(slide.robot(), [&ends[0], &ends[1]], &mut now, &mut links).unwrap();
    let (mut poses, mut waiting) = ([Pose::IDENTITY; 2], [MotionHit::EMPTY; 64]);
    let mut memory = MotionMemory { poses: &mut poses, waiting: &mut waiting };
    let query = Query::new(Isa::detect());
    scene.check_motion(&query, &[id], &mut motion, 1e-4, &mut memory).unwrap().verdict
}

#[test]
fn motions_through_holes_are_not_free() {
    let mut rng = Rng::new(8);
    let (tree, surface) =
        (capped::<Node16<18>>(&tunnel()), Builder::new().build(&mesh_of(&tunnel())).unwrap());
    let small: Tree = Builder::new().build_as(&mesh_of(&cuboid([-0.1; 3], [0.1; 3], false))).unwrap();
    let cloud = PointCloud::new(&[[0.1, 0.0, 0.0], [0.0, 0.05, 0.1]]).unwrap();
    let query = Query::new(Isa::detect());
    let (mut free, mut hits, mut unresolved) = (0, 0, 0);
    for round in 0..if cfg!(miri) { 4 } else { 600 / suite_step() } {
        let (is_cloud, is_other) = (round % 3 == 1, round % 3 == 2);
        let radius = if round % 4 == 0 { 0.02 } else { 0.0 };
        let ends = [rng.range(-3.0, 3.0), *rng.pick(&[-3.0, -1.2, -1.1, 0.0, 1.05, 1.1, 1.2, 3.0])];
        let y = rng.range(-0.7, 0.7);
        let slide = Slide::new([ends[0].min(ends[1]), ends[0].max(ends[1])], y);
        let mut verdicts = [&tree, &surface].map(|tree| {
            let mut scene = Scene::new();
            let body: Body<'_, Node16<18>> =
                if is_cloud { Body::new(cloud.view()) } else { Body::new(small.view()).with_radius(radius) };
            // The solid moves, or the other body.
            let (moving, fixed) =
                if is_other { (Body::new(tree.view()), body) } else { (body, Body::new(tree.view())) };
            let id = scene.insert(moving, &at([-9.0, 0.0, 0.0])).unwrap();
            scene.insert(fixed.fixed(), &Pose::IDENTITY).unwrap();
            let verdict = check_motion(&mut scene, id, &slide);
            let [[low, high]] = slide.limits;
            for i in 0..=100 {
                let x = low + f64::from(i) / 100.0 * (high - low);
                scene.place(id, &at([x, y, 0.0])).unwrap();
                let is_free = scene.collide(&query).unwrap().is_free();
                assert!(is_free || verdict != MotionVerdict::Free, "{x} refutes {verdict:?}");
            }
            verdict
        });
        assert_eq!(verdicts[1], MotionVerdict::Free, "nothing touches the walls");
        match &mut verdicts[0] {
            MotionVerdict::Free => free += 1,
            MotionVerdict::Hit { .. } => hits += 1,
            MotionVerdict::Unresolved { .. } => unresolved += 1,
        }
    }
    println!("{free} free, {hits} hits, {unresolved} unresolved");
    assert!(cfg!(miri) || free > 5 && hits > 5 && unresolved < free, "{free} {hits} {unresolved}");
}

#[test]
fn classes_of_pairs_know_caps() {
    let (tree, surface) =
        (capped::<Node16<18>>(&tunnel()), Builder::new().build(&mesh_of(&tunnel())).unwrap());
    let small: Tree = Builder::new().build_as(&mesh_of(&cuboid([-0.1; 3], [0.1; 3], false))).unwrap();
    let dot = dot::<Node16<18>>();
    let class = |tree: &Tree, (body, radius): (&Tree, f64), limits: [f64; 2]| {
        let (slide, mut scene) = (Slide::new(limits, 0.05), Scene::new());
        let id = scene.insert(Body::new(body.view()).with_radius(radius), &Pose::IDENTITY).unwrap();
        let fixed = scene.insert(Body::new(tree.view()).fixed(), &Pose::IDENTITY).unwrap();
        let query = Query::new(Isa::detect());
        scene.classify_pair(&query, &[id], slide.robot(), (id, fixed), 4000).unwrap().fate
    };
    let cube = (&small, 0.0);
    assert_eq!(class(&surface, cube, [-3.0, 3.0]), PairClass::Never);
    assert_eq!(class(&tree, cube, [-3.0, 3.0]), PairClass::Sometimes);
    assert_eq!(class(&tree, cube, [-3.0, -1.2]), PairClass::Never);
    // Less than a thousandth of the range is inside.
    assert_eq!(class(&tree, cube, [-9.0, -1.0995]), PairClass::Sometimes);
    // On a cap in the middle, and outside at the end, where the radius does not see the cap.
    assert_eq!(class(&tree, (&dot, 0.5), [0.8, 1.2]), PairClass::Sometimes);
    assert_ne!(class(&tree, (&dot, 0.5), [-0.5, 0.5]), PairClass::Never);
}

// ---- Packings and covers ----------------------------------------------------------------------------------

#[test]
fn packings_and_covers_take_the_caps() {
    let (open, query) = (open_cube(), Query::new(Isa::detect()));
    let mut double = cuboid([-1.0; 3], [1.0; 3], false);
    double.triangles.push(double.triangles[5]);
    for mesh in [open, double] {
        // An edge of three triangles is a border like any other.
        assert!(matches!(Packer::new().pack(&mesh_of(&mesh)), Err(PackError::Open { .. })));
        assert!(mesh_of(&mesh).cover_solid(0.2).is_err());
        let caps = mesh_of(&mesh).caps(3.0).unwrap();
        let mut closed = mesh.clone();
        closed.triangles.extend(caps.triangles);
        let packing = Packer::new().spheres(20).pack(&mesh_of(&closed)).unwrap();
        assert!((packing.volume - 8.0).abs() < 1e-12 && packing.spheres.len() == 20);
        for sphere in &packing.spheres {
            assert!(sphere.centre.iter().all(|x| x.abs() + sphere.radius <= 1.0));
        }
        // What the caps close is covered, too.
        let cover = mesh_of(&closed).cover_solid(0.2).unwrap();
        let cover: Bvh<Node16<18>, Spheres> = Builder::new()
            .build_geometry(&SphereSet { spheres: &cover }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let dot = dot::<Node16<18>>();
        let mut rng = Rng::new(9);
        for _ in 0..500 {
            let p = [(); 3].map(|()| rng.range(-1.0, 1.0));
            assert!(!query.collide(&dot, &cover, &at(p)).is_free(), "{p:?}");
        }
    }
}

// ---- Bytes ------------------------------------------------------------------------------------------------

/// Flips bytes of the header's new fields and of the tree of the caps. No bytes that are accepted make a query panic.
#[test]
fn damaged_caps_are_refused() {
    let mut mesh = tunnel();
    append(&mut mesh, &scaled(&open_cube(), 0.25, [0.25, 0.0, 0.0]));
    let tree = capped::<Node16<18>>(&mesh);
    let (view, bytes) = (tree.view(), tree.as_bytes());
    let lines = usize::from(view.header().cap_lines);
    let from = bytes.len() - 64 * lines;
    let at_fields = [offset_of!(Header, cap_lines), offset_of!(Header, cap_width)];
    assert_eq!((at_fields, view.cap_stats().holes, view.caps().unwrap().len()), ([122, 124], 3, 6));
    assert_eq!(view.stats().total_bytes, bytes.len());
    let other: Tree = Builder::new().build_as(&mesh_of(&cuboid([-0.1; 3], [0.1; 3], false))).unwrap();
    let (mut refused, mut accepted, mut verified) = (0, 0, 0);
    let mut offer = |bytes: &[u8]| {
        let lines = aligned(bytes);
        let bytes = &bytemuck::cast_slice::<_, u8>(&lines)[..bytes.len()];
        match BvhRef::<Node16<18>>::from_bytes(bytes) {
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
            Ok(view) => {
                accepted += 1;
                let query = Query::new(Isa::detect());
                for x in [0.0, 1.0, 3.0] {
                    let pose = at([x, 0.01, 0.02]);
                    let _ = (query.collide(&view, &other, &pose), query.collide(&other, &view, &pose));
                    let _ = query.distance(&view, &other, &pose, 0.0).unwrap();
                    let _ = (view.cap_stats(), view.stats(), view.caps().map(|caps| caps.verify()));
                }
                verified += usize::from(view.verify().is_ok());
            }
        }
    };
    let places: Vec<usize> = (114..128).chain(from..bytes.len()).collect();
    for &place in places.iter().step_by(if cfg!(miri) { 40 } else { 1 }) {
        for bit in if cfg!(miri) { 0..1 } else { 0..8 } {
            let mut bytes = bytes.to_vec();
            bytes[place] ^= 1 << bit;
            offer(&bytes);
        }
    }
    let mut rng = Rng::new(10);
    for _ in 0..if cfg!(miri) { 4 } else { 2000 } {
        let mut bytes = bytes.to_vec();
        (0..3).for_each(|_| bytes[*rng.pick(&places)] = rng.u64() as u8);
        offer(&bytes);
    }
    (0..=lines).for_each(|i| offer(&bytes[..bytes.len() - 64 * i]));
    println!("{refused} refused, {accepted} accepted, {verified} verified");
    assert!(cfg!(miri) || refused > 1000 && accepted > 100 && verified < accepted);

    let with = |change: &dyn Fn(&mut [u8])| {
        let mut bytes = bytes.to_vec();
        change(&mut bytes);
        Bvh::<Node16<18>>::from_bytes(&bytes)
    };
    let error = |change: &dyn Fn(&mut [u8])| with(change).err();
    let caps = |problem| Some(FormatError::Caps { problem });
    let field = |field| Some(FormatError::Header { field });
    let inner = |offset: usize| from + offset;
    assert_eq!(error(&|_| ()), None);
    assert_eq!(error(&|b| b[offset_of!(Header, is_solid)] = 0), field("cap_lines"));
    assert_eq!(error(&|b| b[127] = 0x80), field("cap_width"));
    assert_eq!(error(&|b| b[124..128].copy_from_slice(&f32::INFINITY.to_le_bytes())), field("cap_width"));
    assert_eq!(error(&|b| b[from] = 0), caps("it is no tree of the same node type and length"));
    assert_eq!(
        error(&|b| b[inner(offset_of!(Header, k))] = 14),
        caps("it is no tree of the same node type and length")
    );
    assert_eq!(error(&|b| b[inner(offset_of!(Header, is_solid))] = 1), caps("it is a solid, or empty"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, centre))] ^= 1), caps("it has another frame"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, exponent))] ^= 1), caps("it has another frame"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, depth))] = 9), caps("its contents are invalid"));
    // A surface or a closed solid has no caps, and says so.
    for builder in [Builder::new(), Builder::new().solid_with_caps(1.0)] {
        let closed = builder.build(&mesh_of(&cuboid([-1.0; 3], [1.0; 3], false))).unwrap();
        assert_eq!((closed.view().cap_stats(), closed.view().caps().is_none()), (CapStats::default(), true));
        let mut bytes = closed.as_bytes().to_vec();
        bytes[124] = 1;
        assert_eq!(Bvh::<Node16<18>>::from_bytes(&bytes).err(), field("cap_width"));
    }

    // The vertices follow the header and the node, the caps the vertices: three corners each.
    let view = view.caps().unwrap();
    let vertices = inner(128 + size_of_val(view.nodes()));
    let records = vertices + (12 * view.header().vertex_count as usize).next_multiple_of(4);
    assert_eq!(view.header().vertex_size, 12);
    // The caps of a larger solid in the same frame.
    let [large, small] =
        [0.96875, 0.75].map(|size| capped::<Node16<18>>(&scaled(&open_cube(), size, [0.0; 3])));
    assert_eq!(large.view().frame(), small.view().frame());
    let tail = |tree: &Tree| 64 * usize::from(tree.view().header().cap_lines);
    let (from_large, of_small) =
        (large.as_bytes().len() - tail(&large), small.as_bytes().len() - tail(&small));
    let mixed = [&small.as_bytes()[..of_small], &large.as_bytes()[from_large..]].concat();
    assert_eq!(Bvh::<Node16<18>>::from_bytes(&mixed).err(), caps("a vertex is outside of the solid's box"));
    // Caps that do not fit are found by `verify`: with another corner, and turned.
    let changed = |change: &dyn Fn(&mut [u8])| with(change).unwrap().view().verify().unwrap_err();
    let (nodes, k) = (tree.view().header().node_count, 18);
    let swapped = changed(&|b| (0..4).for_each(|i| b.swap(records + i, records + 4 + i)));
    assert_eq!((swapped.node, swapped.lane, swapped.plane), (nodes, 0, k + 4));
    assert!((swapped.primitive as usize) < mesh.triangles.len());
    let lower = changed(&|b| {
        let code = &mut b[inner(128)..][..2];
        let lower = i16::from_le_bytes([code[0], code[1]]) - 9;
        code.copy_from_slice(&lower.to_le_bytes());
    });
    assert!(lower.node >= nodes && lower.plane < k, "{lower:?}");
}

#[test]
fn trees_of_any_node_type_have_caps() {
    let mesh = open_cube();
    for (k, arity, storage) in
        [(6, 16, StorageKind::Fixed), (18, 4, StorageKind::Fixed), (14, 16, StorageKind::Half)]
    {
        let node = NodeType { k, arity, storage };
        let builder = Builder::new().solid_with_caps(3.0);
        let tree = builder.build_any(&mesh_of(&mesh), node, &mut |_| ControlFlow::Continue(())).unwrap();
        let read: AnyBvh = AnyBvh::from_bytes(tree.as_bytes()).unwrap();
        assert_eq!((read.view().cap_stats(), read.view().verify()), (tree.view().cap_stats(), Ok(())));
        assert_eq!(read.view().cap_stats().triangles, 2);
        let dot = separate([[[0.0; 3]; 3]]);
        let dot = Builder::new().build_any(&mesh_of(&dot), node, &mut |_| ControlFlow::Continue(())).unwrap();
        let query = Query::new(Isa::detect());
        for (x, is_in) in [(0.5, true), (1.0, true), (1.5, false)] {
            let found = query.collide_any(&dot.view(), &read.view(), &at([x, 0.1, 0.2])).unwrap();
            assert_eq!(found.hit().is_some(), is_in);
        }
    }
    // Spheres have neither inside nor caps.
    let set = SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 1.0 }] };
    let build = |builder: Builder| -> Bvh<Node16<18>, Spheres> {
        builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    assert!(build(Builder::new()).as_bytes() == build(Builder::new().solid_with_caps(1.0)).as_bytes());
}
