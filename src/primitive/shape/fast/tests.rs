//! Verdicts against exact arithmetic.

use super::*;
use crate::pose::Pose;
use crate::rng::{CASES_STEP, Rng};
use alloc::{vec, vec::Vec};
use dashu_int::IBig;
use glam::{DMat3, DVec3};

type Exact = [IBig; 3];

/// A polytope in units of a power of two: what its vertices, edges and faces are.
struct Polytope {
    vertices: Vec<Exact>,
    edges: Vec<(Exact, Exact)>,
    /// A corner and two edges from it.
    faces: Vec<(Exact, Exact, Exact)>,
    directions: Vec<Exact>,
    normals: Vec<Exact>,
    /// The face is half of the parallelogram.
    is_triangle: bool,
}

fn integer(x: f64, unit: i32) -> IBig {
    if x == 0.0 {
        return IBig::ZERO;
    }
    let (bits, sign) = (x.abs().to_bits(), x < 0.0);
    let mantissa = bits & ((1 << 52) - 1) | 1 << 52;
    let zeros = mantissa.trailing_zeros();
    let magnitude = IBig::from(mantissa >> zeros);
    let shift = (bits >> 52) as i32 - 1075 + zeros as i32 - unit;
    assert!(shift >= 0, "{x:e} is no multiple of 2^{unit}");
    let magnitude = magnitude << shift as usize;
    if sign { -magnitude } else { magnitude }
}

fn vector(v: &Point, unit: i32) -> Exact {
    v.map(|x| integer(x, unit))
}

fn plus(a: &Exact, b: &Exact) -> Exact {
    [0, 1, 2].map(|i| &a[i] + &b[i])
}

fn minus(a: &Exact, b: &Exact) -> Exact {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

fn inner(a: &Exact, b: &Exact) -> IBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn outer(a: &Exact, b: &Exact) -> Exact {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

impl Polytope {
    fn new(core: &Core, unit: i32) -> Option<Self> {
        let mut p = Self {
            vertices: vec![],
            edges: vec![],
            faces: vec![],
            directions: vec![],
            normals: vec![],
            is_triangle: false,
        };
        match core {
            Core::Point(x) => p.vertices.push(vector(x, unit)),
            Core::Segment(ends) => {
                p.vertices = ends.iter().map(|x| vector(x, unit)).collect();
                let edge = minus(&p.vertices[1], &p.vertices[0]);
                p.edges.push((p.vertices[0].clone(), edge.clone()));
                p.directions.push(edge);
            }
            Core::Cuboid { centre, half } => {
                let (c, h) = (vector(centre, unit), half.map(|h| vector(&h, unit)));
                let full = [0, 1, 2].map(|i| plus(&h[i], &h[i]));
                let low = minus(&minus(&minus(&c, &h[0]), &h[1]), &h[2]);
                for i in 0..8 {
                    let mut v = low.clone();
                    for (j, edge) in full.iter().enumerate() {
                        if i >> j & 1 != 0 {
                            v = plus(&v, edge);
                        }
                    }
                    for (j, edge) in full.iter().enumerate() {
                        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
                        if i >> j & 1 == 0 {
                            p.edges.push((v.clone(), edge.clone()));
                        }
                        if i >> k & 1 == 0 && i >> l & 1 == 0 {
                            p.faces.push((v.clone(), full[k].clone(), full[l].clone()));
                        }
                    }
                    p.vertices.push(v);
                }
                p.normals =
                    vec![outer(&full[0], &full[1]), outer(&full[0], &full[2]), outer(&full[1], &full[2])];
                p.directions = full.to_vec();
            }
            Core::Triangle(corners) => {
                p.vertices = corners.iter().map(|x| vector(x, unit)).collect();
                let [a, b, c] = [0, 1, 2].map(|i| p.vertices[i].clone());
                let (g, h, k) = (minus(&b, &a), minus(&c, &a), minus(&c, &b));
                p.edges = vec![(a.clone(), g.clone()), (a.clone(), h.clone()), (b, k.clone())];
                let normal = outer(&g, &h);
                if inner(&normal, &normal) > IBig::ZERO {
                    // Normals of the edges within the plane, for bodies that are in it too.
                    p.normals = [&g, &h, &k].map(|edge| outer(&normal, edge)).into();
                    p.normals.push(normal);
                    p.faces = vec![(a, g.clone(), h.clone())];
                }
                p.directions = vec![g, h, k];
                p.is_triangle = true;
            }
            _ => return None,
        }
        Some(p)
    }

    fn range(&self, n: &Exact) -> (IBig, IBig) {
        let along: Vec<_> = self.vertices.iter().map(|v| inner(n, v)).collect();
        (along.iter().min().unwrap().clone(), along.iter().max().unwrap().clone())
    }
}

/// Whether the distance of a point from the segment of an edge is at most the root of `square`.
fn near_edge(v: &Exact, (at, edge): &(Exact, Exact), square: &IBig) -> bool {
    let w = minus(v, at);
    let (along, length) = (inner(&w, edge), inner(edge, edge));
    length > IBig::ZERO
        && along >= IBig::ZERO
        && along <= length
        && inner(&w, &w) * &length - &along * &along <= square * length
}

fn near_face(v: &Exact, (at, g, h): &(Exact, Exact, Exact), is_triangle: bool, square: &IBig) -> bool {
    let (w, n) = (minus(v, at), outer(g, h));
    let nn = inner(&n, &n);
    let (x, y) = (inner(&outer(&w, h), &n), inner(&outer(g, &w), &n));
    let height = inner(&w, &n);
    let is_in = |x: &IBig| *x >= IBig::ZERO && *x <= nn;
    let is_beside = is_in(&x) && is_in(&y) && (!is_triangle || &x + &y <= nn);
    nn > IBig::ZERO && is_beside && &height * &height <= square * nn
}

fn near_edges((p, u): &(Exact, Exact), (q, v): &(Exact, Exact), square: &IBig) -> bool {
    let (d, n) = (minus(q, p), outer(u, v));
    let nn = inner(&n, &n);
    if nn == IBig::ZERO {
        return false;
    }
    let (s, t) = (inner(&outer(&d, v), &n), inner(&outer(&d, u), &n));
    let height = inner(&d, &n);
    let is_in = |x: &IBig| *x >= IBig::ZERO && *x <= nn;
    is_in(&s) && is_in(&t) && &height * &height <= square * nn
}

/// Whether two polytopes are within the root of `square`: a vertex, edge or face is, or no axis separates them.
fn within(a: &Polytope, b: &Polytope, square: &IBig) -> bool {
    let near = |a: &Polytope, b: &Polytope| {
        a.vertices.iter().any(|v| {
            b.vertices.iter().any(|w| inner(&minus(v, w), &minus(v, w)) <= *square)
                || b.edges.iter().any(|e| near_edge(v, e, square))
                || b.faces.iter().any(|f| near_face(v, f, b.is_triangle, square))
        })
    };
    if near(a, b) || near(b, a) || a.edges.iter().any(|e| b.edges.iter().any(|f| near_edges(e, f, square))) {
        return true;
    }
    // Only solids can meet without features that do.
    if a.normals.is_empty() && b.normals.is_empty() {
        return false;
    }
    let edges = a.directions.iter().flat_map(|u| b.directions.iter().map(move |v| outer(u, v)));
    a.normals.iter().chain(&b.normals).cloned().chain(edges).all(|n| {
        let ((low, high), (from, to)) = (a.range(&n), b.range(&n));
        low <= to && from <= high
    })
}

/// Whether two shapes with cores that are polytopes are within `margin`, where all numbers are multiples of 2^unit.
fn exact(a: &Shape, b: &Shape, margin: f64, unit: i32) -> Option<bool> {
    let (p, q) = (Polytope::new(&a.core, unit)?, Polytope::new(&b.core, unit)?);
    let reach = integer(a.radius, unit) + integer(b.radius, unit) + integer(margin, unit);
    Some(within(&p, &q, &(&reach * &reach)))
}

pub(crate) fn pose(rng: &mut Rng, range: f64) -> Pose {
    let rows = rng.rotation();
    let rotation = match rng.below(4) {
        0 => DMat3::IDENTITY,
        // Nearly parallel edges.
        1 => DMat3::from_rotation_z(rng.range(-1.0, 1.0) * 2.0_f64.powi(-(rng.below(50) as i32))),
        _ => DMat3::from_cols_array_2d(&rows),
    };
    // Off by almost the tolerance.
    let rotation = if rng.below(4) == 0 {
        let off = DMat3::from_cols_array(&core::array::from_fn(|_| rng.range(-1.0, 1.0) * 2.8e-5));
        rotation + off
    } else {
        rotation
    };
    let t = core::array::from_fn(|_| {
        if rng.below(4) == 0 { rng.int(-2, 2) as f64 } else { rng.range(-range, range) }
    });
    Pose::new(rotation, DVec3::from_array(t)).unwrap()
}

pub(crate) fn shape(rng: &mut Rng, kind: u64) -> Shape {
    let is_grid = rng.below(3) == 0;
    let is_thin = rng.below(4) == 0;
    let mut length = || {
        let l = if is_grid { rng.int(1, 4) as f64 * 0.5 } else { rng.range(0.1, 2.0) };
        if is_thin && rng.below(2) == 0 { l * 2.0_f64.powi(-(rng.below(30) as i32)) } else { l }
    };
    match kind {
        0 => Shape::sphere(length()),
        1 => Shape::capsule(length(), length()),
        2 => Shape::cuboid([length(), length(), length()]),
        3 => Shape::cuboid([length(), length(), length()]).and_then(|s| s.widened(0.3 * length())),
        4 => Shape::cylinder(length(), length()),
        5 => Shape::cone(length(), length()),
        _ => Shape::half_space([length() - 0.6, length() - 0.5, 0.1], length() - 0.5),
    }
    .unwrap()
}

/// Multiples of 2^-110, so that the exact test has short numbers.
fn short(s: &Shape) -> Shape {
    let cut = |x: f64| {
        let big = power_of_two(-56) * 1.5;
        if x.abs() < power_of_two(-58) { (x + big) - big } else { x }
    };
    let point = |p: &Point| p.map(cut);
    let core = match s.core {
        Core::Point(p) => Core::Point(point(&p)),
        Core::Segment(ends) => Core::Segment(ends.map(|p| point(&p))),
        Core::Triangle(corners) => Core::Triangle(corners.map(|p| point(&p))),
        Core::Cuboid { centre, half } => {
            Core::Cuboid { centre: point(&centre), half: half.map(|p| point(&p)) }
        }
        other => other,
    };
    Shape { core, radius: s.radius }
}

/// A shape in another unit.
pub(crate) fn scaled(s: &Shape, by: f64) -> Shape {
    Shape { core: s.core.map(|x| by * x), radius: s.radius * by }
}

/// The greatest margin at which the verdict is `false`, up to rounding, if there is one.
pub(crate) fn distance(a: &Shape, b: &Shape) -> f64 {
    let (mut low, mut high) = (0.0, 16.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if decide(a, b, middle) == Some(false) { low = middle } else { high = middle }
    }
    low
}

/// Spheres on a parallel of an axis that touch up to the last digit.
#[test]
fn spheres_on_an_axis() {
    let mut rng = Rng::new(12);
    let (mut certain, mut apart) = (0, 0);
    for _ in 0..3000 {
        let mut number = |low: i64| rng.int(low, 9) as f64 * 0.1;
        let (r, s, from) = (number(1), number(1), number(0));
        let axis = rng.below(3) as usize;
        let (mut p, mut q) = ([0.7; 3], [0.7; 3]);
        let to = from + (r + s);
        (p[axis], q[axis]) = (from, *rng.pick(&[to, to.next_up(), to.next_down()]));
        let sphere = |p: Point, r: f64| Shape { core: Core::Point(p), radius: r };
        let (a, b) = (sphere(p, r), sphere(q, s));
        if let Some(verdict) = decide(&a, &b, 0.0) {
            assert_eq!(Some(verdict), exact(&a, &b, 0.0, -110), "{a:?} {b:?}");
            certain += 1;
            apart += usize::from(!verdict);
        }
    }
    assert!(certain > 2000 && apart > 500, "{certain} {apart}");
}

/// At margins around the distance, down to its last bits, and in touching positions on a grid.
#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn polytopes_are_decided_as_in_exact_arithmetic() {
    let mut rng = Rng::new(1);
    let (mut certain, mut all) = (0, 0);
    for i in 0..1500 {
        let kinds = (rng.below(4), rng.below(4));
        let (a, b) = (shape(&mut rng, kinds.0), shape(&mut rng, kinds.1));
        let (a, b) = (short(&a.moved(&pose(&mut rng, 1.0))), short(&b.moved(&pose(&mut rng, 1.0))));
        let d = distance(&a, &b);
        let factor = 1.0 + rng.range(-1.0, 1.0) * 2.0_f64.powi(-(rng.below(52) as i32));
        let margins = [0.0, 0.5, d, d * factor, d * (2.0 - factor)];
        for margin in margins.map(|m| if m < power_of_two(-50) { 0.0 } else { m }) {
            let got = decide(&a, &b, margin);
            all += 1;
            if let Some(verdict) = got {
                certain += 1;
                assert_eq!(Some(verdict), exact(&a, &b, margin, -110), "{i}: {a:?} {b:?} {margin:e}");
            }
        }
    }
    assert!(10 * certain > 5 * all);
}

/// A pair of polytopes without a margin that touch up to a few last bits, or up to `least`: long cuboids often by edges
/// that are nearly parallel.
pub(crate) fn touching(rng: &mut Rng, kinds: (u64, u64), least: i64) -> (Shape, Shape) {
    let mut one = |kind| {
        let s = if kind == 2 && rng.below(2) == 0 {
            Shape::cuboid([rng.range(2.0, 4.0), rng.range(0.2, 0.4), rng.range(0.2, 0.4)]).unwrap()
        } else {
            shape(rng, kind)
        };
        let s = Shape {
            core: s.core,
            radius: if kind == 2 || kind == 1 && rng.below(2) == 0 { 0.0 } else { s.radius },
        };
        let p = if rng.below(2) == 0 {
            let small = rng.range(-1.0, 1.0) * 2.0_f64.powi(-(rng.below(30) as i32));
            let (x, z) = (DMat3::from_rotation_x(rng.range(-3.0, 3.0)), DMat3::from_rotation_z(small));
            Pose::new(z * x, DVec3::ZERO).unwrap()
        } else {
            pose(rng, 0.5)
        };
        let off = DMat3::from_cols_array(&core::array::from_fn(|_| rng.range(-1.0, 1.0) * 2.8e-5));
        let off = if rng.below(3) == 0 { DMat3::IDENTITY + off } else { DMat3::IDENTITY };
        s.moved(&p).moved(&Pose::new(off, DVec3::ZERO).unwrap())
    };
    let (a, b) = (one(kinds.0), one(kinds.1));
    let direction: [f64; 3] = core::array::from_fn(|_| rng.range(-1.0, 1.0));
    let at =
        |t: f64| b.moved(&Pose::new(DMat3::IDENTITY, DVec3::from_array(direction.map(|x| t * x))).unwrap());
    let (mut low, mut high) = (0.0, 64.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if decide(&a, &at(middle), 0.0) == Some(false) { high = middle } else { low = middle }
    }
    let by = 2.0_f64.powi(-(rng.int(4, least) as i32));
    let t = high + by * rng.range(-1.0, 1.0);
    (short(&a), short(&at(t)))
}

#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn touching_polytopes_are_decided_as_in_exact_arithmetic() {
    let mut rng = Rng::new(6);
    let (mut certain, mut all) = (0, 0);
    for i in 0..6000 / CASES_STEP {
        let kinds = if rng.below(3) == 0 { (rng.below(3), rng.below(3)) } else { (rng.int(1, 2) as u64, 2) };
        let (a, b) = touching(&mut rng, kinds, 51);
        all += 1;
        if let Some(verdict) = decide(&a, &b, 0.0) {
            certain += 1;
            assert_eq!(Some(verdict), exact(&a, &b, 0.0, -110), "{i}: {a:?} {b:?}");
        }
    }
    assert!(10 * certain > 5 * all, "{certain} of {all}");
}

/// Triangles of any shape, needles, segments and points among them, against points, segments and cuboids, at margins
/// around the distance and moved until they touch.
#[test]
fn triangles_are_decided_as_in_exact_arithmetic() {
    let mut rng = Rng::new(11);
    let (mut certain, mut all, mut hits, mut touching) = (0, 0, 0, [0, 0]);
    for i in 0..4000 / CASES_STEP {
        let is_grid = rng.below(3) == 0;
        let mut corner = || -> Point {
            [(); 3].map(|()| if is_grid { rng.int(-2, 2) as f64 * 0.5 } else { rng.range(-1.0, 1.0) })
        };
        let [p, q, r] = [corner(), corner(), corner()];
        let (along, width) = (rng.range(-0.5, 1.5), *rng.pick(&[1.0, 1.0, 1.0, 1e-3, 1e-9, 0.0]));
        let r = if width == 1.0 { r } else { [0, 1, 2].map(|i| p[i] + along * (q[i] - p[i]) + width * r[i]) };
        let radius = *rng.pick(&[0.0, 0.0, 0.125]);
        let a = short(&Shape { core: Core::Triangle([p, q, r]), radius });
        let kind = rng.below(4);
        let b = shape(&mut rng, kind);
        let b = if rng.below(2) == 0 { Shape { radius: 0.0, ..b } } else { b };
        let b = b.moved(&pose(&mut rng, 1.0));
        let d = distance(&a, &b);
        let factor = 1.0 + rng.range(-1.0, 1.0) * 2.0_f64.powi(-(rng.below(52) as i32));
        let check = |b: &Shape, margin: f64| {
            let b = short(b);
            let verdict = decide(&a, &b, margin);
            assert_eq!(verdict, decide(&b, &a, margin));
            if let Some(verdict) = verdict {
                assert_eq!(Some(verdict), exact(&a, &b, margin, -110), "{i}: {a:?} {b:?} {margin:e}");
            }
            verdict
        };
        for margin in [0.0, 0.5, d, d * factor, d * (2.0 - factor)] {
            let verdict = check(&b, if margin < power_of_two(-50) { 0.0 } else { margin });
            (certain, all) = (certain + usize::from(verdict.is_some()), all + 1);
            hits += usize::from(verdict == Some(true));
        }
        // Away from the triangle until they are apart, and back by a little.
        let direction: [f64; 3] = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        let at = |t: f64| {
            b.moved(&Pose::new(DMat3::IDENTITY, DVec3::from_array(direction.map(|x| t * x))).unwrap())
        };
        let (mut low, mut high) = (0.0, 64.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if decide(&a, &at(middle), 0.0) == Some(false) { high = middle } else { low = middle }
        }
        let t = high + 2.0_f64.powi(-(rng.int(4, 51) as i32)) * rng.range(-1.0, 1.0);
        let verdict = check(&at(t), 0.0);
        touching[0] += usize::from(verdict.is_some());
        touching[1] += 1;
    }
    assert!(10 * certain > 5 * all && hits > 5000 / CASES_STEP, "{certain} of {all}, {hits}");
    assert!(10 * touching[0] > 5 * touching[1], "{touching:?}");
}

/// Pairs of any magnitudes: what overflows or underflows must stay undecided.
#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn numbers_of_any_magnitude_never_give_a_wrong_verdict() {
    let mut rng = Rng::new(2);
    let mut certain = 0;
    for i in 0..2000 / CASES_STEP {
        let all = power_of_two(*rng.pick(&[-240, -160, -101, -99, 0, 99, 101, 160, 250, 290]));
        let mut draw = || {
            let kind = rng.below(4);
            let s = shape(&mut rng, kind);
            let s = short(&s.moved(&pose(&mut rng, 1.0)));
            // Differences of scales, and of the scale of an edge.
            let (mine, edge) =
                (power_of_two(rng.int(-40, 10) as i32 * 6), power_of_two(rng.int(-20, 0) as i32 * 8));
            let factor = *rng.pick(&[1.0, 1.0, mine]);
            let edge = *rng.pick(&[1.0, 1.0, edge]);
            let scaled =
                |x: f64| crate::range::flush((x * factor * all).clamp(-power_of_two(301), power_of_two(301)));
            let point = |p: &Point| p.map(scaled);
            let core = match s.core {
                Core::Point(p) => Core::Point(point(&p)),
                Core::Segment(ends) => Core::Segment(ends.map(|p| point(&p))),
                Core::Cuboid { centre, half: [x, y, z] } => Core::Cuboid {
                    centre: point(&centre),
                    half: [point(&x.map(|x| x * edge)), point(&y), point(&z)],
                },
                other => other,
            };
            Shape { core, radius: scaled(s.radius) }
        };
        let (a, b) = (draw(), draw());
        for margin in [0.0, all, power_of_two(-250), f64::MIN_POSITIVE] {
            if let Some(verdict) = decide(&a, &b, margin) {
                certain += 1;
                // All numbers are multiples of the last bit of the least one.
                assert_eq!(Some(verdict), exact(&a, &b, margin, -1100), "{i}: {a:?} {b:?} {margin:e}");
            }
        }
    }
    assert!(certain > 2000 / CASES_STEP);
}

/// The convex hull of some points: the first of them, and all relative to it.
struct Hull(Point, Vec<Point>);

impl Hull {
    fn new(points: &[Point], origin: &Point) -> Self {
        let at = difference(&points[0], origin);
        Self(at, points.iter().map(|p| difference(p, &points[0])).collect())
    }
}

impl Supported for Hull {
    fn at(&self) -> &Point {
        &self.0
    }

    fn size(&self) -> f64 {
        16.0
    }

    fn inner(&self) -> f64 {
        0.0
    }

    fn nearest_of(&self, _: &Point, _: f64) -> Point {
        self.0
    }

    fn support(&self, n: &Point) -> f64 {
        dot(&self.farthest(n), n)
    }

    fn farthest(&self, n: &Point) -> Point {
        *self.1.iter().max_by(|p, q| dot(p, n).total_cmp(&dot(q, n))).unwrap()
    }
}

/// Corners of a prism or a pyramid inside a cylinder or a cone, or around it; those of other cores.
fn corners(core: &Core, is_around: bool) -> Vec<Point> {
    let add = |p: &Point, q: &Point| [0, 1, 2].map(|i| p[i] + q[i]);
    let multiple = |t: f64, p: &Point| p.map(|x| t * x);
    match core {
        Core::Point(p) => vec![*p],
        Core::Segment(ends) => ends.to_vec(),
        Core::Triangle(corners) => corners.to_vec(),
        Core::Cuboid { centre, half: h } => (0..8)
            .map(|i| {
                let sign = |j: usize| if i >> j & 1 == 0 { -1.0 } else { 1.0 };
                let corner = add(&multiple(sign(0), &h[0]), &multiple(sign(1), &h[1]));
                add(centre, &add(&corner, &multiple(sign(2), &h[2])))
            })
            .collect(),
        Core::Cylinder { centre, half_axis: a, radius } | Core::Cone { base: centre, axis: a, radius } => {
            let is_cone = matches!(core, Core::Cone { .. });
            let least = [0, 1, 2].into_iter().min_by(|i, j| a[*i].abs().total_cmp(&a[*j].abs())).unwrap();
            let mut x = [0.0; 3];
            x[least] = 1.0;
            let unit = |v: Point| multiple(1.0 / dot(&v, &v).sqrt(), &v);
            let x = unit(crate::vector::cross(a, &x));
            let y = unit(crate::vector::cross(a, &x));
            let step = core::f64::consts::PI / 64.0;
            let r = if is_around { radius / step.cos() } else { *radius };
            let mut all = if is_cone { vec![add(centre, a)] } else { vec![] };
            for i in 0..64 {
                let angle = 2.0 * step * f64::from(i);
                let rim = add(&multiple(r * angle.cos(), &x), &multiple(r * angle.sin(), &y));
                if is_cone {
                    all.push(add(centre, &rim));
                    continue;
                }
                all.push(add(centre, &add(a, &rim)));
                all.push(add(centre, &add(&multiple(-1.0, a), &rim)));
            }
            all
        }
        _ => unreachable!(),
    }
}

/// Against prisms and pyramids of 64 sides inside the solids and around them.
#[test]
fn round_solids_are_between_prisms() {
    let mut rng = Rng::new(3);
    let (mut certain, mut all) = (0, 0);
    // Not along the axes.
    let none = Shape::unchecked(Core::Triangle([[0.0; 3]; 3]), 0.0);
    for i in 0..2000 / CASES_STEP {
        let kinds = (*rng.pick(&[0, 1, 2, 4, 5]), *rng.pick(&[4, 5]));
        let (a, b) = (shape(&mut rng, kinds.0), shape(&mut rng, kinds.1));
        let (a, b) = (a.moved(&pose(&mut rng, 2.0)), b.moved(&pose(&mut rng, 2.0)));
        let d = distance(&a, &b);
        for margin in [0.0, d, d * 1.01 + 1e-3, d * 0.99, 0.1] {
            let got = decide(&a, &b, margin);
            assert!(decide(&b, &a, margin).is_none_or(|other| got.is_none_or(|got| got == other)));
            let Some(verdict) = got else { continue };
            let (p, q) = (corners(&a.core, verdict), corners(&b.core, verdict));
            let reach = a.radius + b.radius + margin;
            let other = search::decide(
                &Hull::new(&p, &p[0]),
                &Hull::new(&q, &p[0]),
                &PairAndMargin { a: &none, at: InPlace, b: &none, margin, reach },
            );
            certain += 1;
            all += usize::from(other.is_some());
            assert!(other.is_none_or(|other| other == verdict), "{i}: {a:?} {b:?} {margin:e}");
        }
    }
    assert!(certain > 3000 / CASES_STEP && all > 3000 / CASES_STEP);
}

/// Cylinders along an axis whose distances are roots of integers, at margins next to them.
#[test]
fn cylinders_at_known_distances() {
    let mut rng = Rng::new(4);
    let mut certain = [0, 0];
    for _ in 0..20_000 {
        let axis = rng.below(3) as usize;
        let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut number = |low: i64| rng.int(low, 8) as f64;
        let (r, s, h, k) = (number(1), number(1), number(1), number(1));
        let mut d = [0.0; 3];
        (d[axis], d[x], d[y]) = (number(-8), number(-8), number(-8));
        let along = |h: f64| {
            let mut a = [0.0; 3];
            a[axis] = h;
            a
        };
        let cylinder = |centre, h, radius| Core::Cylinder { centre, half_axis: along(h), radius };
        let a = Shape { core: cylinder([0.0; 3], h, r), radius: 0.0 };
        let kind = rng.below(3);
        let (b, s, k) = match kind {
            0 => (cylinder(d, -k, s), s, k),
            1 => {
                let (low, high) = (along(-k), along(k));
                let ends = [low, high].map(|e| [0, 1, 2].map(|i| e[i] + d[i]));
                (Core::Segment(ends), 0.0, k)
            }
            _ => (Core::Point(d), 0.0, 0.0),
        };
        let b = Shape { core: b, radius: 0.0 };
        let (high, across) = ((d[axis].abs() - h - k).max(0.0), d[x] * d[x] + d[y] * d[y]);
        // The square of the distance is high^2 + max(0, root - r - s)^2.
        let is_within = |m: f64| {
            // Both sides are exact up to 2^-100, and 1e-14 is kept from equality.
            let side = (across.sqrt() - r - s).max(0.0);
            m - high.hypot(side)
        };
        let scale = power_of_two(rng.int(-90, 90) as i32);
        let margin =
            (high.hypot((across.sqrt() - r - s).max(0.0)) * (1.0 + rng.range(-1.0, 1.0) * 1e-10)).max(0.0);
        for m in [margin, 0.0, 1.0] {
            let difference = is_within(m);
            let got = decide(&scaled(&a, scale), &scaled(&b, scale), m * scale);
            if difference.abs() > 1e-14 {
                assert!(got.is_none_or(|got| got == (difference > 0.0)), "{a:?} {b:?} {m:e}: {difference:e}");
            }
            certain[usize::from(got.is_some())] += 1;
        }
    }
    assert!(certain[1] > 4 * certain[0], "{certain:?}");
}

#[test]
fn half_spaces_are_decided_as_in_exact_arithmetic() {
    let mut rng = Rng::new(5);
    let (mut certain, mut all) = (0, 0);
    for i in 0..5000 {
        let kind = rng.below(4);
        let (a, b) = (shape(&mut rng, 6), shape(&mut rng, kind));
        let (a, b) = (a.moved(&pose(&mut rng, 1.0)), short(&b.moved(&pose(&mut rng, 1.0))));
        let Core::HalfSpace { normal, offset } = a.core else { unreachable!() };
        let cut = |x: f64| (x + power_of_two(10)) - power_of_two(10);
        let (normal, offset) = (normal.map(cut), cut(offset));
        let a = Shape { core: Core::HalfSpace { normal, offset }, radius: a.radius };
        let d = distance(&a, &b);
        for margin in [0.0, d, d * (1.0 + rng.range(-1.0, 1.0) * 1e-12), d + power_of_two(-44)] {
            let margin = if margin < power_of_two(-50) { 0.0 } else { margin };
            let p = Polytope::new(&b.core, -110).unwrap();
            let n = vector(&normal, -110);
            let low = p.range(&n).0 - (integer(offset, -110) << 110);
            let reach = integer(b.radius, -110) + integer(margin, -110);
            let want = low <= IBig::ZERO || &low * &low <= &reach * &reach * inner(&n, &n);
            for got in [decide(&a, &b, margin), decide(&b, &a, margin)] {
                all += 1;
                certain += usize::from(got.is_some());
                assert!(got.is_none_or(|got| got == want), "{i}: {a:?} {b:?} {margin:e}");
            }
        }
    }
    assert!(10 * certain > 5 * all);
}

#[test]
fn half_spaces_against_round_shapes_and_half_spaces() {
    let floor = Shape::half_space([0.0, 0.0, 3.0], 0.0).unwrap();
    let at = |s: &Shape, z: f64| s.moved(&Pose::new(DMat3::IDENTITY, DVec3::new(5.0, 2.0, z)).unwrap());
    let lying = |s: &Shape, z: f64| {
        s.moved(
            &Pose::new(DMat3::from_cols_array(&[0., 0., 1., 1., 0., 0., 0., 1., 0.]), DVec3::new(5., 2., z))
                .unwrap(),
        )
    };
    let (cylinder, cone) = (Shape::cylinder(1.0, 4.0).unwrap(), Shape::cone(1.0, 4.0).unwrap());
    let triangle = Core::Triangle([[0., 0., 0.], [1., 0., 0.], [0., 1., 2.]]);
    let triangle = Shape::new(triangle, 0.5).unwrap();
    let cases: [(&dyn Fn(f64) -> Shape, f64); 5] = [
        (&|z| at(&cylinder, z), 2.0),
        (&|z| lying(&cylinder, z), 1.0),
        (&|z| at(&cone, z), 2.0),
        (&|z| lying(&cone, z), 1.0),
        (&|z| at(&triangle, z), 0.5),
    ];
    for (shape, height) in cases {
        for margin in [0.0, 0.25] {
            for (by, want) in [(1e-12, Some(false)), (-1e-12, Some(true)), (-9.0, Some(true)), (0.0, None)] {
                let b = shape(height + margin + by);
                let got = decide(&floor, &b, margin);
                assert!(got == want || by == 0.0 && got == Some(true), "{b:?} {by}");
            }
        }
    }
    let other = |n| Shape::half_space(n, -9.0).unwrap();
    assert_eq!(decide(&floor, &other([0.0, 0.0, 1.0]), 0.0), Some(true));
    assert_eq!(decide(&floor, &other([0.0, 1.0, -1.0]), 0.0), Some(true));
    assert_eq!(decide(&floor, &other([0.0, 0.0, -1.0]), 0.0), None);
}

#[test]
fn odd_margins() {
    let sphere = Shape::sphere(1.0).unwrap();
    for (margin, want) in [(f64::NAN, None), (-1.0, None), (f64::INFINITY, Some(true))] {
        assert_eq!(decide(&sphere, &sphere, margin), want);
    }
}
