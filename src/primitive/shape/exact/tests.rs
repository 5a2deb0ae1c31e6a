//! The exact tests against other methods, in integers and in fixed point: min-norm points of polytopes
//! ([`nearest`]), projections of what is between the planes of a round solid's ends ([`sections`]), and distances with
//! several hundred digits ([`digits`]).

mod aligned;
mod digits;
mod far;
mod nearest;
mod sections;

use super::is_within;
use crate::exact::power_of_two;
use crate::primitive::shape::{Core, Shape};
use crate::range::Point;
use crate::rng::Rng;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::{Add, Mul, Sub};

/// The numbers an oracle computes with.
trait Number: Clone + Ord + From<i64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}
impl<T: Clone + Ord + From<i64> + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

/// For shapes of small whole numbers.
fn whole(x: f64) -> i128 {
    x as i128
}

fn dot<T: Number>(u: &[T; 3], v: &[T; 3]) -> T {
    let product = |k: usize| u[k].clone() * v[k].clone();
    product(0) + product(1) + product(2)
}

fn cross<T: Number>(u: &[T; 3], v: &[T; 3]) -> [T; 3] {
    let product = |i: usize, j: usize| u[i].clone() * v[j].clone();
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| product(i, j) - product(j, i))
}

/// `x u + y v`
fn combined<T: Number>(x: &T, u: &[T; 3], y: &T, v: &[T; 3]) -> [T; 3] {
    [0, 1, 2].map(|k| x.clone() * u[k].clone() + y.clone() * v[k].clone())
}

fn minus<T: Number>(u: &[T; 3], v: &[T; 3]) -> [T; 3] {
    [0, 1, 2].map(|k| u[k].clone() - v[k].clone())
}

/// The corners of a polytope, in a unit in which the conversion is exact.
fn corners<T: Number>(core: &Core, number: impl Fn(f64) -> T) -> Vec<[T; 3]> {
    let vector = |v: &Point| v.map(&number);
    match core {
        Core::Point(p) => vec![vector(p)],
        Core::Segment(ends) => ends.iter().map(vector).collect(),
        Core::Triangle(corners) => corners.iter().map(vector).collect(),
        Core::Cuboid { centre, half } => {
            let sign = |i: usize, j: usize| T::from(if i >> j & 1 == 1 { 1 } else { -1 });
            let (one, half) = (T::from(1), half.map(|h| vector(&h)));
            (0..8)
                .map(|i| (0..3).fold(vector(centre), |p, j| combined(&one, &p, &sign(i, j), &half[j])))
                .collect()
        }
        _ => panic!("{core:?} is no polytope"),
    }
}

/// A shape of whole numbers.
struct Draw<'a> {
    rng: &'a mut Rng,
    /// The greatest magnitude of a coordinate.
    most: i64,
}

impl Draw<'_> {
    fn number(&mut self) -> f64 {
        self.rng.int(-self.most, self.most) as f64
    }

    /// Along an axis one time in three.
    fn vector(&mut self) -> Point {
        if self.rng.below(3) == 0 {
            let mut v = [0.0; 3];
            v[self.rng.below(3) as usize] = self.number();
            return v;
        }
        [0; 3].map(|_| self.number())
    }

    fn axis(&mut self) -> Point {
        loop {
            let axis = self.vector();
            if axis != [0.0; 3] {
                return axis;
            }
        }
    }

    fn point(&mut self) -> Point {
        [0; 3].map(|_| self.number())
    }

    /// Kind 0 is a point, 1 a segment, 2 a triangle, 3 a cuboid, 4 a cylinder, 5 a cone, 6 a half-space.
    fn core(&mut self, kind: usize) -> Core {
        match kind {
            0 => Core::Point(self.point()),
            1 => Core::Segment([0; 2].map(|_| self.point())),
            2 => Core::Triangle([0; 3].map(|_| self.point())),
            3 if self.rng.below(2) == 0 => {
                let mut half = [[0.0; 3]; 3];
                for (k, edge) in half.iter_mut().enumerate() {
                    edge[k] = self.number();
                }
                Core::Cuboid { centre: self.point(), half }
            }
            3 => Core::Cuboid { centre: self.point(), half: [0; 3].map(|_| self.vector()) },
            4 => Core::Cylinder { centre: self.point(), half_axis: self.axis(), radius: self.length() },
            5 => Core::Cone { base: self.point(), axis: self.axis(), radius: self.length() },
            _ => Core::HalfSpace {
                normal: self.axis(),
                offset: if self.rng.below(4) == 0 { 0.0 } else { self.number() * self.most as f64 },
            },
        }
    }

    fn length(&mut self) -> f64 {
        self.rng.int(1, self.most) as f64
    }
}

/// The verdict for two cores widened by parts of a whole number `reach`, scaled by a power of two. Both orders must
/// agree.
fn verdict(rng: &mut Rng, a: &Core, b: &Core, reach: f64) -> Option<bool> {
    let scale = *rng.pick(&[1.0, 1.0, power_of_two(-250), power_of_two(290), power_of_two(3)]);
    let parts =
        *rng.pick(&[[0.0, 0.0, reach], [reach, 0.0, 0.0], [0.0, reach - 1.0, 1.0], [1.0, reach - 1.0, 0.0]]);
    let parts = if reach == 0.0 { [0.0; 3] } else { parts };
    let [p, q, margin] = parts.map(|x| x * scale);
    let (a, b) =
        (Shape { core: a.map(|x| x * scale), radius: p }, Shape { core: b.map(|x| x * scale), radius: q });
    let verdict = is_within(&a, &b, margin);
    assert_eq!(verdict, is_within(&b, &a, margin), "{a:?} {b:?} {margin:e}");
    verdict
}

/// How often each verdict was given, and how often by a touch.
#[derive(Default, Debug)]
struct Tally {
    apart: usize,
    near: usize,
    touching: usize,
}

impl Tally {
    fn add(&mut self, order: core::cmp::Ordering) -> bool {
        self.apart += usize::from(order.is_gt());
        self.near += usize::from(order.is_lt());
        self.touching += usize::from(order.is_eq());
        order.is_le()
    }

    fn check(&self, least: usize, what: &str) {
        let all = [self.apart, self.near, self.touching];
        assert!(all.iter().all(|count| *count >= least), "{what}: {self:?}");
    }
}
