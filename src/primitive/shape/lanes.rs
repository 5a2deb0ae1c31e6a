//! Sixteen spheres, capsules or cuboids for the SIMD kernels, in `f32`.
//!
//! All three are a centre, `N` half edges and a radius: `N` is 0, 1 or 3. The kernels' verdicts are those of the
//! shapes in `f64`: their error bounds include the rounding of these numbers. A shape whose numbers are out of the
//! range of the error analysis is never decided.

use crate::exact::{power_of_two, round_up_f32};
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::Point;
use crate::vector::{dot, sqrt};

/// The range of [`Solid`]'s `size`: products of two sizes and two error bounds are normal numbers. Smaller shapes get
/// the least size.
const LEAST: f64 = power_of_two(-20);
const GREATEST: f64 = power_of_two(30);
/// Cuboids with shorter half edges are not decided.
const SHORTEST: f64 = power_of_two(-60);

/// One shape with `N` half edges.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Solid<const N: usize> {
    /// Its centre.
    pub centre: [f32; 3],
    /// Its half edges.
    pub half: [[f32; 3]; N],
    /// The radius around the core.
    pub radius: f32,
    /// The radius of a ball in the core, or less. Rounded down.
    pub inner: f32,
    /// The sum of the magnitudes of the coordinates of `centre` and `half`, or more: kernels allow for errors in
    /// proportion to it. Infinite for a shape that is not decided.
    pub size: f32,
    /// The approximate reciprocal of the square of each half edge; 0 for one of length 0.
    pub inverse: [f32; N],
    /// The greatest dot product of a half edge with the difference of a point of the core and the centre. Rounded up.
    pub extent: [f32; N],
    /// The approximate length of each half edge.
    pub length: [f32; N],
    /// The greatest cosine of the angle between two half edges. Rounded up.
    pub skew: f32,
}

impl<const N: usize> Solid<N> {
    /// All numbers zero.
    pub const EMPTY: Self = Self {
        centre: [0.0; 3],
        half: [[0.0; 3]; N],
        radius: 0.0,
        inner: 0.0,
        size: 0.0,
        inverse: [0.0; N],
        extent: [0.0; N],
        length: [0.0; N],
        skew: 0.0,
    };

    /// A shape widened by `margin`. `None` if it is not a sphere, capsule or cuboid of `N` half edges.
    #[must_use]
    pub fn new(shape: &Shape, margin: f64) -> Option<Self> {
        let mut half = [[0.0; 3]; N];
        let centre = match (N, shape.core()) {
            (0, Core::Point(p)) => *p,
            (1, Core::Segment([p, q])) => {
                half[0] = [0, 1, 2].map(|i| 0.5 * (q[i] - p[i]));
                [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]))
            }
            (3, Core::Cuboid { centre, half: edges }) => {
                half.copy_from_slice(edges);
                *centre
            }
            _ => return None,
        };
        Some(Self::of(&centre, &half, shape.radius() + margin))
    }

    fn of(centre: &Point, half: &[Point; N], radius: f64) -> Self {
        let norm_1 = |v: &Point| v[0].abs() + v[1].abs() + v[2].abs();
        let largest = |v: &Point| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let narrow = |v: &Point| [v[0] as f32, v[1] as f32, v[2] as f32];
        let size = half.iter().fold(norm_1(centre), |sum, h| sum + norm_1(h));
        let shortest = half.iter().map(largest).fold(f64::INFINITY, f64::min);
        let is_treated = size.max(radius) <= GREATEST && (N < 3 || shortest >= SHORTEST);
        let mut solid = Self {
            centre: narrow(centre),
            half: [[0.0; 3]; N],
            radius: radius as f32,
            // Heights over a face are at least 0.999 of the edge.
            inner: if N < 3 { 0.0 } else { (0.5 * shortest) as f32 },
            size: if is_treated {
                round_up_f32(size.max(LEAST) * (1.0 + power_of_two(-48)))
            } else {
                f32::INFINITY
            },
            inverse: [0.0; N],
            extent: [0.0; N],
            length: [0.0; N],
            skew: 0.0,
        };
        for (i, h) in half.iter().enumerate() {
            let square = dot(h, h);
            solid.half[i] = narrow(h);
            solid.inverse[i] = if largest(h) >= SHORTEST { (1.0 / square) as f32 } else { 0.0 };
            let extent: f64 = half.iter().map(|g| dot(g, h).abs()).sum();
            solid.extent[i] = round_up_f32(extent * (1.0 + power_of_two(-48)));
            solid.length[i] = sqrt(square) as f32;
            for g in &half[..i] {
                let cosine = dot(g, h).abs() / sqrt(dot(g, g) * square);
                solid.skew = solid.skew.max(round_up_f32(cosine + power_of_two(-48)));
            }
        }
        solid
    }
}

/// Up to sixteen shapes with `N` half edges, lane by lane the numbers of [`Solid`].
#[derive(Clone, PartialEq, Debug)]
#[repr(C, align(64))]
pub struct SolidLanes<const N: usize> {
    /// See [`Solid::centre`].
    pub centre: [[f32; 16]; 3],
    /// See [`Solid::half`].
    pub half: [[[f32; 16]; 3]; N],
    /// See [`Solid::radius`].
    pub radius: [f32; 16],
    /// See [`Solid::inner`].
    pub inner: [f32; 16],
    /// See [`Solid::size`].
    pub size: [f32; 16],
    /// See [`Solid::inverse`].
    pub inverse: [[f32; 16]; N],
    /// See [`Solid::extent`].
    pub extent: [[f32; 16]; N],
    /// See [`Solid::length`].
    pub length: [[f32; 16]; N],
    /// See [`Solid::skew`].
    pub skew: [f32; 16],
    /// The lanes that have a shape.
    pub used: u16,
}

/// Sixteen spheres.
pub type SphereLanes = SolidLanes<0>;
/// Sixteen capsules.
pub type CapsuleLanes = SolidLanes<1>;
/// Sixteen cuboids, which may have a radius.
pub type CuboidLanes = SolidLanes<3>;

impl<const N: usize> SolidLanes<N> {
    /// No shape: every lane is apart from everything.
    pub const EMPTY: Self = Self {
        centre: [[0.0; 16]; 3],
        half: [[[0.0; 16]; 3]; N],
        radius: [0.0; 16],
        inner: [0.0; 16],
        size: [0.0; 16],
        inverse: [[0.0; 16]; N],
        extent: [[0.0; 16]; N],
        length: [[0.0; 16]; N],
        skew: [0.0; 16],
        used: 0,
    };

    /// The first sixteen of some shapes. `None` if one of them does not have `N` half edges ([`Solid::new`]).
    #[must_use]
    pub fn new(shapes: &[Shape]) -> Option<Self> {
        let mut lanes = Self::EMPTY;
        for (lane, shape) in shapes.iter().take(16).enumerate() {
            lanes.set(lane, &Solid::new(shape, 0.0)?);
        }
        Some(lanes)
    }

    /// Fills a lane below 16.
    pub fn set(&mut self, lane: usize, solid: &Solid<N>) {
        for axis in 0..3 {
            self.centre[axis][lane] = solid.centre[axis];
        }
        for edge in 0..N {
            for axis in 0..3 {
                self.half[edge][axis][lane] = solid.half[edge][axis];
            }
            self.inverse[edge][lane] = solid.inverse[edge];
            self.extent[edge][lane] = solid.extent[edge];
            self.length[edge][lane] = solid.length[edge];
        }
        self.radius[lane] = solid.radius;
        self.inner[lane] = solid.inner;
        self.size[lane] = solid.size;
        self.skew[lane] = solid.skew;
        self.used |= 1 << lane;
    }
}

/// Which of sixteen shapes a shape is certainly apart from, and which it certainly meets.
#[derive(Copy, Clone, PartialEq, Eq, Debug, Default)]
pub struct Decided {
    /// Bit i: not within the margin of lane i, or lane i is unused.
    pub apart: u16,
    /// Bit i: within the margin of lane i.
    pub within: u16,
}
