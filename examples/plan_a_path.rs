//! A small planner: RRT-Connect for an arm with four joints among boxes, with certified motions.
//!
//! ```sh
//! cargo run --release --features urdf --example plan_a_path -- path.svg
//! ```
//!
//! Two trees of configurations grow from the start and from the goal, in turn: one towards a random configuration, the
//! other towards the new node, until they meet (Kuffner and `LaValle`, ICRA 2000). Each step is checked by
//! `Scene::check_motion`, so the path is free at all times, not only at samples. The picture shows the arm along the
//! path, from the side and from above; without an argument it is written beside the program.

#[path = "plan_a_path/picture.rs"]
mod picture;

use core::error::Error;
use simdop::glam::{DAffine3, DVec3};
use simdop::isa::Isa;
use simdop::motion::{JointMotion, Kinematics, LinkFrame};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::robot::{DisabledPair, LinkShapes, Robot};
use simdop::scene::{Body, BodyId, MotionHit, MotionMemory, Scene};
use std::path::Path;
use std::time::{Duration, Instant};

const URDF: &str = include_str!("arm/arm.urdf");
const SRDF: &str = include_str!("arm/arm.srdf");

/// Side lengths and centres: a floor, a rack of two boards with a back, and a post in front of it.
const BOXES: [[[f64; 3]; 2]; 5] = [
    [[1.8, 1.8, 0.1], [0.0, 0.0, -0.08]],
    [[0.4, 0.8, 0.03], [0.65, 0.0, 0.3]],
    [[0.4, 0.8, 0.03], [0.65, 0.0, 0.85]],
    [[0.03, 0.8, 0.9], [0.87, 0.0, 0.42]],
    [[0.1, 0.1, 1.0], [0.35, -0.55, 0.48]],
];
/// Behind the post, and with the hand between the boards.
const ENDS: [Configuration; 2] = [[-2.2, 0.9, 0.9, 0.3], [0.0, 0.3, 1.6, -0.3]];

/// Values of waist, shoulder, elbow and wrist.
type Configuration = [f64; 4];

const PLANS: usize = 10;

/// Maximum length of a step of a tree, in units of the joint values.
const STEP: f64 = 0.5;

fn distance(p: &Configuration, q: &Configuration) -> f64 {
    p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt()
}

/// A tree of configurations, each with the index of its parent.
struct Grown(Vec<(Configuration, usize)>);

impl Grown {
    fn nearest(&self, to: &Configuration) -> usize {
        let nearer =
            |i: &usize, j: &usize| distance(&self.0[*i].0, to).total_cmp(&distance(&self.0[*j].0, to));
        (0..self.0.len()).min_by(nearer).unwrap_or(0)
    }

    /// The configurations from one to the root.
    fn back(&self, mut from: usize) -> Vec<Configuration> {
        let mut path = vec![self.0[from].0];
        while from != 0 {
            from = self.0[from].1;
            path.push(self.0[from].0);
        }
        path
    }
}

/// The arm among the boxes, and the cost of the queries so far.
struct Planner<'t> {
    scene: Scene<'t, Node16<18>>,
    arm: Vec<BodyId>,
    robot: Kinematics<'t>,
    query: Query,
    edges: usize,
    asking: Duration,
}

impl Planner<'_> {
    fn is_free(&mut self, from: &Configuration, to: &Configuration) -> Result<bool, Box<dyn Error>> {
        let start = Instant::now();
        let (mut values, mut links) = ([0.0; 4], [LinkFrame::EMPTY; 5]);
        let (mut poses, mut waiting) = ([Pose::IDENTITY; 16], [MotionHit::EMPTY; 1024]);
        let mut way = JointMotion::new(self.robot, [from, to], &mut values, &mut links)?;
        let mut memory = MotionMemory { poses: &mut poses, waiting: &mut waiting };
        let answer = self.scene.check_motion(&self.query, &self.arm, &mut way, 1e-4, &mut memory)?;
        self.edges += 1;
        self.asking += start.elapsed();
        Ok(answer.is_free())
    }

    /// One step of a tree: the index of the new node if the step is free, and whether it reaches the target.
    fn extend(
        &mut self,
        tree: &mut Grown,
        to: &Configuration,
    ) -> Result<Option<(usize, bool)>, Box<dyn Error>> {
        let nearest = tree.nearest(to);
        let from = tree.0[nearest].0;
        let share = STEP / distance(&from, to);
        let reached = share >= 1.0;
        let next = if reached { *to } else { core::array::from_fn(|i| from[i] + share * (to[i] - from[i])) };
        if !self.is_free(&from, &next)? {
            return Ok(None);
        }
        tree.0.push((next, nearest));
        Ok(Some((tree.0.len() - 1, reached)))
    }

    fn plan(
        &mut self,
        [start, goal]: [Configuration; 2],
        random: &mut impl FnMut() -> f64,
    ) -> Result<Vec<Configuration>, Box<dyn Error>> {
        let (mut tree, mut other, mut is_from_start) =
            (Grown(vec![(start, 0)]), Grown(vec![(goal, 0)]), true);
        for _ in 0..20_000 {
            let limits = self.robot.limits();
            let drawn = core::array::from_fn(|i| limits[i][0] + (limits[i][1] - limits[i][0]) * random());
            if let Some((new, _)) = self.extend(&mut tree, &drawn)? {
                let target = tree.0[new].0;
                while let Some((met, reached)) = self.extend(&mut other, &target)? {
                    if reached {
                        let (mut path, mut rest) = (tree.back(new), other.back(met));
                        if !is_from_start {
                            core::mem::swap(&mut path, &mut rest);
                        }
                        path.reverse();
                        // Both end with the configuration where they met.
                        path.extend(&rest[1..]);
                        return Ok(path);
                    }
                }
            }
            (tree, other, is_from_start) = (other, tree, !is_from_start);
        }
        Err("no path was found".into())
    }

    /// Shortcuts the path: from each configuration straight to the farthest that a free motion reaches.
    fn shorten(&mut self, path: &[Configuration]) -> Result<Vec<Configuration>, Box<dyn Error>> {
        let (mut short, mut at) = (vec![path[0]], 0);
        while at + 1 < path.len() {
            let mut next = path.len() - 1;
            while next > at + 1 && !self.is_free(&path[at], &path[next])? {
                next -= 1;
            }
            short.push(path[next]);
            at = next;
        }
        Ok(short)
    }
}

/// Numbers from 0 to 1, the same in every run: a 64-bit linear congruential generator (Knuth's MMIX).
fn random() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((state >> 32) as u32) / f64::from(u32::MAX)
    }
}

fn length(path: &[Configuration]) -> f64 {
    path.windows(2).map(|ends| distance(&ends[0], &ends[1])).sum()
}

fn run(file: &Path) -> Result<(), Box<dyn Error>> {
    let robot = Robot::from_urdf(URDF, LinkShapes::Collision)?;
    let asked = robot.pairs(&DisabledPair::from_srdf(SRDF)?)?;
    let (mut scene, mut arm) = (Scene::new(), Vec::new());
    for (i, link) in robot.shapes.iter().enumerate() {
        let shape = link.shape().ok_or("the arm has no mesh files")?;
        arm.push(scene.insert(Body::new(shape), &Pose::IDENTITY)?);
        for j in 0..i {
            if asked.contains(&(j, i)) {
                scene.forbid_collision(arm[j], arm[i])?;
            } else {
                scene.allow_collision(arm[j], arm[i])?;
            };
        }
    }
    for [sides, middle] in BOXES {
        let at = Pose::try_from(DAffine3::from_translation(DVec3::from_array(middle)))?;
        let _ = scene.insert(Body::new(Shape::cuboid(sides)?).fixed(), &at)?;
    }

    let (robot_at, query) = (robot.kinematics()?, Query::new(Isa::detect()));
    let mut planner = Planner { scene, arm, robot: robot_at, query, edges: 0, asking: Duration::ZERO };
    for end in &ENDS {
        assert!(planner.is_free(end, end)?, "the arm may stand there: an edge of no length");
    }
    assert!(!planner.is_free(&ENDS[0], &ENDS[1])?, "something is in the straight way");
    let start = Instant::now();
    (planner.edges, planner.asking) = (0, Duration::ZERO);
    // The route depends on chance: take the shortest of several plans.
    let (mut random, mut plans) = (random(), Vec::new());
    for _ in 0..PLANS {
        let found = planner.plan(ENDS, &mut random)?;
        plans.push(planner.shorten(&along(&found, 64))?);
    }
    plans.sort_by(|p, q| length(p).total_cmp(&length(q)));
    let path = &plans[0];
    let (time, asking, edges) = (start.elapsed(), planner.asking, planner.edges);

    assert!(path.first() == Some(&ENDS[0]) && path.last() == Some(&ENDS[1]));
    for ends in path.windows(2) {
        assert!(planner.is_free(&ends[0], &ends[1])?, "the path is certified");
    }
    println!(
        "{} edges, {:.2} rad long in the joints; the longest of {PLANS} plans: {:.2}",
        path.len() - 1,
        length(path),
        length(&plans[PLANS - 1])
    );
    println!(
        "{edges} edges were asked in {:.2} ms: {:.0} % of the planner's time",
        asking.as_secs_f64() * 1e3,
        100.0 * asking.as_secs_f64() / time.as_secs_f64()
    );
    std::fs::write(file, picture::draw(&robot, &BOXES, &along(path, 12))?)?;
    println!("drawn in {}", file.display());
    Ok(())
}

/// Configurations at equal distances along the path, including both ends.
fn along(path: &[Configuration], count: usize) -> Vec<Configuration> {
    let at = |i: usize| {
        let mut left = length(path) * i as f64 / (count - 1) as f64;
        for ends in path.windows(2) {
            let whole = distance(&ends[0], &ends[1]);
            if left <= whole {
                return core::array::from_fn(|i| ends[0][i] + left / whole * (ends[1][i] - ends[0][i]));
            }
            left -= whole;
        }
        path[path.len() - 1]
    };
    // The last one exactly, not as a rounded sum.
    (0..count - 1).map(at).chain(path.last().copied()).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let beside = std::env::current_exe()?.with_file_name("path.svg");
    run(&std::env::args_os().nth(1).map_or(beside, Into::into))
}

#[test]
fn it_runs() {
    run(&std::env::current_exe().unwrap().with_file_name("path.svg")).unwrap();
}
