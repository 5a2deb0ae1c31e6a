//! A checker in the manner of VAMP (Thomason, Kingston, Kavraki: Motions in microseconds via vectorized planning,
//! 2024): links as a few spheres, and sixteen configurations at a time in `f32`, until all of them are hits.
//!
//! As in VAMP, a sphere around each link is tested before the link's spheres, obstacles are sorted by their distance
//! from the base so that most are never read, and upright obstacles have a shorter test. Unlike in VAMP, cylinders are
//! not replaced by capsules, each configuration has its own verdict, and kinematics are not unrolled into straight-line
//! code.

use crate::robots::{Obstacle, Shape};
use glam::{DAffine3, DQuat, DVec3};
use simdop::isa::{Isa, on_isa};
use simdop::low_level::kernel::Kernel;
use simdop::robot::DisabledPair;
use std::collections::BTreeMap;
use std::path::Path;
use urdf_rs::JointType;

pub(crate) const LANES: usize = 16;
type Lane16 = [f32; LANES];
type Point16 = [Lane16; 3];

/// A sphere on a link.
#[derive(Copy, Clone)]
struct Ball {
    centre: [f32; 3],
    radius: f32,
}

struct Joint {
    parent: usize,
    variable: usize,
    multiplier: f32,
    offset: f32,
    is_turning: bool,
    rows: [[f32; 3]; 3],
    at: [f32; 3],
}

struct Link {
    name: String,
    frame: usize,
    whole: Ball,
    balls: Vec<Ball>,
    /// Index of its first sphere among those of all links.
    first: usize,
}

#[derive(Clone)]
struct Frame {
    rows: [Point16; 3],
    at: Point16,
}

/// A robot as spheres.
pub(crate) struct SphereRobot {
    joints: Vec<Joint>,
    links: Vec<Link>,
    pairs: Vec<[usize; 2]>,
    memory: Memory,
}

struct Memory {
    values: Vec<Lane16>,
    frames: Vec<Frame>,
    wholes: Vec<Point16>,
    balls: Vec<Point16>,
    is_placed: Vec<bool>,
}

fn affine(pose: &urdf_rs::Pose) -> DAffine3 {
    let [roll, pitch, yaw] = *pose.rpy;
    let turn = DQuat::from_euler(glam::EulerRot::ZYX, yaw, pitch, roll);
    DAffine3::from_rotation_translation(turn, DVec3::from_array(*pose.xyz))
}

fn single(p: DVec3) -> [f32; 3] {
    p.to_array().map(|x| x as f32)
}

/// A sphere around spheres.
fn around(balls: &[Ball]) -> Ball {
    let side = |i: usize, sign: f32| {
        balls
            .iter()
            .map(|ball| ball.centre[i] + sign * ball.radius)
            .fold(-sign * f32::INFINITY, |most, x| if sign > 0.0 { most.max(x) } else { most.min(x) })
    };
    let centre = [0, 1, 2].map(|i| 0.5 * (side(i, 1.0) + side(i, -1.0)));
    let reach = |ball: &Ball| {
        let away = [0, 1, 2].map(|i| ball.centre[i] - centre[i]);
        away.iter().map(|x| x * x).sum::<f32>().sqrt() + ball.radius
    };
    Ball { centre, radius: balls.iter().map(reach).fold(0.0, f32::max) * (1.0 + 1e-6) }
}

impl SphereRobot {
    /// Reads the URDF file, the SRDF file and the spheres in a folder. `variables`: the order of the values.
    pub(crate) fn read(folder: &Path, name: &str, variables: &[String]) -> Self {
        let text = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
        let urdf = urdf_rs::read_from_string(&text(&format!("{name}.urdf"))).unwrap();
        let root =
            urdf.links.iter().find(|link| urdf.joints.iter().all(|joint| joint.child.link != link.name));
        // For each link: its frame, rotated so that the joint's axis is the third, and its pose in that frame.
        let mut placed = vec![(root.unwrap().name.clone(), 0, DAffine3::IDENTITY)];
        let (mut joints, mut next) = (Vec::new(), 0);
        while let Some((parent, frame, at)) = placed.get(next).cloned() {
            next += 1;
            for joint in urdf.joints.iter().filter(|joint| joint.parent.link == parent) {
                let origin = at * affine(&joint.origin);
                let is_turning = match joint.joint_type {
                    JointType::Revolute | JointType::Continuous => true,
                    JointType::Prismatic => false,
                    _ => {
                        placed.push((joint.child.link.clone(), frame, origin));
                        continue;
                    }
                };
                let turn = DQuat::from_rotation_arc(DVec3::Z, DVec3::from_array(*joint.axis.xyz).normalize());
                let constant = origin * DAffine3::from_quat(turn);
                let leader = joint.mimic.as_ref().map_or(&joint.name, |mimic| &mimic.joint);
                let mimic = joint.mimic.as_ref();
                joints.push(Joint {
                    parent: frame,
                    variable: variables.iter().position(|name| name == leader).unwrap(),
                    multiplier: mimic.and_then(|mimic| mimic.multiplier).unwrap_or(1.0) as f32,
                    offset: mimic.and_then(|mimic| mimic.offset).unwrap_or(0.0) as f32,
                    is_turning,
                    rows: [0, 1, 2].map(|i| single(constant.matrix3.row(i))),
                    at: single(constant.translation),
                });
                placed.push((joint.child.link.clone(), joints.len(), DAffine3::from_quat(turn.inverse())));
            }
        }
        let links = links(&text("spheres.tsv"), &placed);
        let disabled = DisabledPair::from_srdf(&text(&format!("{name}.srdf"))).unwrap();
        let is_tested = |a: &Link, b: &Link| {
            a.frame != b.frame && !disabled.iter().any(|pair| pair.is_of(&a.name, &b.name))
        };
        let all = (0..links.len()).flat_map(|i| (i + 1..links.len()).map(move |j| [i, j]));
        let pairs = all.filter(|&[i, j]| is_tested(&links[i], &links[j])).collect();
        let nowhere = Frame { rows: [[[0.0; LANES]; 3]; 3], at: [[0.0; LANES]; 3] };
        let mut frames = vec![nowhere; joints.len() + 1];
        for i in 0..3 {
            frames[0].rows[i][i] = [1.0; LANES];
        }
        let balls = links.iter().map(|link| link.balls.len()).sum();
        let memory = Memory {
            values: vec![[0.0; LANES]; variables.len()],
            frames,
            wholes: vec![[[0.0; LANES]; 3]; links.len()],
            balls: vec![[[0.0; LANES]; 3]; balls],
            is_placed: vec![false; links.len()],
        };
        Self { joints, links, pairs, memory }
    }

    /// Number of spheres.
    pub(crate) fn spheres(&self) -> usize {
        self.memory.balls.len()
    }

    /// Stops testing the pairs of links whose spheres meet in all of these configurations, as VAMP does. Returns their
    /// number.
    pub(crate) fn drop_pairs_that_always_meet(&mut self, configurations: &[f64]) -> usize {
        let all = core::mem::take(&mut self.pairs);
        let (before, nothing) = (all.len(), SphereWorld::new(&[]));
        let mut kept = Vec::new();
        for pair in all {
            self.pairs = vec![pair];
            if self.free(&nothing, configurations).contains(&true) {
                kept.push(pair);
            }
        }
        self.pairs = kept;
        before - self.pairs.len()
    }

    /// Which configurations are free, by the spheres.
    pub(crate) fn free(&mut self, world: &SphereWorld, configurations: &[f64]) -> Vec<bool> {
        let length = self.memory.values.len();
        let mut free = Vec::with_capacity(configurations.len() / length);
        let isa = Isa::detect();
        for sixteen in configurations.chunks(LANES * length) {
            let mut lanes = 0;
            for (lane, values) in sixteen.chunks(length).enumerate() {
                lanes |= 1 << lane;
                for (of, value) in self.memory.values.iter_mut().zip(values) {
                    of[lane] = *value as f32;
                }
            }
            let hit: u16 = on_isa!(isa, token => token.run(
                #[inline(always)]
                || self.hits(world, lanes),
            ));
            free.extend((0..sixteen.len() / length).map(|lane| hit >> lane & 1 == 0));
        }
        free
    }

    /// The lanes, among these, in which bodies meet.
    #[inline(always)]
    fn hits(&mut self, world: &SphereWorld, lanes: u16) -> u16 {
        let Self { joints, links, pairs, memory } = self;
        let Memory { values, frames, wholes, balls, is_placed } = memory;
        for (i, joint) in joints.iter().enumerate() {
            let (before, after) = frames.split_at_mut(i + 1);
            joint.go_to(&values[joint.variable], &before[joint.parent], &mut after[0]);
        }
        let (mut hit, all) = (0, lanes);
        for (i, link) in links.iter().enumerate() {
            wholes[i] = frames[link.frame].apply(&link.whole.centre);
            let near = world.meets(&wholes[i], link.whole.radius) & all & !hit;
            is_placed[i] = false;
            if near == 0 {
                continue;
            }
            if link.balls.len() == 1 {
                hit |= near;
            } else {
                link.place(&frames[link.frame], balls, &mut is_placed[i]);
                for (at, ball) in balls[link.first..].iter().zip(&link.balls) {
                    hit |= world.meets(at, ball.radius);
                }
            }
            if hit & all == all {
                return hit;
            }
        }
        for &[a, b] in &*pairs {
            let (p, q) = (&links[a], &links[b]);
            let near = do_meet(&wholes[a], &wholes[b], p.whole.radius + q.whole.radius);
            if near & all & !hit == 0 {
                continue;
            }
            p.place(&frames[p.frame], balls, &mut is_placed[a]);
            q.place(&frames[q.frame], balls, &mut is_placed[b]);
            for (at, ball) in balls[p.first..].iter().zip(&p.balls) {
                for (other, of) in balls[q.first..].iter().zip(&q.balls) {
                    hit |= do_meet(at, other, ball.radius + of.radius);
                }
            }
            if hit & all == all {
                return hit;
            }
        }
        hit
    }
}

/// The spheres of a table, by link. `placed`: the frame of each link, and its pose there.
fn links(table: &str, placed: &[(String, usize, DAffine3)]) -> Vec<Link> {
    let mut by_link: BTreeMap<usize, Vec<Ball>> = BTreeMap::new();
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split('\t').collect();
        let number = |i: usize| -> f64 { fields[i].parse().unwrap() };
        let link = placed.iter().position(|(name, ..)| name == fields[0]).unwrap();
        let centre = placed[link].2.transform_point3(DVec3::new(number(1), number(2), number(3)));
        by_link.entry(link).or_default().push(Ball { centre: single(centre), radius: number(4) as f32 });
    }
    let mut first = 0;
    let link = |(link, balls): (usize, Vec<Ball>)| {
        let begin = first;
        first += balls.len();
        let whole = around(&balls);
        Link { name: placed[link].0.clone(), frame: placed[link].1, whole, balls, first: begin }
    };
    by_link.into_iter().map(link).collect()
}

impl Link {
    #[inline(always)]
    fn place(&self, frame: &Frame, all: &mut [Point16], is_placed: &mut bool) {
        if !*is_placed {
            for (at, ball) in all[self.first..].iter_mut().zip(&self.balls) {
                *at = frame.apply(&ball.centre);
            }
            *is_placed = true;
        }
    }
}

impl Frame {
    #[inline(always)]
    fn apply(&self, p: &[f32; 3]) -> Point16 {
        let mut image = [[0.0; LANES]; 3];
        for (image, (row, at)) in image.iter_mut().zip(self.rows.iter().zip(&self.at)) {
            for lane in 0..LANES {
                image[lane] = row[0][lane] * p[0] + row[1][lane] * p[1] + row[2][lane] * p[2] + at[lane];
            }
        }
        image
    }
}

impl Joint {
    #[inline(always)]
    fn go_to(&self, variable: &Lane16, parent: &Frame, frame: &mut Frame) {
        frame.at = parent.apply(&self.at);
        for (row, of) in frame.rows.iter_mut().zip(&parent.rows) {
            for (j, entry) in row.iter_mut().enumerate() {
                for lane in 0..LANES {
                    entry[lane] = of[0][lane] * self.rows[0][j]
                        + of[1][lane] * self.rows[1][j]
                        + of[2][lane] * self.rows[2][j];
                }
            }
        }
        let mut value = [0.0; LANES];
        for lane in 0..LANES {
            value[lane] = self.multiplier * variable[lane] + self.offset;
        }
        if self.is_turning {
            let [sine, cosine] = sine_and_cosine(&value);
            for [x, y, _] in &mut frame.rows {
                for lane in 0..LANES {
                    let (p, q) = (x[lane], y[lane]);
                    x[lane] = cosine[lane] * p + sine[lane] * q;
                    y[lane] = cosine[lane] * q - sine[lane] * p;
                }
            }
        } else {
            for (at, row) in frame.at.iter_mut().zip(&frame.rows) {
                for lane in 0..LANES {
                    at[lane] += row[2][lane] * value[lane];
                }
            }
        }
    }
}

/// Adding this rounds a number below 2^22 to an integer, in the lowest bits.
const ROUND: f32 = 12_582_912.0;

/// Sines and cosines of angles of up to a few turns, within 1e-6.
#[inline(always)]
fn sine_and_cosine(angles: &Lane16) -> [Lane16; 2] {
    let [mut sines, mut cosines] = [[0.0_f32; LANES]; 2];
    for lane in 0..LANES {
        let shifted = angles[lane] * core::f32::consts::FRAC_2_PI + ROUND;
        let (k, quarters) = (shifted.to_bits(), shifted - ROUND);
        let r = (angles[lane] - quarters * 1.570_312_5) - quarters * 4.838_268e-4;
        let z = r * r;
        let s = r + r * (z * (-1.0 / 6.0 + z * (1.0 / 120.0 - z / 5040.0)));
        let c = 1.0 + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z / 40_320.0)));
        let (s, c) = if k & 1 == 0 { (s, c) } else { (c, s) };
        sines[lane] = f32::from_bits(s.to_bits() ^ (k & 2) << 30);
        cosines[lane] = f32::from_bits(c.to_bits() ^ (k.wrapping_add(1) & 2) << 30);
    }
    [sines, cosines]
}

#[inline(always)]
fn mask(flags: &[u32; LANES]) -> u16 {
    flags.iter().fold(0, |mask, flag| mask | flag) as u16
}

/// The lanes in which two points are at most this far apart.
#[inline(always)]
fn do_meet(a: &Point16, b: &Point16, radii: f32) -> u16 {
    let mut flags = [0_u32; LANES];
    for lane in 0..LANES {
        let (x, y, z) = (a[0][lane] - b[0][lane], a[1][lane] - b[1][lane], a[2][lane] - b[2][lane]);
        flags[lane] = u32::from(x * x + y * y + z * z <= radii * radii) << lane;
    }
    mask(&flags)
}

/// A cuboid or a cylinder; `rows` are its axes in the world.
struct Solid {
    at: [f32; 3],
    rows: [[f32; 3]; 3],
    /// Half the side lengths; for a cylinder the radius, twice, and half the height.
    half: [f32; 3],
    is_round: bool,
    /// Whether its third axis is the world's z axis.
    is_upright: bool,
    /// A lower bound on its distance from the robot's base.
    near: f32,
}

/// Obstacles, the nearest first.
pub(crate) struct SphereWorld {
    solids: Vec<Solid>,
}

impl SphereWorld {
    pub(crate) fn new(obstacles: &[Obstacle]) -> Self {
        let solid = |obstacle: &Obstacle| {
            let (half, is_round) = match obstacle.shape {
                Shape::Cuboid(sides) => (sides.map(|x| 0.5 * x), false),
                Shape::Cylinder { radius, height } => ([radius, radius, 0.5 * height], true),
            };
            let to_solid = obstacle.at.matrix3.transpose();
            // The base, in the frame of the obstacle.
            let base = to_solid * -obstacle.at.translation;
            let gaps = [0, 1, 2].map(|i| (base[i].abs() - half[i]).max(0.0));
            let sides =
                if is_round { (base[0].hypot(base[1]) - half[0]).max(0.0) } else { gaps[0].hypot(gaps[1]) };
            Solid {
                at: single(obstacle.at.translation),
                rows: [0, 1, 2].map(|i| single(to_solid.row(i))),
                half: half.map(|x| x as f32),
                is_round,
                is_upright: obstacle.at.matrix3.z_axis.z > 1.0 - 1e-9,
                near: (sides.hypot(gaps[2]) - 1e-6) as f32,
            }
        };
        let mut solids: Vec<Solid> = obstacles.iter().map(solid).collect();
        solids.sort_by(|a, b| a.near.total_cmp(&b.near));
        Self { solids }
    }

    /// The lanes in which a sphere meets an obstacle.
    #[inline(always)]
    fn meets(&self, p: &Point16, radius: f32) -> u16 {
        // Nonnegative floats order like their bits.
        let mut away = 0;
        for ((x, y), z) in p[0].iter().zip(&p[1]).zip(&p[2]) {
            away = (x * x + y * y + z * z).to_bits().max(away);
        }
        let (reach, mut flags) = (f32::from_bits(away).sqrt() + radius, [0_u32; LANES]);
        for solid in &self.solids {
            if solid.near > reach {
                break;
            }
            match (solid.is_upright, solid.is_round) {
                (true, false) => solid.near_to::<true, false>(p, radius, &mut flags),
                (true, true) => solid.near_to::<true, true>(p, radius, &mut flags),
                (false, false) => solid.near_to::<false, false>(p, radius, &mut flags),
                (false, true) => solid.near_to::<false, true>(p, radius, &mut flags),
            }
        }
        mask(&flags)
    }
}

impl Solid {
    /// Sets the flags of lanes in which a sphere meets it.
    #[inline(always)]
    fn near_to<const UPRIGHT: bool, const ROUND: bool>(
        &self,
        p: &Point16,
        radius: f32,
        flags: &mut [u32; LANES],
    ) {
        let ([a, b, c], at, half) = (self.rows, self.at, self.half);
        let square_radius = radius * radius;
        let mut near = [0_u32; LANES];
        for lane in 0..LANES {
            let (x, y, z) = (p[0][lane] - at[0], p[1][lane] - at[1], p[2][lane] - at[2]);
            let along = if UPRIGHT { z } else { c[0] * x + c[1] * y + c[2] * z };
            let off = beyond(along.abs() - half[2]);
            let square = if ROUND {
                // The axis of an upright cylinder has fixed x and y.
                let square = x * x + y * y + if UPRIGHT { 0.0 } else { z * z - along * along };
                let side = beyond(beyond(square).sqrt() - half[0]);
                side * side
            } else {
                let (u, v) = if UPRIGHT {
                    (a[0] * x + a[1] * y, b[0] * x + b[1] * y)
                } else {
                    (a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z)
                };
                let (u, v) = (beyond(u.abs() - half[0]), beyond(v.abs() - half[1]));
                u * u + v * v
            };
            near[lane] = u32::from(square + off * off <= square_radius) << lane;
        }
        for lane in 0..LANES {
            flags[lane] |= near[lane];
        }
    }
}

/// A length, or 0 if it is negative.
#[inline(always)]
fn beyond(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}
