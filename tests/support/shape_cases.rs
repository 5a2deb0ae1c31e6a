//! Pairs of shapes that are difficult to judge: near contact, exactly touching, nested, parallel, thin, far, tiny, of
//! different sizes, and at both ends of the range.

use crate::shape_oracle::estimate;
use crate::support::rng::Rng;
use simdop::pose::Pose;
use simdop::primitive::shape::{Core, Shape};

type Point = [f64; 3];
type Rows = [[f64; 3]; 3];

/// The kind of a shape's core.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    Point,
    Segment,
    Triangle,
    Cuboid,
    Cylinder,
    Cone,
    HalfSpace,
}

pub(crate) const KINDS: [Kind; 7] =
    [Kind::Point, Kind::Segment, Kind::Triangle, Kind::Cuboid, Kind::Cylinder, Kind::Cone, Kind::HalfSpace];

/// All unordered pairs of kinds.
pub(crate) fn kind_pairs() -> impl Iterator<Item = (Kind, Kind)> {
    (0..KINDS.len()).flat_map(|i| (i..KINDS.len()).map(move |j| (KINDS[i], KINDS[j])))
}

/// Hard pairs of all kinds in turn, without end.
pub(crate) fn hard_pairs(rng: &mut Rng) -> impl Iterator<Item = (Shape, Shape)> {
    let kinds: Vec<(Kind, Kind)> = kind_pairs().collect();
    (0..).map(move |i: usize| hard_pair(kinds[i % kinds.len()], rng))
}

/// A hard pair of two kinds, in either order.
pub(crate) fn hard_pair((p, q): (Kind, Kind), rng: &mut Rng) -> (Shape, Shape) {
    let (p, q) = if rng.below(2) == 0 { (p, q) } else { (q, p) };
    loop {
        let is_flat = p == Kind::HalfSpace && q == Kind::HalfSpace;
        let pair = match rng.below(8) {
            _ if is_flat && rng.below(2) == 0 => opposite(rng),
            0 => on_lattice(p, q, rng),
            1 => touching_flat(p, q, rng),
            2 => touching_at_point(p, q, rng),
            3 => nested(p, q, rng),
            _ => near_contact(p, q, rng),
        };
        if let Some(pair) = pair.and_then(|pair| treated(pair, rng)) {
            return pair;
        }
    }
}

/// A margin that is hard for a pair: mostly none, else the distance up to rounding, or a small integer of the lattice.
pub(crate) fn hard_margin(a: &Shape, b: &Shape, rng: &mut Rng) -> f64 {
    let margin = match rng.below(6) {
        0 => {
            estimate(a, b) * *rng.pick(&[1.0, 1.0 - 1e-9, 1.0 + 1e-9, 1.0 - f64::EPSILON, 1.0 + f64::EPSILON])
        }
        1 => rng.int(1, 5) as f64,
        _ => 0.0,
    };
    if (simdop::range::MIN_COORDINATE..=1e80).contains(&margin) { margin } else { 0.0 }
}

// ---- treatments of a pair ---------------------------------------------------------------------------------------

/// The pair as it is, or at one of the ends of the range, far from the origin, or with one ulp of difference.
fn treated((a, b): (Shape, Shape), rng: &mut Rng) -> Option<(Shape, Shape)> {
    match rng.below(24) {
        // The exponents of a pair's numbers, about 2^-53 .. 2^20, still fit.
        0 => both(&a, &b, |shape| scaled(shape, 2_f64.powi(-190))),
        1 => both(&a, &b, |shape| scaled(shape, 2_f64.powi(270))),
        2 => both(&a, &b, |shape| scaled(shape, 2_f64.powi(-240))),
        3 => {
            let by = core::array::from_fn(|_| *rng.pick(&[0.0, 1e6, -1e6, f64::from(1 << 20)]));
            both(&a, &b, |shape| shifted(shape, &by))
        }
        4 => {
            let ulp = |rng: &mut Rng| rng.int(-1, 1) as f64 * f64::EPSILON * 4.0;
            let by = core::array::from_fn(|_| ulp(rng));
            Some((a, shifted(&b, &by)?))
        }
        // Sizes that differ by 2^400 and more.
        5 if rng.below(4) == 0 => Some((scaled(&a, 2_f64.powi(-200))?, scaled(&b, 2_f64.powi(200))?)),
        _ => Some((a, b)),
    }
}

fn both(a: &Shape, b: &Shape, change: impl Fn(&Shape) -> Option<Shape>) -> Option<(Shape, Shape)> {
    Some((change(a)?, change(b)?))
}

/// All lengths multiplied by a number, without rounding if it is a power of two.
pub(crate) fn scaled(shape: &Shape, by: f64) -> Option<Shape> {
    let flush = |x: f64| if x.abs() < simdop::range::MIN_COORDINATE { 0.0 } else { x };
    let v = |p: Point| p.map(|x| flush(x * by));
    let core = match *shape.core() {
        Core::Point(p) => Core::Point(v(p)),
        Core::Segment(ends) => Core::Segment(ends.map(v)),
        Core::Triangle(corners) => Core::Triangle(corners.map(v)),
        Core::Cuboid { centre, half } => Core::Cuboid { centre: v(centre), half: half.map(v) },
        Core::Cylinder { centre, half_axis, radius } => {
            Core::Cylinder { centre: v(centre), half_axis: v(half_axis), radius: radius * by }
        }
        Core::Cone { base, axis, radius } => Core::Cone { base: v(base), axis: v(axis), radius: radius * by },
        Core::HalfSpace { normal, offset } => Core::HalfSpace { normal, offset: flush(offset * by) },
    };
    Shape::new(core, flush(shape.radius() * by)).ok()
}

fn shifted(shape: &Shape, by: &Point) -> Option<Shape> {
    mapped(shape, &IDENTITY, by)
}

/// The shape with its coordinates in another order.
pub(crate) fn permuted(shape: &Shape, order: [usize; 3]) -> Shape {
    let rows = order.map(|k| IDENTITY[k]);
    mapped(shape, &rows, &[0.0; 3]).expect("a permutation changes no number")
}

const IDENTITY: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Points and vectors mapped by a matrix, which may scale.
fn mapped(shape: &Shape, rows: &Rows, by: &Point) -> Option<Shape> {
    let v = |p: Point| rows.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
    let at = |p: Point| {
        let p = v(p);
        [p[0] + by[0], p[1] + by[1], p[2] + by[2]]
    };
    let core = match *shape.core() {
        Core::Point(p) => Core::Point(at(p)),
        Core::Segment(ends) => Core::Segment(ends.map(at)),
        Core::Triangle(corners) => Core::Triangle(corners.map(at)),
        Core::Cuboid { centre, half } => Core::Cuboid { centre: at(centre), half: half.map(v) },
        Core::Cylinder { centre, half_axis, radius } => {
            Core::Cylinder { centre: at(centre), half_axis: v(half_axis), radius }
        }
        Core::Cone { base, axis, radius } => Core::Cone { base: at(base), axis: v(axis), radius },
        Core::HalfSpace { normal, offset } => {
            let n = v(normal);
            let offset = offset + (n[0] * by[0] + n[1] * by[1] + n[2] * by[2]);
            return Shape::half_space(n, offset).and_then(|s| s.widened(shape.radius())).ok();
        }
    };
    Shape::new(core, shape.radius()).ok()
}

// ---- single shapes ----------------------------------------------------------------------------------------------

/// A shape about the origin, with lengths and coordinates from two sources.
fn shape(
    kind: Kind,
    length: &mut dyn FnMut() -> f64,
    coordinate: &mut dyn FnMut() -> f64,
    radius: f64,
) -> Option<Shape> {
    let mut point = || [coordinate(), coordinate(), coordinate()];
    let core = match kind {
        Kind::Point => Core::Point([0.0; 3]),
        Kind::Segment => Core::Segment([point(), point()]),
        Kind::Triangle => Core::Triangle([point(), point(), point()]),
        Kind::Cuboid => {
            let half = [[length(), 0.0, 0.0], [0.0, length(), 0.0], [0.0, 0.0, length()]];
            Core::Cuboid { centre: [0.0; 3], half }
        }
        Kind::Cylinder => {
            Core::Cylinder { centre: [0.0; 3], half_axis: [0.0, 0.0, length()], radius: length() }
        }
        Kind::Cone => Core::Cone { base: [0.0; 3], axis: [0.0, 0.0, length()], radius: length() },
        Kind::HalfSpace => {
            let normal = point();
            return Shape::half_space(normal, 0.0).and_then(|s| s.widened(radius)).ok();
        }
    };
    Shape::new(core, radius).ok()
}

/// A shape with random numbers, one in four times thin in some directions.
fn random_shape(kind: Kind, rng: &mut Rng) -> Option<Shape> {
    let is_thin = rng.below(4) == 0;
    let radius = if rng.below(2) == 0 { 0.0 } else { rng.range(0.05, 0.5) };
    let (mut lengths, mut coordinates) = (Rng::new(rng.u64()), Rng::new(rng.u64()));
    let mut length = || {
        let thin = if is_thin && lengths.below(2) == 0 { 1e-6 } else { 1.0 };
        lengths.range(0.1, 1.0) * thin
    };
    shape(kind, &mut length, &mut || coordinates.range(-1.0, 1.0), radius)
}

/// A shape with small integers.
fn lattice_shape(kind: Kind, rng: &mut Rng) -> Option<Shape> {
    let radius = if rng.below(2) == 0 { 0.0 } else { rng.int(1, 5) as f64 };
    let (mut lengths, mut coordinates) = (Rng::new(rng.u64()), Rng::new(rng.u64()));
    let mut length = || *lengths.pick(&[1.0, 2.0, 3.0, 4.0, 5.0, 0.5, 10.0]);
    shape(kind, &mut length, &mut || coordinates.int(-3, 3) as f64, radius)
}

/// Signed permutations of the axes, mostly; else a multiple of a rotation with integers.
fn lattice_rows(rng: &mut Rng, only_axes: bool) -> Rows {
    if only_axes || rng.below(3) > 0 {
        let first = rng.below(3) as usize;
        let second = (first + 1 + rng.below(2) as usize) % 3;
        let sign = |rng: &mut Rng| if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let mut rows = [[0.0; 3]; 3];
        for (row, column) in [first, second, 3 - first - second].into_iter().enumerate() {
            rows[row][column] = sign(rng);
        }
        return rows;
    }
    loop {
        // The matrix of a quaternion of integers.
        let [x, y, z, w] = [(); 4].map(|()| rng.int(-2, 2) as f64);
        if [x, y, z, w] != [0.0; 4] {
            let square = |i: f64, j: f64, k: f64| w * w + i * i - j * j - k * k;
            return [
                [square(x, y, z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                [2.0 * (x * y + z * w), square(y, x, z), 2.0 * (y * z - x * w)],
                [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), square(z, x, y)],
            ];
        }
    }
}

/// A random rotation, one by a tiny angle, or one of the axes.
fn rotation(rng: &mut Rng) -> Rows {
    match rng.below(3) {
        0 => rng.rotation(),
        1 => lattice_rows(rng, true),
        _ => {
            let angle = *rng.pick(&[1e-3, 1e-6, 1e-9, 1e-12, 1e-15]) * rng.range(-1.0, 1.0);
            let k = rng.below(3) as usize;
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let mut rows = IDENTITY;
            (rows[i][j], rows[j][i]) = (-angle, angle);
            rows
        }
    }
}

fn posed(shape: &Shape, rows: &Rows, by: &Point) -> Option<Shape> {
    let row = |k: usize| [rows[k][0], rows[k][1], rows[k][2], by[k]];
    let pose = Pose::from_rows([row(0), row(1), row(2)]);
    // A lattice rotation may be a reflection, which also gives a shape.
    pose.map_or_else(|_| mapped(shape, rows, by), |pose| Some(shape.moved(&pose)))
}

// ---- pairs ------------------------------------------------------------------------------------------------------

/// Small integers: contacts, common planes and common axes are frequent.
fn on_lattice(p: Kind, q: Kind, rng: &mut Rng) -> Option<(Shape, Shape)> {
    let a = lattice_shape(p, rng)?;
    let b = lattice_shape(q, rng)?;
    let (rows, other) = (lattice_rows(rng, false), lattice_rows(rng, false));
    let by = core::array::from_fn(|_| rng.int(-8, 8) as f64 * *rng.pick(&[0.0, 1.0, 0.5, 1.0]));
    Some((mapped(&a, &rows, &by)?, mapped(&b, &other, &[0.0; 3])?))
}

/// The largest coordinate k of shapes whose axes and normals are along the coordinate axes.
fn top(shape: &Shape, k: usize) -> Option<f64> {
    let most = |points: &[Point]| points.iter().map(|p| p[k]).reduce(f64::max);
    let across = |axis: &Point, radius: f64| if axis[k] == 0.0 { radius } else { 0.0 };
    Some(
        shape.radius()
            + match shape.core() {
                Core::Point(p) => p[k],
                Core::Segment(ends) => most(ends)?,
                Core::Triangle(corners) => most(corners)?,
                Core::Cuboid { centre, half } => centre[k] + half.iter().map(|h| h[k].abs()).sum::<f64>(),
                Core::Cylinder { centre, half_axis, radius } => {
                    centre[k] + half_axis[k].abs() + across(half_axis, *radius)
                }
                Core::Cone { base, axis, radius } => base[k] + axis[k].max(0.0) + across(axis, *radius),
                Core::HalfSpace { normal, offset } => {
                    let is_axis =
                        (0..3).all(|i| (normal[i] > 0.0) == (i == k) && (i == k || normal[i] == 0.0));
                    return is_axis.then(|| offset / normal[k] + shape.radius());
                }
            },
    )
}

/// Two shapes with axes along the coordinate axes, one on top of the other, mostly without a gap: the exact contact of
/// two faces, a face and a line, and so on. Their middles differ by integers.
fn touching_flat(p: Kind, q: Kind, rng: &mut Rng) -> Option<(Shape, Shape)> {
    let k = rng.below(3) as usize;
    let mut normal = [0.0; 3];
    normal[k] = 1.0;
    let make = |kind, normal, rng: &mut Rng| match kind {
        Kind::HalfSpace => Shape::half_space(normal, rng.int(-3, 3) as f64).ok(),
        _ => lattice_shape(kind, rng),
    };
    let (a, b) = (make(p, normal, rng)?, make(q, normal.map(|x| -x), rng)?);
    let place = |shape: Shape, rng: &mut Rng| match shape.core() {
        Core::HalfSpace { .. } => Some(shape),
        _ => {
            let rows = lattice_rows(rng, true);
            mapped(&shape, &rows, &core::array::from_fn(|_| rng.int(-2, 2) as f64))
        }
    };
    let (a, b) = (place(a, rng)?, place(b, rng)?);
    let mut mirror = IDENTITY;
    mirror[k][k] = -1.0;
    let bottom = -top(&mapped(&b, &mirror, &[0.0; 3])?, k)?;
    let mut by = [0.0; 3];
    let gap = *rng.pick(&[0.0, 0.0, 0.0, 1.0, -1.0, 0.5, 2_f64.powi(-40), -2_f64.powi(-40)]);
    by[k] = top(&a, k)? - bottom + gap;
    Some((a, mapped(&b, &IDENTITY, &by)?))
}

/// A point of the surface or the interior, on the lattice, of a shape whose axes are along the coordinate axes.
fn lattice_point(shape: &Shape, rng: &mut Rng) -> Option<Point> {
    let add = |p: Point, q: Point| core::array::from_fn(|k| p[k] + q[k]);
    let times = |p: &Point, by: f64| p.map(|x| x * by);
    // A vector of length 5 or 1 times `radius` / 5, across an axis if one is given.
    let mut around = |axis: Option<&Point>, radius: f64| {
        let mut v = *rng.pick(&[[3.0, 4.0, 0.0], [4.0, 3.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
        v.rotate_right(rng.below(3) as usize);
        let v = v.map(|x| if rng.below(2) == 0 { x } else { -x });
        let is_across = axis.is_none_or(|axis| (0..3).all(|k| axis[k] * v[k] == 0.0));
        is_across.then(|| times(&v, radius / 5.0))
    };
    let by = around(None, shape.radius())?;
    let point = match shape.core() {
        Core::Point(p) => *p,
        Core::Segment(ends) => *rng.pick(ends),
        Core::Triangle([p, q, r]) => {
            *rng.pick(&[*p, *q, *r, times(&add(*p, *q), 0.5), times(&add(*q, *r), 0.5)])
        }
        Core::Cuboid { centre, half } => {
            half.iter().fold(*centre, |p, h| add(p, times(h, *rng.pick(&[-1.0, 1.0, 1.0, 0.5, 0.0]))))
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let rim = around(Some(half_axis), *radius)?;
            add(add(*centre, rim), times(half_axis, *rng.pick(&[-1.0, 1.0, 0.5, 0.0])))
        }
        Core::Cone { base, axis, radius } => {
            let rim = around(Some(axis), *radius)?;
            let height = *rng.pick(&[0.0, 1.0, 0.5, 0.25]);
            add(add(*base, times(&rim, 1.0 - height)), times(axis, height))
        }
        Core::HalfSpace { .. } => return None,
    };
    Some(add(point, by))
}

/// Two shapes with a common point on the lattice, often the only one. The second has any lattice rotation.
fn touching_at_point(p: Kind, q: Kind, rng: &mut Rng) -> Option<(Shape, Shape)> {
    let place = |kind, rng: &mut Rng| mapped(&lattice_shape(kind, rng)?, &lattice_rows(rng, true), &[0.0; 3]);
    let (a, b) = (place(p, rng)?, place(q, rng)?);
    let (at, of) = (lattice_point(&a, rng)?, lattice_point(&b, rng)?);
    Some((a, mapped(&b, &IDENTITY, &core::array::from_fn(|k| at[k] - of[k]))?))
}

/// Half-spaces with opposite normals of different lengths, and a gap, an overlap or neither.
fn opposite(rng: &mut Rng) -> Option<(Shape, Shape)> {
    let length = *rng.pick(&[1.0, 3.0, 0.125]);
    let normal = rng.rotation()[0].map(|x| (x * 1024.0).round());
    let (offset, gap) =
        (rng.int(-5, 5) as f64, *rng.pick(&[0.0, 1.0, -1.0, 2_f64.powi(-40), -2_f64.powi(-40)]));
    let a = Shape::half_space(normal, offset).ok()?;
    let b = Shape::half_space(normal.map(|x| -x * length), (gap - offset) * length).ok()?;
    let radius = *rng.pick(&[0.0, 0.0, 0.5]);
    Some((a, b.widened(radius).ok()?))
}

/// A shape inside another, or nearly so.
fn nested(p: Kind, q: Kind, rng: &mut Rng) -> Option<(Shape, Shape)> {
    let a = posed(&random_shape(p, rng)?, &rotation(rng), &[0.0; 3])?;
    let small = *rng.pick(&[0.5, 0.125, 2_f64.powi(-20)]);
    let b = scaled(&random_shape(q, rng)?, small)?;
    let by = core::array::from_fn(|_| rng.range(-0.3, 0.3));
    Some((a, posed(&b, &rotation(rng), &by)?))
}

/// Two random shapes, the second moved along a line until it touches the first up to rounding, and from there by a
/// share of its size.
fn near_contact(p: Kind, q: Kind, rng: &mut Rng) -> Option<(Shape, Shape)> {
    let powers = [(0, 0), (0, 0), (0, 0), (20, 0), (0, 20), (-20, -20)];
    let (i, j) = *rng.pick(&powers);
    let (rows, other) = if rng.below(3) == 0 {
        // Parallel up to a tiny angle, or exactly.
        let rows = rotation(rng);
        (rows, if rng.below(2) == 0 { rows } else { rotation(rng) })
    } else {
        (rotation(rng), rotation(rng))
    };
    let a = posed(&scaled(&random_shape(p, rng)?, 2_f64.powi(i))?, &rows, &[0.0; 3])?;
    let b = scaled(&random_shape(q, rng)?, 2_f64.powi(j))?;
    let size = 2_f64.powi(i.max(j));
    let direction = match rng.below(3) {
        0 => rows[2],
        1 => rows[0],
        _ => rng.rotation()[0],
    };
    let place = |s: f64| posed(&b, &other, &direction.map(|x| x * s));
    // The distance is a convex function of s: secants from outside do not overshoot.
    let mut s = 8.0 * size;
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..40 {
        let distance = estimate(&a, &place(s)?);
        // Until it no longer falls: then it is a rounding error, or the line does not hit.
        if distance <= 1e-14 * size || last.is_some_and(|(_, before)| distance >= before) {
            break;
        }
        let slope = last.map_or(1.0, |(t, before)| ((before - distance) / (t - s)).clamp(1e-3, 1.0));
        last = Some((s, distance));
        s -= distance / slope;
    }
    let share = *rng.pick(&[0.05, 0.01, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0]);
    let sign = if rng.below(2) == 0 { 1.0 } else { -1.0 };
    Some((a, place(s + sign * share * size)?))
}
