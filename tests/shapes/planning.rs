//! The Panda and the UR5 among the obstacles of planning problems, which are boxes and cylinders: the pairs that a
//! scene finds are those found by testing every triangle against every obstacle in the world, and those found with fine
//! prisms, within their error.

#[path = "../../benches/support/robots.rs"]
mod robots;

use crate::support::data::{self, MeshData, directory, emulator_step, suite_step};
use crate::support::rng;
use robots::{Obstacle, Problem, SETTINGS, Setting};
use simdop::construct::{Builder, Mesh, OwnedMesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::primitive::shape::{Core, meets, separation};
use simdop::query::Query;
use simdop::scene::{Body, BodyId, BodyTree, Scene};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

type Tree = Bvh<Node16<18>>;

/// Maximum error of the fine prisms, relative to the radius.
const ERROR: f64 = 1e-6;
/// Scenes round the poses of bodies in each other's frames, and count bodies this near as a hit.
const ROUNDING: f64 = 1e-12;

/// Pairs of a link and an obstacle.
#[derive(Default)]
struct Counts {
    hits: usize,
    frees: usize,
    /// Pairs that only prisms meet.
    of_prisms: usize,
}

/// The bodies' indices in the pairs of a link and an obstacle.
type Pairs = BTreeSet<(usize, usize)>;

/// A scene of links and obstacles in which no link is tested against another.
struct World<'t> {
    scene: Scene<'t, Node16<18>>,
    links: Vec<BodyId>,
    obstacles: Vec<BodyId>,
}

impl<'t> World<'t> {
    fn new(links: &'t [Tree], obstacles: &[(BodyTree<'t, Node16<18>>, Pose)]) -> Self {
        let mut scene = Scene::new();
        let mut insert = |body: Body<'t, Node16<18>>, at: &Pose| scene.insert(body, at).unwrap();
        let ids: Vec<BodyId> =
            links.iter().map(|link| insert(Body::new(link.view()), &Pose::IDENTITY)).collect();
        let obstacles =
            obstacles.iter().map(|(tree, at)| insert(Body::new(tree.clone()).fixed(), at)).collect();
        for i in 0..ids.len() {
            for j in 0..i {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            }
        }
        Self { scene, links: ids, obstacles }
    }

    fn hits(&mut self, at: &[Pose]) -> Pairs {
        for (id, pose) in self.links.iter().zip(at) {
            self.scene.place(*id, pose).unwrap();
        }
        let mut found = Pairs::new();
        let index = |ids: &[BodyId], hit: [BodyId; 2]| ids.iter().position(|id| hit.contains(id)).unwrap();
        let (links, obstacles) = (&self.links, &self.obstacles);
        let visit = |hit: simdop::scene::SceneHit| {
            let hit = [hit.a, hit.b];
            assert!(found.insert((index(links, hit), index(obstacles, hit))), "each pair once");
            ControlFlow::Continue(())
        };
        let _ = self.scene.for_each_hit(&Query::new(Isa::detect()), 0.0, visit).unwrap();
        found
    }
}

/// The triangles of a link, and a ball around it.
struct Link {
    corners: Vec<[[f64; 3]; 3]>,
    centre: [f64; 3],
    radius: f64,
}

impl Link {
    fn new(mesh: &MeshData) -> Self {
        Self { corners: mesh.corners(), centre: mesh.centre(), radius: 0.5 * mesh.diagonal() * (1.0 + 1e-9) }
    }

    fn triangles(&self, at: &Pose) -> impl Iterator<Item = Shape> {
        self.corners
            .iter()
            .map(|corners| Shape::new(Core::Triangle(corners.map(|p| at.apply(p))), 0.0).unwrap())
    }

    fn meets(&self, at: &Pose, obstacle: &Shape) -> bool {
        let around = Shape::new(Core::Point(at.apply(self.centre)), self.radius).unwrap();
        meets(&around, obstacle) && self.triangles(at).any(|triangle| meets(&triangle, obstacle))
    }

    /// An upper bound of the distance, within 1e-9.
    fn distance(&self, at: &Pose, obstacle: &Shape) -> f64 {
        let upper = |triangle| separation(&triangle, obstacle, f64::INFINITY, 1e-9).unwrap().upper;
        self.triangles(at).map(upper).fold(f64::INFINITY, f64::min)
    }
}

fn prism(obstacle: &Obstacle) -> OwnedMesh {
    match obstacle.shape {
        robots::Shape::Cuboid(sides) => OwnedMesh::cuboid(sides),
        robots::Shape::Cylinder { radius, height } => OwnedMesh::cylinder(radius, height, ERROR * radius),
    }
    .unwrap()
}

fn check(problem: &Problem, links: &[Link], trees: &[Tree], counts: &mut Counts) {
    let at: Vec<Pose> = problem.obstacles.iter().map(|o| Pose::try_from(o.at).unwrap()).collect();
    let shapes: Vec<Shape> = problem.obstacles.iter().map(|o| o.shape.shape()).collect();
    let in_world: Vec<Shape> = shapes.iter().zip(&at).map(|(shape, at)| shape.moved(at)).collect();
    let solid = |obstacle| Builder::new().solid().build_as(&prism(obstacle).as_mesh()).unwrap();
    let prisms: Vec<Tree> = problem.obstacles.iter().map(solid).collect();
    let of_shapes: Vec<_> =
        shapes.iter().map(|shape| BodyTree::from(*shape)).zip(at.iter().copied()).collect();
    let of_prisms: Vec<_> =
        prisms.iter().map(|tree| BodyTree::from(tree.view())).zip(at.iter().copied()).collect();
    let (mut round, mut fine) = (World::new(trees, &of_shapes), World::new(trees, &of_prisms));
    for poses in &problem.poses {
        let poses: Vec<Pose> = poses.iter().map(|pose| Pose::try_from(*pose).unwrap()).collect();
        let (found, near) = (round.hits(&poses), fine.hits(&poses));
        for (i, link) in links.iter().enumerate() {
            for (j, obstacle) in in_world.iter().enumerate() {
                let is_hit = found.contains(&(i, j));
                if link.meets(&poses[i], obstacle) {
                    assert!(is_hit, "missed: link {i}, obstacle {j}");
                } else if is_hit {
                    assert!(link.distance(&poses[i], obstacle) < ROUNDING, "link {i}, obstacle {j}");
                }
                *(if is_hit { &mut counts.hits } else { &mut counts.frees }) += 1;
                let is_near = near.contains(&(i, j));
                assert!(is_near || !is_hit, "a prism contains its cylinder: link {i}, obstacle {j}");
                if is_near && !is_hit {
                    counts.of_prisms += 1;
                    let robots::Shape::Cylinder { radius, .. } = problem.obstacles[j].shape else {
                        assert!(link.distance(&poses[i], obstacle) < ROUNDING, "link {i}, box {j}");
                        continue;
                    };
                    let distance = link.distance(&poses[i], obstacle);
                    assert!(distance <= ERROR * radius + ROUNDING, "link {i}, obstacle {j}: {distance}");
                }
            }
        }
    }
}

fn among_obstacles(setting: &Setting, step: usize) {
    let Some(data) = directory() else { return };
    let robot = setting.robot(&data);
    let tree = |mesh: &MeshData| {
        Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
    };
    let trees: Vec<Tree> = robot.links.iter().map(|link| tree(&link.mesh)).collect();
    let links: Vec<Link> = robot.links.iter().map(|link| Link::new(&link.mesh)).collect();
    let mut counts = Counts::default();
    for problem in setting.problems(&data, &robot, step) {
        check(&problem, &links, &trees, &mut counts);
    }
    assert!(
        counts.hits > 40 / suite_step() && counts.frees > 1000 / suite_step(),
        "{} {}",
        counts.hits,
        counts.frees
    );
    // An error of a ten-thousandth of a millimetre hardly ever changes a verdict.
    assert!(counts.of_prisms < 3, "{}", counts.of_prisms);
}

#[test]
fn the_panda_meets_what_its_triangles_meet() {
    among_obstacles(&SETTINGS[0], 20 * suite_step());
}

#[test]
fn the_ur5_meets_what_its_triangles_meet() {
    among_obstacles(&SETTINGS[2], 20 * suite_step() * emulator_step());
}
