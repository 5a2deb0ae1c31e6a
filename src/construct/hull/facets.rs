//! The triangles of the hull of points in space, one point at a time.
//!
//! A facet *sees* a point that is strictly on its outer side. The facets that see a new point form one region, whose
//! border is a simple cycle: if the point moves a little towards the inside, it is in no facet's plane and is seen by
//! the same facets. Triangles from the border to the point replace them. Facets whose plane contains the point stay,
//! and may get another triangle in their plane; so no triangle is degenerate.

use super::orientation::height;
use crate::range::Point;
use alloc::boxed::Box;
use alloc::vec::Vec;

const NONE: u32 = u32::MAX;

/// A triangle of the hull.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// Counterclockwise as seen from outside.
    pub(super) corners: [u32; 3],
    /// The facets beyond the edges from each corner to the next.
    pub(super) across: [u32; 3],
    /// The points not yet inserted that it sees, ascending: the first is inserted next.
    outside: Box<[u32]>,
    is_gathered: bool,
}

/// The hull of the points so far.
pub(super) struct Facets<'a> {
    points: &'a [Point],
    facets: Vec<Facet>,
    /// Unused places in `facets`.
    unused: Vec<u32>,
    /// For each point not yet inserted, a facet that sees it, or [`NONE`] if it is in the hull.
    seen_by: Vec<u32>,
    /// During an insertion: the facets that see the point, and the edges of their border, by facet and corner.
    region: Vec<u32>,
    border: Vec<(u32, usize)>,
    /// For each vertex on the border, the new facet at the edge that begins there.
    begins: Vec<u32>,
    found: Vec<u32>,
}

impl<'a> Facets<'a> {
    /// The hull of points, the first four of which are not in a plane.
    pub(super) fn around(points: &'a [Point]) -> Self {
        let mut hull = Self {
            points,
            facets: Vec::new(),
            unused: Vec::new(),
            seen_by: alloc::vec![NONE; points.len()],
            region: Vec::new(),
            border: Vec::new(),
            begins: alloc::vec![NONE; points.len()],
            found: Vec::new(),
        };
        hull.begin();
        for point in 4..points.len() as u32 {
            if hull.seen_by[point as usize] != NONE {
                hull.insert(point);
            }
        }
        for &place in &hull.unused {
            hull.facets[place as usize].corners = [NONE; 3];
        }
        hull
    }

    /// All facets. Those not in use are [unused](is_unused).
    pub(super) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Makes the tetrahedron of the first four points.
    fn begin(&mut self) {
        let is_outside = self.height([0, 1, 2], 3) > 0.0;
        let [a, b] = if is_outside { [1, 0] } else { [0, 1] };
        let corners = [[a, b, 2], [b, a, 3], [2, b, 3], [a, 2, 3]];
        let across = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
        for (corners, across) in corners.into_iter().zip(across) {
            let outside = (4..self.points.len() as u32).filter(|&point| self.height(corners, point) > 0.0);
            let outside: Box<[u32]> = outside.collect();
            for &point in &outside {
                self.seen_by[point as usize] = self.facets.len() as u32;
            }
            self.facets.push(Facet { corners, across, outside, is_gathered: false });
        }
    }

    fn height(&self, corners: [u32; 3], point: u32) -> f64 {
        let [a, b, c] = corners.map(|v| &self.points[v as usize]);
        height([a, b, c], &self.points[point as usize])
    }

    /// Whether a facet sees the next point.
    fn sees(&self, facet: u32, point: u32) -> bool {
        self.facets[facet as usize].outside.first() == Some(&point)
    }

    /// Inserts the next point, which is outside.
    fn insert(&mut self, point: u32) {
        self.gather(point);
        for &facet in &self.region {
            for &other in &self.facets[facet as usize].outside {
                self.seen_by[other as usize] = NONE;
            }
        }
        for i in 0..self.border.len() {
            self.add(self.border[i], point);
        }
        self.join();
        for &facet in &self.region {
            self.facets[facet as usize].outside = Box::default();
        }
        self.unused.append(&mut self.region);
    }

    /// Finds the facets that see a point, and their border.
    fn gather(&mut self, point: u32) {
        self.border.clear();
        self.region.clear();
        self.reach(self.seen_by[point as usize]);
        let mut next = 0;
        while let Some(&facet) = self.region.get(next) {
            next += 1;
            let across = self.facets[facet as usize].across;
            for (edge, beyond) in across.into_iter().enumerate() {
                if self.sees(beyond, point) {
                    self.reach(beyond);
                } else {
                    self.border.push((facet, edge));
                }
            }
        }
    }

    fn reach(&mut self, facet: u32) {
        if !core::mem::replace(&mut self.facets[facet as usize].is_gathered, true) {
            self.region.push(facet);
        }
    }

    /// Adds the facet from an edge of the border to the point, and joins it with the facet beyond the edge.
    fn add(&mut self, (facet, edge): (u32, usize), point: u32) {
        let Facet { corners, across, .. } = self.facets[facet as usize];
        let (from, to, beyond) = (corners[edge], corners[(edge + 1) % 3], across[edge]);
        let new = self.unused.last().copied().unwrap_or(self.facets.len() as u32);
        let corners = [from, to, point];
        self.find(corners, [facet, beyond], new);
        let outside = self.found.as_slice().into();
        let made = Facet { corners, across: [beyond, NONE, NONE], outside, is_gathered: false };
        if self.unused.pop().is_some() {
            self.facets[new as usize] = made;
        } else {
            self.facets.push(made);
        }
        let back = &mut self.facets[beyond as usize];
        for (corner, across) in back.corners.iter().zip(&mut back.across) {
            if *corner == to {
                *across = new;
            }
        }
        self.begins[from as usize] = new;
    }

    /// Finds the points that a new facet sees. It lies between two facets at one of its edges: at least one of the two
    /// sees each point that it sees, and it sees each point that both see.
    ///
    /// So each point outside the new hull is seen by the facet in `seen_by`. The facets that saw it were connected: if
    /// all were in the region, a new facet sees it; otherwise two facets at an edge of the border saw it, and the new
    /// one between them does.
    fn find(&mut self, corners: [u32; 3], [inside, beyond]: [u32; 2], new: u32) {
        self.found.clear();
        let mut inside = &*self.facets[inside as usize].outside;
        let mut stays = &*self.facets[beyond as usize].outside;
        loop {
            let other = match (inside, stays) {
                ([p, ..], [q, ..]) => *p.min(q),
                ([p, ..], []) | ([], [p, ..]) => *p,
                ([], []) => break,
            };
            let is_seen_by_both = inside.first() == stays.first();
            if let Some(rest) = inside.strip_prefix(&[other]) {
                inside = rest;
            }
            if let Some(rest) = stays.strip_prefix(&[other]) {
                stays = rest;
            }
            // The inserted point is a corner, which no facet beyond the border sees.
            if is_seen_by_both || self.height(corners, other) > 0.0 {
                self.found.push(other);
                self.seen_by[other as usize] = new;
            }
        }
    }

    /// Joins the new facets with each other: the edge of one ends where that of the next begins.
    fn join(&mut self) {
        for i in 0..self.border.len() {
            let (facet, edge) = self.border[i];
            let corners = self.facets[facet as usize].corners;
            let new = self.begins[corners[edge] as usize];
            let next = self.begins[corners[(edge + 1) % 3] as usize];
            self.facets[new as usize].across[1] = next;
            self.facets[next as usize].across[2] = new;
        }
    }
}

/// Whether a facet is unused.
pub(super) fn is_unused(facet: &Facet) -> bool {
    facet.corners[0] == NONE
}
