//! The kernels of points and of boxes of points.

use crate::digest::{Digest, words};
use crate::pairs;
use crate::support::rng::Rng;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::node::{Aabb16, Box3, Bucket};

/// How numbers are drawn.
#[derive(Copy, Clone, PartialEq, Debug)]
enum Mode {
    /// Small integers, also as the squared radius: often a point is exactly at the radius.
    Lattice,
    /// Numbers of similar size. The squared radius is often one of the squared distances, or the next number
    /// below it.
    Near,
    /// Any finite numbers: subnormal differences, squares that are zero or infinite.
    Finite,
    /// Any bits: infinities, NaNs of any payload, -0, boxes whose lower corner is above the upper one.
    AnyBits,
}

const MODES: [Mode; 4] = [Mode::Lattice, Mode::Near, Mode::Finite, Mode::AnyBits];

fn number(rng: &mut Rng, mode: Mode) -> f32 {
    const SPECIAL: [f32; 10] = [
        0.0,
        -0.0,
        1.0,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    match mode {
        Mode::Lattice => rng.int(-3, 3) as f32,
        Mode::Near => rng.range(-1.0, 1.0) as f32,
        Mode::AnyBits if rng.below(2) == 0 => number(rng, Mode::Lattice),
        Mode::AnyBits if rng.below(2) == 0 => *rng.pick(&SPECIAL),
        Mode::AnyBits => f32::from_bits(rng.u64() as u32),
        Mode::Finite if rng.below(3) == 0 => *rng.pick(&SPECIAL[..7]),
        Mode::Finite => loop {
            let any = f32::from_bits(rng.u64() as u32);
            if any.is_finite() {
                break any;
            }
        },
    }
}

fn point(rng: &mut Rng, mode: Mode) -> [f32; 3] {
    [(); 3].map(|()| number(rng, mode))
}

/// A box; in a quarter of the cases, a point.
fn some_box(rng: &mut Rng, mode: Mode) -> Box3 {
    let (p, q) = (point(rng, mode), point(rng, mode));
    match rng.below(4) {
        0 => Box3::of_point(p),
        _ if mode == Mode::AnyBits => Box3 { lower: p, upper: q },
        _ => {
            // A tenth of the range of the points, so that most boxes are separate.
            let share = if mode == Mode::Near { 0.1 } else { 1.0 };
            let end = |i: usize| if mode == Mode::Near { p[i] + share * q[i] } else { q[i] };
            let ends = [0, 1, 2].map(|i| (p[i], end(i)));
            Box3 { lower: ends.map(|(x, y)| x.min(y)), upper: ends.map(|(x, y)| x.max(y)) }
        }
    }
}

/// A node and a bucket. One lane in eight is unused.
fn node_and_bucket(rng: &mut Rng, mode: Mode) -> (Aabb16, Bucket) {
    let (mut node, mut bucket) = (Aabb16::EMPTY, Bucket::EMPTY);
    for lane in 0..16 {
        let (of, p) = (some_box(rng, mode), point(rng, mode));
        if rng.below(8) != 0 {
            for (i, x) in p.into_iter().enumerate() {
                (node.lower[i][lane], node.upper[i][lane]) = (of.lower[i], of.upper[i]);
                bucket.coordinates[i][lane] = x;
            }
            bucket.indices[lane] = rng.u64() as u32;
        }
    }
    (node, bucket)
}

/// The square of a radius.
fn square(rng: &mut Rng, mode: Mode, distances: &[f32; 16]) -> f32 {
    let one = *rng.pick(distances);
    match (mode, rng.below(4)) {
        (Mode::Lattice, _) => rng.int(0, 12) as f32,
        (_, 0) => one,
        (_, 1) => one.next_down(),
        (Mode::Near, _) => rng.range(0.0, 2.0) as f32,
        (_, 2) => number(rng, mode),
        _ => *rng.pick(&[0.0, -0.0, f32::MAX, f32::INFINITY, f32::MIN_POSITIVE]),
    }
}

/// A kernel's answer: masks of boxes and of points, and squared distances.
#[derive(PartialEq, Debug)]
struct Answer {
    masks: [u16; 2],
    /// All NaNs count as equal.
    squares: [[u32; 16]; 2],
}

fn answer<E: Kernel>(
    kernel: E,
    query: (&Box3, [f32; 3]),
    square: f32,
    (node, bucket): &(Aabb16, Bucket),
) -> Answer {
    // Squares are never negative.
    let mut squares = [[-1.0; 16]; 2];
    let masks = kernel.run(
        #[inline(always)]
        || {
            kernel.box_squares(query.0, node, &mut squares[0]);
            kernel.point_squares(query.1, bucket, &mut squares[1]);
            [kernel.boxes_near(query.0, square, node), kernel.points_near(query.1, square, bucket)]
        },
    );
    let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
    Answer { masks, squares: squares.map(|of| of.map(bits)) }
}

pub(crate) fn points_equal_the_scalar_kernel<E: Kernel>(kernel: E, name: &str) {
    let mut rng = Rng::new(7);
    let count = if cfg!(miri) { 12 } else { pairs() };
    let mut digest = Digest::EMPTY;
    for mode in MODES {
        let mut ones = [0_u64; 2];
        for i in 0..count / 4 {
            let (around, p) = (some_box(&mut rng, mode), point(&mut rng, mode));
            // A single query is a box that is a point.
            let around = if rng.below(2) == 0 { around } else { Box3::of_point(p) };
            let of = node_and_bucket(&mut rng, mode);
            let mut distances = [0.0; 16];
            match rng.below(2) {
                0 => Scalar::new().box_squares(&around, &of.0, &mut distances),
                _ => Scalar::new().point_squares(p, &of.1, &mut distances),
            }
            let square = square(&mut rng, mode, &distances);
            let got = answer(kernel, (&around, p), square, &of);
            let want = answer(Scalar::new(), (&around, p), square, &of);
            assert_eq!(got, want, "{name} {mode:?} {i}: {around:?} {p:?} {square:e} {of:?}");
            for (side, squares) in got.squares.iter().enumerate() {
                let near = |lane: usize| f32::from_bits(squares[lane]) <= square;
                let mask = (0..16).fold(0, |mask, lane| mask | u16::from(near(lane)) << lane);
                assert_eq!(got.masks[side], mask, "{name} {mode:?} {i}: as the squares say");
                ones[side] += u64::from(mask.count_ones());
                squares.iter().for_each(|&bits| digest.add(bits.into()));
            }
            words(&got.masks).for_each(|word| digest.add(word));
        }
        let shares = ones.map(|ones| ones as f64 / (count / 4 * 16) as f64);
        assert!(
            cfg!(miri) || shares.iter().all(|share| (0.05..0.8).contains(share)),
            "{mode:?}: {shares:?} of the bits are 1"
        );
    }
    println!("{name}: {count} queries against sixteen boxes and sixteen points, digest {:016x}", digest.0);
}

/// For every mask: the indices of the slots that are set, in order. The rest of the output is unspecified.
pub(crate) fn picks_are_the_slots_of_the_mask<E: Kernel>(kernel: E, name: &str) {
    let mut rng = Rng::new(8);
    for mask in (0..=u16::MAX).step_by(if cfg!(miri) { 2979 } else { 1 }) {
        let indices = [(); 16].map(|()| rng.u64() as u32);
        let mut found = [0; 16];
        kernel.run(
            #[inline(always)]
            || kernel.pick(mask, &indices, &mut found),
        );
        let want: Vec<_> = (0..16).filter(|slot| mask >> slot & 1 != 0).map(|slot| indices[slot]).collect();
        assert_eq!(found[..want.len()], want, "{name} {mask:#x}");
    }
}

/// A box with `p` as a corner; in each coordinate `p` is the lower or the upper end.
fn around(rng: &mut Rng, p: [f32; 3]) -> Box3 {
    let mode = *rng.pick(&MODES[..3]);
    let ends = p.map(|x| (x, if rng.below(3) == 0 { x } else { number(rng, mode) }));
    Box3 { lower: ends.map(|(x, y)| x.min(y)), upper: ends.map(|(x, y)| x.max(y)) }
}

/// The reason why a search may skip a box, and a packet may skip it for all of its queries: as rounded, squared
/// distances do not decrease when a box, on either side, is replaced by a point in it. Any finite numbers.
#[test]
fn a_box_is_not_farther_than_what_is_in_it() {
    let mut rng = Rng::new(9);
    let scalar = Scalar::new();
    let mut digest = Digest::EMPTY;
    for i in 0..if cfg!(miri) { 10 } else { pairs() } {
        // Numbers mostly of one mode, so that seldom one dominates the others.
        let mode = MODES[i as usize % 3];
        let any = |rng: &mut Rng| if rng.below(4) == 0 { *rng.pick(&MODES[..3]) } else { mode };
        let asks = any(&mut rng);
        let q = point(&mut rng, asks);
        let packet = around(&mut rng, q);
        let (mut node, mut wider, mut bucket) = (Aabb16::EMPTY, Aabb16::EMPTY, Bucket::EMPTY);
        for lane in 0..16 {
            let of = any(&mut rng);
            let p = point(&mut rng, of);
            let inner = around(&mut rng, p);
            let mut outer = inner;
            outer.add(&some_box(&mut rng, mode));
            for (i, x) in p.into_iter().enumerate() {
                (node.lower[i][lane], node.upper[i][lane]) = (inner.lower[i], inner.upper[i]);
                (wider.lower[i][lane], wider.upper[i][lane]) = (outer.lower[i], outer.upper[i]);
                bucket.coordinates[i][lane] = x;
            }
        }
        let boxes = |query: &Box3, node: &Aabb16| {
            let mut squares = [-1.0; 16];
            scalar.box_squares(query, node, &mut squares);
            squares
        };
        let mut to_points = [-1.0; 16];
        scalar.point_squares(q, &bucket, &mut to_points);
        let single = Box3::of_point(q);
        let chain = [boxes(&packet, &wider), boxes(&packet, &node), boxes(&single, &node), to_points];
        for lane in 0..16 {
            let squares = chain.map(|squares| squares[lane]);
            assert!(
                squares[0] >= 0.0 && squares.is_sorted(),
                "{squares:?}: {q:?} {packet:?} {node:?} {bucket:?}"
            );
            squares.iter().for_each(|x| digest.add(x.to_bits().into()));
        }
        // Boxes that are the points themselves are exactly as far as the points.
        let flat = Aabb16 { lower: bucket.coordinates, upper: bucket.coordinates, ..node };
        assert_eq!(boxes(&single, &flat).map(f32::to_bits), to_points.map(f32::to_bits), "{q:?} {bucket:?}");
        for square in to_points {
            let near = scalar.points_near(q, square, &bucket);
            assert_eq!(near & !scalar.boxes_near(&packet, square, &node), 0, "{q:?} {square:e} {node:?}");
        }
    }
    println!("scalar: squares of boxes and of points in them, digest {:016x}", digest.0);
}
