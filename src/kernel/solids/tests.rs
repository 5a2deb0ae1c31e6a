//! Verdicts against those of the filter in `f64`. `tests/kernel_law` compares the instruction sets.

use super::*;
use crate::isa::Scalar;
use crate::kernel::Kernel;
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::primitive::shape::fast;
use crate::rng::Rng;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// A sphere, capsule or cuboid near the origin.
fn shape(rng: &mut Rng, edges: usize) -> Shape {
    let is_grid = rng.below(3) == 0;
    let mut length = || {
        let l = if is_grid { rng.int(1, 4) as f64 * 0.25 } else { rng.range(0.1, 1.5) };
        if rng.below(16) == 0 { l * 2.0_f64.powi(-(rng.below(20) as i32)) } else { l }
    };
    let shape = match edges {
        0 => Shape::sphere(length()),
        1 => Shape::capsule(length(), length()),
        _ => Shape::cuboid([length(), length(), length()]),
    };
    let shape = shape.unwrap();
    let shape = if edges == 3 && rng.below(4) == 0 { shape.widened(0.1).unwrap() } else { shape };
    let rows = rng.rotation();
    let rotation = if is_grid { DMat3::IDENTITY } else { DMat3::from_cols_array_2d(&rows) };
    let t =
        core::array::from_fn(|_| if is_grid { rng.int(-4, 4) as f64 * 0.25 } else { rng.range(-1.2, 1.2) });
    shape.moved(&Pose::new(rotation, DVec3::from_array(t)).unwrap())
}

/// The numbers of bits that the kernel decides, and that the filter in `f64` decides.
fn check<const M: usize, const N: usize>(rng: &mut Rng) -> [u32; 2] {
    let query = shape(rng, M);
    let shapes: Vec<_> = (0..rng.int(1, 16)).map(|_| shape(rng, N)).collect();
    let mut lanes = SolidLanes::<N>::new(&shapes).unwrap();
    let mut margin = *rng.pick(&[0.0, 0.0, 0.25, 0.1]);
    if rng.below(2) == 0 {
        // A margin close to the distance of one of them.
        let one = rng.pick(&shapes);
        let (mut low, mut high) = (0.0, 8.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if fast::decide(&query, one, middle) == Some(false) { low = middle } else { high = middle }
        }
        margin = low * (1.0 + rng.range(-1.0, 1.0) * 2.0_f64.powi(-(rng.below(26) as i32)));
    }
    // Shapes of other scales, far away relative to their size.
    let scale = 2.0_f64.powi(*rng.pick(&[0, 0, -15, 20, -25, 40]));
    let shift = if rng.below(4) == 0 { rng.range(-100.0, 100.0) } else { 0.0 };
    let pose = |s: &Shape| {
        let moved = s.moved(&Pose::new(DMat3::IDENTITY, DVec3::new(shift, 0.0, -shift)).unwrap());
        fast::tests::scaled(&moved, scale)
    };
    let (query, shapes) = (pose(&query), shapes.iter().map(pose).collect::<Vec<_>>());
    let margin = margin * scale;
    for (lane, shape) in shapes.iter().enumerate() {
        lanes.set(lane, &Solid::new(shape, 0.0).unwrap());
    }
    let got = Scalar::new().solids(&Solid::<M>::new(&query, margin).unwrap(), &lanes);
    assert_eq!(got.apart & got.within, 0);
    let mut counts = [(got.apart & lanes.used | got.within).count_ones(), 0];
    for lane in 0..16 {
        let Some(shape) = shapes.get(lane) else {
            assert!(got.apart >> lane & 1 == 1 && got.within >> lane & 1 == 0);
            continue;
        };
        let want = fast::decide(&query, shape, margin);
        counts[1] += u32::from(want.is_some());
        for (mask, verdict) in [(got.apart, false), (got.within, true)] {
            if mask >> lane & 1 == 1 {
                assert!(want.is_none_or(|want| want == verdict), "{query:?} {shape:?} {margin:e}");
            }
        }
        assert!(scale < power_of_two(40) || (got.apart | got.within) >> lane & 1 == 0, "out of range");
    }
    counts
}

#[test]
fn verdicts_are_those_of_the_filter() {
    let mut rng = Rng::new(1);
    let mut counts = [0, 0];
    for _ in 0..2000 {
        for [some, all] in [
            check::<0, 0>(&mut rng),
            check::<0, 1>(&mut rng),
            check::<0, 3>(&mut rng),
            check::<1, 0>(&mut rng),
            check::<1, 1>(&mut rng),
            check::<1, 3>(&mut rng),
            check::<3, 0>(&mut rng),
            check::<3, 1>(&mut rng),
            check::<3, 3>(&mut rng),
        ] {
            counts = [counts[0] + some, counts[1] + all];
        }
    }
    assert!(10 * counts[0] > 5 * counts[1], "{counts:?}");
}

/// Cuboids that touch up to a gap or overlap down to 2^-25 of their size, to test the axes.
#[test]
fn touching_cuboids() {
    let mut rng = Rng::new(2);
    let mut certain = 0;
    let count = 6000;
    for _ in 0..count {
        let (a, b) = fast::tests::touching(&mut rng, (2, 2), 25);
        let (query, lanes) = (Solid::<3>::new(&a, 0.0).unwrap(), SolidLanes::<3>::new(&[b, b]).unwrap());
        let (got, want) = (Scalar::new().solids(&query, &lanes), fast::decide(&a, &b, 0.0));
        let verdicts = (got.apart >> 1 & 1 == 1, got.within >> 1 & 1 == 1);
        assert!(verdicts != (true, true) && verdicts.0 == (got.apart & 1 == 1));
        if verdicts != (false, false) {
            certain += 1;
            assert!(want.is_none_or(|want| want == verdicts.1), "{a:?} {b:?}: {verdicts:?}");
        }
    }
    assert!(10 * certain > 4 * count, "{certain}");
}

#[test]
fn other_kinds_have_no_lanes() {
    let (sphere, cone) = (Shape::sphere(1.0).unwrap(), Shape::cone(1.0, 1.0).unwrap());
    assert!(Solid::<3>::new(&sphere, 0.0).is_none() && Solid::<1>::new(&cone, 0.0).is_none());
    assert!(SolidLanes::<0>::new(&[sphere, cone]).is_none() && SolidLanes::<0>::new(&[]).is_some());
}
