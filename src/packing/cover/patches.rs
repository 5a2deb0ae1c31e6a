//! Patches of a surface, and which of them are covered by spheres.
//!
//! A binary tree of boxes sums the area that a large sphere would cover from few entries.

use crate::primitive::triangle::Triangle;
use alloc::vec::Vec;
use glam::DVec3;

/// A piece of a triangle.
pub(super) struct Patch {
    pub(super) corners: [DVec3; 3],
    pub(super) middle: DVec3,
    /// Twice the area, along the normal.
    pub(super) area: DVec3,
    is_held: bool,
}

/// What is uncovered: its area, and its number of patches for comparing zero areas.
#[derive(Copy, Clone, PartialEq, PartialOrd, Default)]
pub(super) struct Unheld {
    area: f64,
    count: usize,
}

/// A node of the tree: a range of the patches.
struct PatchBox {
    low: DVec3,
    high: DVec3,
    rest: Unheld,
    start: usize,
    end: usize,
    /// The second child, stored after all of the first; `None` for a leaf. The first child is stored next.
    second: Option<usize>,
}

pub(super) struct Patches {
    all: Vec<Patch>,
    boxes: Vec<PatchBox>,
}

/// Maximum number of patches in a leaf.
const LEAF: usize = 8;

impl Unheld {
    fn and(self, other: Self) -> Self {
        Self { area: self.area + other.area, count: self.count + other.count }
    }
}

impl Patch {
    fn new(corners: &Triangle) -> Self {
        let corners = corners.map(DVec3::from_array);
        let [p, q, r] = corners;
        Self { corners, middle: (p + q + r) / 3.0, area: (q - p).cross(r - p), is_held: false }
    }

    /// Whether all of it is within reach of a point.
    pub(super) fn is_within(&self, reach: f64, centre: DVec3) -> bool {
        self.corners.iter().all(|p| p.distance(centre) <= reach)
    }

    fn rest(&self) -> Unheld {
        if self.is_held { Unheld::default() } else { Unheld { area: self.area.length(), count: 1 } }
    }
}

impl PatchBox {
    /// Whether all (`Some(true)`) or nothing (`Some(false)`) of it is within reach of a point; `None` if undecided.
    fn is_within(&self, reach: f64, centre: DVec3) -> Option<bool> {
        let farthest = (centre - self.low).abs().max((centre - self.high).abs());
        if farthest.length() <= reach {
            return Some(true);
        }
        let nearest = centre.clamp(self.low, self.high);
        (nearest.distance(centre) > reach).then_some(false)
    }
}

impl Patches {
    pub(super) fn new(pieces: &[Triangle]) -> Self {
        let all = pieces.iter().map(Patch::new).collect();
        let mut patches = Self { all, boxes: Vec::new() };
        let mut order: Vec<usize> = (0..patches.all.len()).collect();
        if !order.is_empty() {
            patches.add(&mut order, 0);
        }
        // Reorder the patches to match the tree.
        let mut unordered: Vec<Option<Patch>> = patches.all.into_iter().map(Some).collect();
        patches.all = order.iter().filter_map(|&i| unordered[i].take()).collect();
        patches
    }

    /// Adds the subtree of some patches, whose range begins at `start`, and reorders them.
    fn add(&mut self, order: &mut [usize], start: usize) {
        let corners = || order.iter().flat_map(|&i| self.all[i].corners);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let rest = order.iter().fold(Unheld::default(), |sum, &i| sum.and(self.all[i].rest()));
        let this = self.boxes.len();
        self.boxes.push(PatchBox { low, high, rest, start, end: start + order.len(), second: None });
        if order.len() <= LEAF {
            // Sort, so that the order does not depend on the selection algorithm.
            order.sort_unstable();
            return;
        }
        let axis = (high - low).max_position();
        let place = |i: &usize| self.all[*i].middle[axis];
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |i, j| place(i).total_cmp(&place(j)).then(i.cmp(j)));
        let (first, second) = order.split_at_mut(half);
        self.add(first, start);
        self.boxes[this].second = Some(self.boxes.len());
        self.add(second, start + half);
    }

    /// The first uncovered patch at or after `from`.
    pub(super) fn next(&self, from: usize) -> Option<usize> {
        (from..self.all.len()).find(|&i| !self.all[i].is_held)
    }

    pub(super) fn get(&self, index: usize) -> &Patch {
        &self.all[index]
    }

    /// The uncovered patches within reach of a point.
    pub(super) fn near(&self, reach: f64, centre: DVec3) -> Vec<usize> {
        let mut found = Vec::new();
        self.near_below(0, reach, centre, &mut found);
        found
    }

    fn near_below(&self, index: usize, reach: f64, centre: DVec3, found: &mut Vec<usize>) {
        let Some(this) = self.boxes.get(index).filter(|this| this.rest.count > 0) else { return };
        match (this.is_within(reach, centre), this.second) {
            (Some(false), _) => {}
            (_, Some(second)) => {
                self.near_below(index + 1, reach, centre, found);
                self.near_below(second, reach, centre, found);
            }
            (_, None) => {
                let is_near = |&i: &usize| !self.all[i].is_held && self.all[i].is_within(reach, centre);
                found.extend((this.start..this.end).filter(is_near));
            }
        }
    }

    /// The uncovered patches that a sphere would cover.
    pub(super) fn gain(&self, reach: f64, centre: DVec3) -> Unheld {
        self.gain_below(0, reach, centre)
    }

    fn gain_below(&self, index: usize, reach: f64, centre: DVec3) -> Unheld {
        let Some(this) = self.boxes.get(index).filter(|this| this.rest.count > 0) else {
            return Unheld::default();
        };
        match (this.is_within(reach, centre), this.second) {
            (Some(true), _) => this.rest,
            (Some(false), _) => Unheld::default(),
            (None, Some(second)) => {
                self.gain_below(index + 1, reach, centre).and(self.gain_below(second, reach, centre))
            }
            (None, None) => {
                let within =
                    self.all[this.start..this.end].iter().filter(|patch| patch.is_within(reach, centre));
                within.fold(Unheld::default(), |sum, patch| sum.and(patch.rest()))
            }
        }
    }

    /// Marks the patches within reach of a sphere's centre as covered.
    pub(super) fn hold(&mut self, reach: f64, centre: DVec3) {
        self.hold_below(0, reach, centre);
    }

    fn hold_below(&mut self, index: usize, reach: f64, centre: DVec3) {
        let Some(this) = self.boxes.get(index).filter(|this| this.rest.count > 0) else { return };
        let (range, second) = (this.start..this.end, this.second);
        let within = this.is_within(reach, centre);
        if within == Some(false) {
            return;
        }
        self.boxes[index].rest = if let Some(second) = second {
            self.hold_below(index + 1, reach, centre);
            self.hold_below(second, reach, centre);
            self.boxes[index + 1].rest.and(self.boxes[second].rest)
        } else {
            for patch in &mut self.all[range.clone()] {
                patch.is_held |= patch.is_within(reach, centre);
            }
            self.all[range].iter().fold(Unheld::default(), |sum, patch| sum.and(patch.rest()))
        };
    }
}
