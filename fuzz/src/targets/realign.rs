//! Realignment gives the scalar kernel's bits on every instruction set; and the realigned planes of a real tree bound
//! its moved triangles, decided exactly.

use crate::bodies::{Body, bodies, pose, small_body};
use crate::planes::{float, narrow, pair, turned_4, turned_16, wide};
use crate::support::dyadic::{Dyadic, dot};
use crate::values::value;
use crate::{Input, Mode, for_k, on_every_isa};
use simdop::isa::Scalar;
use simdop::low_level::directions;
use simdop::low_level::frame::Frame;
use simdop::low_level::key::Storage;
use simdop::low_level::realign::Realignment;
use simdop::node::{Link, Node4, Node16};
use simdop::pose::Pose;
use simdop::query::Lanes;
use simdop::range::Point;

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, k) = (input.mode(), input.u8());
    for_k!(k, check(&mut input, mode));
}

fn check<const K: usize, S: Storage>(input: &mut Input, mode: Mode)
where
    Node16<K, S>: Lanes<Map = Realignment<K, S>>,
    Node4<K, S>: Lanes<Map = Realignment<K, S>>,
{
    if mode != Mode::Real && !input.one_in(4) {
        let map = any_map::<K, S>(input, mode);
        let (wide, narrow) = (wide(pair::<16, K, S>(input, mode).1), narrow(pair::<4, K, S>(input, mode).1));
        kernels_agree(&map, &wide, &narrow);
        return;
    }
    if mode == Mode::Real {
        let body = input.pick(&bodies().0);
        turned_planes_bound(body, &pose(input, mode), input);
    } else if let Some(body) = small_body(input, mode) {
        turned_planes_bound(&body, &pose(input, mode), input);
    }
}

/// Checks the leaves of the root, realigned to the frame of another body.
fn turned_planes_bound<const K: usize, S: Storage>(a: &Body<Node16<K, S>>, pose: &Pose, input: &mut Input)
where
    Node16<K, S>: Lanes<Map = Realignment<K, S>>,
{
    let b = input.pick(&bodies::<Node16<K, S>>().0).tree.view().frame();
    let view = a.tree.view();
    let map = Realignment::<K, S>::new(pose, &view.extent(), &b);
    let Some(root) = view.nodes().first() else { return };
    let narrow = narrow(root.planes.map(|p| [p[0], p[1], p[2], p[3]]));
    kernels_agree(&map, root, &narrow);

    let query = turned_16(Scalar::new(), &map, root);
    for (lane, child) in root.child.iter().enumerate() {
        if let Link::Leaf { first, count } = child.link() {
            for p in (first..first + count).flat_map(|index| view.primitive(index)) {
                let moved = pose.apply(p);
                for (j, n) in directions::table(K).vectors.iter().enumerate() {
                    let limit = value::<S>(!query[j ^ 1][lane]);
                    assert!(bounds(limit, n, &moved, &b), "k {K} plane {j} {limit} cuts off {moved:?}");
                }
            }
        }
    }
}

fn kernels_agree<const K: usize, S: Storage>(
    map: &Realignment<K, S>,
    wide: &Node16<K, S>,
    narrow: &Node4<K, S>,
) {
    let (want_16, want_4) = (turned_16(Scalar::new(), map, wide), turned_4(Scalar::new(), map, narrow));
    on_every_isa!(kernel => {
        assert_eq!(turned_16(kernel, map, wide), want_16, "{kernel:?} k {K} {map:?} {wide:x?}");
        assert_eq!(turned_4(kernel, map, narrow), want_4, "{kernel:?} k {K} {map:?} {narrow:x?}");
    });
}

/// A map with arbitrary values, except negative weights.
fn any_map<const K: usize, S: Storage>(input: &mut Input, mode: Mode) -> Realignment<K, S> {
    let mut float = || float(input, mode);
    let mut map = Realignment::from_parts([[0; 4]; K], [[0.0; K]; 3], [0.0; K]);
    for j in 0..K {
        for weights in &mut map.weights {
            weights[j] = float().abs();
        }
        map.offset[j] = float();
    }
    for source in map.sources.as_flattened_mut() {
        *source = input.u8() % K as u8;
    }
    map
}

/// Whether `limit` is an upper bound on `n . p` in the frame. Intervals far wider than the rounding errors decide most
/// cases.
fn bounds(limit: f64, n: &[i8; 3], p: &Point, frame: &Frame) -> bool {
    assert!(!limit.is_nan(), "{limit} is no bound");
    if limit == f64::INFINITY {
        return true;
    }
    let scale = frame.scale();
    let (mut value, mut size) = (0.0, limit.abs());
    for i in 0..3 {
        value += f64::from(n[i]) * (p[i] - frame.centre[i]) * scale;
        size += f64::from(n[i]).abs() * (p[i].abs() + frame.centre[i].abs()) * scale;
    }
    if (value - limit).abs() > 64.0 * f64::EPSILON * size {
        return value < limit;
    }
    let offset = [0, 1, 2].map(|i| Dyadic::from(p[i]) - Dyadic::from(frame.centre[i]));
    let support = dot(n.map(|x| Dyadic::from(f64::from(x))), offset) * Dyadic::power_of_two(frame.exponent);
    support <= Dyadic::from(limit)
}
