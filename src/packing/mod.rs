//! Sphere packings: fill a closed mesh with disjoint spheres, greedily, the largest that fits first.
//!
//! ```
//! use simdop::{construct::Mesh, packing::Packer};
//!
//! // A cube of edge 2: its largest sphere is the unit sphere, and fills pi / 6 of it.
//! let vertices: Vec<[f64; 3]> =
//!     (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| 2.0 * f64::from(x) - 1.0)).collect();
//! let triangles = [
//!     [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
//!     [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
//! ];
//! let packing = Packer::new().spheres(9).pack(&Mesh { vertices: &vertices, triangles: &triangles })?;
//! assert_eq!(packing.volume, 8.0);
//! assert!((packing.spheres[0].radius - 1.0).abs() < 1e-3);
//! let shares: Vec<f64> = packing.shares().collect();
//! assert!((shares[0] - core::f64::consts::FRAC_PI_6).abs() < 1e-2 && shares[8] > 0.6);
//! # Ok::<(), simdop::packing::PackError>(())
//! ```
//!
//! Packings represent volumes: the penetration volume of two bodies is the overlap of their spheres (Weller and
//! Zachmann, *Inner Sphere Trees for Proximity and Penetration Queries*, RSS 2009; Weller, Mainzer, Srinivas,
//! Teschner, Zachmann, *Massively Parallel Batch Neural Gas for Bounding Volume Hierarchy Construction*, VRIPHYS
//! 2014, section 3). [`text`] reads and writes them.
//!
//! # Guarantees
//!
//! * **Inside.** Each sphere lies inside the mesh: no point of a triangle is nearer to its centre than its radius,
//!   and a ray from its centre crosses the mesh an odd number of times. Both hold in exact arithmetic for the given
//!   coordinates, with those below [`MIN_COORDINATE`](crate::range::MIN_COORDINATE) set to 0.
//! * **Disjoint.** The distance between two centres is at least the sum of the radii, in exact arithmetic: spheres at
//!   most touch.
//! * **Determinism.** The same spheres on every machine and, with the feature `rayon`, for any number of threads in
//!   the current pool.
//!
//! The size of a sphere is approximate. Its centre is a local maximum of the clearance, to about 1/1000, and its
//! radius is at least two thirds of the largest that would have fit at that time. (Where proving that would take too
//! long, as in curved shells a thousand times as wide as they are thick, it is at least two thirds of the largest
//! that a few hundred trials found.)
//!
//! Radii are single-precision numbers, and so are centres where rounding costs less than 1/1000 of the radius, that
//! is, in all meshes but those far from their origin. Trees of such spheres are stored in single precision.

mod ascent;
mod closed;
mod cover;
mod cube;
mod error;
mod grid;
mod search;
mod surface;
pub mod text;

pub use error::PackError;

use crate::construct::Mesh;
use crate::frame::scale_to_one;
use crate::primitive::{Sphere, sphere};
use crate::range::{Point, flush};
use alloc::vec::Vec;
use core::ops::ControlFlow;
use surface::Surface;

/// Fills meshes with spheres.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Packer {
    spheres: usize,
}

/// Disjoint spheres inside a mesh.
#[derive(Clone, PartialEq, Debug)]
pub struct Packing {
    /// The spheres, in the mesh's unit, in the order of placement: roughly the largest first. None is more than about
    /// 1.5 times as large as one before it.
    pub spheres: Vec<Sphere>,
    /// The volume that the mesh encloses, in its unit cubed: the sum of signed tetrahedra, so that a region enclosed
    /// twice counts twice.
    pub volume: f64,
}

/// Progress of a packing.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Filling {
    /// Number of spheres placed.
    pub placed: usize,
    /// Number of spheres requested.
    pub asked: usize,
    /// The fraction of the volume that they cover.
    pub share: f64,
}

impl Default for Packer {
    fn default() -> Self {
        Self::new()
    }
}

impl Packer {
    /// Requests 1000 spheres.
    #[must_use]
    pub const fn new() -> Self {
        Self { spheres: 1000 }
    }

    /// Sets the number of spheres.
    #[must_use]
    pub const fn spheres(self, spheres: usize) -> Self {
        Self { spheres }
    }

    /// Fills a mesh. The result has fewer spheres than requested if no other sphere fits whose radius is above 2^-21
    /// of the mesh's width.
    ///
    /// The mesh must be closed, as [`Mesh::caps`] makes it: with vertices of equal coordinates merged, as many of its
    /// triangles run along each edge in one direction as in the other. Usually that is one in each direction; two in
    /// each, where parts touch along an edge, and degenerate triangles are accepted too. The mesh may have several
    /// parts and cavities, and either orientation. A point is inside if a ray from it crosses the mesh an odd number of
    /// times: the intersection of two overlapping parts is outside.
    ///
    /// # Errors
    /// [`PackError`].
    pub fn pack(&self, mesh: &Mesh<'_>) -> Result<Packing, PackError> {
        self.pack_with(mesh, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`Packer::pack`], reporting progress to `observer` at least every few hundred spheres. Stops if `observer`
    /// returns `Break`.
    ///
    /// # Errors
    /// [`PackError`] if the mesh is invalid, or [`PackError::Cancelled`] if `observer` returned `Break`.
    pub fn pack_with(
        &self,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Filling) -> ControlFlow<()>,
    ) -> Result<Packing, PackError> {
        closed::check(mesh)?;
        // Scale by a power of two: exact.
        let corners = mesh.triangles.iter().flatten().flat_map(|&v| mesh.vertices[v as usize]);
        let scale = scale_to_one(corners.fold(0.0, |greatest: f64, x| greatest.max(x.abs())));
        let vertices: Vec<Point> = mesh.vertices.iter().map(|p| p.map(|x| flush(x) * scale)).collect();
        let scaled = Mesh { vertices: &vertices, triangles: mesh.triangles };
        let surface = Surface::new(&scaled).map_err(PackError::Mesh)?;
        let volume = closed::volume(surface.triangles(), surface.middle()).ok_or(PackError::Flat)?;

        let (mut known, mut covered) = (0, 0.0);
        let mut observer = |balls: &[grid::Ball]| {
            covered += balls[known..].iter().map(|ball| sphere::volume(ball.radius)).sum::<f64>();
            known = balls.len();
            observer(Filling { placed: known, asked: self.spheres, share: covered / volume })
        };
        let balls = search::fill(&surface, self.spheres, &mut observer).ok_or(PackError::Cancelled)?;
        let unscale = 1.0 / scale;
        let sphere = |ball: &grid::Ball| Sphere {
            centre: (ball.centre * unscale).to_array(),
            radius: ball.radius * unscale,
        };
        let spheres = balls.iter().map(sphere).collect();
        Ok(Packing { spheres, volume: volume * (unscale * unscale * unscale) })
    }
}

impl Packing {
    /// The cumulative fraction of the mesh's volume that the spheres cover: the first, the first two, and so on.
    pub fn shares(&self) -> impl Iterator<Item = f64> {
        // Relative to the volume from the start: the cube of a radius may underflow.
        let unit = libm::cbrt(self.volume);
        self.spheres.iter().scan(0.0, move |covered, sphere| {
            *covered += sphere::volume(sphere.radius / unit);
            Some(*covered)
        })
    }
}
