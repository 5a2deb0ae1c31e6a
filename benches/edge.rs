//! Motions of a planner: does the robot meet anything on its way? `cargo bench --features urdf --bench edge` prints a
//! table.
//!
//! The Panda on every seventh problem of MotionBenchMaker: straight motions in the joints from the start and the goal
//! towards random configurations, of several lengths, as in a planner's tree, and from the start to the goal. The links
//! are meshes, the obstacles boxes and cylinders.
//! *Certified*: `Scene::check_motion`. *Sampled*: the scene at as many times as VAMP uses, 32 per unit of length in the
//! joints.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/robots.rs"]
mod robots;
#[path = "support/short.rs"]
mod short;

use core::num::NonZeroU32;
use data::{MeshData, directory};
use page::show;
use rng::Rng;
use robots::{Problem, SETTINGS};
use short::count;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::motion::{JointMotion, LinkFrame};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use simdop::scene::{Body, BodyId, MotionAnswer, MotionHit, MotionMemory, MotionVerdict, Scene};
use std::path::Path;
use std::time::Instant;

type Tree = Bvh<Node16<18>>;

/// Samples per unit of length in the joints, as in VAMP.
const RESOLUTION: f64 = 32.0;

/// Results for motions of one length.
#[derive(Default)]
struct Row {
    certified: Vec<f64>,
    sampled: Vec<f64>,
    free: usize,
    hits: usize,
    unresolved: usize,
    missed: usize,
    times: u64,
    samples: u64,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The Panda, and the data for its motion queries.
struct Panda {
    robot: Robot,
    /// Pairs of bodies that are tested.
    pairs: Vec<(usize, usize)>,
    links: Vec<Tree>,
}

impl Panda {
    fn read(folder: &Path) -> Self {
        let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
        let robot = Robot::from_urdf(&text("panda.urdf"), LinkShapes::Collision).unwrap();
        let pairs = robot.pairs(&DisabledPair::from_srdf(&text("panda.srdf")).unwrap()).unwrap();
        let tree = |shape: &LinkShape| {
            let LinkShape::Mesh { file, .. } = shape else { panic!("a link of the Panda is a mesh") };
            let mesh = MeshData::obj(&folder.join(file));
            Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
        };
        let links = robot.shapes.iter().map(tree).collect();
        Self { robot, pairs, links }
    }

    /// Among the obstacles of a problem.
    fn scene<'t>(&'t self, problem: &Problem) -> (Scene<'t, Node16<18>>, Vec<BodyId>) {
        let mut scene = Scene::new();
        let insert = |link: &'t Tree| scene.insert(Body::new(link.view()), &Pose::IDENTITY).unwrap();
        let ids: Vec<BodyId> = self.links.iter().map(insert).collect();
        for i in 0..ids.len() {
            for j in i + 1..ids.len() {
                if self.pairs.contains(&(i, j)) {
                    scene.forbid_collision(ids[i], ids[j]).unwrap();
                } else {
                    scene.allow_collision(ids[i], ids[j]).unwrap();
                };
            }
        }
        for obstacle in &problem.obstacles {
            let at = Pose::try_from(obstacle.at).unwrap();
            let _ = scene.insert(Body::new(obstacle.shape.shape()).fixed(), &at).unwrap();
        }
        (scene, ids)
    }
}

/// A scene, and the memory for its motion queries.
struct Asked<'p, 't> {
    panda: &'p Panda,
    scene: Scene<'t, Node16<18>>,
    moving: Vec<BodyId>,
    links: Vec<LinkFrame>,
    values: Vec<f64>,
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
}

impl Asked<'_, '_> {
    /// Times a motion, certified and sampled, and adds it to a row.
    fn ask(&mut self, row: &mut Row, from: &[f64], to: &[f64]) {
        let query = Query::new(Isa::detect());
        let kinematics = self.panda.robot.kinematics().unwrap();
        let length = from.iter().zip(to).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt();
        let parts = NonZeroU32::new((RESOLUTION * length).ceil().max(1.0) as u32).unwrap();
        let mut best = [f64::INFINITY; 2];
        let mut answers: [Option<MotionAnswer>; 2] = [None; 2];
        for _ in 0..count(5, 1) {
            for is_sampled in [false, true] {
                let start = Instant::now();
                let mut motion =
                    JointMotion::new(kinematics, [from, to], &mut self.values, &mut self.links).unwrap();
                let mut memory = MotionMemory { poses: &mut self.poses, waiting: &mut self.waiting };
                let answer = if is_sampled {
                    self.scene.check_motion_discrete(&query, &self.moving, &mut motion, parts, &mut memory)
                } else {
                    self.scene.check_motion(&query, &self.moving, &mut motion, 1e-6, &mut memory)
                };
                let slot = usize::from(is_sampled);
                best[slot] = best[slot].min(start.elapsed().as_secs_f64() * 1e6);
                answers[slot] = Some(answer.unwrap());
            }
        }
        let [certified, sampled] = answers.map(Option::unwrap);
        row.certified.push(best[0]);
        row.sampled.push(best[1]);
        row.times += certified.times;
        row.samples += sampled.times;
        let is_sampled_hit = matches!(sampled.verdict, MotionVerdict::Hit { .. });
        match certified.verdict {
            MotionVerdict::Free => {
                assert!(!is_sampled_hit, "certified free, and a sample is a hit");
                row.free += 1;
            }
            MotionVerdict::Hit { .. } => {
                row.hits += 1;
                row.missed += usize::from(!is_sampled_hit);
            }
            MotionVerdict::Unresolved { .. } => row.unresolved += 1,
        }
    }
}

fn main() {
    page::begin(
        "Edges of a planner",
        "Microseconds an edge of the Panda, forward kinematics included, the least of five runs. *Certified*: \
         `Scene::check_motion`. *Sampled*: 32 samples per unit of length. *Missed*: hits that no sample finds. \
         *Times*: placements of the robot.",
    );
    let Some(data) = directory() else { return };
    let panda = Panda::read(&data.join("robots/panda"));
    let mut rng = Rng::new(16);
    let mut rows = ["0.1", "0.3", "1", "start to goal"].map(|name| (name, Row::default()));
    let setting = &SETTINGS[0];
    for problem in setting.problems(&data, &setting.robot(&data), count(7, 70)) {
        let (scene, moving) = panda.scene(&problem);
        let variables = &panda.robot.variables;
        let ends: [Vec<f64>; 2] = problem
            .ends
            .each_ref()
            .map(|end| variables.iter().map(|name| end.get(name).copied().unwrap_or(0.0)).collect());
        let mut asked = Asked {
            panda: &panda,
            scene,
            links: vec![LinkFrame::EMPTY; panda.robot.joints.len() + 1],
            values: vec![0.0; variables.len()],
            poses: vec![Pose::IDENTITY; 2 * moving.len()],
            waiting: vec![MotionHit::EMPTY; 8192],
            moving,
        };
        for end in &ends {
            for (row, length) in rows.iter_mut().zip([0.1, 0.3, 1.0]) {
                for _ in 0..5 {
                    let to = towards(&mut rng, &panda.robot.limits, end, length);
                    asked.ask(&mut row.1, end, &to);
                }
            }
        }
        asked.ask(&mut rows[3].1, &ends[0], &ends[1]);
    }
    print(&mut rows);
    page::write();
}

fn print(rows: &mut [(&str, Row)]) {
    show!(
        "| length, rad | free | hits | unresolved | missed | certified, median / mean | sampled, median / mean | \
         times, certified / sampled |"
    );
    show!("|---|--:|--:|--:|--:|--:|--:|--:|");
    for (name, row) in rows {
        let edges = row.certified.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / edges;
        let means = [mean(&row.certified), mean(&row.sampled)];
        show!(
            "| {name} | {} | {} | {} | {} | {:.2} / {:.2} | {:.2} / {:.2} | {:.1} / {:.1} |",
            row.free,
            row.hits,
            row.unresolved,
            row.missed,
            median(&mut row.certified),
            means[0],
            median(&mut row.sampled),
            means[1],
            row.times as f64 / edges,
            row.samples as f64 / edges,
        );
    }
}

/// A configuration within the limits, in a random direction from another, at this distance in the joints.
fn towards(rng: &mut Rng, limits: &[[f64; 2]], from: &[f64], length: f64) -> Vec<f64> {
    let target: Vec<f64> = limits.iter().map(|[low, high]| rng.range(*low, *high)).collect();
    let whole = from.iter().zip(&target).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt();
    from.iter().zip(&target).map(|(p, q)| p + (q - p) * (length / whole).min(1.0)).collect()
}
