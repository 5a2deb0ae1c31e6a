//! Merges triangles in one plane into one polygon, whose corners are those of the hull.

use super::facets::{Facet, is_unused};
use super::fan::add_fan;
use super::orientation::{compare, height};
use crate::construct::input::OwnedMesh;
use crate::range::Point;
use alloc::vec::Vec;

const NONE: u32 = u32::MAX;

/// The mesh of closed facets, whose corners are indices of points.
pub(super) fn mesh(points: &[Point], facets: &[Facet]) -> OwnedMesh {
    let planes = FacetPlanes::of(points, facets);
    let is_corner = planes.corners(points.len());
    let mut order: Vec<u32> = (0..points.len() as u32).filter(|&p| is_corner[p as usize]).collect();
    order.sort_unstable_by(|&p, &q| compare(&points[p as usize], &points[q as usize]));
    let mut index = alloc::vec![NONE; points.len()];
    for (i, &point) in order.iter().enumerate() {
        index[point as usize] = i as u32;
    }
    let mut triangles = Vec::with_capacity(2 * order.len());
    let (mut next, mut polygon) = (alloc::vec![NONE; points.len()], Vec::new());
    for plane in 0..planes.ends.len() {
        let Some(start) = planes.link_border(plane, &mut next) else { continue };
        polygon.clear();
        let mut at = start;
        loop {
            if index[at as usize] != NONE {
                polygon.push(index[at as usize]);
            }
            at = next[at as usize];
            if at == start {
                break;
            }
        }
        add_fan(&polygon, &mut triangles);
    }
    triangles.sort_unstable();
    OwnedMesh { vertices: order.iter().map(|&point| points[point as usize]).collect(), triangles }
}

/// The facets by planes.
struct FacetPlanes<'a> {
    facets: &'a [Facet],
    /// For each facet, the index of its plane.
    of_facet: Vec<u32>,
    /// The facets, grouped by plane, and the end of each plane's group.
    members: Vec<u32>,
    ends: Vec<usize>,
}

impl<'a> FacetPlanes<'a> {
    fn of(points: &[Point], facets: &'a [Facet]) -> Self {
        let mut planes = Self {
            facets,
            of_facet: alloc::vec![NONE; facets.len()],
            members: Vec::with_capacity(facets.len()),
            ends: Vec::new(),
        };
        for first in 0..facets.len() {
            if is_unused(&facets[first]) || planes.of_facet[first] != NONE {
                continue;
            }
            let plane = planes.ends.len() as u32;
            let mut next = planes.members.len();
            planes.of_facet[first] = plane;
            planes.members.push(first as u32);
            // The surface is convex: facets in one plane are connected across edges.
            while let Some(&member) = planes.members.get(next) {
                next += 1;
                let facet = &facets[member as usize];
                for beyond in facet.across {
                    if planes.of_facet[beyond as usize] == NONE
                        && are_coplanar(points, facet, &facets[beyond as usize])
                    {
                        planes.of_facet[beyond as usize] = plane;
                        planes.members.push(beyond);
                    }
                }
            }
            planes.ends.push(planes.members.len());
        }
        planes
    }

    fn facets(&self, plane: usize) -> impl Iterator<Item = &'a Facet> {
        let start = if plane == 0 { 0 } else { self.ends[plane - 1] };
        self.members[start..self.ends[plane]].iter().map(|&facet| &self.facets[facet as usize])
    }

    /// For each point whether it is a corner of the hull, where at least three planes meet. At any other point of an
    /// edge, two meet.
    fn corners(&self, points: usize) -> Vec<bool> {
        let mut first_two = alloc::vec![[NONE; 2]; points];
        let mut is_corner = alloc::vec![false; points];
        for plane in 0..self.ends.len() {
            for corner in self.facets(plane).flat_map(|facet| facet.corners) {
                let known = &mut first_two[corner as usize];
                let plane = plane as u32;
                match known.iter().position(|known| *known == plane || *known == NONE) {
                    Some(place) => known[place] = plane,
                    None => is_corner[corner as usize] = true,
                }
            }
        }
        is_corner
    }

    /// For each point on the border of a plane's facets, writes the next one. Returns one of them.
    fn link_border(&self, plane: usize, next: &mut [u32]) -> Option<u32> {
        let mut start = None;
        for facet in self.facets(plane) {
            for (i, beyond) in facet.across.into_iter().enumerate() {
                if self.of_facet[beyond as usize] != plane as u32 {
                    let from = facet.corners[i];
                    next[from as usize] = facet.corners[(i + 1) % 3];
                    start = Some(from);
                }
            }
        }
        start
    }
}

/// Whether two facets with a common edge are in one plane.
fn are_coplanar(points: &[Point], facet: &Facet, beyond: &Facet) -> bool {
    let [a, b, c] = facet.corners.map(|v| &points[v as usize]);
    let apex = beyond.corners.into_iter().find(|v| !facet.corners.contains(v));
    apex.is_some_and(|apex| height([a, b, c], &points[apex as usize]) == 0.0)
}
