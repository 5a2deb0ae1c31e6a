//! The kernels of spheres, capsules and cuboids.

use crate::digest::Digest;
use crate::pairs;
use crate::support::rng::Rng;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::primitive::shape::lanes::{Solid, SolidLanes};

/// A solid with numbers of similar size (mode 0), on a lattice, where many touch and edges are parallel (1), or with
/// any bits (2).
fn solid<const N: usize>(rng: &mut Rng, mode: u64) -> Solid<N> {
    const SPECIAL: [f32; 8] =
        [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, f32::MAX, 1e-40];
    let mut number = |low: i64, high: i64| match mode {
        0 => rng.range(low as f64, high as f64) as f32,
        1 => rng.int(low, high) as f32,
        _ if rng.below(3) == 0 => *rng.pick(&SPECIAL),
        _ => f32::from_bits(rng.u64() as u32),
    };
    let centre = [(); 3].map(|()| number(-4, 4));
    let half = [(); N].map(|()| [(); 3].map(|()| number(-1, 1)));
    let mut solid = Solid { centre, half, radius: number(0, 2), ..Solid::EMPTY };
    if mode == 2 {
        (solid.inner, solid.size, solid.skew) = (number(0, 1), number(0, 1), number(0, 1));
        for i in 0..N {
            (solid.inverse[i], solid.extent[i], solid.length[i]) = (number(0, 1), number(0, 1), number(0, 1));
        }
        return solid;
    }
    solid.size = 16.0;
    for i in 0..N {
        let dot = |j: usize| {
            let (g, h) = (&half[i], &half[j]);
            (g[0] * h[0] + g[1] * h[1]) + g[2] * h[2]
        };
        solid.inverse[i] = 1.0 / dot(i);
        (solid.extent[i], solid.length[i]) = ((0..N).map(|j| dot(j).abs()).sum(), dot(i).sqrt());
    }
    solid
}

/// Adds the kernel's masks, for a query with `M` half edges and lanes with `N`, to the digest; returns how many bits
/// are 1.
fn compare<E: Kernel, const M: usize, const N: usize>(
    kernel: E,
    name: &str,
    rng: &mut Rng,
    digest: &mut Digest,
) -> [u32; 2] {
    let mode = rng.below(3);
    let query = solid::<M>(rng, mode);
    let mut lanes = SolidLanes::<N>::EMPTY;
    for lane in 0..16 {
        if rng.below(8) != 0 {
            let mode = if mode == 2 { rng.below(3) } else { mode };
            lanes.set(lane, &solid(rng, mode));
        }
    }
    let got = kernel.run(
        #[inline(always)]
        || kernel.solids(&query, &lanes),
    );
    let want = Scalar::new().solids(&query, &lanes);
    assert_eq!(got, want, "{name}: {query:?} {lanes:?}");
    assert_eq!(
        (got.apart | lanes.used, got.within & !lanes.used),
        (u16::MAX, 0),
        "{name}: unused lanes are apart"
    );
    digest.add(u64::from(got.apart) << 16 | u64::from(got.within));
    [(got.apart & lanes.used).count_ones(), got.within.count_ones()]
}

/// Both masks are those of the scalar kernel.
pub(crate) fn solids_equal_the_scalar_kernel<E: Kernel>(kernel: E, name: &str) {
    let mut rng = Rng::new(11);
    let count = (pairs() / 16).max(1);
    let (mut ones, mut digest) = ([0_u64; 2], Digest::EMPTY);
    for _ in 0..count {
        let (rng, digest) = (&mut rng, &mut digest);
        for [apart, within] in [
            compare::<E, 0, 0>(kernel, name, rng, digest),
            compare::<E, 0, 1>(kernel, name, rng, digest),
            compare::<E, 0, 3>(kernel, name, rng, digest),
            compare::<E, 1, 0>(kernel, name, rng, digest),
            compare::<E, 1, 1>(kernel, name, rng, digest),
            compare::<E, 1, 3>(kernel, name, rng, digest),
            compare::<E, 3, 0>(kernel, name, rng, digest),
            compare::<E, 3, 1>(kernel, name, rng, digest),
            compare::<E, 3, 3>(kernel, name, rng, digest),
        ] {
            ones[0] += u64::from(apart);
            ones[1] += u64::from(within);
        }
    }
    let all = (count * 9 * 16) as f64;
    let shares = ones.map(|n| n as f64 / all);
    assert!(
        cfg!(miri) || shares.iter().all(|share| (0.05..0.7).contains(share)),
        "{shares:?} of the bits are 1"
    );
    println!("{name}: {count} of each pair of solids, {shares:?}, digest {:016x}", digest.0);
}
