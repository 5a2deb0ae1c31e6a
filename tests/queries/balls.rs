//! The bounding balls of trees of spheres: they contain everything below them, are not larger than necessary,
//! and bound the volume that two bodies share.

use crate::aligned;
use crate::lens::lens;
use crate::support::dyadic::{Dyadic, dot};
use crate::support::rng::Rng;
use crate::support::shapes;
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::construct::{Builder, Magnification, SphereSet, Splitter};
use simdop::hierarchy::{Bvh, BvhRef, FormatError, Header};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::node::{Ball16, BoundingBall, Child, Link, Node4, Node16};
use simdop::primitive::{Primitive, Sphere, Spheres};
use simdop::query::Lanes;
use std::f64::consts::PI;

type Tree = Bvh<Node16<6>, Spheres>;

fn build<N: Lanes>(spheres: &[Sphere], builder: Builder) -> Bvh<N, Spheres> {
    builder.build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Spheres of different sizes around a point; some coincide, some are inside others, some are points.
fn spheres(rng: &mut Rng, count: usize, unit: f64, at: f64) -> Vec<Sphere> {
    let mut spheres = Vec::<Sphere>::new();
    while spheres.len() < count {
        let sphere = match rng.below(8) {
            0 if !spheres.is_empty() => *rng.pick(&spheres),
            1 if !spheres.is_empty() => {
                Sphere { radius: 0.5 * rng.pick(&spheres).radius, ..*rng.pick(&spheres) }
            }
            kind => Sphere {
                centre: [(); 3].map(|()| unit * (at + rng.range(-1.0, 1.0))),
                radius: if kind == 2 { 0.0 } else { unit * 10_f64.powf(rng.range(-6.0, -0.5)) },
            },
        };
        spheres.push(sphere);
    }
    spheres
}

/// The primitives below a lane.
fn below(tree: &BvhRef<'_, Node16<6>, Spheres>, child: Child) -> Vec<Sphere> {
    match child.link() {
        Link::Empty => vec![],
        Link::Leaf { first, count } => (first..first + count).map(|index| tree.primitive(index)).collect(),
        Link::Inner(node) => {
            tree.nodes()[node as usize].child.iter().flat_map(|child| below(tree, *child)).collect()
        }
    }
}

/// Whether a sphere is within a ball of the tree's frame, in exact arithmetic.
fn holds(tree: &BvhRef<'_, Node16<6>, Spheres>, ball: &BoundingBall, sphere: &Sphere) -> bool {
    let (frame, number) = (tree.frame(), |x: f64| Dyadic::from(x));
    let scale = number(frame.scale());
    let way: [Dyadic; 3] = core::array::from_fn(|i| {
        (number(sphere.centre[i]) - number(frame.centre[i])) * scale.clone() - number(ball.centre[i].into())
    });
    let room = number(ball.radius.into()) - number(sphere.radius) * scale;
    room >= number(0.0) && room.clone() * room >= dot(way.clone(), way)
}

fn check(spheres: &[Sphere], builder: Builder) {
    let tree: Tree = build(spheres, builder);
    tree.view().verify().unwrap();
    let view = BvhRef::<Node16<6>, Spheres>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!(view.balls().len(), view.nodes().len());
    assert_eq!(view.stats().ball_bytes, 320 * view.nodes().len());
    for (node, balls) in view.nodes().iter().zip(view.balls()) {
        for (lane, child) in node.child.iter().enumerate() {
            let (ball, below) = (balls.lane(lane), below(&view, *child));
            assert!(below.iter().all(|sphere| holds(&view, &ball, sphere)), "{ball:?} {below:?}");
            let scale = view.frame().scale();
            let volume: f64 = below.iter().map(|s| 4.0 / 3.0 * PI * (s.radius * scale).powi(3)).sum();
            let said = f64::from(ball.volume);
            assert!(said >= volume * (1.0 - 1e-12) && said <= volume * 1.000_001 + 1e-38, "{said} {volume}");
            if let [sphere] = below[..] {
                // The sphere itself, except for the rounding of its centre.
                assert!(f64::from(ball.radius) <= sphere.radius * scale * 1.000_001 + 5e-3);
            }
        }
    }
}

#[test]
fn balls_hold_what_is_below() {
    let mut rng = Rng::new(1);
    let splitters = [
        Splitter::MeanWidth,
        Splitter::ExtendedLongestAxis,
        Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 },
    ];
    for (i, splitter) in splitters.into_iter().enumerate() {
        for (unit, at) in [(1.0, 0.0), (1e-60, 0.3), (1e70, 0.0), (1.0, 1e9), (3.0, 0.0)] {
            let spheres = spheres(&mut rng, 300, unit, at);
            check(&spheres, Builder::new().splitter(splitter).leaf_size(1 + 5 * i as u32));
        }
    }
    for count in 1..40 {
        check(&spheres(&mut rng, count, 1.0, 0.0), Builder::new());
        check(&spheres(&mut rng, count, 1.0, 0.0), Builder::new().leaf_size(16));
    }
    let point = Sphere { centre: [1.0, -2.0, 1e-3], radius: 0.0 };
    check(&[point; 20], Builder::new());
    check(&[], Builder::new());
}

#[test]
fn trees_may_do_without() {
    let spheres = spheres(&mut Rng::new(2), 100, 1.0, 0.0);
    let with: Tree = build(&spheres, Builder::new());
    let without: Tree = build(&spheres, Builder::new().without_balls());
    without.view().verify().unwrap();
    assert_eq!((without.view().balls().len(), without.view().stats().ball_bytes), (0, 0));
    let balls = size_of_val(with.view().balls());
    assert_eq!(with.as_bytes().len(), without.as_bytes().len() + balls);
    assert!(build::<Node4<6>>(&spheres, Builder::new()).view().balls().is_empty());
}

/// A tree with some changed bytes: the error of reading it, or of verifying it.
fn changed(tree: &Tree, change: impl FnOnce(&mut [u8])) -> (Option<FormatError>, Option<u32>) {
    let mut lines = aligned(tree.as_bytes());
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
    change(bytes);
    match BvhRef::<Node16<6>, Spheres>::from_bytes(&bytes[..tree.as_bytes().len()]) {
        Ok(view) => (None, view.verify().err().map(|error| error.plane)),
        Err(error) => (Some(error), None),
    }
}

#[test]
fn what_is_wrong_with_balls_is_said() {
    let tree: Tree = build(&spheres(&mut Rng::new(3), 100, 1.0, 0.0), Builder::new().leaf_size(2));
    let view = tree.view();
    let start = 128 + size_of_val(view.nodes());
    let with = |node: usize, change: &dyn Fn(&mut Ball16)| {
        changed(&tree, |bytes| {
            let place = &mut bytes[start + 320 * node..][..320];
            let mut balls: Ball16 = bytemuck::pod_read_unaligned(place);
            change(&mut balls);
            place.copy_from_slice(bytemuck::bytes_of(&balls));
        })
    };
    assert_eq!(with(0, &|_| ()), (None, None));
    let mut unused = 0;
    for (index, node) in view.nodes().iter().enumerate() {
        for (lane, child) in node.child.iter().enumerate() {
            let refused = |change: &dyn Fn(&mut Ball16)| {
                let (node, lane) = (index as u32, lane as u32);
                let problem = "a ball is not finite, or larger than the body";
                assert_eq!(with(index, change), (Some(FormatError::Node { node, lane, problem }), None));
            };
            if *child == Child::EMPTY {
                unused += 1;
                refused(&|balls| balls.centre[1][lane] = 0.0);
                refused(&|balls| balls.centre[2][lane] = -f32::NAN);
                refused(&|balls| balls.radius[lane] = 1.0);
                refused(&|balls| balls.volume[lane] = f32::MIN_POSITIVE);
                continue;
            }
            let [x, ..] = view.header().half_width;
            refused(&|balls| balls.centre[0][lane] = x.next_up());
            refused(&|balls| balls.centre[0][lane] = f32::NAN);
            refused(&|balls| balls.radius[lane] = -f32::MIN_POSITIVE);
            refused(&|balls| balls.radius[lane] = f32::NAN);
            refused(&|balls| balls.radius[lane] = 1e6);
            refused(&|balls| balls.volume[lane] = f32::INFINITY);
            refused(&|balls| balls.volume[lane] = -1.0);
            // The spheres below touch the ball, up to rounding.
            assert_eq!(with(index, &|balls| balls.radius[lane] *= 0.999_99), (None, Some(8)));
            let is_point = view.balls()[index].volume[lane] < f32::MIN_POSITIVE;
            let cut = with(index, &|balls| balls.volume[lane] *= 0.999_99);
            assert_eq!(cut, (None, if is_point { None } else { Some(9) }));
        }
    }
    assert!(unused > 0);
    let flag = offset_of!(Header, has_balls);
    let (refused, _) = changed(&tree, |bytes| bytes[flag] = 2);
    assert_eq!(refused, Some(FormatError::Header { field: "has_balls" }));
    let (refused, _) = changed(&tree, |bytes| bytes[flag] = 0);
    assert!(matches!(refused, Some(FormatError::TooLong { .. })));
}

/// The flag is rejected before anything behind it is read: with other nodes the balls would not be aligned.
#[test]
fn trees_that_have_no_balls_cannot_say_so() {
    fn flagged<N: Lanes, P: Primitive>(tree: &Bvh<N, P>) -> Option<FormatError> {
        let mut lines = aligned(tree.as_bytes());
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        bytes[offset_of!(Header, has_balls)] = 1;
        BvhRef::<N, P>::from_bytes(&bytes[..tree.as_bytes().len()]).err()
    }
    let want = Some(FormatError::Header { field: "has_balls" });
    let spheres = spheres(&mut Rng::new(4), 100, 1.0, 0.0);
    assert_eq!(flagged(&build::<Node4<6>>(&spheres, Builder::new())), want);
    let mesh = shapes::torus(5, 3);
    assert_eq!(flagged(&crate::build::<Node4<14>>(&mesh)), want);
    assert_eq!(flagged(&crate::build::<Node16<18>>(&mesh)), want);
}

/// Balls of any sizes, and balls whose sizes differ by a factor of 1000 where the smaller one just leaves the
/// larger: there the lens depends little on the larger radius, and digits cancel.
#[test]
fn bounds_of_volumes_are_those_of_the_lens() {
    let mut rng = Rng::new(4);
    let mut by_lens = 0;
    for round in 0..60_000 {
        let size = 10_f64.powf(rng.range(-3.0, 2.0));
        let mut ball = |share: f64| {
            let centre = [(); 3].map(|()| rng.range(-1.0, 1.0) as f32);
            let radius = (size * share * 10_f64.powf(rng.range(-2.0, 0.0))) as f32;
            let volume = (8.4 * f64::from(radius).powi(3) * rng.range(0.0, 1.0)) as f32;
            BoundingBall { centre, radius, volume }
        };
        let (mut a, mut b) = (ball(1.0), ball(1.0));
        if round % 2 == 1 {
            b = ball(0.1_f64.powi(round / 2 % 5));
            let way = rng.rotation()[0];
            let d = f64::from(a.radius) + f64::from(b.radius) * rng.range(-1.001, 1.0).powi(3);
            b.centre = core::array::from_fn(|i| a.centre[i] + (way[i] * d) as f32);
            (a.volume, b.volume) = (f32::MAX, f32::MAX);
        }
        if rng.below(2) == 0 {
            core::mem::swap(&mut a, &mut b);
        }
        let (mut balls, mut shared) = (Ball16::EMPTY, [0.0; 16]);
        balls.set(5, &b);
        Scalar::new().balls_share(&a, &balls, &mut shared);
        assert!((0..16).all(|lane| lane == 5 || shared[lane] == 0.0), "unused lanes");
        let got = f64::from(shared[5]);
        let way: [f64; 3] = core::array::from_fn(|i| f64::from(a.centre[i]) - f64::from(b.centre[i]));
        let distance = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (r, s) = (f64::from(a.radius), f64::from(b.radius));
        let of_lens = lens(r, s, distance);
        let want = of_lens.min(a.volume.into()).min(b.volume.into());
        // Balls that barely meet are the concern of the radii's pads.
        if distance < (r + s) * (1.0 - 1e-6) {
            assert!(got >= want * (1.0 - 1e-9), "{a:?} {b:?}: {got:e} is below {want:e}");
        }
        let slack = 2e-5 * (r + s) * r.min(s).powi(2) + 1e-5 * want + 1e-29;
        assert!(got <= want + slack, "{a:?} {b:?}: {got:e} is not {want:e}");
        by_lens += u32::from(want > 0.0 && want == of_lens);
    }
    assert!(by_lens > 20_000, "{by_lens}");
}
