//! The libraries compared, each with a scene for every problem.

use super::{Task, rows};
use crate::data::MeshData;
use crate::driver::{Body as Driven, Driver, Scene as Managed};
use crate::entrants::{loaded, tree};
use crate::robots::{Obstacle, Shape};
use crate::suites::Rows;
use simdop::construct::{Builder, OwnedMesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{Body, BodyId, Scene};
use std::path::Path;
use std::rc::Rc;

/// The form of obstacles in a library. Links are always surfaces.
#[derive(Copy, Clone, PartialEq)]
pub(super) enum Obstacles {
    Surfaces,
    /// A link inside an obstacle is a hit. The peers use boxes, and convex bodies for the prisms.
    Solids,
}

pub(super) const OBSTACLES: [Obstacles; 2] = [Obstacles::Surfaces, Obstacles::Solids];

impl Obstacles {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Surfaces => "surfaces",
            Self::Solids => "solids",
        }
    }
}

/// Whether the links are free at these poses in a problem.
type Decide<'t> = Box<dyn FnMut(usize, &[Rows]) -> bool + 't>;

/// A library with a scene for every problem of a robot.
pub(super) struct Entrant<'t> {
    pub(super) name: String,
    pub(super) version: String,
    pub(super) is_free: Decide<'t>,
}

pub(super) const OURS: &str = "simdop";

/// Peers with managers, each with both of its volumes.
const DRIVERS: [(&str, &str); 6] = [
    ("FCL OBB", "fcl-OBB"),
    ("FCL OBBRSS", "fcl-OBBRSS"),
    ("FCL native OBB", "fcl-native"),
    ("FCL native OBBRSS", "fcl-native-OBBRSS"),
    ("Coal OBB", "coal-OBB"),
    ("Coal OBBRSS", "coal-OBBRSS"),
];

/// All available libraries.
pub(super) fn entrants<'t>(
    task: &'t Task,
    trees: &'t Trees,
    obstacles: Obstacles,
    drivers: &Path,
) -> Vec<Entrant<'t>> {
    let managed = loaded(&DRIVERS, drivers).into_iter();
    let managed = managed.map(|(name, driver)| managed_by(name, &driver, task, obstacles));
    core::iter::once(ours(task, trees, obstacles)).chain(managed).collect()
}

type Node = Node16<18>;

/// simdop's trees.
pub(super) struct Trees {
    links: Vec<Bvh<Node>>,
    /// The trees of each problem's obstacles.
    surfaces: Vec<Vec<Bvh<Node>>>,
    solids: Vec<Vec<Bvh<Node>>>,
}

/// The mesh of an obstacle, about its origin.
fn mesh(obstacle: &Obstacle) -> MeshData {
    let OwnedMesh { vertices, triangles } = obstacle.shape.mesh();
    MeshData { vertices, triangles }
}

impl Trees {
    pub(super) fn new(task: &Task) -> Self {
        let obstacles = |builder: Builder| {
            let build = |obstacle: &Obstacle| tree(builder, &mesh(obstacle));
            task.problems.iter().map(|problem| problem.obstacles.iter().map(build).collect()).collect()
        };
        Self {
            links: task.robot.links.iter().map(|link| tree(Builder::new(), &link.mesh)).collect(),
            surfaces: obstacles(Builder::new()),
            solids: obstacles(Builder::new().solid()),
        }
    }
}

fn ours<'t>(task: &Task, trees: &'t Trees, obstacles: Obstacles) -> Entrant<'t> {
    let pose = |rows: &Rows| Pose::from_rows(*rows).expect("the places are rigid");
    let scene = |problem: usize| -> (Scene<'t, Node>, Vec<BodyId>) {
        let mut scene = Scene::new();
        let mut insert = |body, at: &Pose| scene.insert(body, at).expect("there is room");
        let links: Vec<BodyId> =
            trees.links.iter().map(|link| insert(Body::new(link.view()), &Pose::IDENTITY)).collect();
        let still = match obstacles {
            Obstacles::Surfaces => &trees.surfaces[problem],
            Obstacles::Solids => &trees.solids[problem],
        };
        for (tree, obstacle) in still.iter().zip(&task.problems[problem].obstacles) {
            let _ = insert(Body::new(tree.view()).fixed(), &pose(&rows(&obstacle.at)));
        }
        for i in 0..links.len() {
            for j in i + 1..links.len() {
                let is_asked = task.robot.pairs.contains(&(i, j));
                if is_asked {
                    scene.forbid_collision(links[i], links[j]).expect("both are there")
                } else {
                    scene.allow_collision(links[i], links[j]).expect("both are there")
                };
            }
        }
        (scene, links)
    };
    let mut scenes: Vec<_> = (0..task.problems.len()).map(scene).collect();
    let query = Query::new(Isa::detect());
    Entrant {
        name: OURS.to_owned(),
        version: Isa::detect().name().to_owned(),
        is_free: Box::new(move |problem, places| {
            let (scene, links) = &mut scenes[problem];
            for (link, rows) in links.iter().zip(places) {
                scene.place(*link, &pose(rows)).expect("it is there");
            }
            scene.collide(&query).expect("there is no margin").is_free()
        }),
    }
}

fn managed_by<'t>(name: &str, driver: &Rc<Driver>, task: &'t Task, obstacles: Obstacles) -> Entrant<'t> {
    let robot = &task.robot;
    let links: Vec<Driven> = robot.links.iter().map(|link| Driver::build(driver, &link.mesh)).collect();
    let links = Rc::new(links);
    let pair = |i: usize, j: usize| robot.pairs.contains(&(i.min(j), i.max(j)));
    let asked: Vec<bool> = (0..links.len()).flat_map(|i| (0..links.len()).map(move |j| pair(i, j))).collect();
    let body = |obstacle: &Obstacle| match (obstacles, &obstacle.shape) {
        (Obstacles::Surfaces, _) => Driver::build(driver, &mesh(obstacle)),
        (Obstacles::Solids, Shape::Cuboid(sides)) => Driver::cuboid(driver, sides),
        (Obstacles::Solids, Shape::Cylinder { .. }) => Driver::convex(driver, &mesh(obstacle)),
    };
    let scene = |problem: usize| {
        let still = &task.problems[problem].obstacles;
        let still = still.iter().map(|obstacle| (body(obstacle), rows(&obstacle.at))).collect();
        let first: Vec<Rows> = task.problems[problem].poses[0].iter().map(rows).collect();
        Driver::scene(driver, &links, &first, &asked, still)
    };
    let mut scenes: Vec<Managed> = (0..task.problems.len()).map(scene).collect();
    Entrant {
        name: name.to_owned(),
        version: driver.version(),
        is_free: Box::new(move |problem, places| !scenes[problem].collides(places)),
    }
}
