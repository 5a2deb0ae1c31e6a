//! Spheres around a mesh: a smaller body, when a robot need not know its surroundings to the last digit.
//!
//! Triangles are halved along their longest edges into *pieces*, a fraction of the error wide. The first piece that no sphere holds yet
//! is the seed of another one: of some centres near it, on the mesh, the one is taken from which most pieces that are not held are within
//! reach. So spheres grow away from what is held already, and overlap little.
//!
//! A sphere of radius r whose centre is at most d from the mesh has no point farther than `r + d` from it. What rounding does to the
//! corners of pieces, halved at most 200 times, is less than 2^-44 of the largest coordinate; each radius is greater by that.

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

/// Of the largest coordinate, for the roundings of corners.
pub(crate) const ROUNDING: f64 = power_of_two(-44);
/// No smaller error, of the largest coordinate, so that roundings are little of it.
const LEAST_ERROR: f64 = power_of_two(-36);

/// Why a mesh cannot be covered.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum CoverError {
    /// The error is not above 2^-36 of the largest coordinate, or not finite.
    Error {
        /// The error asked for.
        given: f64,
        /// None smaller is possible.
        least: f64,
    },
    /// The error is so small that the mesh would be cut into more than 2^24 pieces, some fifty for each sphere.
    TooMany,
    /// There is something wrong with the mesh.
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
    /// Spheres that hold every point of the mesh, and no point that is farther than `error` from it, in its unit. So a body of
    /// these spheres that is free of others says for certain that the mesh is; a hit means that the others come within `error` of
    /// the mesh. Of the surface: what is wholly inside of a closed mesh may be free of the spheres;
    /// [`Mesh::cover_solid`] holds the inside, too. Points are covered as triangles whose three corners are one.
    ///
    /// The same spheres on every machine. An empty mesh has none.
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

/// Whether roundings are little of an error, where no coordinate is larger.
pub(crate) fn check_error(given: f64, largest: f64) -> Result<(), CoverError> {
    let least = LEAST_ERROR * largest;
    if given > least && given.is_finite() { Ok(()) } else { Err(CoverError::Error { given, least }) }
}

/// No edge of a piece is longer, of the error.
const LONGEST: f64 = 0.25;
/// More pieces would take gigabytes.
const MOST_PIECES: usize = 1 << 24;
/// Centres that are tried for a sphere.
const TRIED: usize = 24;

/// A part of a triangle.
struct Piece {
    corners: Triangle,
    middle: Point,
    /// Twice, in squares of the error.
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

/// Halves triangles along their longest edges until none is longer than that.
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

/// Where a point is among cubes as wide as the error.
type CoverCell = [i64; 3];

struct Cover {
    error: f64,
    pad: f64,
    /// In the order of their cubes.
    pieces: Vec<Piece>,
    /// Of each cube that has pieces, in ascending order, the first.
    cubes: Vec<(CoverCell, usize)>,
}

impl Cover {
    fn new(triangles: &[Triangle], error: f64, pad: f64) -> Result<Self, CoverError> {
        let placed = |t: Triangle| {
            let piece = Piece::new(t, error);
            (piece.middle.map(|x| libm::floor(x / error) as i64), piece)
        };
        let mut pieces: Vec<(CoverCell, Piece)> =
            cut(triangles, LONGEST * error)?.into_iter().map(placed).collect();
        pieces.sort_by_key(|(cube, _)| *cube);
        let mut cubes: Vec<(CoverCell, usize)> = Vec::new();
        for (i, (cube, _)) in pieces.iter().enumerate() {
            if cubes.last().is_none_or(|(last, _)| last != cube) {
                cubes.push((*cube, i));
            }
        }
        Ok(Self { error, pad, pieces: pieces.into_iter().map(|(_, piece)| piece).collect(), cubes })
    }

    /// Pieces whose middles are in the cubes around that of a point, among them all within the error of it.
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
        // What is at most this far from a point of the mesh, with pads for it and for where that point is.
        let reach = (self.error - 4.0 * self.pad) * (1.0 - power_of_two(-40));
        for seed in 0..self.pieces.len() {
            if self.pieces[seed].is_held {
                continue;
            }
            let is_near = |&i: &usize| self.pieces[seed].is_within(reach, &self.pieces[i].middle);
            let centres: Vec<usize> = self.around(&self.pieces[seed].middle).filter(is_near).collect();
            let tried = TRIED.min(centres.len());
            // By area, and by number where there is none: points have no area.
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

    /// The pieces that a sphere would hold and none does yet.
    fn not_held<'p>(&'p self, centre: &'p Point, reach: f64) -> impl Iterator<Item = usize> + 'p {
        let is_new = move |i: &usize| !self.pieces[*i].is_held && self.pieces[*i].is_within(reach, centre);
        self.around(centre).filter(is_new)
    }

    /// Around some pieces that are within reach of a centre: the smallest, if no point of it is too far from the mesh, or one about
    /// that centre.
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
