//! Every set of directions against oracles that do not use its hull, its grid or its walk: the definition of a
//! decomposition, and the best of all triples of directions.

#[path = "support/data.rs"]
mod data;
#[path = "support/rng.rs"]
mod rng;

use data::{by_suite, suite_step};
use rng::Rng;
use simdop::low_level::directions::{Directions, SUPPORTED, table};

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Uniform on the sphere, then scaled by up to 2^±20.
fn ray(rng: &mut Rng) -> Vector {
    loop {
        let u: Vector = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        if (0.01..1.0).contains(&dot(u, u)) {
            let scale = 2.0_f64.powi(rng.int(-20, 20) as i32) / length(u);
            return u.map(|x| x * scale);
        }
    }
}

/// To find the best of all triples of directions: every invertible triple, inverted by Cramer's rule, and the
/// lengths of its directions.
struct Triples(Vec<([Vector; 3], Vector)>);

impl Triples {
    fn new<const K: usize>() -> Self {
        let n = Directions::<K>::VECTORS;
        let mut triples = Vec::new();
        for a in 0..K {
            for b in 0..a {
                for c in 0..b {
                    let [a, b, c] = [n[a], n[b], n[c]];
                    let determinant = dot(a, cross(b, c));
                    if determinant.abs() > 0.5 {
                        let rows = [cross(b, c), cross(c, a), cross(a, b)];
                        let lengths = [length(a), length(b), length(c)];
                        triples.push((rows.map(|row| row.map(|x| x / determinant)), lengths));
                    }
                }
            }
        }
        Self(triples)
    }

    /// The optimum of: minimise `sum c |n|` subject to `sum c n = u`, `c >= 0`. A basic solution has at most
    /// three terms.
    fn least_cost(&self, u: Vector) -> f64 {
        let slack = -1e-13 * length(u);
        let cost = |(rows, lengths): &([Vector; 3], Vector)| {
            let c = rows.map(|row| dot(row, u));
            if c.iter().all(|&c| c >= slack) { dot(c, *lengths) } else { f64::INFINITY }
        };
        self.0.iter().map(cost).fold(f64::INFINITY, f64::min)
    }
}

/// Checks the definition: three distinct directions; nonnegative weights; their sum is u; -u has the antipodal
/// directions. Returns the cost `sum c |n|`.
fn check_decomposition<const K: usize>(u: Vector) -> f64 {
    let n = Directions::<K>::VECTORS;
    let found = Directions::<K>::decompose(u);
    let [a, b, c] = found.directions.map(usize::from);
    assert!(a != b && b != c && c != a, "k = {K}, u = {u:?}: {found:?}");
    assert!(found.weights.iter().all(|&c| c >= 0.0 && c.is_finite()), "k = {K}, u = {u:?}: {found:?}");
    let terms = [(a, 0), (b, 1), (c, 2)].map(|(j, l)| n[j].map(|x| x * found.weights[l]));
    let sum = add(add(terms[0], terms[1]), terms[2]);
    let residual = length(add(sum, u.map(|x| -x)));
    assert!(
        residual <= 2.0_f64.powi(-46) * length(u),
        "k = {K}, u = {u:?}: {found:?} misses it by {residual:e}"
    );

    let opposite = Directions::<K>::decompose(u.map(|x| -x));
    for (direction, weight) in found.directions.map(|j| j ^ 1).into_iter().zip(found.weights) {
        let other =
            (0..3).filter(|&m| opposite.directions[m] == direction).map(|m| opposite.weights[m]).sum::<f64>();
        // On a border, -u may use the face next to the antipodal one. Then the corner that differs has no
        // weight.
        assert!(
            (other - weight).abs() <= 1e-12 * length(u),
            "k = {K}, u = {u:?}: {found:?} but {opposite:?}"
        );
    }
    (0..3).map(|l| found.weights[l] * length(n[usize::from(found.directions[l])])).sum()
}

fn random_rays<const K: usize>() {
    let mut rng = Rng::new(K as u64);
    let triples = Triples::new::<K>();
    for i in 0..100_000 / suite_step() {
        let u = ray(&mut rng);
        let cost = check_decomposition::<K>(u);
        if i % 10 == 0 {
            let least = triples.least_cost(u);
            assert!(
                (cost - least).abs() <= 1e-12 * cost,
                "k = {K}, u = {u:?}: costs {cost}, the best {least}"
            );
        }
    }
}

/// Rays where two or more faces meet exactly, and rays beside them by one unit in the last place or somewhat
/// more.
fn borders<const K: usize>() {
    let n = Directions::<K>::VECTORS;
    let triples = Triples::new::<K>();
    let mut rays = n.to_vec();
    for (j, &p) in n.iter().enumerate() {
        for (m, &q) in n.iter().enumerate() {
            if m != j ^ 1 {
                rays.push(add(p, q));
                rays.push(add(p.map(|x| x * 0.1), q.map(|x| x * 0.7)));
            }
        }
    }
    // Coprime to the step of small suites: all kinds of rays.
    for ray in rays.into_iter().step_by(by_suite(1, 29)) {
        for axis in 0..3 {
            let x = ray[axis];
            for beside in [x.next_down(), x, x.next_up(), x - 1e-10, x + 1e-10] {
                let mut u = ray;
                u[axis] = beside;
                let (cost, least) = (check_decomposition::<K>(u), triples.least_cost(u));
                assert!(
                    (cost - least).abs() <= 1e-12 * cost,
                    "k = {K}, u = {u:?}: costs {cost}, the best {least}"
                );
            }
        }
    }
    for (j, &u) in n.iter().enumerate() {
        let found = Directions::<K>::decompose(u);
        for l in 0..3 {
            let expected = if usize::from(found.directions[l]) == j { 1.0 } else { 0.0 };
            assert!((found.weights[l] - expected).abs() <= 1e-14, "k = {K}: direction {j} is {found:?}");
        }
        assert!(found.directions.contains(&(j as u8)), "k = {K}: direction {j} is {found:?}");
    }
}

/// The result is unspecified, but valid: indices in range, no negative weight, no panic.
fn hopeless<const K: usize>() {
    let odd =
        [0.0, -0.0, 1.0, -1.0, 5e-324, -1e-310, 1e300, f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    for index in 0..odd.len().pow(3) {
        let u = [index, index / odd.len(), index / odd.len().pow(2)].map(|digit| odd[digit % odd.len()]);
        let found = Directions::<K>::decompose(u);
        assert!(found.directions.iter().all(|&j| usize::from(j) < K), "k = {K}, u = {u:?}: {found:?}");
        assert!(found.weights.iter().all(|&c| c >= 0.0), "k = {K}, u = {u:?}: {found:?}");
    }
}

fn constants<const K: usize>(slabs: &[[i8; 3]]) {
    let exact = |n: [i8; 3]| n.map(f64::from);
    let expected: Vec<Vector> = slabs.iter().flat_map(|&n| [exact(n), exact(n.map(|x| -x))]).collect();
    assert_eq!(Directions::<K>::VECTORS.to_vec(), expected, "k = {K}");
    assert_eq!(table(K).vectors.iter().map(|&n| exact(n)).collect::<Vec<_>>(), expected, "k = {K}");
    assert_eq!(Directions::<K>::SLABS, K / 2, "k = {K}");
    let greatest = slabs.iter().flatten().map(|x| x.unsigned_abs()).max();
    assert_eq!(Some(Directions::<K>::MAX_COMPONENT), greatest.map(f64::from), "k = {K}");
    for (n, bound) in expected.iter().zip(Directions::<K>::LENGTHS) {
        // In units of 2^-52 a bound is an integer, and so is every square.
        let scaled = (bound * 2.0_f64.powi(52)) as u128;
        let below = (bound.next_down().next_down() * 2.0_f64.powi(52)) as u128;
        let square = (dot(*n, *n) as u128) << 104;
        assert!(scaled * scaled >= square, "k = {K}: {n:?} is longer than {bound}");
        assert!(below * below < square, "k = {K}: {bound} is far above the length of {n:?}");
    }
}

/// The documented mean width of a rotated ball, to three digits.
fn mean_width<const K: usize>(documented: f64) {
    let mut rng = Rng::new(7);
    let rays = 40_000;
    let n = Directions::<K>::VECTORS;
    let mut sum = 0.0;
    for _ in 0..rays {
        let u = ray(&mut rng);
        let found = Directions::<K>::decompose(u);
        let width = |l: usize| found.weights[l] * length(n[usize::from(found.directions[l])]);
        sum += (width(0) + width(1) + width(2)) / length(u);
    }
    let mean = sum / f64::from(rays);
    assert!((mean - documented).abs() < 0.003, "k = {K}: a turned ball is {mean} times as wide");
}

macro_rules! for_each_k {
    ($($name:ident: $check:ident;)*) => {$(
        #[test]
        fn $name() {
            $check::<6>();
            $check::<14>();
            $check::<18>();
            $check::<26>();
            $check::<32>();
        }
    )*};
}

for_each_k! {
    random_rays_take_the_best_three_directions: random_rays;
    rays_on_borders_take_the_best_three_directions: borders;
    every_bit_pattern_gets_an_answer: hopeless;
}

#[test]
fn sets_are_as_documented() {
    assert_eq!(SUPPORTED, [6, 14, 18, 26, 32]);
    let axes = vec![[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let corners = vec![[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]];
    let edges = vec![[1, 1, 0], [0, 1, 1], [1, 0, 1], [1, -1, 0], [0, 1, -1], [-1, 0, 1]];
    let twos = vec![[2, -1, -1], [-1, 2, -1], [-1, -1, 2], [1, 1, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]];
    let threes = vec![[3, -2, 1], [1, 3, -2], [-2, 1, 3], [3, 1, -2], [-2, 3, 1], [1, -2, 3]];
    constants::<6>(&axes);
    constants::<14>(&[axes.clone(), corners.clone()].concat());
    constants::<18>(&[axes.clone(), edges.clone()].concat());
    constants::<26>(&[axes.clone(), edges, corners].concat());
    constants::<32>(&[axes, twos, threes].concat());
}

#[test]
fn a_turned_ball_is_as_wide_as_documented() {
    mean_width::<6>(1.499);
    mean_width::<14>(1.167);
    mean_width::<18>(1.128);
    mean_width::<26>(1.088);
    mean_width::<32>(1.068);
}
