use super::*;
use glam::{Affine3, Affine3A, DAffine3, DQuat, Quat, Vec3};

#[test]
fn glam_types_give_the_matrix_that_glam_applies() {
    let (q, t) = (DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0), DVec3::new(1.0, -2.0, 0.5));
    let affine = DAffine3::from_rotation_translation(q, t);
    let p = DVec3::new(0.7, 11.0, -3.0);
    let want = affine.transform_point3(p);
    for pose in [Pose::try_from(affine).unwrap(), Pose::try_from((q, t)).unwrap()] {
        let got = DVec3::from_array(pose.apply(p.to_array()));
        assert!((want - got).length() < 1e-14, "{want} {got}");
    }
    let single = Affine3A::from_rotation_translation(q.as_quat(), t.as_vec3());
    let pair = Pose::try_from((q.as_quat(), t.as_vec3())).unwrap();
    for pose in [Pose::try_from(single).unwrap(), Pose::try_from(Affine3::from(single)).unwrap(), pair] {
        let got = DVec3::from_array(pose.apply(p.to_array()));
        assert!((want - got).length() < 1e-5, "{want} {got}");
    }
}

/// Rotations about many axes.
fn turns() -> impl Iterator<Item = DQuat> {
    (0..2000).map(|i| {
        let [x, y, z] = [0.7, 1.3, 2.9].map(|step| f64::from(i) * step);
        DQuat::from_euler(glam::EulerRot::XYZ, x, y, z)
    })
}

fn of(q: [f64; 4]) -> Result<Pose, PoseError> {
    Pose::try_from((DQuat::from_array(q), DVec3::new(1.0, 2.0, 3.0)))
}

#[test]
fn a_quaternion_that_is_not_a_unit_one_is_refused() {
    let refused = |q: [f64; 4]| match of(q) {
        Err(PoseError::NotUnit { deviation }) => deviation,
        other => panic!("{q:?}: {other:?}"),
    };
    assert_eq!(refused([0.0; 4]), 1.0, "an unset message");
    assert_eq!(refused([0.0, 0.0, 0.0, 2.0]), 3.0, "its matrix is the identity");
    assert_eq!(refused([0.0, 0.0, 0.0, -0.5]), 0.75);
    assert_eq!(refused([1.0; 4]), 3.0);
    assert_eq!(refused([0.0, 1e200, 0.0, 0.0]), f64::INFINITY);
    assert_eq!(refused([5e-324, 0.0, 0.0, 0.0]), 1.0);
    for turn in turns() {
        for factor in [0.0, 0.5, 0.9999, 1.0001, 2.0] {
            let deviation = refused((turn * factor).to_array());
            assert!((deviation - f64::abs(factor * factor - 1.0)).abs() < 1e-12, "{turn} {factor}");
        }
    }
    let single = (Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), Vec3::ZERO);
    assert_eq!(Pose::try_from(single), Err(PoseError::NotUnit { deviation: 1.0 }));
}

#[test]
fn a_quaternion_that_is_not_finite_is_refused_as_such() {
    for component in 0..4 {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut q = [0.0, 0.0, 0.0, 1.0];
            q[component] = value;
            assert_eq!(of(q), Err(PoseError::NotFinite), "{q:?}");
        }
    }
    let nowhere = (DQuat::IDENTITY, DVec3::new(0.0, f64::NAN, 0.0));
    assert_eq!(Pose::try_from(nowhere), Err(PoseError::NotFinite));
    assert_eq!(Pose::try_from((DQuat::IDENTITY, DVec3::new(0.0, 0.0, 1e300))), Err(PoseError::TooFar));
}

/// Quaternions rounded to `f32`, printed with five digits, or slightly off for another reason: the pose must be a
/// rotation to within `f64` rounding, and no farther from the intended one than the quaternion.
#[test]
fn a_quaternion_that_is_nearly_a_unit_one_gives_a_rotation() {
    let five_digits = |x: f64| (x * 1e5).round() / 1e5;
    for turn in turns() {
        let exact = DMat3::from_quat(turn);
        let single = turn.as_quat();
        for (q, off) in [
            (turn, 1e-14),
            (-turn, 1e-14),
            (turn * (1.0 - 4.9e-5), 1e-14),
            (turn * (1.0 + 4.9e-5), 1e-14),
            (single.as_dquat(), 1e-6),
            (DQuat::from_array(turn.to_array().map(five_digits)), 1e-4),
        ] {
            let pose = of(q.to_array()).unwrap_or_else(|e| panic!("{q}: {e}"));
            let rotation = DMat3::from_cols_array_2d(pose.rows()).transpose();
            assert!(rotation.abs_diff_eq(exact, off), "{q}: {rotation} {exact}");
            let product = rotation * rotation.transpose();
            assert!(product.abs_diff_eq(DMat3::IDENTITY, 1e-14), "{q}: {product}");
            assert_eq!(pose.translation(), [1.0, 2.0, 3.0]);
        }
        let pose = Pose::try_from((single, Vec3::ZERO)).unwrap();
        assert_eq!(
            pose.rows(),
            of(single.as_dquat().to_array()).unwrap().rows(),
            "converted before all else"
        );
    }
    assert_eq!(of([0.0, 0.0, 0.0, 1.0]).unwrap().rows(), Pose::IDENTITY.rows());
}

/// Vertices of the cube of all points, rotated onto an axis and translated: no accepted pose moves a point farther.
#[test]
fn moved_points_are_in_the_range_of_moved_points() {
    let mut farthest = 0.0;
    let third = f64::sqrt(1.0 / 3.0);
    let diagonal = DQuat::from_rotation_arc(DVec3::splat(third), DVec3::X);
    for turn in turns().chain([diagonal]) {
        // The longest rows that are accepted.
        let rotation = DMat3::from_quat(turn) * (1.0 + 0.499 * Pose::TOLERANCE);
        for corner in 0..8 {
            let signs: Point = core::array::from_fn(|i| if corner >> i & 1 == 0 { 1.0 } else { -1.0 });
            let pose = Pose::new(rotation, MAX_COORDINATE * DVec3::from_array(signs)).unwrap();
            for other in 0..8 {
                let p = core::array::from_fn(|i| MAX_COORDINATE * (1.0 - f64::from(other >> i & 1) * 2.0));
                farthest = pose.apply(p).iter().fold(farthest, |m: f64, x| m.max(x.abs()));
            }
        }
    }
    assert!(farthest <= MAX_MOVED, "{farthest:e}");
    assert!(farthest > 2.73 * MAX_COORDINATE, "the worst case is among them: {farthest:e}");
}

#[test]
fn what_is_not_rigid_is_refused() {
    let ok = [[1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    assert!(Pose::from_rows(ok).is_ok());
    let with = |row: usize, column: usize, value: f64| {
        let mut rows = ok;
        rows[row][column] = value;
        Pose::from_rows(rows)
    };
    for row in 0..3 {
        for column in 0..4 {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert_eq!(with(row, column, value), Err(PoseError::NotFinite));
            }
            let off = with(row, column, if row == column { -0.9998 } else { 2e-4 });
            assert_eq!(matches!(off, Err(PoseError::NotOrthonormal { .. })), column < 3, "{row} {column}");
        }
        assert_eq!(with(row, 3, -1e300), Err(PoseError::TooFar));
    }
    assert!(matches!(with(0, 0, 1.001), Err(PoseError::NotOrthonormal { .. })));
    assert!(matches!(with(0, 1, 1e-3), Err(PoseError::NotOrthonormal { .. })));
    assert!(matches!(with(0, 0, 1e200), Err(PoseError::NotOrthonormal { .. })));
    assert!(matches!(with(0, 0, 0.0), Err(PoseError::NotOrthonormal { .. })));
    assert_eq!(with(2, 2, -1.0), Err(PoseError::Mirrored));
}

#[cfg(feature = "mint")]
#[test]
fn mint_types_give_the_pose_of_their_numbers() {
    let (q, t) = (DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0), DVec3::new(1.0, -2.0, 0.5));
    let want = Pose::try_from((q, t)).unwrap();
    let of_quaternion = mint::Quaternion { v: [q.x, q.y, q.z].into(), s: q.w };
    assert_eq!(Pose::try_from((of_quaternion, mint::Vector3::from(t.to_array()))), Ok(want));
    let rows: [[f64; 4]; 3] = core::array::from_fn(|i| {
        let ([x, y, z], shift) = (want.rows()[i], want.translation()[i]);
        [x, y, z, shift]
    });
    let by_rows = mint::RowMatrix3x4::from(rows);
    assert_eq!(Pose::try_from(by_rows), Ok(want));
    assert_eq!(Pose::try_from(mint::ColumnMatrix3x4::from(by_rows)), Ok(want));
    let single = mint::RowMatrix3x4::from(rows.map(|row| row.map(|x| x as f32)));
    let got = Pose::try_from(single).unwrap();
    assert_eq!(got.rows()[1][2], f64::from(want.rows()[1][2] as f32));
    assert_eq!(
        Pose::try_from(mint::RowMatrix3x4::from([[2.0_f64; 4]; 3])).map(|_| ()),
        Err(PoseError::NotOrthonormal { deviation: 12.0 })
    );
}

#[cfg(feature = "nalgebra")]
#[test]
fn nalgebra_isometries_give_the_pose_that_they_apply() {
    let motion = nalgebra::Isometry3::new(
        nalgebra::Vector3::new(1.0, -2.0, 0.5),
        nalgebra::Vector3::new(0.3, 1.1, -2.0),
    );
    let p = [0.7, 11.0, -3.0];
    let want = motion * nalgebra::Point3::from(p);
    for (pose, off) in
        [(Pose::try_from(motion).unwrap(), 1e-14), (Pose::try_from(motion.cast::<f32>()).unwrap(), 1e-5)]
    {
        let got = pose.apply(p);
        assert!((0..3).all(|i| (got[i] - want[i]).abs() < off), "{want} {got:?}");
    }
    let mut far = motion;
    far.translation.vector[1] = f64::NAN;
    assert_eq!(Pose::try_from(far), Err(PoseError::NotFinite));
}
