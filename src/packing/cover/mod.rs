//! Covering a solid with spheres: its surface and its interior.
//!
//! A sphere whose centre is at depth `d` inside may have the radius `d + error`: none of its points is farther than
//! the error from the solid. It covers far more of the surface than a sphere centred on the surface, so few spheres
//! are enough.
//!
//! The surface is covered first. It is cut into patches, and a sphere must cover each patch with everything within a
//! *margin* of it. For the first uncovered patch, candidates are spheres that cover it, centred below nearby points
//! of the surface. The candidate that covers most of the uncovered area is added.
//!
//! The rest of the interior is covered by an octree of cubes. A cube that meets the surface and is no wider than the
//! margin is covered by the sphere of a patch that it meets. A cube that does not meet the surface is entirely
//! outside or inside. In the latter case an existing sphere covers it, or one about its centre is added, or it is
//! subdivided.

mod patches;

use super::surface::Surface;
use crate::construct::{
    BuildError, COVER_ROUNDING, CoverError, Mesh, OpenEdge, Unclosed, check_closed, check_cover_error, cut,
};
use crate::exact::power_of_two;
use crate::frame::scale_to_one;
use crate::primitive::Sphere;
use crate::primitive::triangle::Triangle;
use crate::range::{Point, flush};
use alloc::vec::Vec;
use glam::DVec3;
use patches::{Patch, Patches};

impl Mesh<'_> {
    /// Spheres that cover every point of the solid bounded by the mesh, and no point farther than `error` from it, in
    /// the mesh's unit. So if a body of these spheres is free, the solid is certainly free; a hit means that the
    /// other body comes within `error` of the solid. The interior is defined as in
    /// [`Builder::solid`](crate::construct::Builder::solid).
    ///
    /// There are far fewer spheres than from [`Mesh::cover`] if the solid is thick, since most of each sphere is
    /// inside. Every machine computes the same spheres. An empty mesh gives none.
    ///
    /// ```
    /// use simdop::construct::OwnedMesh;
    /// let cube = OwnedMesh::cuboid([1.0; 3])?;
    /// let (solid, surface) = (cube.as_mesh().cover_solid(0.1)?, cube.as_mesh().cover(0.1)?);
    /// let is_held = |spheres: &[simdop::primitive::Sphere]| {
    ///     spheres
    ///         .iter()
    ///         .any(|sphere| sphere.centre.iter().map(|x| x * x).sum::<f64>() <= sphere.radius * sphere.radius)
    /// };
    /// assert!(is_held(&solid) && !is_held(&surface)); // the middle of the cube
    /// assert!(solid.len() < surface.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CoverError`], which contains [`BuildError::Open`] if the mesh is not closed ([`Mesh::caps`] closes holes).
    pub fn cover_solid(&self, error: f64) -> Result<Vec<Sphere>, CoverError> {
        check_closed(self).map_err(|unclosed| {
            CoverError::Mesh(match unclosed {
                Unclosed::Mesh(error) => error,
                Unclosed::Open(OpenEdge { edge, corners, forward, backward }) => {
                    BuildError::Open { edge, corners, forward, backward }
                }
            })
        })?;
        let corners = || self.triangles.iter().flatten().map(|&vertex| self.vertices[vertex as usize]);
        let largest = corners().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        check_cover_error(error, largest)?;
        if self.triangles.is_empty() {
            return Ok(Vec::new());
        }
        // Scale by a power of two: exact.
        let scale = scale_to_one(largest);
        let vertices: Vec<Point> = self.vertices.iter().map(|p| p.map(|x| flush(x) * scale)).collect();
        let scaled = Mesh { vertices: &vertices, triangles: self.triangles };
        let surface = Surface::new(&scaled).map_err(CoverError::Mesh)?;
        let mut cover = SolidCover::new(&surface, error * scale, COVER_ROUNDING * (largest * scale));
        cover.hold_surface(&scaled)?;
        cover.hold_inside(&scaled);
        let unscale = 1.0 / scale;
        let sphere = |sphere: &Sphere| Sphere {
            centre: sphere.centre.map(|x| x * unscale),
            radius: sphere.radius * unscale,
        };
        Ok(cover.spheres.iter().map(sphere).collect())
    }

    /// For each point, a radius within which every point is certainly inside the solid; 0 for a point outside. `None`
    /// if the mesh is invalid or not closed.
    #[cfg(feature = "planning")]
    pub(crate) fn depths_inside(&self, points: &[Point]) -> Option<Vec<f64>> {
        check_closed(self).ok()?;
        let corners = || self.triangles.iter().flatten().map(|&vertex| self.vertices[vertex as usize]);
        let scale = scale_to_one(corners().flatten().fold(0.0, |most: f64, x| most.max(x.abs())));
        let vertices: Vec<Point> = self.vertices.iter().map(|p| p.map(|x| flush(x) * scale)).collect();
        let surface = Surface::new(&Mesh { vertices: &vertices, triangles: self.triangles }).ok()?;
        let depth = |p: &Point| {
            let p = p.map(|x| x * scale);
            let is_inside = surface.winds_around(DVec3::from_array(p));
            if is_inside { surface.certain_clearance(p, WIDEST) * (NARROW / scale) } else { 0.0 }
        };
        Some(points.iter().map(depth).collect())
    }
}

/// Maximum edge length of a patch, relative to the error.
const LONGEST: f64 = 0.25;
/// Margin around a patch, relative to the error. A smaller one takes more cubes, a larger one more spheres.
const MARGIN: f64 = 0.125;
/// Maximum number of patches, per sphere, under which candidate centres are tried.
const TRIED: usize = 24;
/// Bisection steps between the deepest valid centre and an invalid one.
const HALVINGS: usize = 3;
/// Larger than any distance between coordinates of at most 2.
const WIDEST: f64 = 8.0;
/// Bounds the relative rounding error of distances and sums in this module.
const NARROW: f64 = 1.0 - power_of_two(-40);

struct SolidCover<'s> {
    surface: &'s Surface,
    error: f64,
    /// Bounds the rounding errors of patches and cubes.
    pad: f64,
    spheres: Vec<Sphere>,
}

/// A cube that may contain uncovered points.
#[derive(Copy, Clone)]
struct Cell {
    centre: DVec3,
    half: f64,
    /// Known to lie entirely inside the solid.
    is_inside: bool,
}

impl Cell {
    /// Radius of a ball around it, for any rounding of its centre.
    fn reach(&self, pad: f64) -> f64 {
        // Above the square root of 3.
        1.7321 * self.half + pad
    }

    fn eighth(&self, number: usize) -> Self {
        let half = 0.5 * self.half;
        let side = |axis: usize| if number >> axis & 1 == 1 { half } else { -half };
        Self { centre: self.centre + DVec3::new(side(0), side(1), side(2)), half, ..*self }
    }
}

impl<'s> SolidCover<'s> {
    const fn new(surface: &'s Surface, error: f64, pad: f64) -> Self {
        Self { surface, error, pad, spheres: Vec::new() }
    }

    /// The radius of a sphere about a point inside, whose depth is taken to be at most `limit`.
    fn radius_inside(&self, centre: DVec3, limit: f64) -> f64 {
        let depth = self.surface.certain_clearance(centre.to_array(), limit);
        (depth + self.error - 4.0 * self.pad) * NARROW
    }

    /// The distance from the centre within which a sphere covers patches with their margins.
    fn reach(&self, radius: f64) -> f64 {
        radius * NARROW - MARGIN * self.error - 2.0 * self.pad
    }

    fn hold_surface(&mut self, mesh: &Mesh<'_>) -> Result<(), CoverError> {
        let corner = |vertex: u32| mesh.vertices[vertex as usize];
        let triangles: Vec<Triangle> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        let mut patches = Patches::new(&cut(&triangles, LONGEST * self.error)?);
        let mut from = 0;
        while let Some(seed) = patches.next(from) {
            from = seed;
            let sphere = self.best_sphere(&patches, patches.get(seed));
            patches.hold(self.reach(sphere.radius), DVec3::from_array(sphere.centre));
            self.spheres.push(sphere);
        }
        Ok(())
    }

    /// Among candidate spheres that cover a patch, the one that covers most of the uncovered area.
    fn best_sphere(&self, patches: &Patches, seed: &Patch) -> Sphere {
        // The centre is on the surface, up to roundings of the patch.
        let radius = (self.error - 4.0 * self.pad) * NARROW;
        let mut best = Sphere { centre: seed.middle.to_array(), radius };
        let mut most = patches.gain(self.reach(radius), seed.middle);
        let near = patches.near(self.reach(radius), seed.middle);
        let tried = TRIED.min(near.len());
        for k in 0..tried {
            let base = patches.get(near[k * near.len() / tried]);
            for normal in [base.area, -base.area] {
                let Some(normal) = normal.try_normalize() else { continue };
                self.below(base.middle, normal, seed, &mut |sphere| {
                    let gain = patches.gain(self.reach(sphere.radius), DVec3::from_array(sphere.centre));
                    if gain > most {
                        (best, most) = (sphere, gain);
                    }
                });
            }
        }
        best
    }

    /// Calls `show` with spheres that cover a patch, centred inside on a line from the surface. Depths are doubled
    /// until a sphere fails, then bisected.
    fn below(&self, from: DVec3, normal: DVec3, seed: &Patch, show: &mut dyn FnMut(Sphere)) {
        let mut at = |depth: f64| {
            let centre = from + depth * normal;
            if !self.surface.winds_around(centre) {
                return false;
            }
            let radius = self.radius_inside(centre, depth);
            let does_hold = seed.is_within(self.reach(radius), centre);
            if does_hold {
                show(Sphere { centre: centre.to_array(), radius });
            }
            does_hold
        };
        let mut depth = 0.5 * self.error;
        while at(depth) {
            depth *= 2.0;
        }
        let (mut shallow, mut deep) = (0.5 * depth, depth);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (shallow + deep);
            *(if at(middle) { &mut shallow } else { &mut deep }) = middle;
        }
    }

    fn hold_inside(&mut self, mesh: &Mesh<'_>) {
        let corners =
            || mesh.triangles.iter().flatten().map(|&v| DVec3::from_array(mesh.vertices[v as usize]));
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let half = 0.5 * (high - low).max_element() + self.pad;
        let cube = Cell { centre: 0.5 * low + 0.5 * high, half, is_inside: false };
        self.hold_cube(cube, &[], 0);
    }

    /// Covers the part of a cube that is inside the solid. `around` are the spheres among the first `known` that
    /// reach into the cube.
    fn hold_cube(&mut self, mut cube: Cell, around: &[usize], known: usize) {
        let reach = cube.reach(self.pad);
        let away = |sphere: &Sphere| DVec3::from_array(sphere.centre).distance(cube.centre);
        let mut near = Vec::new();
        for i in around.iter().copied().chain(known..self.spheres.len()) {
            let (away, radius) = (away(&self.spheres[i]), self.spheres[i].radius);
            if away + reach <= radius * NARROW {
                return;
            }
            if away <= radius + reach {
                near.push(i);
            }
        }
        if !cube.is_inside {
            let is_at_surface = self.surface.certain_clearance(cube.centre.to_array(), reach) < reach;
            if is_at_surface && 2.01 * reach <= MARGIN * self.error
                || !is_at_surface && !self.surface.winds_around(cube.centre)
            {
                return;
            }
            cube.is_inside = !is_at_surface;
        }
        if cube.is_inside {
            let radius = self.radius_inside(cube.centre, WIDEST);
            // A larger radius than needed, so that the sphere covers neighbouring cubes too.
            if 2.0 * reach <= radius {
                self.spheres.push(Sphere { centre: cube.centre.to_array(), radius });
                return;
            }
        }
        let known = self.spheres.len();
        for number in 0..8 {
            self.hold_cube(cube.eighth(number), &near, known);
        }
    }
}
