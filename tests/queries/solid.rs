//! Solid bodies: a body wholly inside a solid is a hit. The oracle uses the verdicts of surfaces, which other
//! tests prove, and winding numbers in exact arithmetic, from rays in random directions that pass no edge.

use crate::support::data::{MeshData, emulator_step, suite_step};
use crate::support::dyadic::sign_of_determinant;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate, torus};
use crate::support::turns::{pose, rotation};
use crate::{HalfNode, aligned, mesh_of};
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef, FormatError, Header};
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Answer, Completion, Lanes, Query, Verdict};
use simdop::range::Point;

type Triangle = [Point; 3];

// ---- The oracle -------------------------------------------------------------------------------------------

fn has_no_area([a, b, c]: &Triangle) -> bool {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    axes.iter().all(|axis| sign_of_determinant(a, b, c, [axis, &[0.0; 3]]) == 0)
}

/// The winding number of closed triangles around a point that is on none of them.
fn winding(p: &Point, triangles: &[Triangle], rng: &mut Rng) -> i32 {
    let crossed = |t: &Triangle, d: &Point| -> Option<i32> {
        let [a, b, c] = t;
        let sides = [[a, b], [b, c], [c, a]].map(|[q, r]| sign_of_determinant(p, q, r, [d, &[0.0; 3]]));
        match sides {
            [1, 1, 1] | [-1, -1, -1] => {
                // The side of the plane that the point is on: with the direction, it tells whether the plane is
                // ahead.
                let ahead = sign_of_determinant(a, b, c, [a, p]);
                assert_ne!(ahead, 0, "the point is on a triangle");
                Some(if ahead == sides[0] { sides[0] } else { 0 })
            }
            _ if sides.contains(&1) && sides.contains(&-1) => Some(0),
            [0, 0, 0] if has_no_area(t) => Some(0),
            // Through an edge, or along the plane.
            _ => None,
        }
    };
    for _ in 0..100 {
        let d = [(); 3].map(|()| rng.int(-1_000_000, 1_000_000) as f64);
        if let Some(sum) = triangles.iter().map(|t| crossed(t, &d)).sum::<Option<i32>>() {
            return sum;
        }
    }
    panic!("no ray misses all edges")
}

#[test]
fn the_oracle_knows_what_is_in_a_box() {
    let mut rng = Rng::new(1);
    let shells = [([0.0; 3], [8.0; 3], false), ([2.0; 3], [6.0; 3], true), ([-1.0; 3], [3.0; 3], false)];
    let mut solid = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    shells.iter().for_each(|(low, high, inside_out)| append(&mut solid, &cuboid(*low, *high, *inside_out)));
    let triangles = solid.corners();
    for _ in 0..2000 / suite_step() {
        let p = [(); 3].map(|()| rng.int(-5, 20) as f64 * 0.5 + 0.25);
        let of = |(low, high, inside_out): &([f64; 3], [f64; 3], bool)| {
            let is_in = (0..3).all(|i| low[i] < p[i] && p[i] < high[i]);
            i32::from(is_in) * if *inside_out { -1 } else { 1 }
        };
        assert_eq!(winding(&p, &triangles, &mut rng), shells.iter().map(of).sum::<i32>(), "{p:?}");
    }
}

// ---- Bodies -----------------------------------------------------------------------------------------------

/// A mesh of several parts.
#[derive(Clone)]
struct Body {
    mesh: MeshData,
    /// The part of each triangle.
    part_of: Vec<usize>,
}

impl Body {
    fn new(parts: &[MeshData]) -> Self {
        let mut body =
            Self { mesh: MeshData { vertices: Vec::new(), triangles: Vec::new() }, part_of: Vec::new() };
        for (index, part) in parts.iter().enumerate() {
            append(&mut body.mesh, part);
            body.part_of.extend(core::iter::repeat_n(index, part.triangles.len()));
        }
        body
    }

    fn parts(&self) -> usize {
        self.part_of.iter().max().map_or(0, |last| last + 1)
    }

    /// A random corner of each part.
    fn corners(&self, rng: &mut Rng) -> Vec<Point> {
        let corner = |part: usize| {
            let first = self.part_of.iter().position(|&p| p == part).unwrap();
            let count = self.part_of.iter().filter(|&&p| p == part).count();
            let t = self.mesh.triangles[first + rng.below(count as u64) as usize];
            self.mesh.vertices[t[rng.below(3) as usize] as usize]
        };
        (0..self.parts()).map(corner).collect()
    }

    fn scaled(&self, factor: f64, shift: Point) -> Self {
        Self { mesh: scaled(&self.mesh, factor, shift), part_of: self.part_of.clone() }
    }

    fn build<N: Lanes>(&self, builder: Builder) -> Bvh<N> {
        let tree = builder.build_as::<N>(&mesh_of(&self.mesh)).unwrap();
        tree.view().verify().unwrap();
        tree
    }
}

/// The surface of a cube of edge 4 n, with n x n squares on each face: rays from the grid pass many corners.
fn squares(low: Point, n: u32, inside_out: bool) -> MeshData {
    let mut mesh = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    for axis in 0..3 {
        for end in [0.0, 1.0] {
            for (i, j) in (0..n * n).map(|i| (f64::from(i % n), f64::from(i / n))) {
                let corner = |x: f64, y: f64| {
                    let mut p = low;
                    p[axis] += 4.0 * f64::from(n) * end;
                    p[(axis + 1) % 3] += 4.0 * (i + x);
                    p[(axis + 2) % 3] += 4.0 * (j + y);
                    p
                };
                let quad = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
                let first = mesh.vertices.len() as u32;
                mesh.vertices.extend(quad);
                let is_turned = (end == 0.0) != inside_out;
                let turn = |t: [u32; 3]| if is_turned { [t[0], t[2], t[1]] } else { t };
                mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| turn(t).map(|v| v + first)));
            }
        }
    }
    mesh
}

fn octahedron(r: f64, centre: Point) -> MeshData {
    let corner = |i: usize| {
        let mut p = centre;
        p[i / 2] += if i.is_multiple_of(2) { r } else { -r };
        p
    };
    let sides = (0..8).map(|i: usize| {
        let [x, y, z] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
        if i.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
    });
    MeshData {
        vertices: (0..6).map(corner).collect(),
        triangles: sides.map(|t| t.map(|v| v as u32)).collect(),
    }
}

fn torn(mesh: &MeshData) -> MeshData {
    separate(mesh.corners())
}

/// Closed bodies, about 16 across.
fn solids() -> Vec<Body> {
    let shell = |low: f64, high: f64, inside_out: bool| cuboid([low; 3], [high; 3], inside_out);
    let mut ring = scaled(&torus(10, 6), 6.0, [0.0; 3]);
    // On a grid some triangles lose their area, and the surface stays closed.
    ring.vertices.iter_mut().flatten().for_each(|x| *x = x.round());
    vec![
        Body::new(&[shell(-8.0, 8.0, false)]),
        Body::new(&[shell(-8.0, 8.0, true)]),
        Body::new(&[squares([-8.0; 3], 4, false)]),
        Body::new(&[scaled(&squares([-8.0; 3], 4, false), 0.5, [0.0; 3])]),
        Body::new(&[torn(&octahedron(9.0, [0.0, 1.0, 0.0]))]),
        Body::new(&[ring]),
        // A cavity with a solid inside it.
        Body::new(&[shell(-8.0, 8.0, false), shell(-5.0, 5.0, true), shell(-1.0, 1.0, false)]),
        Body::new(&[squares([-8.0; 3], 4, true), squares([-4.0; 3], 2, false)]),
        // Twice solid.
        Body::new(&[shell(-8.0, 8.0, false), shell(-5.0, 5.0, false)]),
        // Overlapping, and touching.
        Body::new(&[
            cuboid([-8.0, -8.0, -8.0], [3.0, 3.0, 3.0], false),
            cuboid([-3.0, -3.0, -3.0], [8.0, 8.0, 8.0], false),
        ]),
        Body::new(&[cuboid([-8.0; 3], [0.0, 8.0, 8.0], false), octahedron(7.0, [8.0, 0.0, 0.0])]),
        Body::new(&[shell(-8.0, -2.0, false), torn(&shell(2.0, 8.0, false))]),
    ]
}

/// Small bodies; some are surfaces with a border.
fn small_ones() -> Vec<Body> {
    let cube = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0], false);
    let flag = |x: f64| separate([[[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 1.0]]]);
    vec![
        Body::new(&[cube(0.0)]),
        Body::new(&[octahedron(1.0, [0.0; 3])]),
        Body::new(&[flag(0.0)]),
        Body::new(&[flag(0.0), cube(6.0)]),
        Body::new(&[cube(20.0), flag(-4.0), octahedron(0.5, [0.0; 3])]),
        Body::new(&[separate([[[1.0, 2.0, 3.0]; 3]])]),
        Body::new(&[torn(&cube(0.0)), cube(3.0)]),
    ]
}

fn is_closed(body: &Body) -> bool {
    Builder::fast().solid().build_as::<Node16<6>>(&mesh_of(&body.mesh)).is_ok()
}

// ---- Placements -------------------------------------------------------------------------------------------

/// One body, baked as a surface and, if possible, as a solid.
struct StaticBvh<N> {
    body: Body,
    surface: Bvh<N>,
    solid: Option<Bvh<N>>,
}

impl<N: Lanes> StaticBvh<N> {
    fn new(body: &Body, builder: Builder) -> Self {
        let solid = is_closed(body).then(|| body.build::<N>(builder.solid()));
        Self { body: body.clone(), surface: body.build::<N>(builder), solid }
    }
}

#[derive(Default, Debug)]
struct Seen {
    apart: usize,
    touching: usize,
    inside: usize,
    ties: usize,
}

/// Which parts are inside a solid.
fn parts_inside(corners: &[Point], solid: &[Triangle], rng: &mut Rng, seen: &mut Seen) -> Vec<bool> {
    // An edge or a corner ahead, to the accuracy of `f64`.
    let is_tie = |p: &Point, t: &Triangle| {
        let [a, b, c] = t.map(|q| [q[0] - p[0], q[1] - p[1], q[2] - p[2]]);
        [[a, b], [b, c], [c, a]].iter().any(|[u, v]| {
            let along = u[1] * v[1] + u[2] * v[2];
            u[0].max(v[0]) > 0.0 && u[1] * v[2] == u[2] * v[1] && along <= 0.0
        })
    };
    seen.ties += usize::from(corners.iter().any(|p| solid.iter().any(|t| is_tie(p, t))));
    corners.iter().map(|p| winding(p, solid, rng) != 0).collect()
}

/// Queries one placement of A in the frame of B, and checks every answer.
fn check<N: Lanes>(a: &StaticBvh<N>, b: &StaticBvh<N>, pose: &Pose, rng: &mut Rng, seen: &mut Seen) {
    let scalar = Query::new(Isa::SCALAR);
    let surfaces = scalar.collide(&a.surface, &b.surface, pose);
    let (tree_a, tree_b) = (a.solid.as_ref().unwrap_or(&a.surface), b.solid.as_ref().unwrap_or(&b.surface));
    let (tree_a, tree_b) = match rng.below(4) {
        0 => (tree_a, &b.surface),
        1 => (&a.surface, tree_b),
        _ => (tree_a, tree_b),
    };
    let answer = scalar.collide(tree_a, tree_b, pose);
    for isa in Isa::available() {
        assert_eq!(Query::new(isa).collide(tree_a, tree_b, pose), answer, "{isa}");
    }
    if surfaces.hit().is_some() {
        seen.touching += 1;
        assert_eq!(answer, surfaces, "surfaces that meet are all there is to it");
        return;
    }
    let moved: Vec<Point> = a.body.mesh.vertices.iter().map(|p| pose.apply(*p)).collect();
    let mut in_b = vec![false; a.body.parts()];
    if tree_b.view().is_solid() {
        let corners: Vec<_> = a.body.corners(rng).into_iter().map(|p| pose.apply(p)).collect();
        in_b = parts_inside(&corners, &b.body.mesh.corners(), rng, seen);
    }
    let mut in_a = vec![false; b.body.parts()];
    if tree_a.view().is_solid() {
        let placed: Vec<Triangle> =
            a.body.mesh.triangles.iter().map(|t| t.map(|v| moved[v as usize])).collect();
        in_a = parts_inside(&b.body.corners(rng), &placed, rng, seen);
    }
    let is_inside = in_b.contains(&true) || in_a.contains(&true);
    *(if is_inside { &mut seen.inside } else { &mut seen.apart }) += 1;
    match answer.verdict {
        Verdict::Hit(pair) => {
            assert!(is_inside, "{pose:?}");
            let (part_a, part_b) = (a.body.part_of[pair.a as usize], b.body.part_of[pair.b as usize]);
            assert!(in_b[part_a] || in_a[part_b], "{pair:?} names a part that is inside");
        }
        verdict => assert!(!is_inside && verdict == Verdict::Free, "{verdict:?} {pose:?}"),
    }
    assert_eq!(answer.hint, surfaces.hint);
    let (more, less) = (answer.stats, surfaces.stats);
    assert!(more.visits >= less.visits && more.primitive_pairs >= less.primitive_pairs);
    if rng.below(8) == 0 {
        check_distances(a, b, (tree_a, tree_b), pose, (&answer, rng));
    }
}

fn check_distances<N: Lanes>(
    a: &StaticBvh<N>,
    b: &StaticBvh<N>,
    (tree_a, tree_b): (&Bvh<N>, &Bvh<N>),
    pose: &Pose,
    (answer, rng): (&Answer, &mut Rng),
) {
    let query = Query::new(Isa::detect());
    let is_hit = answer.hit().is_some();
    let surfaces = query.distance(&a.surface, &b.surface, pose, 0.0).unwrap();
    let distance = query.distance(tree_a, tree_b, pose, 0.0).unwrap();
    assert_eq!(distance.hint, surfaces.hint);
    if is_hit {
        assert_eq!((distance.lower, distance.upper, distance.completion), (0.0, 0.0, Completion::Complete));
        let witness = distance.witness.unwrap();
        assert_eq!((distance.verdict(), witness.a), (Verdict::Hit(answer.hit().unwrap()), witness.b));
    } else {
        assert_eq!((distance.lower, distance.upper), (surfaces.lower, surfaces.upper));
        assert_eq!((distance.witness, distance.verdict()), (surfaces.witness, Verdict::Free));
    }
    let near = query.distance_up_to(tree_a, tree_b, pose, 0.0, 0.5 * surfaces.lower).unwrap();
    assert_eq!(near.verdict().hit().is_some(), is_hit);
    for margin in [0.0, 0.5 * surfaces.lower, 2.0 * surfaces.upper] {
        let within = query.within(tree_a, tree_b, pose, margin).unwrap();
        assert_eq!(within.hit().is_some(), is_hit || margin > surfaces.upper, "{margin}");
        assert_eq!(within.is_free(), within.hit().is_none());
    }
    // With a budget: never falsely free, and bounds that hold.
    let budget = rng.below(answer.stats.visits + 1);
    let asked = query.with_budget(budget);
    let part = asked.collide(tree_a, tree_b, pose);
    assert!(part.stats.visits <= budget);
    match part.verdict {
        Verdict::Unknown { lower, upper } => {
            assert_eq!(lower, 0.0);
            assert!(is_hit || upper >= surfaces.lower, "{upper} {surfaces:?}");
        }
        verdict => assert_eq!(verdict, answer.verdict),
    }
    let part = asked.distance(tree_a, tree_b, pose, 0.0).unwrap();
    assert!(part.stats.visits <= budget);
    assert!(part.lower == 0.0 || !is_hit && part.lower <= surfaces.upper, "{part:?}");
    assert!(!is_hit || !part.verdict().is_free());
    let part = asked.within(tree_a, tree_b, pose, 0.5 * surfaces.lower).unwrap();
    assert!(!is_hit || !part.is_free());
    if let Verdict::Unknown { lower, .. } = part.verdict {
        assert!(lower == 0.0 || !is_hit);
    }
}

/// A rotation about the grid's axes, or a random one, and a shift along the grid, or a random one.
fn placement(rng: &mut Rng, reach: f64, scale: f64, shift: Point) -> Pose {
    let (is_on_grid, is_along_axes) = (rng.below(3) > 0, rng.below(2) > 0);
    let turn = loop {
        let turn = rotation(rng);
        if !is_along_axes || turn.as_flattened().iter().all(|x| x.fract() == 0.0) {
            break turn;
        }
    };
    let step = *rng.pick(&[0.5, 2.0]);
    let mut along = || {
        let x = rng.range(-1.0, 1.0) * reach;
        if is_on_grid { (x / step).round() * step } else { x }
    };
    // Both bodies are at `shift`, which the rotation must not move.
    let t = core::array::from_fn(|i| {
        let turned: f64 = (0..3).map(|j| turn[i][j] * shift[j]).sum();
        (shift[i] - turned) + along() * scale
    });
    pose(&turn, t)
}

fn random_placements<N: Lanes>(seed: u64, count: usize) {
    let (solids, small) = (solids(), small_ones());
    let (mut rng, mut seen) = (Rng::new(seed), Seen::default());
    for round in 0..count.div_ceil(100) {
        // In any unit and far from the origin: there the corners are no longer on the grid.
        let (scale, shift) = match round % 4 {
            0..2 => (1.0, [0.0; 3]),
            2 => (0.25, [1000.0, -500.0, 4.0]),
            _ => (2_f64.powi(rng.int(-60, 60) as i32), [0.0; 3]),
        };
        let builder = Builder::new().leaf_size(1 + rng.below(3) as u32);
        let one = rng.pick(&solids).scaled(scale, shift);
        let other = if rng.below(4) == 0 { rng.pick(&solids) } else { rng.pick(&small) };
        let other = other.scaled(scale * [1.0, 0.5, 1.0 / 3.0][rng.below(3) as usize], shift);
        let (one, other) = (StaticBvh::<N>::new(&one, builder), StaticBvh::<N>::new(&other, builder));
        for _ in 0..100.min(count) {
            let pose = placement(&mut rng, 9.0, scale, shift);
            if rng.below(2) == 0 {
                check(&one, &other, &pose, &mut rng, &mut seen);
            } else {
                check(&other, &one, &pose, &mut rng, &mut seen);
            }
        }
    }
    println!("{seen:?}");
    if count > 1000 {
        for kind in [seen.apart, seen.touching, seen.inside, 10 * seen.ties] {
            assert!(kind > count / 10, "{seen:?}");
        }
    }
}

/// Most of the placements, at k = 18 and arity 16.
#[test]
fn what_is_inside_of_a_solid_is_a_hit() {
    random_placements::<Node16<18>>(2, if cfg!(miri) { 20 } else { 80_000 / suite_step() / emulator_step() });
}

#[test]
fn so_it_is_for_other_node_types() {
    let count = if cfg!(miri) { 4 } else { 8_000 / suite_step() };
    #[cfg(simdop_all_nodes)]
    {
        random_placements::<Node16<6>>(3, count);
        random_placements::<Node16<32>>(4, count);
    }
    random_placements::<HalfNode>(4, count);
    random_placements::<Node4<14>>(5, count);
}

// ---- Spheres ----------------------------------------------------------------------------------------------

#[test]
fn spheres_in_a_solid_are_hits() {
    let (mut rng, mut seen) = (Rng::new(6), Seen::default());
    let solids: Vec<_> =
        solids().iter().map(|body| StaticBvh::<Node16<18>>::new(body, Builder::new())).collect();
    let queries: Vec<_> = Isa::available().map(Query::new).collect();
    let rounds = if cfg!(miri) { 3 } else { 4000 / suite_step() };
    for _ in 0..rounds {
        let radius = *rng.pick(&[0.0, 0.25, 0.5]);
        let count = 1 + rng.below(3);
        let spheres: Vec<Sphere> = (0..count)
            .map(|_| Sphere { centre: [(); 3].map(|()| rng.int(-18, 18) as f64 * 0.5 + 0.125), radius })
            .collect();
        // Marking them as solid changes nothing.
        let set = SphereSet { spheres: &spheres };
        let build = |builder: Builder| -> Bvh<Node16<18>, Spheres> {
            builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap()
        };
        let tree = build(Builder::new().solid());
        assert_eq!(tree.as_bytes(), build(Builder::new()).as_bytes());
        assert!(!tree.view().is_solid() && tree.view().parts().eq(0..count as u32));
        let body = rng.pick(&solids);
        let Some(solid) = &body.solid else { panic!("all of them are closed") };
        let pose = placement(&mut rng, 3.0, 1.0, [0.0; 3]);
        let is_first = rng.below(2) == 0;
        let ask = |query: &Query, mesh: &Bvh<Node16<18>>| {
            if is_first { query.collide(&tree, mesh, &pose) } else { query.collide(mesh, &tree, &pose) }
        };
        let (surface, answer) = (ask(&queries[0], &body.surface), ask(&queries[0], solid));
        assert!(queries.iter().all(|query| ask(query, solid) == answer));
        if surface.hit().is_some() {
            assert_eq!(answer, surface);
            seen.touching += 1;
            continue;
        }
        let corners = body.body.mesh.corners();
        let is_in = |sphere: &Sphere, rng: &mut Rng| {
            if is_first {
                winding(&pose.apply(sphere.centre), &corners, rng) != 0
            } else {
                let placed: Vec<Triangle> = corners.iter().map(|t| t.map(|p| pose.apply(p))).collect();
                winding(&sphere.centre, &placed, rng) != 0
            }
        };
        let inside: Vec<bool> = spheres.iter().map(|sphere| is_in(sphere, &mut rng)).collect();
        match answer.hit() {
            Some(pair) => {
                seen.inside += 1;
                assert!(inside[if is_first { pair.a } else { pair.b } as usize], "{pair:?}");
            }
            None => {
                seen.apart += 1;
                assert!(answer.is_free() && !inside.contains(&true), "{spheres:?} {pose:?}");
            }
        }
    }
    assert!(
        rounds < 500 || [seen.apart, seen.touching, seen.inside].iter().all(|&n| n > rounds / 20),
        "{seen:?}"
    );
}

/// The reported pair has the lowest index in the source mesh, for every tree.
#[test]
fn the_crossed_triangle_of_the_lowest_index_is_named() {
    let mut solid = squares([-8.0; 3], 4, false);
    append(&mut solid, &squares([-4.0; 3], 2, false));
    let dot = separate([[[0.5, 1.0, 2.0]; 3]]);
    let dot = Builder::new().build(&mesh_of(&dot)).unwrap();
    for leaf_size in [1, 4] {
        for shift in 0..5 {
            let mut mesh = solid.clone();
            mesh.triangles.rotate_left(shift * 37);
            let tree: Bvh<Node16<18>> =
                Builder::new().leaf_size(leaf_size).solid().build_as(&mesh_of(&mesh)).unwrap();
            // At x = 4 and at x = 8.
            let is_crossed = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
                let side =
                    |p: Point, q: Point| (q[1] - p[1]) * (2.0 - p[2]) - (q[2] - p[2]) * (1.0 - p[1]) > 0.0;
                [4.0, 8.0].contains(&a[0])
                    && a[0] == b[0]
                    && a[0] == c[0]
                    && side(a, b)
                    && side(b, c)
                    && side(c, a)
            };
            let want = mesh.triangles.iter().position(is_crossed).unwrap() as u32;
            let query = Query::new(Isa::detect());
            let pair = query.collide(&dot, &tree, &Pose::IDENTITY).hit().unwrap();
            assert_eq!((pair.a, pair.b), (0, want));
            let pair = query.collide(&tree, &dot, &Pose::IDENTITY).hit().unwrap();
            assert_eq!((pair.a, pair.b), (want, 0));
        }
    }
}

// ---- Baking -----------------------------------------------------------------------------------------------

#[test]
fn open_meshes_are_refused_where_they_are_open() {
    let closed = cuboid([0.0; 3], [1.0; 3], false);
    let build = |mesh: &MeshData| Builder::new().solid().build(&mesh_of(mesh)).map(|_| ());
    let edges = |t: [u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    for index in 0..12 {
        let gone = closed.triangles[index];
        let (mut open, mut turned, mut double) = (closed.clone(), closed.clone(), closed.clone());
        open.triangles.remove(index);
        turned.triangles[index].swap(0, 1);
        double.triangles.push(gone);
        for (mesh, counts) in [(&open, [1, 0]), (&turned, [2, 0]), (&double, [2, 1])] {
            for mesh in [mesh, &torn(mesh)] {
                let error = build(mesh).unwrap_err();
                let BuildError::Open { edge, corners, forward, backward } = error else { panic!("{error}") };
                assert_eq!(corners, edge.map(|v| mesh.vertices[v as usize]));
                let found = edges(gone).map(|e| e.map(|v| closed.vertices[v as usize]));
                assert!(found.contains(&corners) || found.contains(&[corners[1], corners[0]]));
                let (most, least) = (forward.max(backward), forward.min(backward));
                assert_eq!([most, least], counts);
                let text = error.to_string();
                assert!(
                    text.contains("open") && text.contains(&format!("vertices {} and {}", edge[0], edge[1]))
                );
            }
            assert!(Builder::new().build(&mesh_of(mesh)).is_ok(), "surfaces may be open");
        }
        assert_eq!(build(&torn(&closed)), Ok(()));
    }
    let empty = Builder::new().solid().build(&Mesh { vertices: &[], triangles: &[] }).unwrap();
    let cube: Bvh<Node16<18>> = Builder::new().solid().build_as(&mesh_of(&closed)).unwrap();
    assert_eq!(empty.view().parts().len(), 0);
    assert!(Query::new(Isa::detect()).collide(&empty, &cube, &Pose::IDENTITY).is_free());
    assert!(Query::new(Isa::detect()).collide(&cube, &empty, &Pose::IDENTITY).is_free());
}

#[test]
fn every_tree_knows_its_parts() {
    for body in solids().iter().chain(&small_ones()) {
        for builder in [Builder::new(), Builder::new().leaf_size(5), Builder::fast()] {
            let tree: Bvh<Node16<18>> = body.build(builder);
            let view = tree.view();
            let parts: Vec<u32> = view.parts().collect();
            assert!(parts.is_sorted() && parts.len() == body.parts());
            let mut found: Vec<_> = parts.iter().map(|&p| body.part_of[view.source(p) as usize]).collect();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..body.parts()), "one of each");
            assert_eq!((view.stats().parts, view.is_solid()), (body.parts(), false));
            let one_part = view.header().part_count == 0;
            assert_eq!(one_part, body.parts() == 1);
            let again = Bvh::<Node16<18>>::from_bytes(tree.as_bytes()).unwrap();
            assert!(again.view().parts().eq(parts) && again.as_bytes() == tree.as_bytes());
        }
        if is_closed(body) {
            let [solid, surface] =
                [Builder::new().solid(), Builder::new()].map(|b| body.build::<Node16<18>>(b));
            assert!(solid.view().is_solid() && solid.view().header().is_solid == 1);
            let at = offset_of!(Header, is_solid);
            let mut bytes = solid.as_bytes().to_vec();
            bytes[at] = 0;
            assert_eq!(bytes, surface.as_bytes(), "nothing else is different");
        }
    }
}

/// Whatever the bytes, a tree is rejected or safe.
#[test]
fn solids_from_outside_are_safe() {
    let mut rng = Rng::new(7);
    let cube = cuboid([-1.0; 3], [1.0; 3], false);
    let parts: Vec<MeshData> = (0..5).map(|i| scaled(&cube, 1.0, [4.0 * f64::from(i), 0.0, 0.0])).collect();
    let tree: Bvh<Node16<18>> = Body::new(&parts).build(Builder::new().solid());
    let other: Bvh<Node16<18>> =
        Body::new(&[octahedron(0.25, [0.25; 3]), octahedron(0.25, [4.25, 0.0, 0.0])])
            .build(Builder::new().solid());
    let header = *tree.view().header();
    let bytes = tree.as_bytes();
    let section = (bytes.len() - 64..bytes.len()).rev().find(|&i| bytes[i] != 0).unwrap() / 4 * 4 - 16;
    let read: Vec<u32> =
        bytes[section..section + 20].chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(read.iter().copied().eq(tree.view().parts()), "{read:?}");
    let at = [offset_of!(Header, is_solid), offset_of!(Header, part_count)];
    assert_eq!((at, header.part_count), ([114, 116], 5));
    let places: Vec<usize> = (at[0]..128).chain(section..section + 20).collect();
    let (mut refused, mut accepted) = (0, 0);
    let mut offer = |bytes: &[u8]| {
        let lines = aligned(bytes);
        let bytes = &bytemuck::cast_slice::<_, u8>(&lines)[..bytes.len()];
        match BvhRef::<Node16<18>>::from_bytes(bytes) {
            Err(_) => refused += 1,
            Ok(view) => {
                accepted += 1;
                let query = Query::new(Isa::detect());
                for x in [0.0, 4.0, 30.0] {
                    let pose = pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [x, 0.0, 0.0]);
                    let _ = (query.collide(&view, &other, &pose), query.collide(&other, &view, &pose));
                    let _ = query.distance(&view, &other, &pose, 0.0).unwrap();
                }
            }
        }
    };
    for &place in &places {
        for step in if cfg!(miri) { vec![1, 255] } else { (1..=255).collect() } {
            let mut bytes = bytes.to_vec();
            bytes[place] = bytes[place].wrapping_add(step);
            offer(&bytes);
        }
    }
    for _ in 0..if cfg!(miri) { 10 } else { 2000 } {
        let mut bytes = bytes.to_vec();
        (0..2).for_each(|_| bytes[*rng.pick(&places)] = rng.u64() as u8);
        offer(&bytes);
    }
    assert!(refused > 0 && accepted > 0);

    let with = |change: &dyn Fn(&mut [u8])| {
        let mut bytes = bytes.to_vec();
        change(&mut bytes);
        Bvh::<Node16<18>>::from_bytes(&bytes).err()
    };
    assert_eq!(with(&|_| ()), None);
    assert_eq!(with(&|b| b[114] = 2), Some(FormatError::Header { field: "is_solid" }));
    assert_eq!(with(&|b| b[120] = 1), Some(FormatError::OtherStorage { storage: 1 }));
    assert_eq!(with(&|b| b[125] = 1), Some(FormatError::Header { field: "cap_width" }));
    assert_eq!(with(&|b| b[section] = b[section + 4]), Some(FormatError::Part { index: 1 }));
    assert_eq!(with(&|b| b[section + 16] = 60), Some(FormatError::Part { index: 4 }));
    assert_eq!(with(&|b| b[116] = 1), Some(FormatError::Header { field: "part_count" }));
}

/// `verify` does not prove the flag of solids, which the builder sets: bytes without the flag equal the tree of the
/// surface, and give its answers.
#[test]
fn without_the_flag_a_solid_is_its_surface() {
    let cube = Body::new(&[cuboid([-1.0; 3], [1.0; 3], false)]);
    let (solid, surface): (Bvh<Node16<18>>, Bvh<Node16<18>>) =
        (cube.build(Builder::new().solid()), cube.build(Builder::new()));
    let inner: Bvh<Node16<18>> = Body::new(&[octahedron(0.25, [0.1; 3])]).build(Builder::new());
    let mut bytes = solid.as_bytes().to_vec();
    bytes[offset_of!(Header, is_solid)] = 0;
    assert!(bytes == surface.as_bytes(), "the flag is all that differs");
    let flipped = Bvh::<Node16<18>>::from_bytes(&bytes).unwrap();
    assert_eq!(flipped.view().verify(), Ok(()));
    let query = Query::new(Isa::detect());
    assert!(!query.collide(&inner, &solid, &Pose::IDENTITY).is_free());
    assert!(query.collide(&inner, &flipped, &Pose::IDENTITY).is_free());
}
