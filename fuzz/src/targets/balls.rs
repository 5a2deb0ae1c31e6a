//! Overlap masks and bounds on shared volumes of balls are the same on every instruction set; and for moderate numbers
//! the shared volume of two balls does not exceed the bound.

use crate::planes::float;
use crate::spheres::{distance, lens};
use crate::{Input, Mode, on_every_isa};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::node::{Ball16, BoundingBall};

/// Initial value of rows and bounds, which no kernel returns.
const ROW: u16 = 0x5a5a;
const BOUND: f32 = -0.5;

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, other) = (input.mode(), input.mode());
    let (lane, wanted) = (input.below(16), input.u16());
    let a = balls(&mut input, mode);
    let mut b = balls(&mut input, if mode == Mode::AnyBits { other } else { mode });
    if mode == Mode::Real {
        (0..16).for_each(|to| touch(&a.lane(lane), to, &mut b, &mut input));
    }
    let want = rows_and_bounds(Scalar::new(), &a, wanted, lane, &b);
    on_every_isa!(kernel => {
        let got = rows_and_bounds(kernel, &a, wanted, lane, &b);
        assert_eq!((got.0, got.1.map(bits)), (want.0, want.1.map(bits)), "{kernel:?} {wanted:x} {lane} {a:?} {b:?}");
    });
    let (rows, bounds) = want;
    for row in (0..16).filter(|row| wanted >> row & 1 == 0) {
        assert_eq!(rows[row], ROW, "a row that is not wanted");
    }
    let mut met = [ROW; 16];
    Scalar::new().balls_meet(&a, 1 << lane, &b, &mut met);
    for (to, bound) in bounds.iter().enumerate() {
        let (one, other) = (a.lane(lane), b.lane(to));
        assert_eq!(*bound > 0.0, met[lane] >> to & 1 != 0, "{bound:e}: {one:?} {other:?}");
        if is_moderate(&one) && is_moderate(&other) {
            let least = least_bound(&one, &other);
            assert!(f64::from(*bound) >= least, "{bound:e} is below {least:e}: {one:?} {other:?}");
        }
    }
}

/// All NaNs are equal, whatever their other bits.
fn bits(x: f32) -> u32 {
    if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }
}

fn rows_and_bounds<E: Kernel>(
    kernel: E,
    a: &Ball16,
    wanted: u16,
    lane: usize,
    b: &Ball16,
) -> ([u16; 16], [f32; 16]) {
    let (mut rows, mut bounds) = ([ROW; 16], [BOUND; 16]);
    kernel.run(
        #[inline(always)]
        || {
            kernel.balls_meet(a, wanted, b, &mut rows);
            kernel.balls_share(&a.lane(lane), b, &mut bounds);
        },
    );
    (rows, bounds)
}

/// Sixteen balls: on a lattice, so that many touch; with arbitrary bits; or as in trees, with unused lanes.
fn balls(input: &mut Input, mode: Mode) -> Ball16 {
    let mut balls = Ball16::EMPTY;
    for lane in 0..16 {
        let ball = match mode {
            Mode::Grid => BoundingBall {
                centre: [(); 3].map(|()| input.int(-3, 3) as f32),
                radius: input.int(0, 2) as f32,
                volume: input.int(0, 9) as f32,
            },
            Mode::AnyBits => BoundingBall {
                centre: [(); 3].map(|()| float(input, mode)),
                radius: float(input, mode),
                volume: float(input, mode),
            },
            Mode::Real if input.one_in(5) => BoundingBall::EMPTY,
            Mode::Real => {
                let centre = [(); 3].map(|()| f32::from(input.u16() as i16) / 256.0);
                let radius = f32::from(input.u16()) / 512.0 * (-(input.int(0, 16) as f32)).exp2();
                let fill = f32::from(input.u8()) / 60.0;
                BoundingBall { centre, radius, volume: radius.powi(3) * fill }
            }
        };
        balls.set(lane, &ball);
    }
    balls
}

/// Sometimes moves a ball to where it nearly touches another from the outside, or from the inside.
fn touch(one: &BoundingBall, lane: usize, balls: &mut Ball16, input: &mut Input) {
    let (choice, mut ball) = (input.below(4), balls.lane(lane));
    if choice < 2 {
        return;
    }
    let way = [(); 3].map(|()| f32::from(input.u8() as i8));
    let length = way.iter().map(|x| x * x).sum::<f32>().sqrt().max(1.0);
    let apart = if choice == 2 { one.radius + ball.radius } else { (one.radius - ball.radius).abs() };
    let off = ball.radius * f32::from(input.u8() as i8) * (-(input.int(0, 24) as f32)).exp2();
    ball.centre = core::array::from_fn(|i| one.centre[i] + way[i] / length * (apart + off));
    balls.set(lane, &ball);
}

/// Whether squares and cubes of the numbers are far from the limits of `f32`, and no radius is negative.
fn is_moderate(ball: &BoundingBall) -> bool {
    let most = 1_048_576.0;
    ball.centre.iter().all(|x| x.abs() <= most)
        && (0.0..=most).contains(&ball.radius)
        && ball.volume.is_finite()
}

/// The shared volume of two balls, in `f64`. If they hardly overlap, that of slightly smaller balls, since the kernels
/// rely there on the padding of rotated balls.
fn least_bound(a: &BoundingBall, b: &BoundingBall) -> f64 {
    let (r, s) = (f64::from(a.radius), f64::from(b.radius));
    let d = distance(&a.centre.map(f64::from), &b.centre.map(f64::from));
    let rim = 16.0 / 16_777_216.0 * (d + r + s);
    let shared = lens((r - rim).max(0.0), s, d).min(lens(r, s, d));
    shared.min(a.volume.into()).min(b.volume.into()) * (1.0 - 1e-9)
}
