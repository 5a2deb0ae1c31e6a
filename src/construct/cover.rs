//! Spheres that cover a mesh: a smaller body for applications that tolerate an error.
//!
//! Triangles are halved along their longest edges into *pieces*, whose edges are a fraction of the error. The first
//! piece that no sphere covers is the seed of the next sphere. Of several candidate centres near it on the mesh, the
//! one with the most uncovered pieces within reach is chosen. So spheres extend away from covered pieces, and overlap
//! little.
//!
//! No point of a sphere of radius r whose centre is at most d from the mesh is farther than `r + d` from the mesh.
//! Rounding changes the corners of pieces, halved at most 200 times, by less than 2^-44 of the largest coordinate; each
//! radius is larger by that.

use super::bake::smallest_enclosing;
use super::error::BuildError;
use super::input::{Mesh, check_records, check_vertices};
use crate::exact::power_of_two;
use crate::primitive::triangle::Triangle;
use crate::primitive::triangle::point::Foot;
use crate::primitive::{Sphere, Triangles};
use crate::range::Point;
use crate::vector::{cross, difference, length};
use alloc::vec::Vec;
use core::fmt;

/// Allowance for the roundings of corners, relative to the largest coordinate.
pub(crate) const ROUNDING: f64 = power_of_two(-44);
/// The least error, relative to the largest coordinate, so that roundings are negligible.
const LEAST_ERROR: f64 = power_of_two(-36);

/// Why a mesh cannot be covered.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum CoverError {
    /// The error is not finite, or not above 2^-36 of the largest coordinate.
    Error {
        /// The value given.
        given: f64,
        /// The bound that the error must exceed.
        least: f64,
    },
    /// The error would require more than 2^24 pieces, about fifty per sphere.
    TooMany,
    /// The mesh is invalid.
    Mesh(BuildError),
}

impl fmt::Display for CoverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error { given, least } => {
                write!(f, "an error of {given}: must be finite and above {least} with these coordinates")
            }
            Self::TooMany => f.write_str(
                "the error is too small for this mesh: it would be cut into more than 16,777,216 pieces",
            ),
            Self::Mesh(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for CoverError {}

impl Mesh<'_> {
    /// Spheres that contain every point of the mesh, and no point farther than `error` from it, in its unit. If a body
    /// of these spheres is free, so is the mesh, certainly; if it is hit, the other body comes within `error` of the
    /// mesh. The spheres cover the surface only: a body wholly inside a closed mesh may be free. [`Mesh::cover_solid`]
    /// covers the interior, too. Points are covered as triangles with three equal corners.
    ///
    /// The spheres are the same on every machine. An empty mesh gives none.
    ///
    /// ```
    /// use simdop::construct::{Builder, OwnedMesh, SphereSet};
    /// use simdop::{hierarchy::Bvh, node::Node16, primitive::Spheres};
    /// let cube = OwnedMesh::cuboid([1.0; 3])?;
    /// let spheres = cube.as_mesh().cover(0.1)?;
    /// let coarse: Bvh<Node16<18>, Spheres> = Builder::new()
    ///     .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| core::ops::ControlFlow::Continue(()))?;
    /// assert!(coarse.view().len() > 100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CoverError`].
    pub fn cover(&self, error: f64) -> Result<Vec<Sphere>, CoverError> {
        check_vertices::<Triangles>(self.vertices).map_err(CoverError::Mesh)?;
        check_records(self.triangles, self.vertices.len()).map_err(CoverError::Mesh)?;
        let triangles: Vec<Triangle> =
            self.triangles.iter().map(|t| t.map(|vertex| self.vertices[vertex as usize])).collect();
        let largest = triangles.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        check_error(error, largest)?;
        Ok(Cover::new(&triangles, error, ROUNDING * largest)?.spheres())
    }
}

/// Checks that an error is large compared with roundings, if no coordinate is above `largest`.
pub(crate) fn check_error(given: f64, largest: f64) -> Result<(), CoverError> {
    let least = LEAST_ERROR * largest;
    if given > least && given.is_finite() { Ok(()) } else { Err(CoverError::Error { given, least }) }
}

/// The longest edge of a piece, relative to the error.
const LONGEST: f64 = 0.25;
/// Limit of the number of pieces: more would take gigabytes.
const MOST_PIECES: usize = 1 << 24;
/// Candidate centres per sphere.
const TRIED: usize = 24;

/// A part of a triangle.
#[derive(Copy, Clone)]
struct Piece {
    corners: Triangle,
    middle: Point,
    /// Twice the area, in units of the squared error.
    area: f64,
    is_held: bool,
}

impl Piece {
    fn new(corners: Triangle, error: f64) -> Self {
        let [p, q, r] = &corners;
        let [u, v] = [q, r].map(|corner| difference(corner, p).map(|x| x / error));
        let area = length(&cross(&u, &v));
        let third = 1.0 / 3.0;
        Self {
            middle: [0, 1, 2].map(|i| third * p[i] + third * q[i] + third * r[i]),
            corners,
            area,
            is_held: false,
        }
    }

    fn is_within(&self, reach: f64, centre: &Point) -> bool {
        self.corners.iter().all(|p| length(&difference(p, centre)) <= reach)
    }
}

/// Halves triangles along their longest edges until no edge is longer than `longest`.
pub(crate) fn cut(triangles: &[Triangle], longest: f64) -> Result<Vec<Triangle>, CoverError> {
    let (mut waiting, mut pieces) = (triangles.to_vec(), Vec::new());
    while let Some(t) = waiting.pop() {
        let edge = |i: usize| length(&difference(&t[i], &t[(i + 1) % 3]));
        let i = (0..3).fold(0, |most, i| if edge(i) > edge(most) { i } else { most });
        if edge(i) <= longest {
            pieces.push(t);
        } else {
            let (p, q, r) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
            let m = [0, 1, 2].map(|axis| 0.5 * p[axis] + 0.5 * q[axis]);
            waiting.extend([[m, q, r], [p, m, r]]);
        }
        if pieces.len() + waiting.len() > MOST_PIECES {
            return Err(CoverError::TooMany);
        }
    }
    Ok(pieces)
}

/// A cell of a grid whose cubes are as wide as the error.
type CoverCell = [i64; 3];

struct Cover {
    error: f64,
    pad: f64,
    /// Sorted by their cubes.
    pieces: Vec<Piece>,
    /// The first piece of each cube that has any, in ascending order.
    cubes: Vec<(CoverCell, usize)>,
}

impl Cover {
    fn new(triangles: &[Triangle], error: f64, pad: f64) -> Result<Self, CoverError> {
        let unordered: Vec<Piece> =
            cut(triangles, LONGEST * error)?.into_iter().map(|t| Piece::new(t, error)).collect();
        let cell = |piece: &Piece| piece.middle.map(|x| libm::floor(x / error) as i64);
        let mut order: Vec<(CoverCell, usize)> =
            unordered.iter().enumerate().map(|(i, piece)| (cell(piece), i)).collect();
        order.sort_unstable();
        let pieces = order.iter().map(|&(_, i)| unordered[i]).collect();
        let mut cubes: Vec<(CoverCell, usize)> = Vec::new();
        for (i, (cube, _)) in order.iter().enumerate() {
            if cubes.last().is_none_or(|(last, _)| last != cube) {
                cubes.push((*cube, i));
            }
        }
        Ok(Self { error, pad, pieces, cubes })
    }

    /// Pieces whose middles are in a point's cube or its neighbours. They include all pieces within the error of the
    /// point.
    fn around(&self, p: &Point) -> impl Iterator<Item = usize> + '_ {
        let [x, y, z] = p.map(|x| libm::floor(x / self.error) as i64);
        let end = |k: usize| self.cubes.get(k).map_or(self.pieces.len(), |(_, first)| *first);
        let columns = (x - 1..=x + 1).flat_map(move |x| (y - 1..=y + 1).map(move |y| (x, y)));
        columns.flat_map(move |(x, y)| {
            let from = self.cubes.partition_point(|(cube, _)| *cube < [x, y, z - 1]);
            let to = self.cubes.partition_point(|(cube, _)| *cube <= [x, y, z + 1]);
            end(from)..end(to)
        })
    }

    fn spheres(mut self) -> Vec<Sphere> {
        let mut spheres = Vec::new();
        // Distance from a point of the mesh, minus the pads for the point and the mesh.
        let reach = (self.error - 4.0 * self.pad) * (1.0 - power_of_two(-40));
        for seed in 0..self.pieces.len() {
            if self.pieces[seed].is_held {
                continue;
            }
            let is_near = |&i: &usize| self.pieces[seed].is_within(reach, &self.pieces[i].middle);
            let centres: Vec<usize> = self.around(&self.pieces[seed].middle).filter(is_near).collect();
            let tried = TRIED.min(centres.len());
            // Compare by area, then by number, since areas may be zero, as for points.
            let (mut best, mut most) = (seed, (-1.0, 0));
            for k in 0..tried {
                let centre = centres[k * centres.len() / tried];
                let new = self.not_held(&self.pieces[centre].middle, reach);
                let gain = new.fold((0.0, 0), |(area, count), i| (area + self.pieces[i].area, count + 1));
                if gain > most {
                    (best, most) = (centre, gain);
                }
            }
            let centre = self.pieces[best].middle;
            let new: Vec<usize> = self.not_held(&centre, reach).collect();
            spheres.push(self.sphere(centre, &new));
            for i in new {
                self.pieces[i].is_held = true;
            }
        }
        spheres
    }

    /// The uncovered pieces within `reach` of a centre.
    fn not_held<'p>(&'p self, centre: &'p Point, reach: f64) -> impl Iterator<Item = usize> + 'p {
        let is_new = move |i: &usize| !self.pieces[*i].is_held && self.pieces[*i].is_within(reach, centre);
        self.around(centre).filter(is_new)
    }

    /// A sphere around pieces within reach of a centre: the smallest one, if no point of it is too far from the mesh;
    /// otherwise one around that centre.
    fn sphere(&self, centre: Point, held: &[usize]) -> Sphere {
        let local =
            |p: &Point| Sphere { centre: difference(p, &centre).map(|x| x / self.error), radius: 0.0 };
        let corners = || held.iter().flat_map(|&i| &self.pieces[i].corners);
        let points: Vec<Sphere> = corners().map(local).collect();
        let middle = smallest_enclosing(&points);
        let middle = [0, 1, 2].map(|i| centre[i] + middle[i] * self.error);
        let radius = |centre: &Point| {
            let reach = corners().map(|p| length(&difference(p, centre))).fold(0.0, f64::max);
            reach * (1.0 + power_of_two(-48)) + self.pad
        };
        let from_mesh = held
            .iter()
            .map(|&i| Foot::of(&middle, &self.pieces[i].corners).upper)
            .fold(f64::INFINITY, f64::min);
        let (small, own) = (radius(&middle), radius(&centre));
        if small < own && small + (from_mesh + self.pad) <= self.error {
            return Sphere { centre: middle, radius: small };
        }
        Sphere { centre, radius: own }
    }
}
