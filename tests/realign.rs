//! Realignment loses no collision: the rotated planes bound every moved point, which exact arithmetic decides;
//! and they are not much wider than necessary.

#[path = "support/one_point.rs"]
mod one_point;
mod support;

use one_point::{NO_EXTENT, OnePoint, for_each_k};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::BvhRef;
use simdop::low_level::directions::{self, Directions};
use simdop::low_level::frame::{BodyBounds, Frame};
use simdop::low_level::key::{Fixed, Key};
use simdop::low_level::realign::{InversePose, Realignment};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::Lanes;
use simdop::range::MIN_COORDINATE;
use simdop::range::Point;
use support::data::suite_step;
use support::dyadic::{Dyadic, dot, key_value};
use support::rng::Rng;
use support::shapes;
use support::turns::{add, pose, random_point, rotation};

// ---- Difficult poses and frames ---------------------------------------------------------------------------

/// The exponent that scales this size to between 2^12 and 2^13, similar to the builder's.
fn exponent_for(size: f64) -> i32 {
    12 - ((size.to_bits() >> 52) as i32 - 1023)
}

/// The body's size relative to the other body's, and the distance of its coordinates from the origin relative
/// to its size.
fn size_and_distance(rng: &mut Rng) -> (f64, f64) {
    (*rng.pick(&[1e-3, 0.05, 1.0, 1.0, 30.0, 1e3]), *rng.pick(&[0.0, 1.0, 1.0, 1e3, 1e6, 1e12]))
}

// ---- The exact decision -----------------------------------------------------------------------------------

fn offset(p: f64, centre: f64) -> Dyadic {
    Dyadic::from(p) - Dyadic::from(centre)
}

fn exact_support(n: &[i8; 3], p: &Point, frame: &Frame) -> Dyadic {
    let n = n.map(|x| Dyadic::from(f64::from(x)));
    let d = [0, 1, 2].map(|i| offset(p[i], frame.centre[i]));
    dot(n, d) * Dyadic::power_of_two(frame.exponent)
}

/// Whether the plane is an upper bound of `n . p` in the frame. Intervals that are far wider than the rounding
/// errors decide most cases.
fn bounds(key: Key, n: &[i8; 3], p: &Point, frame: &Frame) -> bool {
    let limit = key_value(key.code());
    assert!(!limit.is_nan(), "{key:?} is no bound");
    if limit == f64::INFINITY {
        return true;
    }
    let scale = f64::from_bits(((frame.exponent + 1023) as u64) << 52);
    let (mut value, mut size) = (0.0, limit.abs());
    for i in 0..3 {
        let x = f64::from(n[i]);
        value += x * (p[i] - frame.centre[i]) * scale;
        size += x.abs() * (p[i].abs() + frame.centre[i].abs()) * scale;
    }
    let margin = 64.0 * f64::EPSILON * size;
    if (value - limit).abs() > margin {
        return value < limit;
    }
    exact_support(n, p, frame) <= Dyadic::from(limit)
}

/// What a test has checked.
#[derive(Default, Debug)]
struct Tally {
    checks: u64,
    /// Planes that no coordinate can exceed.
    unbounded: u64,
}

fn check<const K: usize>(keys: &[Key; K], p: &Point, frame: &Frame, tally: &mut Tally, what: &str) {
    for (j, n) in directions::table(K).vectors.iter().enumerate() {
        tally.checks += 1;
        tally.unbounded += u64::from(keys[j] == Key::INFINITY);
        assert!(bounds(keys[j], n, p, frame), "k {K} plane {j} {:?} cuts off {p:?}: {what}", keys[j]);
    }
}

// ---- Bodies as they are built -----------------------------------------------------------------------------

fn turned_planes_bound_the_moved_triangles<const K: usize>()
where
    Node16<K>: Lanes,
{
    let mut rng = Rng::new(K as u64);
    let mut tally = Tally::default();
    let wanted = 1_200_000 / suite_step() as u64;
    while tally.checks < wanted {
        let (size, distance) = size_and_distance(&mut rng);
        let centre = random_point(&mut rng, [0.0, 1.0, 1e3, 1e9].map(|x| x * size));
        let spread = *rng.pick(&[0.0, 1e-6, 0.1, 1.0]);
        let mut mesh = shapes::soup(&mut rng, 16, spread);
        mesh.vertices.iter_mut().for_each(|p| *p = add(p.map(|x| x * size), centre));
        let (turn, away) = (rotation(&mut rng), random_point(&mut rng, [size.max(1.0) * distance]));
        let pose = pose(&turn, away);
        let near = if rng.below(8) == 0 { [0.0; 3] } else { pose.apply(centre) };
        let frame = Frame { centre: add(near, random_point(&mut rng, [1.0])), exponent: exponent_for(1.0) };
        check_mesh::<K>(&mesh.vertices, &mesh.triangles, &pose, &frame, &mut tally);
    }
    println!("k {K:2}: {tally:?}");
    assert!(tally.unbounded * 2 < tally.checks, "most planes are finite: {tally:?}");
}

/// Builds a tree of at most 16 triangles, rotates its lanes, and checks each lane's planes against the moved
/// corners.
fn check_mesh<const K: usize>(
    vertices: &[Point],
    triangles: &[[u32; 3]],
    pose: &Pose,
    frame: &Frame,
    tally: &mut Tally,
) where
    Node16<K>: Lanes,
{
    let tree = Builder::new().build_as::<Node16<K>>(&Mesh { vertices, triangles }).unwrap();
    let view: BvhRef<'_, Node16<K>> = tree.view();
    let map = Realignment::<K>::new(pose, &view.extent(), frame);
    for j in 0..K {
        let sum = map.terms(j).iter().fold(0.0, |sum, (_, w)| sum + f64::from(*w));
        let is_finite = sum * f64::from(view.extent().max_plane) < f64::from(f32::MAX);
        assert!(is_finite || map.offset[j] == f32::INFINITY, "k {K} plane {j}: {pose:?} {map:?}");
    }
    let planes = &view.nodes()[0].planes;
    let triangles = (0..view.len()).map(|index| view.primitive(index as u32));
    for (lane, corners) in triangles.enumerate() {
        let keys: [Key; K] = core::array::from_fn(|j| map.plane(j, |source| planes[source][lane]));
        for p in corners {
            check(&keys, &pose.apply(p), frame, tally, &format!("{pose:?} {:?}", view.extent()));
        }
    }
}

#[test]
fn turned_planes_bound_moved_triangles() {
    for_each_k!(turned_planes_bound_the_moved_triangles);
}

/// Coordinates so small that moving a corner flushes some of them to zero, and so large that they nearly
/// overflow.
fn the_ends_of_the_range<const K: usize>()
where
    Node16<K>: Lanes,
{
    let mut rng = Rng::new(100 + K as u64);
    let mut tally = Tally::default();
    for i in 0..400 / suite_step() {
        let size = if i % 2 == 0 { MIN_COORDINATE * *rng.pick(&[1.5, 4.0, 1e3, 1e9]) } else { 1e89 };
        let mut mesh = shapes::soup(&mut rng, 16, 0.3);
        let flush = |x: f64| if x.abs() < MIN_COORDINATE { 0.0 } else { x };
        mesh.vertices.iter_mut().flatten().for_each(|x| *x = flush(*x * size));
        let away = random_point(&mut rng, [0.0, 0.5].map(|x| x * size));
        let pose = pose(&rotation(&mut rng), away);
        let frame = Frame { centre: random_point(&mut rng, [size]), exponent: exponent_for(size) };
        check_mesh::<K>(&mesh.vertices, &mesh.triangles, &pose, &frame, &mut tally);
    }
    println!("k {K:2}: {tally:?}");
}

#[test]
fn turned_planes_bound_bodies_at_the_ends_of_the_range() {
    for_each_k!(the_ends_of_the_range);
}

/// A body 10^33 to 10^40 times larger than the other one's unit, with a corner next to the other body. Products
/// of planes and weights overflow `f32`, with either sign, where the planes of that corner are small.
fn bodies_too_large_for_single_precision<const K: usize>()
where
    Node16<K>: Lanes,
{
    let mut rng = Rng::new(150 + K as u64);
    let mut tally = Tally::default();
    for i in 0..400 {
        let size = f64::from_bits((1023 + 110 + i % 23) << 52);
        let mut mesh = shapes::soup(&mut rng, 16, 0.3);
        mesh.vertices.iter_mut().flatten().for_each(|x| *x *= size);
        let turn = rotation(&mut rng);
        let corner = pose(&turn, [0.0; 3]).apply(*rng.pick(&mesh.vertices));
        let frame = Frame { centre: random_point(&mut rng, [1.0]), exponent: exponent_for(1.0) };
        check_mesh::<K>(
            &mesh.vertices,
            &mesh.triangles,
            &pose(&turn, corner.map(|x| -x)),
            &frame,
            &mut tally,
        );
    }
    println!("k {K:2}: {tally:?}");
}

#[test]
fn turned_planes_bound_bodies_too_large_for_single_precision() {
    for_each_k!(bodies_too_large_for_single_precision);
}

// ---- One point close to the next key ----------------------------------------------------------------------

/// The value of some key.
fn some_bound(rng: &mut Rng) -> f64 {
    key_value(rng.int(-20_000, 20_000) as i16)
}

/// Where the point's own planes are tight, every inequality between the point and its rotated planes is an
/// equation. The translation puts the point within a few units in the last place of an `f64` from the value of
/// a key. In a quarter of the cases the point is above it, and then the result must be the next key, although
/// `f32` is too coarse to distinguish the two.
fn planes_of_one_point<const K: usize>() {
    let mut rng = Rng::new(200 + K as u64);
    let mut tally = Tally::default();
    let (mut above, mut next) = (0_u64, 0_u64);
    let wanted = 1_000_000 / suite_step() as u64;
    while tally.checks < wanted {
        let body = OnePoint::<K>::new(&mut rng);
        let turn = rotation(&mut rng);
        let (_, distance) = size_and_distance(&mut rng);
        let away = random_point(&mut rng, [distance]);
        let frame =
            Frame { centre: add(away, random_point(&mut rng, [1.0])), exponent: rng.int(-3, 9) as i32 };
        let j = rng.below(K as u64) as usize;
        let n = &directions::table(K).vectors[j];
        // One coordinate of the translation that the direction does not ignore determines the support.
        let axis = (0..3).find(|&i| n[i] != 0).unwrap();
        let mut t = away;
        let bound = some_bound(&mut rng);
        let want = bound / f64::from_bits(((frame.exponent + 1023) as u64) << 52);
        for _ in 0..3 {
            let moved = pose(&turn, t).apply(body.point);
            let now: f64 = (0..3).map(|i| f64::from(n[i]) * (moved[i] - frame.centre[i])).sum();
            t[axis] += (want - now) / f64::from(n[axis]);
        }
        let pose = pose(&turn, t);
        let map = Realignment::<K>::new(&pose, &body.extent, &frame);
        let keys: [Key; K] = core::array::from_fn(|j| map.plane(j, |source| body.planes[source]));
        let moved = pose.apply(body.point);
        check(&keys, &moved, &frame, &mut tally, &format!("{pose:?} {:?} {frame:?}", body.extent));

        let exact = exact_support(n, &moved, &frame);
        above += u64::from(exact > Dyadic::from(bound));
        let steps = i32::from(keys[j].code()) - i32::from(Key::<Fixed>::round_up_f64(bound).unwrap().code());
        next += u64::from(steps == 1);
    }
    println!("k {K:2}: {tally:?}, {above} a hair above a key, {next} planes at the key next to it");
    assert!(above * K as u64 * 4 > tally.checks, "often above the key: {above}");
}

#[test]
fn turned_planes_of_one_point_a_hair_above_a_key() {
    for_each_k!(planes_of_one_point);
}

// ---- The inverse pose -------------------------------------------------------------------------------------

/// Body B is one point y, and A has a point p there, at A's greatest distance from the centre of its frame. B's
/// planes, rotated into A's frame and moved out, bound p, up to the error of `f64` between y and the moved p.
fn the_way_back_of_one_point<const K: usize>() {
    let mut rng = Rng::new(300 + K as u64);
    let (mut checks, mut decided) = (0_u64, 0_u64);
    while checks < 200_000 / suite_step() as u64 {
        let b = OnePoint::<K>::new(&mut rng);
        let (size, distance) = size_and_distance(&mut rng);
        let turn = rotation(&mut rng);
        let pose = pose(&turn, random_point(&mut rng, [distance]));
        // Three steps of refinement bring p as close to y as `f64` allows, because the transpose is nearly the
        // inverse.
        let mut p = [0.0; 3];
        for _ in 0..8 {
            let moved = pose.apply(p);
            let left: Point = core::array::from_fn(|i| b.point[i] - moved[i]);
            p = core::array::from_fn(|j| p[j] + (0..3).map(|i| pose.rows()[i][j] * left[i]).sum::<f64>());
        }
        let moved = pose.apply(p);
        let gap = (0..3).map(|i| (b.point[i] - moved[i]).powi(2)).sum::<f64>().sqrt() * (1.0 + 1e-12);

        let mut a = NO_EXTENT;
        a.frame.exponent = exponent_for(size);
        a.frame.centre = add(p, random_point(&mut rng, [0.0, 1.0, 1.0]).map(|x| x * size));
        let way: Point = core::array::from_fn(|i| p[i] - a.frame.centre[i]);
        a.radius = way.iter().map(|x| x * x).sum::<f64>().sqrt() * (1.0 + 1e-15);
        a.max_coordinate = p.iter().chain(&a.frame.centre).fold(0.0, |m, x| x.abs().max(m));

        let back = InversePose::new(&pose, &a, &b.extent);
        let mut map = Realignment::<K>::new(&back.pose, &b.extent, &a.frame);
        let scale = f64::from_bits(((1023 + a.frame.exponent) as u64) << 52);
        map.widen(back.outwards::<Triangles>(0.0, &b.extent) * scale);
        for (j, n) in directions::table(K).vectors.iter().enumerate() {
            checks += 1;
            let limit = key_value(map.plane(j, |source| b.planes[source]).code());
            if limit.is_finite() {
                decided += 1;
                let slack = directions::table(K).lengths[j] * gap * scale;
                let exact = exact_support(n, &p, &a.frame);
                let what = || format!("k {K} plane {j} cuts off {p:?}: {pose:?} {a:?} {:?}", b.extent);
                assert!(exact <= Dyadic::from(limit) + Dyadic::from(slack), "{}", what());
            }
        }
    }
    assert!(decided * 2 > checks, "{decided} of {checks}");
}

#[test]
fn planes_of_b_bound_points_of_a_on_the_way_back() {
    for_each_k!(the_way_back_of_one_point);
}

// ---- The bound of the offset ------------------------------------------------------------------------------

/// Below any normal product of a code and a weight: three such products, each off by at most 2^-150.
const UNDERFLOW_EXPONENT: i32 = -148;

/// The bound that the module's documentation proves, without the allowance for `f64` in its last two lines, in
/// exact arithmetic.
fn required_offset<const K: usize>(
    map: &Realignment<K>,
    j: usize,
    pose: &Pose,
    a: &BodyBounds,
    b: &Frame,
) -> Dyadic {
    let exact = |x: f64| Dyadic::from(x);
    let vectors = directions::table(K).vectors;
    let n = vectors[j].map(|x| exact(x.into()));
    let m = pose.rows().map(|row| row.map(exact));
    let ratio = Dyadic::power_of_two(b.exponent - a.frame.exponent);
    let (mut pad, mut reach, mut half) =
        (Dyadic::power_of_two(UNDERFLOW_EXPONENT), Dyadic::zero(), Dyadic::zero());
    for (_, w) in map.terms(j) {
        assert!(w >= 0.0, "weights are not negative");
        // A code is half a step less than the plane, so the plane is half a step farther out than the term of
        // the sum.
        reach = reach + exact(w.into()) * (exact(a.max_plane.into()) + exact(0.5));
        half = half + exact(w.into()) * exact(0.5);
    }
    for i in 0..3 {
        let column = [0, 1, 2].map(|row| m[row][i].clone());
        let u = dot(n.clone(), column) * ratio.clone();
        let sum = |sum: Dyadic, (source, weight): (usize, f32)| {
            sum + exact(weight.into()) * exact(vectors[source][i].into())
        };
        let residual = u - map.terms(j).into_iter().fold(Dyadic::zero(), sum);
        pad = pad + residual.abs() * exact(a.half_width[i].into());
    }
    let centre = a.frame.centre.map(exact);
    let shift = [0, 1, 2].map(|row| {
        let turned = dot(m[row].clone(), centre.clone());
        turned + exact(pose.translation()[row]) - exact(b.centre[row])
    });
    let tau = dot(n, shift) * Dyadic::power_of_two(b.exponent);
    // 4 u / (1 - 4 u) < 4 u + 17 u^2 for u = 2^-24.
    let gamma_4 = Dyadic::power_of_two(-22) + exact(17.0) * Dyadic::power_of_two(-48);
    tau.clone() + pad + half.clone() + gamma_4 * (reach + tau.abs() + half)
}

fn offsets_are_no_less_than_proven<const K: usize>() {
    let mut rng = Rng::new(300 + K as u64);
    let (mut checks, mut unbounded) = (0, 0);
    for _ in 0..4000 / suite_step() {
        let mut a = NO_EXTENT;
        a.frame.exponent = if rng.below(8) == 0 { rng.int(-300, 300) } else { rng.int(-12, 12) } as i32;
        a.frame.centre = random_point(&mut rng, [0.0, 1.0, 1e6, 1e12]);
        a.half_width = random_point(&mut rng, [0.0, 1.0, 127.0, 16_000.0]).map(|x| x.abs() as f32);
        let widest = a.half_width.into_iter().fold(0.0, f32::max);
        // Small planes do not hide the error of the weights.
        a.max_plane = (widest * *rng.pick(&[1e-4, 1.0]) * rng.range(1.0, 6.0) as f32).max(0.5);
        let scale = f64::from_bits(((1023 - a.frame.exponent) as u64) << 52);
        a.max_coordinate =
            a.frame.centre.iter().fold(0.0, |m: f64, x| m.max(x.abs())) + f64::from(widest) * scale;
        let t = random_point(&mut rng, [0.0, 1.0, 1e3, 1e6, 1e12]);
        let pose = pose(&rotation(&mut rng), t);
        let centre = add(pose.apply(a.frame.centre), random_point(&mut rng, [0.0, 1.0, 100.0]));
        let b = Frame { centre, exponent: rng.int(-12, 12) as i32 };
        let map = Realignment::<K>::new(&pose, &a, &b);
        for j in 0..K {
            let offset = f64::from(map.offset[j]);
            if offset == f64::INFINITY || map.terms(j).iter().any(|(_, weight)| *weight == f32::INFINITY) {
                assert_eq!(offset, f64::INFINITY, "an unbounded weight makes the plane unbounded");
                unbounded += 1;
                continue;
            }
            checks += 1;
            let required = required_offset(&map, j, &pose, &a, &b);
            assert!(
                Dyadic::from(offset) >= required,
                "k {K} plane {j}: offset {offset:e} < {required:?} for {pose:?} {a:?} {b:?}"
            );
        }
    }
    println!("k {K:2}: {checks} offsets, {unbounded} unbounded");
    assert!(unbounded * 4 < checks, "most offsets are finite");
}

#[test]
fn offsets_pay_for_every_rounding() {
    for_each_k!(offsets_are_no_less_than_proven);
}

/// For bodies far from the origin, nearly all of the offset is the pad for rounded coordinates, and rounding
/// must not reduce it. The two offsets of a slab have opposite translations, so their sum is twice the pad.
fn far_offsets_hold_the_pad_for_coordinates<const K: usize>() {
    let mut rng = Rng::new(350 + K as u64);
    let greatest = |p: &Point| p.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for _ in 0..400 / suite_step() {
        let mut a = NO_EXTENT;
        a.frame.centre = random_point(&mut rng, [1e16, 1e20, 1e28]);
        a.half_width = [127.0; 3];
        a.max_plane = 300.0;
        a.max_coordinate = greatest(&a.frame.centre);
        let pose = pose(&rotation(&mut rng), random_point(&mut rng, [0.0, 1e16, 1e20]));
        let b = Frame { centre: pose.apply(a.frame.centre), exponent: rng.int(-12, 12) as i32 };
        let map = Realignment::<K>::new(&pose, &a, &b);
        let exact = |x: f64| Dyadic::from(x);
        let coordinates = exact(8.0) * exact(a.max_coordinate)
            + exact(greatest(&pose.translation()))
            + exact(greatest(&b.centre));
        for (n, offsets) in directions::table(K).vectors.iter().step_by(2).zip(map.offset.chunks_exact(2)) {
            let length = n.iter().map(|&x| f64::from(x).abs()).sum::<f64>();
            let pads = exact(2.0 * length) * Dyadic::power_of_two(b.exponent - 46) * coordinates.clone();
            let sum = exact(offsets[0].into()) + exact(offsets[1].into());
            assert!(sum >= pads, "k {K}: {offsets:?} for {pose:?} {a:?} {b:?}");
        }
    }
}

#[test]
fn far_offsets_are_not_rounded_below_their_pad() {
    for_each_k!(far_offsets_hold_the_pad_for_coordinates);
}

// ---- Margins, width and infinity --------------------------------------------------------------------------

/// Planes that are widened by the margin bound everything within the margin of a point, whose support is
/// `n . p + |n| margin`.
fn widened_planes_hold_the_margin<const K: usize>() {
    let mut rng = Rng::new(400 + K as u64);
    for _ in 0..4000 / suite_step() {
        let body = OnePoint::<K>::new(&mut rng);
        let pose = pose(&rotation(&mut rng), random_point(&mut rng, [10.0]));
        let moved = pose.apply(body.point);
        let frame =
            Frame { centre: add(moved, random_point(&mut rng, [1.0])), exponent: rng.int(-3, 9) as i32 };
        let margin = *rng.pick(&[1e-12, 1e-3, 0.1, 1.0, 3.0, 1e4]) * rng.unit();
        let mut map = Realignment::<K>::new(&pose, &body.extent, &frame);
        let before = map.offset;
        map.widen(margin);
        for (j, (&old, &new)) in before.iter().zip(&map.offset).enumerate() {
            if new == f32::INFINITY {
                continue;
            }
            let [old, new] = [old, new].map(|offset| Dyadic::from(f64::from(offset)));
            let reach = Dyadic::from(Directions::<K>::LENGTHS[j]) * Dyadic::from(margin);
            // The rounding of the sum in the offset: half a unit in the last place of the offset.
            let rounding = Dyadic::power_of_two(-24) * new.clone().abs();
            assert!(new - rounding >= old + reach, "k {K} offset {j}: margin {margin:e}");
        }
        for (j, n) in directions::table(K).vectors.iter().enumerate() {
            let limit = key_value(map.plane(j, |source| body.planes[source]).code());
            if limit == f64::INFINITY {
                continue;
            }
            let room = Dyadic::from(limit) - exact_support(n, &moved, &frame);
            let square = n.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
            let reach = Dyadic::from(margin) * Dyadic::from(margin) * Dyadic::from(square);
            assert!(
                room >= Dyadic::zero() && room.clone() * room >= reach,
                "k {K} plane {j}: margin {margin:e}"
            );
        }
    }
}

#[test]
fn widened_planes_hold_everything_within_the_margin() {
    for_each_k!(widened_planes_hold_the_margin);
}

/// The width of a body after realignment over its true width, the mean over random rotations and directions,
/// for a ball-like cloud in the cube.
fn width_ratio<const K: usize>() -> f64
where
    Node16<K>: Lanes,
{
    let mut rng = Rng::new(500);
    let (mut sum, mut count) = (0.0, 0.0);
    for _ in 0..400 {
        let mesh = shapes::soup(&mut rng, 16, 1.0);
        let builder = Builder::new().leaf_size(16);
        let tree =
            builder.build_as::<Node16<K>>(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles });
        let tree = tree.unwrap();
        let view: BvhRef<'_, Node16<K>> = tree.view();
        let pose = pose(&rng.rotation(), [0.0; 3]);
        let map = Realignment::<K>::new(&pose, &view.extent(), &view.frame());
        let key = |j: usize| map.plane(j, |source| view.nodes()[0].planes[source][0]);
        let moved: Vec<Point> = mesh.vertices.iter().map(|p| pose.apply(*p)).collect();
        for j in (0..K).step_by(2) {
            let n = Directions::<K>::VECTORS[j];
            let along = |p: &Point| (n[0] * p[0] + n[1] * p[1]) + n[2] * p[2];
            let high = moved.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            let low = moved.iter().map(along).fold(f64::INFINITY, f64::min);
            let turned = (key(j).to_f64() + key(j + 1).to_f64()) / view.frame().scale();
            sum += turned / (high - low);
            count += 1.0;
        }
    }
    sum / count
}

/// All other tests here accept a decomposition that bounds, but loosely.
#[test]
fn turned_planes_are_not_much_wider_than_the_body() {
    let ratios = [
        width_ratio::<6>(),
        width_ratio::<14>(),
        width_ratio::<18>(),
        width_ratio::<26>(),
        width_ratio::<32>(),
    ];
    println!("width after / before, k = 6, 14, 18, 26, 32: {ratios:.3?}");
    for (ratio, limit) in ratios.into_iter().zip([1.75, 1.35, 1.3, 1.25, 1.22]) {
        assert!((1.0..limit).contains(&ratio), "{ratio} is not below {limit}");
    }
}
