//! A robot through the C functions and through the library, and faulty robots.

use super::{IDENTITY, Rng, handle, pose};
use simdop::motion::{Joint, JointKind, Kinematics, LinkBody};
use simdop::pose::Pose;
use simdop_capi::*;

/// The description of a robot.
#[derive(Clone)]
pub(crate) struct Parts {
    pub(crate) base: simdop_pose,
    pub(crate) joints: Vec<simdop_joint>,
    pub(crate) bodies: Vec<simdop_link_body>,
    pub(crate) limits: Vec<[f64; 2]>,
}

impl Parts {
    /// A tree of joints of both kinds, one of which mimics another, with three bodies, and a variable that moves
    /// nothing.
    pub(crate) fn random(rng: &mut Rng) -> Self {
        let joint = |i: u32, rng: &mut Rng| simdop_joint {
            kind: rng.below(2) as u32,
            parent: if rng.below(4) == 0 { rng.below(u64::from(i) + 1) as u32 } else { i },
            variable: if i == 3 { 1 } else { i },
            origin: pose(rng).0,
            axis: [0; 3].map(|_| rng.range(-2.0, 2.0)),
            multiplier: if i == 3 { -0.5 } else { 1.0 },
            offset: if i == 3 { 0.25 } else { 0.0 },
        };
        let joints: Vec<_> = (0..rng.int(4, 7) as u32).map(|i| joint(i, rng)).collect();
        let links = joints.len() as u64 + 1;
        let body = |rng: &mut Rng| simdop_link_body { link: rng.below(links) as u32, pose: pose(rng).0 };
        let bodies = (0..3).map(|_| body(rng)).collect();
        Self { base: pose(rng).0, limits: vec![[-2.0, 2.0]; joints.len() + 1], joints, bodies }
    }

    /// Values within the limits.
    pub(crate) fn values(&self, rng: &mut Rng) -> Vec<f64> {
        self.limits.iter().map(|&[low, high]| rng.range(low, high)).collect()
    }

    pub(crate) fn robot(&self) -> Result<Box<simdop_robot>, simdop_error> {
        let Self { base, joints, bodies, limits } = self;
        // SAFETY: the lengths are those of the vectors.
        handle(|robot| unsafe {
            simdop_robot_new(
                Some(base),
                joints.as_ptr(),
                joints.len(),
                bodies.as_ptr(),
                bodies.len(),
                limits.as_ptr().cast(),
                limits.len(),
                robot,
            )
        })
    }

    /// The same robot through the library.
    pub(crate) fn with_kinematics<R>(&self, ask: impl FnOnce(Kinematics<'_>) -> R) -> R {
        let checked = |pose: &simdop_pose| Pose::from_rows(pose.rows).unwrap();
        let joint = |joint: &simdop_joint| {
            let kind = [JointKind::Revolute, JointKind::Prismatic][joint.kind as usize];
            Joint::new(kind, joint.parent, checked(&joint.origin), joint.axis, joint.variable)
                .and_then(|made| made.following(joint.multiplier, joint.offset))
                .unwrap()
        };
        let body = |body: &simdop_link_body| LinkBody { link: body.link, at: checked(&body.pose) };
        let joints: Vec<_> = self.joints.iter().map(joint).collect();
        let bodies: Vec<_> = self.bodies.iter().map(body).collect();
        ask(Kinematics::new(&joints, &bodies, &self.limits).unwrap().with_base(checked(&self.base)))
    }
}

/// A joint that rotates about z, at its link's origin, by the first variable, and a body on its link.
pub(crate) fn hinge() -> Parts {
    let kind = simdop_joint_kind::Revolute as u32;
    let (origin, axis) = (IDENTITY, [0.0, 0.0, 1.0]);
    let joint = simdop_joint { kind, parent: 0, variable: 0, origin, axis, multiplier: 1.0, offset: 0.0 };
    let body = simdop_link_body { link: 1, pose: IDENTITY };
    Parts { base: IDENTITY, joints: vec![joint], bodies: vec![body], limits: vec![[-2.0, 2.0]] }
}

/// Invalid robots, with the error code of each.
pub(crate) fn faults() -> Vec<(simdop_error, Parts)> {
    let mut mirrored = IDENTITY;
    mirrored.rows[1][1] = -1.0;
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let mut faults = Vec::new();
    let mut fault = |error: simdop_error, change: &dyn Fn(&mut Parts)| {
        let mut parts = hinge();
        change(&mut parts);
        faults.push((error, parts));
    };
    for number in [1, u32::MAX] {
        fault(simdop_error::MotionNoSuchLink, &|parts| parts.joints[0].parent = number);
        fault(simdop_error::MotionNoSuchVariable, &|parts| parts.joints[0].variable = number);
    }
    for number in [2, u32::MAX] {
        fault(simdop_error::MotionNoSuchKind, &|parts| parts.joints[0].kind = number);
        fault(simdop_error::MotionNoSuchLink, &|parts| parts.bodies[0].link = number);
    }
    for limits in [[1.0, 0.0], [nan, 0.0], [0.0, nan], [0.0, infinite], [-infinite, 0.0]] {
        fault(simdop_error::MotionLimits, &|parts| parts.limits[0] = limits);
    }
    for axis in [[0.0; 3], [0.0, nan, 1.0], [infinite, 0.0, 0.0]] {
        fault(simdop_error::MotionNoDirection, &|parts| parts.joints[0].axis = axis);
    }
    for number in [nan, infinite] {
        fault(simdop_error::MotionNotFinite, &|parts| parts.joints[0].multiplier = number);
        fault(simdop_error::MotionNotFinite, &|parts| parts.joints[0].offset = number);
    }
    fault(simdop_error::PoseMirrored, &|parts| parts.base = mirrored);
    fault(simdop_error::PoseMirrored, &|parts| parts.joints[0].origin = mirrored);
    fault(simdop_error::PoseMirrored, &|parts| parts.bodies[0].pose = mirrored);
    faults
}

/// As in `mod.rs`, for items that not all tests use.
const _: () = {
    let _ = (Parts::random, Parts::values, Parts::robot, faults);
    let _ = |parts: Parts| parts.with_kinematics(|_| ());
};
