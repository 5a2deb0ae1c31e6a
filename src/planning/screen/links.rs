//! Bodies of a robot as spheres: each body lies in the union of the outer spheres, and contains the inner ones.
//!
//! The covers are those of [`Mesh::cover_solid`], or of [`Mesh::cover`] for a surface, with the smallest error that
//! needs few enough spheres. An inner sphere shares its centre with an outer one, so that one look-up serves both: its
//! radius is the depth of the centre in the solid. A solid with capped holes has no inner spheres, since a body may be
//! inside and meet nothing.

use crate::construct::Mesh;
use crate::hierarchy::BvhRef;
use crate::packing::Packer;
use crate::planning::{LinkGeometry, PlanningNode};
use crate::primitive::shape::hull_of;
use crate::primitive::{Shape, Sphere};
use crate::range::Point;
use crate::scene::{BodyTree, SharedTree};
use crate::vector::{difference, length};
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

/// Maximum number of spheres of a fine cover, each with one of 64 bits, and of a coarse cover: whole blocks of sixteen.
const MOST_FINE: usize = 64;
const MOST_COARSE: usize = 16;
/// Number of spheres of a packing.
const MOST_INSIDE: usize = 64;
/// The first error, relative to the diagonal, and the ratio of each error to the one before.
const FIRST: f64 = 0.3;
const STEP: f64 = 0.8;
const STEPS: usize = 20;
/// Allowance for the rounding of a radius.
const ABOVE: f64 = 1.0 + 1e-12;

/// Spheres about one centre, in the frame of a body.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct Concentric {
    pub(super) centre: Point,
    /// Radius of the cover's sphere.
    pub(super) outer: f64,
    /// Radius of a sphere that is certainly inside the body; 0 if there is none.
    pub(super) inner: f64,
}

/// A body of a robot as spheres.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct LinkSpheres {
    /// A sphere around the body.
    pub(super) whole: Concentric,
    /// Covers of the body.
    pub(super) coarse: Vec<Concentric>,
    pub(super) fine: Vec<Concentric>,
    /// Spheres inside the body.
    pub(super) inside: Vec<Sphere>,
}

impl LinkSpheres {
    /// `None` for a half-space, and for a mesh that cannot be covered.
    pub(super) fn of(geometry: &LinkGeometry) -> Option<Self> {
        match geometry {
            LinkGeometry::Shape(shape) => Self::of_shape(shape),
            LinkGeometry::Mesh { tree, .. } => Self::of_mesh(&tree.view()),
        }
    }

    /// The spheres of a body in a scene. `None` also for bodies of other kinds.
    pub(super) fn of_body(tree: &BodyTree<'_, PlanningNode>, radius: f64) -> Option<Self> {
        let mut spheres = match tree {
            BodyTree::Shape(shape) => Self::of_shape(shape),
            BodyTree::Mesh(tree) => Self::of_mesh(tree),
            BodyTree::Shared(SharedTree::Mesh(tree)) => Self::of_mesh(&tree.view()),
            _ => None,
        }?;
        let covers = spheres.coarse.iter_mut().chain(&mut spheres.fine);
        for sphere in covers.chain([&mut spheres.whole]) {
            sphere.outer = (sphere.outer + radius) * ABOVE;
        }
        Some(spheres)
    }

    fn of_shape(shape: &Shape) -> Option<Self> {
        if shape.is_half_space() {
            return None;
        }
        let (corners, radius) = hull_of(shape);
        let corners: Vec<Point> = corners.collect();
        let whole = around(&corners, radius)?;
        Some(Self { whole, coarse: vec![whole], fine: vec![whole], inside: Vec::new() })
    }

    fn of_mesh(tree: &BvhRef<'_, PlanningNode>) -> Option<Self> {
        let of = |tree: &BvhRef<'_, PlanningNode>| -> Vec<[Point; 3]> {
            (0..tree.len() as u32).map(|i| tree.primitive(i)).collect()
        };
        let mut triangles = of(tree);
        let caps = tree.caps();
        triangles.extend(caps.iter().flat_map(of));
        // Equal corners become one vertex.
        let (mut places, mut vertices) = (BTreeMap::new(), Vec::new());
        let mut vertex = |p: &Point| {
            *places.entry(p.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                vertices.push(*p);
                vertices.len() as u32 - 1
            })
        };
        let records: Vec<[u32; 3]> = triangles.iter().map(|t| [0, 1, 2].map(|i| vertex(&t[i]))).collect();
        let mesh = Mesh { vertices: &vertices, triangles: &records };
        let whole = around(&vertices, 0.0)?;
        let is_solid = tree.is_solid();
        let has_inside = is_solid && caps.is_none();
        let packed = if has_inside { Packer::new().spheres(MOST_INSIDE).pack(&mesh).ok() } else { None };
        let inside = packed.map_or_else(Vec::new, |packing| packing.spheres);
        let [coarse, fine] = covers(&mesh, &whole, is_solid, has_inside)?;
        Some(Self { whole, coarse, fine, inside })
    }
}

/// A sphere around balls of one radius about some points, centred on the points' bounding box.
fn around(points: &[Point], radius: f64) -> Option<Concentric> {
    let (mut low, mut high) = (*points.first()?, *points.first()?);
    for p in points {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    let centre = [0, 1, 2].map(|i| 0.5 * low[i] + 0.5 * high[i]);
    let farthest = points.iter().map(|p| length(&difference(p, &centre))).fold(0.0, f64::max);
    Some(Concentric { centre, outer: (farthest + radius) * ABOVE, inner: 0.0 })
}

/// Two covers, of at most [`MOST_COARSE`] and [`MOST_FINE`] spheres.
fn covers(
    mesh: &Mesh<'_>,
    whole: &Concentric,
    is_solid: bool,
    has_inside: bool,
) -> Option<[Vec<Concentric>; 2]> {
    let mut error = FIRST * 2.0 * whole.outer;
    let mut fine = vec![Sphere { centre: whole.centre, radius: whole.outer }];
    let mut coarse = None;
    for _ in 0..STEPS {
        let spheres = if is_solid { mesh.cover_solid(error) } else { mesh.cover(error) }.ok()?;
        if spheres.len() > MOST_COARSE && coarse.is_none() {
            coarse = Some(fine.clone());
        }
        if spheres.len() > MOST_FINE {
            break;
        }
        (fine, error) = (spheres, error * STEP);
    }
    let coarse = coarse.unwrap_or_else(|| fine.clone());
    Some([with_depths(mesh, coarse, has_inside)?, with_depths(mesh, fine, has_inside)?])
}

/// The spheres, sorted, with the depths of their centres.
fn with_depths(mesh: &Mesh<'_>, mut spheres: Vec<Sphere>, has_inside: bool) -> Option<Vec<Concentric>> {
    // Sorted along the longest side, so that the spheres of a block are near each other.
    let sides = [0, 1, 2].map(|i| {
        let along = || spheres.iter().map(|sphere| sphere.centre[i]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    });
    let longest = (1..3).fold(0, |most, i| if sides[i] > sides[most] { i } else { most });
    spheres.sort_by(|a, b| a.centre[longest].total_cmp(&b.centre[longest]));
    let centres: Vec<Point> = spheres.iter().map(|sphere| sphere.centre).collect();
    let inner = if has_inside { mesh.depths_inside(&centres)? } else { vec![0.0; centres.len()] };
    let both = spheres.iter().zip(inner);
    Some(both.map(|(s, inner)| Concentric { centre: s.centre, outer: s.radius, inner }).collect())
}
