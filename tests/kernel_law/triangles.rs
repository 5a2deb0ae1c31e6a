//! The filter of triangle pairs.

use crate::pairs;
use crate::support::rng::Rng;
use simdop::isa::{Isa, on_isa};
use simdop::low_level::kernel::Kernel;
use simdop::primitive::triangle::Probe;

/// On every instruction set the filter of four triangles equals the filter of one. Corners lie on a small grid
/// or on few planes, or have any size.
#[test]
fn filters_of_four_triangles_are_those_of_one() {
    for isa in Isa::available() {
        let mut rng = Rng::new(500);
        let mut apart = [0_u64; 2];
        for i in 0..pairs() / 8 + 4 {
            let size =
                if i % 3 == 0 { f64::from_bits(((1023 + rng.int(-190, 290)) as u64) << 52) } else { 1.0 };
            let mut point = |shift: f64| match i % 4 {
                0 => core::array::from_fn(|_| rng.int(-2, 2) as f64 * size),
                1 => {
                    // An oblique plane, up to rounding.
                    let (x, y) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
                    [x, y, 0.7 - 0.3 * x - 1.1 * y + shift]
                }
                _ => core::array::from_fn(|_| (rng.range(-1.0, 1.0) + shift) * size),
            };
            let one = [point(0.0), point(0.0), point(0.0)];
            let four = [0.0, 0.1, 0.5, 1.0].map(|shift| [point(shift), point(shift), point(shift)]);
            let margin = if i % 2 == 0 { 0.0 } else { rng.range(0.0, 0.5) * size };
            let probe = Probe::with_margin(&one, margin);
            let want = (0..4).fold(0, |mask, k| mask | u16::from(probe.is_apart(&four[k])) << k);
            let got = on_isa!(isa, kernel => kernel.run(#[inline(always)] || kernel.apart_4(&probe, &four)));
            assert_eq!(got, want, "{isa}: {one:?} {four:?}");
            apart[0] += u64::from(want.count_ones());
            apart[1] += 4;
        }
        let share = apart[0] as f64 / apart[1] as f64;
        assert!(cfg!(miri) || (0.3..0.95).contains(&share), "{share} of the pairs are told apart");
    }
}
