//! Which points and boxes are within reach, their distances, and the slots of a mask are the same on every instruction
//! set; and with this rounding no box is farther than a point in it.

use crate::planes::float;
use crate::{Input, Mode, on_every_isa};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::node::{Aabb16, Box3, Bucket};

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let mode = input.mode();
    let q = [(); 3].map(|()| float(&mut input, mode));
    let mut query = Box3::of_point(q);
    if input.one_in(2) {
        query = other_corner(q, &mut input, mode);
    }
    let (node, bucket) = node_and_bucket(&mut input, mode);
    let mut distances = [[0.0; 16]; 2];
    Scalar::new().box_squares(&query, &node, &mut distances[0]);
    Scalar::new().point_squares(q, &bucket, &mut distances[1]);
    let one = distances[input.below(2)][input.below(16)];
    let square = match input.below(4) {
        0 => float(&mut input, mode),
        1 => one.next_down(),
        _ => one,
    };
    let want = answer(Scalar::new(), &query, q, square, (&node, &bucket));
    on_every_isa!(kernel => {
        let got = answer(kernel, &query, q, square, (&node, &bucket));
        assert_eq!(got, want, "{kernel:?} {query:?} {q:?} {square:e} {node:?} {bucket:?}");
    });
    for (mask, squares) in [want.boxes, want.points].iter().zip(distances) {
        assert!((0..16).all(|lane| (mask >> lane & 1 != 0) == (squares[lane] <= square)));
    }
    let slots = (0..16).filter(|slot| want.points >> slot & 1 != 0);
    assert!(want.picked.iter().copied().eq(slots.map(|slot| bucket.indices[slot])));
    // Unless something is infinite or NaN, a box that has the point as a corner is not farther than the point.
    for lane in 0..16 {
        let (of, p) = (node.lane(lane), bucket.coordinates.map(|of| of[lane]));
        let holds = (0..3).all(|i| of.lower[i] <= p[i] && p[i] <= of.upper[i]);
        if holds
            && of.lower.iter().chain(&of.upper).chain(&query.lower).chain(&query.upper).all(|x| x.is_finite())
        {
            let holds_q = (0..3).all(|i| query.lower[i] <= q[i] && q[i] <= query.upper[i]);
            assert!(!holds_q || distances[0][lane] <= distances[1][lane], "{query:?} {q:?} {of:?} {p:?}");
        }
    }
}

/// Two corners with arbitrary bits, not always the lower one first.
fn other_corner(p: [f32; 3], input: &mut Input, mode: Mode) -> Box3 {
    let ends = p.map(|x| {
        let y = float(input, mode);
        let in_order = x <= y || mode == Mode::AnyBits && input.one_in(8);
        if in_order { (x, y) } else { (y, x) }
    });
    Box3 { lower: ends.map(|end| end.0), upper: ends.map(|end| end.1) }
}

/// Points, and boxes of which they are corners; some lanes are unused.
fn node_and_bucket(input: &mut Input, mode: Mode) -> (Aabb16, Bucket) {
    let (mut node, mut bucket) = (Aabb16::EMPTY, Bucket::EMPTY);
    for lane in 0..16 {
        let p = [(); 3].map(|()| float(input, mode));
        let of = other_corner(p, input, mode);
        if input.one_in(8) {
            continue;
        }
        for (i, x) in p.into_iter().enumerate() {
            (node.lower[i][lane], node.upper[i][lane]) = (of.lower[i], of.upper[i]);
            bucket.coordinates[i][lane] = x;
        }
        bucket.indices[lane] = input.u32();
    }
    (node, bucket)
}

#[derive(PartialEq, Debug)]
struct Answer {
    boxes: u16,
    points: u16,
    /// All NaNs are equal, whatever their other bits.
    squares: [[u32; 16]; 2],
    picked: Vec<u32>,
}

fn answer<E: Kernel>(
    kernel: E,
    query: &Box3,
    q: [f32; 3],
    square: f32,
    (node, bucket): (&Aabb16, &Bucket),
) -> Answer {
    // No square is negative.
    let (mut squares, mut found) = ([[-1.0; 16]; 2], [0; 16]);
    let (boxes, points) = kernel.run(
        #[inline(always)]
        || {
            kernel.box_squares(query, node, &mut squares[0]);
            kernel.point_squares(q, bucket, &mut squares[1]);
            let points = kernel.points_near(q, square, bucket);
            kernel.pick(points, &bucket.indices, &mut found);
            (kernel.boxes_near(query, square, node), points)
        },
    );
    let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
    let picked = found[..points.count_ones() as usize].to_vec();
    Answer { boxes, points, squares: squares.map(|of| of.map(bits)), picked }
}
