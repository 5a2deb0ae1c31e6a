//! Each bound against `f64` kinematics, closed forms, or the scene.

use super::apart;
use super::blocks::all_lanes;
use super::bodies::ScreenedScene;
use super::chain::{LaneChain, LaneFrame};
use super::grid::{ClearanceGrid, GridSize};
use super::lanes::{LANES, mask};
use super::links::LinkSpheres;
use super::robot::RobotBounds;
use super::rows::RowShape;
use super::standing::Standing;
use super::whole::Screen;
use crate::construct::{Builder, OwnedMesh};
use crate::isa::Isa;
use crate::motion::{Joint, JointKind, Kinematics, LinkBody, LinkFrame};
use crate::planning::{LinkGeometry, PlanningNode};
use crate::pose::Pose;
use crate::primitive::shape::{Core, Shape, separation};
use crate::query::Query;
use crate::random::SplitMix64;
use crate::range::Point;
use crate::scene::{Body, Scene};
use crate::vector::{difference, length, sqrt};
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use glam::{DQuat, DVec3};

fn share(random: &mut SplitMix64) -> f64 {
    random.bits() as f64 / 2.0_f64.powi(64)
}

fn within(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low + (high - low) * share(random)
}

fn point(random: &mut SplitMix64, reach: f64) -> Point {
    [(); 3].map(|()| within(random, -reach, reach))
}

fn pose(random: &mut SplitMix64, reach: f64) -> Pose {
    let turn = DQuat::from_euler(
        glam::EulerRot::ZYX,
        within(random, -3.0, 3.0),
        within(random, -3.0, 3.0),
        within(random, -3.0, 3.0),
    );
    Pose::try_from((turn, DVec3::from_array(point(random, reach)))).unwrap()
}

/// Points of links in lanes agree with the scene's kinematics, up to the bound.
#[test]
fn lanes_are_within_their_error() {
    let mut random = SplitMix64(3);
    let (mut worst, mut worst_seen) = (0.0_f64, 0.0_f64);
    for round in 0..60 {
        let joint = |i: usize, random: &mut SplitMix64| {
            let kind = if (i + round).is_multiple_of(4) { JointKind::Prismatic } else { JointKind::Revolute };
            let parent = if i > 2 && i.is_multiple_of(5) { i - 2 } else { i };
            let joint = Joint::new(kind, parent as u32, pose(random, 0.4), point(random, 1.0), i as u32);
            joint.unwrap().following(within(random, -2.0, 2.0), within(random, -1.0, 1.0)).unwrap()
        };
        let joints: Vec<Joint> = (0..8).map(|i| joint(i, &mut random)).collect();
        let bodies: Vec<LinkBody> = (0..=8).map(|link| LinkBody { link, at: Pose::IDENTITY }).collect();
        let limits = [[-3.0, 3.0]; 8];
        let base = pose(&mut random, if round % 2 == 0 { 1.0 } else { 50.0 });
        let kinematics = Kinematics::new(&joints, &bodies, &limits).unwrap().with_base(base);
        let chain = LaneChain::new(&kinematics).unwrap();
        let values: Vec<[f64; LANES]> =
            (0..8).map(|_| core::array::from_fn(|_| within(&mut random, -3.0, 3.0))).collect();
        let mut frames = vec![LaneFrame::NOWHERE; 9];
        chain.go_to(&values, &mut frames);
        let (mut links, mut poses) = (vec![LinkFrame::EMPTY; 9], vec![Pose::IDENTITY; 9]);
        for lane in 0..LANES {
            let now: Vec<f64> = values.iter().map(|of| of[lane]).collect();
            kinematics.go_to(&now, &mut links, &mut poses).unwrap();
            for (link, at) in poses.iter().enumerate() {
                for p in [[0.0; 3], point(&mut random, 0.3), point(&mut random, 3.0)] {
                    let on_link = chain.on_link(link, &p);
                    let found = frames[link].apply(&on_link.map(|x| x as f32));
                    let found = [0, 1, 2].map(|i| f64::from(found[i][lane]));
                    let off = length(&difference(&found, &at.apply(p)));
                    let bound = chain.error(link, &on_link);
                    assert!(off <= bound, "link {link}, {p:?}: {off} above {bound}");
                    worst = worst.max(off / bound);
                    // The same point seen from another link.
                    let other = (link + 4) % 9;
                    let seen = frames[link].in_lane(lane).seen_from(&frames[other].in_lane(lane));
                    let single = on_link.map(|x| [x as f32; LANES]);
                    let image = seen.apply(&single).map(|of| f64::from(of[0]));
                    let (rows, origin) = (poses[other].rows(), poses[other].translation());
                    let apart = difference(&found, &origin);
                    let back = [0, 1, 2].map(|i| (0..3).map(|j| rows[j][i] * apart[j]).sum::<f64>());
                    let off = length(&difference(&image, &chain.on_link(other, &back)));
                    let bound = chain.error_seen_from(other, link, &on_link);
                    assert!(off <= bound, "link {link} from {other}, {p:?}: {off} above {bound}");
                    worst_seen = worst_seen.max(off / bound);
                }
            }
        }
    }
    assert!(worst > 0.02 && worst_seen > 0.01, "bounds are far from what occurs: {worst}, {worst_seen}");
}

/// A world of three shapes, and the distance of a point from them in closed form.
struct TwoShapes {
    scene: Scene<'static, PlanningNode>,
    ids: Vec<crate::scene::BodyId>,
    ball: Point,
}

const SIDES: Point = [0.4, 0.3, 0.2];
const BALL: f64 = 0.15;

impl TwoShapes {
    fn new(ball: Point) -> Self {
        let mut scene = Scene::new();
        let at = |p: Point| Pose::IDENTITY.shifted(&p);
        let cuboid = Body::new(Shape::cuboid(SIDES).unwrap()).fixed();
        let sphere = Body::new(Shape::sphere(BALL).unwrap()).fixed();
        let ids =
            vec![scene.insert(cuboid, &at([0.0; 3])).unwrap(), scene.insert(sphere, &at(ball)).unwrap()];
        Self { scene, ids, ball }
    }

    fn distance(&self, p: &Point) -> f64 {
        let outside = [0, 1, 2].map(|i| (p[i].abs() - 0.5 * SIDES[i]).max(0.0));
        length(&outside).min((length(&difference(p, &self.ball)) - BALL).max(0.0))
    }

    fn standing(&self) -> Standing {
        Standing::new(&self.scene, &self.ids, 1e-5, &Query::new(Isa::detect())).unwrap()
    }
}

/// Spheres that the grid reports free are free, and inner spheres that it reports to meet something do; it decides
/// most.
fn attack(grid: &ClearanceGrid, shapes: &TwoShapes, random: &mut SplitMix64) {
    let (decided, hits) = decided_and_hits(grid, shapes, random, 0.12);
    assert!(decided > 40_000 * LANES * 7 / 10 && hits > 10_000, "{decided} {hits}");
}

/// Checks what the grid reports of spheres, of which the inner ones are at most so large, and counts it.
fn decided_and_hits(
    grid: &ClearanceGrid,
    shapes: &TwoShapes,
    random: &mut SplitMix64,
    largest_inner: f64,
) -> (usize, usize) {
    let (mut decided, mut hits) = (0, 0);
    for _ in 0..40_000 {
        let (outer, inner) = (within(random, 0.001, 0.19), within(random, 0.001, largest_inner));
        let points: [Point; LANES] = core::array::from_fn(|_| point(random, 0.75));
        let lanes = [0, 1, 2].map(|i| core::array::from_fn(|lane| points[lane][i] as f32));
        let [free, hit] =
            grid.look_up(&lanes, &all_lanes(grid.radii(outer, inner))).map(|flags| mask(&flags));
        for (lane, point) in points.iter().enumerate() {
            // The query point of the grid, in `f32`.
            let distance = shapes.distance(&point.map(|x| f64::from(x as f32)));
            let (is_free, is_hit) = (free >> lane & 1 == 1, hit >> lane & 1 == 1);
            assert!(!is_free || distance > outer, "{distance} is within {outer}");
            assert!(!is_hit || distance < inner, "{distance} is beyond {inner}");
            decided += usize::from(is_free || is_hit);
            hits += usize::from(is_hit);
        }
    }
    (decided, hits)
}

/// Distances beyond the greatest byte of a cell, with larger inner spheres. No cell is so far away that its box is not
/// divided.
#[test]
fn grids_with_large_inner_spheres_bound_distances() {
    let mut random = SplitMix64(19);
    let size = GridSize { cell: 0.012, outer: 0.5, inner: 0.45 };
    let shapes = TwoShapes::new([0.05; 3]);
    let grid = ClearanceGrid::new(&mut shapes.standing(), [[-0.41; 3], [0.41; 3]], size).unwrap();
    let (decided, _) = decided_and_hits(&grid, &shapes, &mut random, size.inner);
    assert!(decided > 100_000, "{decided}");
}

/// Distances of rows of points from each simple shape are those that the bounds of two shapes say.
#[test]
fn rows_are_as_far_as_shapes() {
    let mut random = SplitMix64(17);
    let (mut apart, mut inside, mut worst) = (0, 0, 0.0_f64);
    for round in 0..4000 {
        let mut size = || within(&mut random, 0.01, 0.5);
        let shape = match round % 4 {
            0 => Shape::sphere(size()),
            1 => Shape::capsule(size(), size()),
            2 => Shape::cuboid([size(), size(), size()]),
            _ => Shape::cylinder(size(), size()),
        };
        let radius = if round % 8 < 4 { 0.0 } else { within(&mut random, 0.0, 0.2) };
        let shape = shape.unwrap().widened(radius).unwrap().moved(&pose(&mut random, 0.3));
        let row = RowShape::new(&shape).unwrap();
        let (from, step) = (point(&mut random, 0.8), within(&mut random, 0.001, 0.1));
        let mut distances = [f64::INFINITY; 16];
        row.lessen(&from, step, &mut distances);
        let error = row.error(&from, 16.0 * step);
        assert!(error < 1e-13, "{error}");
        for (i, &distance) in distances.iter().enumerate() {
            let p = Shape::unchecked(Core::Point([from[0], from[1], from[2] + step * i as f64]), 0.0);
            let found = separation(&p, &shape, f64::INFINITY, 0.0).unwrap();
            let is_close = found.lower <= distance + error && distance <= found.upper + error;
            assert!(is_close, "{shape:?}: {distance}, not {} to {}", found.lower, found.upper);
            (apart, inside) = (apart + usize::from(distance > 0.0), inside + usize::from(distance == 0.0));
            worst = worst.max(distance - found.upper);
        }
    }
    assert!(apart > 20_000 && inside > 1_500 && worst < 1e-14, "{apart} {inside} {worst}");
    assert!(RowShape::new(&Shape::cone(0.1, 0.2).unwrap()).is_none());
}

#[test]
fn grids_bound_distances() {
    let mut random = SplitMix64(5);
    // No sphere meets anything outside.
    let corners = [[-0.68; 3], [0.68; 3]];
    let size = GridSize { cell: 0.02, outer: 0.2, inner: 0.12 };
    let shapes = TwoShapes::new([0.3, 0.2, 0.25]);
    let mut grid = ClearanceGrid::new(&mut shapes.standing(), corners, size).unwrap();
    attack(&grid, &shapes, &mut random);
    // The ball moves, and the cells near both of its places follow.
    let moved = TwoShapes::new([-0.3, 0.25, -0.1]);
    for ball in [shapes.ball, moved.ball] {
        let around = [-BALL, BALL].map(|by| ball.map(|x| x + by));
        grid.update(&mut moved.standing(), &around).unwrap();
    }
    attack(&grid, &moved, &mut random);
}

/// Outer spheres contain the solid, and the solid contains the inner ones.
#[test]
fn covers_hold_links_and_links_hold_inner_spheres() {
    let mesh = OwnedMesh::cylinder(0.06, 0.3, 0.001).unwrap();
    let tree = Builder::new().solid().build_as(&mesh.as_mesh()).unwrap();
    let spheres = LinkSpheres::of(&LinkGeometry::Mesh { tree: Arc::new(tree), hole: None }).unwrap();
    let mut random = SplitMix64(7);
    let side = 0.06 * (1.0 - 0.02); // Every prism about the cylinder contains this.
    let is_inside = |p: &Point| p[0] * p[0] + p[1] * p[1] <= side * side && p[2].abs() <= 0.15;
    for cover in [&spheres.coarse, &spheres.fine, &vec![spheres.whole]] {
        let holds = |p: &Point| cover.iter().any(|s| length(&difference(p, &s.centre)) <= s.outer);
        let mut inside = 0;
        for _ in 0..20_000 {
            let p = [
                within(&mut random, -0.06, 0.06),
                within(&mut random, -0.06, 0.06),
                within(&mut random, -0.15, 0.15),
            ];
            if is_inside(&p) {
                inside += 1;
                assert!(holds(&p), "{p:?}");
            }
        }
        assert!(inside > 10_000);
        for t in &mesh.triangles {
            let [p, q, r] = t.map(|vertex| mesh.vertices[vertex as usize]);
            for _ in 0..50 {
                let (u, v) = (share(&mut random), share(&mut random));
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let on = [0, 1, 2].map(|i| p[i] + u * (q[i] - p[i]) + v * (r[i] - p[i]));
                let near =
                    cover.iter().any(|s| length(&difference(&on, &s.centre)) <= s.outer * (1.0 + 1e-12));
                assert!(near, "{on:?}");
            }
        }
        for s in cover.iter().filter(|s| s.inner > 0.0) {
            let [x, y, z] = s.centre;
            let depth = (0.062 - sqrt(x * x + y * y)).min(0.15 - z.abs());
            assert!(s.inner <= depth + 1e-12, "{s:?} is {depth} deep");
        }
    }
    assert!(spheres.fine.len() > spheres.coarse.len() && spheres.coarse.len() > 1);
    assert!(spheres.fine.iter().filter(|s| s.inner > 0.03).count() > 2);
}

/// Spheres reported apart are apart, and most spheres that are apart are reported so.
#[test]
fn spheres_that_are_called_apart_are() {
    let mut random = SplitMix64(9);
    let (mut said, mut apart) = (0, 0);
    for _ in 0..40_000 {
        let centres = |random: &mut SplitMix64| {
            let points: [Point; LANES] = core::array::from_fn(|_| point(random, 0.5));
            [0, 1, 2].map(|i| core::array::from_fn(|lane| points[lane][i] as f32))
        };
        let (a, b) = (centres(&mut random), centres(&mut random));
        let [r, s] = [(); 2].map(|()| within(&mut random, 0.0, 0.5));
        let radius = |r: f64| [apart::radius(r); LANES];
        let free = mask(&apart::are_apart((&a, &radius(r)), (&b, &radius(s))));
        for lane in 0..LANES {
            let distance = length(&[0, 1, 2].map(|i| f64::from(a[i][lane]) - f64::from(b[i][lane])));
            let is_free = free >> lane & 1 == 1;
            assert!(!is_free || distance > r + s, "{distance}, {r} and {s}");
            (said, apart) = (said + usize::from(is_free), apart + usize::from(distance > r + s));
        }
    }
    assert!(said * 1000 > apart * 999 && apart > 40_000 * LANES / 10, "{said} of {apart}");
}

/// For a link seen from another: spheres that the grid reports free are free of the other link's body, and inner
/// spheres that it reports to meet the body do, at all poses of both.
#[test]
fn links_seen_from_others_keep_their_bounds() {
    let mut random = SplitMix64(13);
    let joint = |i: u32, random: &mut SplitMix64| {
        Joint::new(JointKind::Revolute, i, pose(random, 0.2), point(random, 1.0), i).unwrap()
    };
    let (mut free, mut met, mut all) = (0, 0, 0);
    for round in 0..2 {
        let joints: Vec<Joint> = (0..6).map(|i| joint(i, &mut random)).collect();
        let bodies: Vec<LinkBody> =
            [2, 6].into_iter().map(|link| LinkBody { link, at: pose(&mut random, 0.1) }).collect();
        let limits = [[-3.0, 3.0]; 6];
        let geometry = [SIDES, [0.1, 0.12, 0.14]].map(|sides| {
            let mesh = OwnedMesh::cuboid(sides).unwrap();
            LinkGeometry::of_mesh(&mesh.as_mesh(), 0.0).unwrap()
        });
        let bare = Kinematics::new(&joints, &bodies, &limits).unwrap();
        let bounds = RobotBounds::of(&bare, &geometry, &[(0, 1)]).unwrap();
        let kinematics = bare.with_base(pose(&mut random, if round % 2 == 0 { 1.0 } else { 50.0 }));
        let mut scene: Scene<'static, PlanningNode> = Scene::new();
        let ids: Vec<_> =
            geometry.iter().map(|body| scene.insert(body.body(), &Pose::IDENTITY).unwrap()).collect();
        let query = Query::new(Isa::detect());
        let around = ScreenedScene { scene: &scene, kinematics, links: &ids, objects: &[], query };
        let screen = Screen::new(&around, &Arc::new(bounds), 0.02).unwrap().unwrap();
        assert!(screen.pairs.len() == 1 && screen.pairs[0].seen.len() == 2, "each has a grid");
        let (mut doubts, isa) = (screen.doubts(6), Isa::detect());
        let (mut links, mut poses) = (vec![LinkFrame::EMPTY; 7], vec![Pose::IDENTITY; 2]);
        for _ in 0..700 {
            doubts.values =
                (0..6).map(|_| core::array::from_fn(|_| within(&mut random, -3.0, 3.0))).collect();
            let decided = screen.decide(isa, u16::MAX, &mut doubts);
            for lane in 0..LANES {
                let now: Vec<f64> = doubts.values.iter().map(|of| of[lane]).collect();
                kinematics.go_to(&now, &mut links, &mut poses).unwrap();
                scene.place_all(&ids, &poses).unwrap();
                let does_meet = scene.do_meet(&query, ids[0], ids[1]).unwrap();
                let (is_free, is_hit) = (decided.free >> lane & 1 == 1, decided.hit >> lane & 1 == 1);
                assert!(if does_meet { !is_free } else { !is_hit }, "{now:?}");
                (free, met, all) =
                    (free + usize::from(is_free), met + usize::from(is_hit), all + usize::from(does_meet));
            }
        }
    }
    assert!(free > 2000 && 2 * met > all && met > 500, "{free} free, {met} of {all} met");
}

/// Tables agree with the scene, at random values.
#[test]
fn tables_agree_with_the_scene() {
    const ROUNDS: usize = 6500;
    let about = |axis: Point, parent: u32, at: Point| {
        Joint::new(JointKind::Revolute, parent, Pose::IDENTITY.shifted(&at), axis, parent).unwrap()
    };
    let joints = [
        about([0.0, 1.0, 0.0], 0, [0.0, 0.0, 0.1]),
        about([1.0, 0.0, 0.0], 1, [0.0, 0.0, 0.3]),
        about([0.0, 1.0, 0.0], 2, [0.0, 0.0, 0.3]),
    ];
    let limits = [[-2.8, 2.8]; 3];
    let bodies: Vec<LinkBody> =
        (0..4).map(|link| LinkBody { link, at: Pose::IDENTITY.shifted(&[0.0, 0.0, 0.15]) }).collect();
    let geometry = |i: usize| {
        let mesh = OwnedMesh::cuboid([0.1, 0.08, 0.24 + 0.01 * i as f64]).unwrap();
        LinkGeometry::of_mesh(&mesh.as_mesh(), 0.0).unwrap()
    };
    let geometry: Vec<LinkGeometry> = (0..4).map(geometry).collect();
    let kinematics = Kinematics::new(&joints, &bodies, &limits).unwrap();
    let pairs = [(0, 2), (0, 3), (1, 3)];
    let bounds = RobotBounds::of(&kinematics, &geometry, &pairs).unwrap();
    let query = Query::new(Isa::detect());
    let mut scene: Scene<'static, PlanningNode> = Scene::new();
    let ids: Vec<_> =
        geometry.iter().map(|body| scene.insert(body.body(), &Pose::IDENTITY).unwrap()).collect();
    let (mut links, mut poses) = (vec![LinkFrame::EMPTY; 4], vec![Pose::IDENTITY; 4]);
    let mut random = SplitMix64(11);
    let (mut said, mut met, mut around) = (0, 0, 0);
    for _ in 0..ROUNDS {
        let values: Vec<[f64; LANES]> =
            (0..3).map(|_| core::array::from_fn(|_| within(&mut random, -2.8, 2.8))).collect();
        for &(i, j) in &pairs {
            let table = bounds.tables.get(bounds.tables.find(j, i).unwrap()).unwrap();
            let [free, meet] = table.look_up(&values);
            // A motion by these changes from the values, over half of the time.
            let by: [f64; 3] = [(); 3].map(|()| within(&mut random, -0.8, 0.8));
            let along = table.cells_along([&[0.0; 3], &by]);
            let [free_around, _] = table.look_up_around(&values, &[0.5 * along; LANES]);
            assert_eq!(free_around & !free, 0);
            for lane in 0..LANES {
                let mut now: Vec<f64> = values.iter().map(|of| of[lane]).collect();
                kinematics.go_to(&now, &mut links, &mut poses).unwrap();
                scene.place_all(&ids, &poses).unwrap();
                let does_meet = scene.do_meet(&query, ids[i], ids[j]).unwrap();
                let (says_free, says_meet) = (free >> lane & 1 == 1, meet >> lane & 1 == 1);
                assert!(if does_meet { !says_free } else { !says_meet }, "{i} {j} {now:?}");
                said += usize::from(says_free || says_meet);
                met += usize::from(says_meet);
                if free_around >> lane & 1 == 1 {
                    let share = if random.bits() & 1 == 0 { 0.5 } else { within(&mut random, -0.5, 0.5) };
                    for (value, by) in now.iter_mut().zip(&by) {
                        *value = (*value + share * by).clamp(-2.8, 2.8);
                    }
                    kinematics.go_to(&now, &mut links, &mut poses).unwrap();
                    scene.place_all(&ids, &poses).unwrap();
                    assert!(!scene.do_meet(&query, ids[i], ids[j]).unwrap(), "{i} {j} {now:?}");
                    // Each cell on the way is free.
                    let there: Vec<[f64; LANES]> = now.iter().map(|value| [*value; LANES]).collect();
                    assert_eq!(table.look_up(&there)[0], u16::MAX, "{i} {j} {now:?}");
                    around += 1;
                }
            }
        }
    }
    assert!(said > ROUNDS * 3 * LANES * 8 / 10 && met > 2000, "{said} {met}");
    assert!(around > ROUNDS * 3 * LANES * 4 / 10, "{around}");
}

/// No point of a body moves farther within a span than its bound, relative to any link before it.
#[test]
fn bodies_move_no_farther_than_their_bound() {
    const JOINTS: usize = 6;
    let mut random = SplitMix64(15);
    let (mut worst, mut all) = (0.0_f64, 0);
    for round in 0..40 {
        let joint = |i: usize, random: &mut SplitMix64| {
            let kind = if (i + round).is_multiple_of(5) { JointKind::Prismatic } else { JointKind::Revolute };
            let joint = Joint::new(kind, i as u32, pose(random, 0.3), point(random, 1.0), i as u32).unwrap();
            joint.following(within(random, -1.5, 1.5), within(random, -1.0, 1.0)).unwrap()
        };
        let joints: Vec<Joint> = (0..JOINTS).map(|i| joint(i, &mut random)).collect();
        let bodies: Vec<LinkBody> =
            (0..=JOINTS as u32).map(|link| LinkBody { link, at: pose(&mut random, 0.1) }).collect();
        let limits = [[-3.0, 3.0]; JOINTS];
        let sides = [0.1, 0.2, 0.05];
        let geometry = [(); JOINTS + 1].map(|()| LinkGeometry::Shape(Shape::cuboid(sides).unwrap()));
        let bare = Kinematics::new(&joints, &bodies, &limits).unwrap();
        let bounds = RobotBounds::of(&bare, &geometry, &[]).unwrap();
        let kinematics = bare.with_base(pose(&mut random, if round % 2 == 0 { 1.0 } else { 50.0 }));
        let mut scene: Scene<'static, PlanningNode> = Scene::new();
        let insert = |body: &LinkGeometry| scene.insert(body.body(), &Pose::IDENTITY).unwrap();
        let ids: Vec<_> = geometry.iter().map(insert).collect();
        for i in 0..ids.len() {
            for j in 0..i {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            }
        }
        let query = Query::new(Isa::detect());
        let around = ScreenedScene { scene: &scene, kinematics, links: &ids, objects: &[], query };
        let screen = Screen::new(&around, &Arc::new(bounds), 0.02).unwrap().unwrap();
        let mut doubts = screen.doubts(JOINTS);
        let at = |ends: [&[f64]; 2], time: f64| {
            let now: Vec<f64> = ends[0].iter().zip(ends[1]).map(|(p, q)| p + time * (q - p)).collect();
            let mut poses = vec![Pose::IDENTITY; JOINTS + 1];
            kinematics.go_to(&now, &mut vec![LinkFrame::EMPTY; JOINTS + 1], &mut poses).unwrap();
            poses
        };
        for _ in 0..20 {
            let from: Vec<f64> = (0..JOINTS).map(|_| within(&mut random, -3.0, 3.0)).collect();
            let reach = within(&mut random, 0.01, 2.0);
            let to = from.iter().map(|x| (x + within(&mut random, -reach, reach)).clamp(-3.0, 3.0));
            let to: Vec<f64> = to.collect();
            let ends = [&from[..], &to[..]];
            let _ = screen.start_motion(Isa::detect(), ends, &mut doubts);
            let [first_intervals, _] = Screen::STEPS;
            let _ = first_intervals(&screen, Isa::detect(), &mut doubts);
            for body in 0..=JOINTS {
                // No pair is tested, so it was not placed.
                screen.place(body, &mut doubts);
            }
            // The number of the first interval is the count of intervals.
            let lanes = doubts.motion.intervals[0] as usize;
            for _ in 0..20 {
                let (lane, body) = (random.below(lanes), 1 + random.below(JOINTS));
                let (middle, span) = crate::scene::Interval(doubts.motion.intervals[lane]).middle();
                let share = if random.bits() & 1 == 0 { 1.0 } else { within(&mut random, -1.0, 1.0) };
                let (then, now) = (at(ends, middle), at(ends, middle + share * span));
                // Number of joints, from the body's link on.
                let count = 1 + random.below(body);
                let bound = f64::from(doubts.motion.moved[screen.levers.of(body)][count - 1][lane]);
                let p = sides.map(|side| if random.bits() & 1 == 0 { 0.5 * side } else { -0.5 * side });
                let base = body - count;
                let seen = |poses: &[Pose]| poses[base].inverse().unwrap().apply(poses[body].apply(p));
                let moved = length(&difference(&seen(&then), &seen(&now)));
                assert!(moved <= bound + 1e-9, "{moved} above {bound}");
                (worst, all) = (worst.max(moved / bound), all + usize::from(moved > 0.5 * bound));
            }
        }
    }
    assert!(worst > 0.9 && all > 500, "bounds are far from what occurs: {worst} {all}");
}
