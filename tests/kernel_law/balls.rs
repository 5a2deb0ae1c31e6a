//! The kernels of balls.

use crate::digest::{Digest, words};
use crate::pairs;
use crate::support::rng::Rng;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::node::Ball16;

/// Sixteen balls: on a lattice (mode 0), as in trees, with unused lanes (1), or with any bits.
fn balls(rng: &mut Rng, mode: u64) -> Ball16 {
    const SPECIAL: [f32; 8] =
        [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, f32::MAX, 1e-40];
    let mut balls = Ball16::EMPTY;
    for lane in 0..16 {
        let mut ball = balls.lane(lane);
        match mode {
            // Many balls on a lattice touch.
            0 => {
                ball.centre = [(); 3].map(|()| rng.int(-3, 3) as f32);
                (ball.radius, ball.volume) = (rng.int(0, 2) as f32, rng.int(0, 9) as f32);
            }
            1 if rng.below(5) == 0 => {}
            1 => {
                ball.centre = [(); 3].map(|()| rng.range(-90.0, 90.0) as f32);
                ball.radius = rng.range(0.0, 1.0).powi(3) as f32 * 60.0;
                ball.volume = ball.radius.powi(3) * rng.range(0.0, 4.0) as f32;
            }
            _ => {
                let mut any =
                    || if rng.below(3) == 0 { *rng.pick(&SPECIAL) } else { f32::from_bits(rng.u64() as u32) };
                (ball.centre, ball.radius, ball.volume) = ([any(), any(), any()], any(), any());
            }
        }
        balls.set(lane, &ball);
    }
    balls
}

/// Masks and shared volumes are bit for bit those of the scalar kernel. Rows that are not requested stay
/// unchanged.
pub(crate) fn balls_equal_the_scalar_kernel<E: Kernel>(kernel: E, name: &str) {
    let mut rng = Rng::new(5);
    let count = (pairs() / 4).max(1);
    let (mut ones, mut digest) = (0_u64, Digest::EMPTY);
    for i in 0..count {
        let (mode_a, mode_b) = if i % 3 == 2 { (2, rng.below(3)) } else { (i % 3, i % 3) };
        let (a, b) = (balls(&mut rng, mode_a), balls(&mut rng, mode_b));
        let (wanted, lane) = (rng.u64() as u16, rng.below(16) as usize);
        let run = |rows: &mut [u16; 16], shared: &mut [f32; 16]| {
            kernel.run(
                #[inline(always)]
                || {
                    kernel.balls_meet(&a, wanted, &b, rows);
                    kernel.balls_share(&a.lane(lane), &b, shared);
                },
            );
        };
        let (mut got, mut want) = (([0x5a5a; 16], [0.5; 16]), ([0x5a5a; 16], [0.5; 16]));
        run(&mut got.0, &mut got.1);
        Scalar::new().balls_meet(&a, wanted, &b, &mut want.0);
        if cfg!(miri) {
            // libm computes square roots with inline assembly, which Miri does not support: the kernel runs,
            // and its volumes are not compared.
            want.1 = got.1;
        } else {
            Scalar::new().balls_share(&a.lane(lane), &b, &mut want.1);
        }
        // All NaNs count as equal.
        let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
        assert_eq!((got.0, got.1.map(bits)), (want.0, want.1.map(bits)), "{name} pair {i}: {a:?} {b:?}");
        for row in (0..16).filter(|row| wanted >> row & 1 != 0) {
            ones += u64::from(got.0[row].count_ones());
            if row == lane {
                let met = (0..16).fold(0, |mask, i| mask | u16::from(got.1[i] > 0.0) << i);
                assert_eq!(met, got.0[row], "{name} pair {i}: a volume is shared where balls meet");
            }
        }
        words(&got.0).for_each(|word| digest.add(word));
    }
    let share = ones as f64 / (count * 8 * 16) as f64;
    assert!(cfg!(miri) || (0.02..0.6).contains(&share), "{share} of the bits are 1");
    println!("{name}: {count} pairs of sixteen balls, digest {:016x}", digest.0);
}
