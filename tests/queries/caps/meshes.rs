//! Meshes with holes.

use super::oracle::{Triangle, is_closed};
use crate::mesh_of;
use crate::support::data::{MeshData, by_suite, directory};
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate, torus, wavy_torus};
use crate::support::turns::pose;
use alloc::collections::{BTreeMap, BTreeSet};
use simdop::construct::Builder;
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Lanes;
use simdop::range::Point;
use std::path::Path;

pub(super) type Tree = Bvh<Node16<18>>;

/// The caps of a tree.
pub(super) fn caps_of<N: Lanes>(tree: &Bvh<N>) -> Vec<Triangle> {
    tree.view()
        .caps()
        .map_or_else(Vec::new, |caps| (0..caps.len() as u32).map(|i| caps.primitive(i)).collect())
}

/// A closed surface of a cube, with n x n squares on each face, projected to a sphere if `round`.
pub(super) fn ball(n: u32, round: bool) -> MeshData {
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

/// The mesh with equal vertices joined.
pub(super) fn joined(triangles: impl IntoIterator<Item = Triangle>) -> MeshData {
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

pub(super) fn stl(path: &Path) -> MeshData {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let number = |at: &[u8]| f64::from(f32::from_le_bytes(at.try_into().unwrap()));
    let corner = |t: &[u8], at: usize| [0, 4, 8].map(|i| number(&t[at + i..at + i + 4]));
    joined(bytes[84..].chunks_exact(50).map(|t| [12, 24, 36].map(|at| corner(t, at))))
}

/// Cuts a few holes of up to `most` triangles, or damages the mesh otherwise.
pub(super) fn cut(mesh: &MeshData, most: u64, rng: &mut Rng) -> MeshData {
    let mut mesh = mesh.clone();
    for _ in 0..1 + rng.below(4) {
        let first = rng.below(mesh.triangles.len() as u64) as usize;
        let seed = mesh.triangles[first];
        match rng.below(8) {
            // Reversed orientation, a doubled triangle, and a wall inside: edges of two, three and more triangles.
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

/// The names and meshes of the data sets, closed ones and ones with holes.
pub(super) fn real_meshes() -> [Vec<(String, MeshData)>; 2] {
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
    let [closed, open] = [by_suite(&closed[..], &closed[..3]), by_suite(&open[..], &open[3..6])];
    [closed, open].map(|names| names.iter().map(read).collect())
}

pub(super) fn made() -> Vec<MeshData> {
    let mut two = ball(3, false);
    append(&mut two, &scaled(&ball(4, true), 0.5, [0.1, 0.0, 0.2]));
    let mut hollow = ball(4, true);
    append(&mut hollow, &cuboid([-0.3; 3], [0.3; 3], true));
    vec![ball(2, false), ball(5, true), torus(12, 8), wavy_torus(800), ball(6, false), two, hollow]
}

pub(super) fn capped<N: Lanes>(mesh: &MeshData) -> Bvh<N> {
    let tree = Builder::new().solid_with_caps(f64::INFINITY).build_as::<N>(&mesh_of(mesh)).unwrap();
    let view = tree.view();
    view.verify().unwrap();
    let again = Bvh::<N>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!((again.view().cap_stats(), view.is_solid()), (view.cap_stats(), true));
    tree
}

/// The triangles of the mesh and the caps of its tree, which close it.
pub(super) fn closed_by_caps<N: Lanes>(mesh: &MeshData, tree: &Bvh<N>) -> Vec<Triangle> {
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

/// Points in the box of the mesh, near its vertices, and near and on caps.
pub(super) fn points(mesh: &MeshData, caps: &[Triangle], count: usize, rng: &mut Rng) -> Vec<Point> {
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
            // Damage may cancel: a triangle without area that is appended, or one that is reversed twice.
            _ if caps.is_empty() => core::array::from_fn(|i| rng.range(low[i], high[i])),
            0 => near(*rng.pick(&mesh.vertices), rng),
            1 => on_cap(rng),
            2..6 => near(on_cap(rng), rng),
            _ => core::array::from_fn(|i| rng.range(low[i], high[i])),
        }
    };
    (0..count).map(|_| point(rng)).collect()
}

/// A point at any pose without rotation. One corner is off by less than the rounding of the translation, since the
/// planes of a body of one point would be coarse.
pub(super) fn dot<N: Lanes>() -> Bvh<N> {
    let off = [2.0_f64.powi(-200), 0.0, 0.0];
    Builder::new().build_as(&mesh_of(&separate([[[0.0; 3], [0.0; 3], off]]))).unwrap()
}

pub(super) fn at(t: Point) -> Pose {
    pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], t)
}

pub(super) fn open_cube() -> MeshData {
    let mut open = cuboid([-1.0; 3], [1.0; 3], false);
    // Without the side at x = 1.
    open.triangles.truncate(10);
    open
}

/// Without its sides at x = -1 and x = 1.
pub(super) fn tunnel() -> MeshData {
    let mut open = open_cube();
    open.triangles.retain(|t| !t.iter().all(|&v| open.vertices[v as usize][0] == -1.0));
    open
}
