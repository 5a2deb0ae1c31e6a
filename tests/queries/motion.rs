//! Motions: no point moves farther than the motion bound, and bodies are where an independent forward
//! kinematics has them.

use crate::support::rng::Rng;
use core::f64::consts::PI;
use glam::{DAffine3, DQuat, DVec3};
use simdop::motion::{
    CarriedBall, Joint, JointKind, JointMotion, Kinematics, LinkBody, LinkFrame, Motion, MotionError, Screw,
    ScrewMotion,
};
use simdop::pose::Pose;

/// A joint, independent of the library's types.
struct Spec {
    kind: JointKind,
    parent: u32,
    origin: DAffine3,
    axis: DVec3,
    variable: usize,
    multiplier: f64,
    offset: f64,
}

fn vector(rng: &mut Rng, size: f64) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| rng.range(-size, size)))
}

fn affine(rng: &mut Rng, size: f64) -> DAffine3 {
    let turn = DQuat::from_axis_angle(vector(rng, 1.0).normalize(), rng.range(-3.0, 3.0));
    DAffine3::from_rotation_translation(turn, vector(rng, size))
}

fn pose(at: DAffine3) -> Pose {
    Pose::try_from(at).unwrap()
}

/// A pose whose matrix is as far from a rotation as rounding to five digits makes it.
fn skewed(rng: &mut Rng, at: DAffine3) -> Pose {
    let mut off = || 1.0 + rng.range(-2e-5, 2e-5);
    let stretch = DAffine3::from_scale(DVec3::new(off(), off(), off()));
    pose(DAffine3 { translation: at.translation, ..at * stretch })
}

/// A tree of joints of both kinds, one of which mimics another.
fn specs(rng: &mut Rng, joints: u32) -> Vec<Spec> {
    (0..joints)
        .map(|i| Spec {
            kind: if rng.below(3) == 0 { JointKind::Prismatic } else { JointKind::Revolute },
            parent: if rng.below(4) == 0 { rng.below(u64::from(i) + 1) as u32 } else { i },
            origin: affine(rng, 0.5),
            axis: vector(rng, 1.0),
            variable: if i == 3 { 1 } else { i as usize },
            multiplier: if i == 3 { -0.5 } else { 1.0 },
            offset: if i == 3 { 0.25 } else { 0.0 },
        })
        .collect()
}

fn joints(specs: &[Spec]) -> Vec<Joint> {
    let joint = |spec: &Spec| {
        Joint::new(spec.kind, spec.parent, pose(spec.origin), spec.axis.to_array(), spec.variable as u32)
            .and_then(|joint| joint.following(spec.multiplier, spec.offset))
            .unwrap()
    };
    specs.iter().map(joint).collect()
}

/// The poses of the links, computed with glam.
fn frames(specs: &[Spec], base: DAffine3, values: &[f64]) -> Vec<DAffine3> {
    let mut frames = vec![base];
    for spec in specs {
        let value = spec.multiplier * values[spec.variable] + spec.offset;
        let moved = match spec.kind {
            JointKind::Revolute => DAffine3::from_axis_angle(spec.axis.normalize(), value),
            JointKind::Prismatic => DAffine3::from_translation(spec.axis.normalize() * value),
        };
        frames.push(frames[spec.parent as usize] * spec.origin * moved);
    }
    frames
}

/// The rounding error of a position some units from the origin.
const CLOSE: f64 = 1e-13;

#[test]
fn bodies_stand_where_their_joints_lead() {
    let mut rng = Rng::new(170);
    for _ in 0..200 {
        let specs = specs(&mut rng, 6);
        let (joints, base) = (joints(&specs), affine(&mut rng, 1.0));
        let places: Vec<DAffine3> = (0..4).map(|_| affine(&mut rng, 0.3)).collect();
        let bodies: Vec<LinkBody> =
            (0..4).map(|i| LinkBody { link: 2 * i, at: pose(places[i as usize]) }).collect();
        let limits = [[-4.0, 4.0]; 6];
        let robot = Kinematics::new(&joints, &bodies, &limits).unwrap().with_base(pose(base));
        let values: Vec<f64> = (0..6).map(|_| rng.range(-4.0, 4.0)).collect();
        let (mut links, mut poses) = ([LinkFrame::EMPTY; 7], [Pose::IDENTITY; 4]);
        robot.go_to(&values, &mut links, &mut poses).unwrap();
        let frames = frames(&specs, base, &values);
        for (i, pose) in poses.iter().enumerate() {
            let expected = frames[2 * i] * places[i];
            let p = vector(&mut rng, 1.0);
            let off = DVec3::from_array(pose.apply(p.to_array())) - expected.transform_point3(p);
            assert!(off.length() < 10.0 * CLOSE, "{off}");
        }
    }
}

/// Points on a sphere, in the frame of a body at `pose`.
fn points(rng: &mut Rng, centre: DVec3, radius: f64) -> Vec<DVec3> {
    (0..12).map(|_| centre + vector(rng, 1.0).normalize() * radius).collect()
}

/// Queries the motion bound of balls of a motion's bodies at a time, and samples how far their points move
/// around that time. Returns the sum of the observed lengths, and that of the bounds.
fn check_paths(rng: &mut Rng, motion: &mut impl Motion, span: f64) -> (f64, f64) {
    let n = motion.bodies();
    let mut poses = vec![Pose::IDENTITY; n];
    let balls: Vec<(DVec3, f64)> = (0..n).map(|_| (vector(rng, 0.4), rng.range(0.0, 0.3))).collect();
    let inside: Vec<Vec<DVec3>> = balls.iter().map(|&(c, r)| points(rng, c, r)).collect();
    let time = rng.range(span, 1.0 - span);
    motion.go_to(time, &mut poses).unwrap();
    let at = |poses: &[Pose], i: usize, p: DVec3| DVec3::from_array(poses[i].apply(p.to_array()));
    let before = poses.clone();
    let carried: Vec<CarriedBall> = (0..n)
        .map(|i| CarriedBall { centre: at(&before, i, balls[i].0).to_array(), radius: balls[i].1 })
        .collect();
    let said: Vec<f64> = (0..n).map(|i| motion.motion_bound(i, &carried[i], span)).collect();
    let between: Vec<f64> =
        (1..n).map(|i| motion.motion_bound_between((0, &carried[0]), (i, &carried[i]), span)).collect();
    let mut seen = vec![0.0_f64; 2 * n - 1];
    for k in 0..40 {
        motion.go_to(time + span * (f64::from(k) / 19.5 - 1.0), &mut poses).unwrap();
        for i in 0..n {
            for &p in &inside[i] {
                seen[i] = seen[i].max((at(&poses, i, p) - at(&before, i, p)).length());
            }
        }
        for i in 1..n {
            for (&p, &q) in inside[0].iter().zip(&inside[i]) {
                let now = (at(&poses, 0, p) - at(&poses, i, q)).length();
                seen[n - 1 + i] = seen[n - 1 + i].max((at(&before, 0, p) - at(&before, i, q)).length() - now);
            }
        }
    }
    for (i, (seen, said)) in seen.iter().zip(said.iter().chain(&between)).enumerate() {
        // The test's own rounding.
        assert!(*seen <= said + CLOSE, "{i}: {seen} seen, {said} said");
    }
    for i in 1..n {
        assert!(
            between[i - 1] <= (said[0] + said[i]) * (1.0 + 1e-12),
            "the sum of both paths is a bound as well"
        );
    }
    (seen.iter().sum(), said.iter().sum::<f64>() + between.iter().sum::<f64>())
}

#[test]
fn no_point_gets_farther_than_is_said() {
    let mut rng = Rng::new(171);
    for (span, least) in [(0.4, 0.25), (0.1, 0.35), (0.003, 0.4), (1e-9, 0.4)] {
        let (mut seen, mut said) = (0.0, 0.0);
        for _ in 0..60 {
            let specs = specs(&mut rng, 5);
            let joints = joints(&specs);
            let bodies = [5, 3, 1, 0].map(|link| LinkBody { link, at: pose(affine(&mut rng, 0.3)) });
            let limits = [[-4.0, 4.0]; 5];
            let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
            let mut values = || -> Vec<f64> { (0..5).map(|_| rng.range(-1.5, 1.5)).collect() };
            let ends = [values(), values()];
            let (mut values, mut links) = ([0.0; 5], [LinkFrame::EMPTY; 6]);
            let mut motion = JointMotion::new(robot, [&ends[0], &ends[1]], &mut values, &mut links).unwrap();
            let (a, b) = check_paths(&mut rng, &mut motion, span);
            (seen, said) = (seen + a, said + b);
        }
        assert!(seen >= least * said, "span {span}: {seen} seen, {said} said");
    }
}

/// The first joint's origin, the base and the placements of the bodies on their links are not exact rotations.
#[test]
fn no_point_gets_farther_where_matrices_are_not_quite_rotations() {
    let mut rng = Rng::new(176);
    for _ in 0..200 {
        let at = affine(&mut rng, 0.5);
        let origin = skewed(&mut rng, at);
        let joints = [
            Joint::new(JointKind::Revolute, 0, origin, vector(&mut rng, 1.0).to_array(), 0).unwrap(),
            Joint::new(JointKind::Revolute, 1, Pose::IDENTITY, vector(&mut rng, 1.0).to_array(), 1).unwrap(),
        ];
        let bodies = [1, 2].map(|link| LinkBody { link, at: skewed(&mut rng, DAffine3::IDENTITY) });
        let base = skewed(&mut rng, DAffine3::IDENTITY);
        let robot = Kinematics::new(&joints, &bodies, &[[-4.0, 4.0]; 2]).unwrap().with_base(base);
        // One joint, by so little that arc and chord are equal: a point moves as far as the bound.
        let joint = rng.below(2) as usize;
        let mut ends = [[0.1, 0.3]; 2];
        ends[1][joint] += 1e-3;
        let (mut values, mut links) = ([0.0; 2], [LinkFrame::EMPTY; 3]);
        let mut motion = JointMotion::new(robot, [&ends[0], &ends[1]], &mut values, &mut links).unwrap();
        let (mut poses, p) = ([Pose::IDENTITY; 2], vector(&mut rng, 1.0).to_array());
        motion.go_to(0.5, &mut poses).unwrap();
        let ball = CarriedBall { centre: poses[1].apply(p), radius: 0.0 };
        let said = motion.motion_bound(1, &ball, 0.5);
        motion.go_to(1.0, &mut poses).unwrap();
        let seen = DVec3::from_array(poses[1].apply(p)).distance(DVec3::from_array(ball.centre));
        assert!(seen <= said + 1e-15 && said <= seen * (1.0 + 1e-6) + 1e-12, "{seen} seen, {said} said");
    }
}

#[test]
fn rounding_far_from_the_origin_is_paid_for() {
    let mut rng = Rng::new(175);
    for _ in 0..40 {
        let specs = specs(&mut rng, 5);
        let joints = joints(&specs);
        let bodies = [5, 3, 1, 0].map(|link| LinkBody { link, at: pose(affine(&mut rng, 0.3)) });
        let limits = [[-4.0, 4.0]; 5];
        let far = affine(&mut rng, 1e7);
        let robot = Kinematics::new(&joints, &bodies, &limits).unwrap().with_base(pose(far));
        let ends = [[0.3; 5], [-0.4; 5]];
        let (mut values, mut links) = ([0.0; 5], [LinkFrame::EMPTY; 6]);
        let mut motion = JointMotion::new(robot, [&ends[0], &ends[1]], &mut values, &mut links).unwrap();
        // The motion itself is a thousandth of the rounding errors.
        let _ = check_paths(&mut rng, &mut motion, 1e-12);
    }
}

#[test]
fn bodies_on_one_link_do_not_move_as_they_see_each_other() {
    let mut rng = Rng::new(172);
    let specs = specs(&mut rng, 5);
    let joints = joints(&specs);
    let bodies = [4, 4].map(|link| LinkBody { link, at: pose(affine(&mut rng, 0.3)) });
    let limits = [[-4.0, 4.0]; 5];
    let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
    let (mut values, mut links) = ([0.0; 5], [LinkFrame::EMPTY; 6]);
    let mut motion = JointMotion::new(robot, [&[-1.0; 5], &[1.0; 5]], &mut values, &mut links).unwrap();
    let mut poses = [Pose::IDENTITY; 2];
    motion.go_to(0.5, &mut poses).unwrap();
    let ball = CarriedBall { centre: poses[0].translation(), radius: 1.0 };
    let path = motion.motion_bound_between((0, &ball), (1, &ball), 0.5);
    assert!(path > 0.0 && path < 1e-11, "{path}");
}

#[test]
fn screws_lead_from_one_pose_to_the_other() {
    let mut rng = Rng::new(173);
    for i in 0..400 {
        let from = affine(&mut rng, 2.0);
        let axis = vector(&mut rng, 1.0).normalize();
        let angle = match i % 8 {
            0 => 0.0,
            1 => PI,
            2 => PI - 1e-9,
            3 => 1e-9,
            4 => PI - 1e-4,
            _ => rng.range(0.0, PI),
        };
        let shift = if i % 16 == 0 { DVec3::ZERO } else { vector(&mut rng, 2.0) };
        let to = DAffine3::from_rotation_translation(DQuat::from_axis_angle(axis, angle), shift) * from;
        let screw = Screw::between(&pose(from), &pose(to)).unwrap();
        for (time, expected) in [(0.0, from), (1.0, to)] {
            let at = screw.at(time, &pose(from)).unwrap();
            let p = vector(&mut rng, 1.0);
            let off = DVec3::from_array(at.apply(p.to_array())) - expected.transform_point3(p);
            assert!(off.length() < 5e-7, "case {i}, angle {angle}, time {time}: {off}");
        }
    }
}

#[test]
fn no_point_of_a_screw_gets_farther_than_is_said() {
    let mut rng = Rng::new(174);
    for (span, least) in [(0.4, 0.4), (0.01, 0.4), (1e-9, 0.3)] {
        let (mut seen, mut said) = (0.0, 0.0);
        for _ in 0..100 {
            let mut number = || rng.range(-2.0, 2.0);
            let (angle, advance) = (number(), number());
            let screw = Screw::new([number(), number(), number()], [number(), number(), 0.1], angle, advance);
            let starts = [pose(affine(&mut rng, 1.0)), pose(affine(&mut rng, 1.0))];
            let mut motion = ScrewMotion::new(screw.unwrap(), &starts);
            let (a, b) = check_paths(&mut rng, &mut motion, span);
            (seen, said) = (seen + a, said + b);
        }
        assert!(seen >= least * said, "span {span}: {seen} seen, {said} said");
    }
}

#[test]
fn what_is_no_motion_is_refused() {
    let z = [0.0, 0.0, 1.0];
    let joint =
        |parent, variable| Joint::new(JointKind::Revolute, parent, Pose::IDENTITY, z, variable).unwrap();
    let body = |link| LinkBody { link, at: Pose::IDENTITY };
    for axis in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
        let none = Joint::new(JointKind::Prismatic, 0, Pose::IDENTITY, axis, 0);
        assert_eq!(none, Err(MotionError::NoDirection), "{axis:?}");
        assert_eq!(Screw::new([0.0; 3], axis, 1.0, 0.0), Err(MotionError::NoDirection));
    }
    assert_eq!(Screw::new([0.0; 3], z, f64::NAN, 0.0), Err(MotionError::NotFinite));
    assert_eq!(joint(0, 0).following(f64::INFINITY, 0.0), Err(MotionError::NotFinite));
    let limits = [[-1.0, 1.0]];
    let refused = |joints: &[Joint], bodies: &[LinkBody], limits: &[[f64; 2]]| {
        Kinematics::new(joints, bodies, limits).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(&[joint(1, 0)], &[], &limits), MotionError::NoSuchLink { index: 0, link: 1 });
    assert_eq!(refused(&[joint(0, 1)], &[], &limits), MotionError::NoSuchVariable { joint: 0, variable: 1 });
    assert_eq!(refused(&[joint(0, 0)], &[body(2)], &limits), MotionError::NoSuchLink { index: 1, link: 2 });
    for limits in [[1.0, -1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        assert_eq!(refused(&[joint(0, 0)], &[], &[limits]), MotionError::Limits { variable: 0 });
    }
    let (joints, bodies) = ([joint(0, 0)], [body(1)]);
    let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
    assert_eq!(robot.check(&[0.0, 0.0]), Err(MotionError::Length { given: 2, needed: 1 }));
    let out = robot.check(&[1.5]);
    assert_eq!(out, Err(MotionError::OutOfLimits { variable: 0, given: 1.5 }));
    assert!(matches!(robot.check(&[f64::NAN]), Err(MotionError::OutOfLimits { variable: 0, .. })));
    let mut one = [LinkFrame::EMPTY];
    let mut two = [LinkFrame::EMPTY; 2];
    let short = MotionError::Length { given: 1, needed: 2 };
    assert_eq!(robot.go_to(&[0.0], &mut one, &mut [Pose::IDENTITY]), Err(short));
    assert_eq!(robot.go_to(&[0.0], &mut two, &mut []), Err(MotionError::Length { given: 0, needed: 1 }));
    let refused = |ends, values: &mut [f64], links: &mut [LinkFrame]| {
        JointMotion::new(robot, ends, values, links).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused([&[0.0], &[0.5]], &mut [0.0], &mut one), short);
    assert_eq!(refused([&[0.0], &[0.5]], &mut [], &mut two), MotionError::Length { given: 0, needed: 1 });
    assert_eq!(
        refused([&[0.0], &[2.0]], &mut [0.0], &mut two),
        MotionError::OutOfLimits { variable: 0, given: 2.0 }
    );
}
