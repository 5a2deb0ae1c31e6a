//! Patches of a surface, and which of them are covered by spheres.
//!
//! A binary tree of boxes sums the area that a large sphere would cover from few entries.

use crate::primitive::triangle::Triangle;
use alloc::vec::Vec;
use glam::DVec3;

/// A piece of a triangle.
#[derive(Copy, Clone)]
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

/// What the order of the patches depends on. There may be a million of them, so that sorting does not look them up.
struct PatchPlace {
    low: DVec3,
    high: DVec3,
    middle: DVec3,
    index: usize,
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

    /// Whether all of it is within reach of a point. `reach` is positive.
    pub(super) fn is_within(&self, reach: f64, centre: DVec3) -> bool {
        self.corners.iter().all(|p| p.distance_squared(centre) <= reach * reach)
    }

    fn rest(&self) -> Unheld {
        if self.is_held { Unheld::default() } else { Unheld { area: self.area.length(), count: 1 } }
    }
}

impl PatchBox {
    fn around(patches: &[Patch], start: usize) -> Self {
        let corners = || patches.iter().flat_map(|patch| patch.corners);
        Self {
            low: corners().fold(DVec3::INFINITY, DVec3::min),
            high: corners().fold(DVec3::NEG_INFINITY, DVec3::max),
            rest: patches.iter().fold(Unheld::default(), |sum, patch| sum.and(patch.rest())),
            start,
            end: start + patches.len(),
            second: None,
        }
    }

    fn of_children(boxes: &[Self], first: usize, second: usize) -> Self {
        let (p, q) = (&boxes[first], &boxes[second]);
        Self {
            low: p.low.min(q.low),
            high: p.high.max(q.high),
            rest: p.rest.and(q.rest),
            start: p.start,
            end: q.end,
            second: Some(second),
        }
    }

    /// Whether all (`Some(true)`) or nothing (`Some(false)`) of it is within reach of a point; `None` if undecided.
    fn is_within(&self, reach: f64, centre: DVec3) -> Option<bool> {
        let farthest = (centre - self.low).abs().max((centre - self.high).abs());
        if farthest.length_squared() <= reach * reach {
            return Some(true);
        }
        let nearest = centre.clamp(self.low, self.high);
        (nearest.distance_squared(centre) > reach * reach).then_some(false)
    }
}

impl Patches {
    pub(super) fn new(pieces: &[Triangle]) -> Self {
        let unordered: Vec<Patch> = pieces.iter().map(Patch::new).collect();
        let place = |(index, patch): (usize, &Patch)| {
            let [p, q, r] = patch.corners;
            PatchPlace { low: p.min(q).min(r), high: p.max(q).max(r), middle: patch.middle, index }
        };
        let mut order: Vec<PatchPlace> = unordered.iter().enumerate().map(place).collect();
        let mut patches = Self { all: Vec::with_capacity(order.len()), boxes: Vec::new() };
        if !order.is_empty() {
            patches.add(&unordered, &mut order);
        }
        patches
    }

    /// Adds some patches, and the subtree of them.
    fn add(&mut self, unordered: &[Patch], order: &mut [PatchPlace]) {
        let (this, start) = (self.boxes.len(), self.all.len());
        if order.len() <= LEAF {
            // Sort, so that the order does not depend on the selection algorithm.
            order.sort_unstable_by_key(|place| place.index);
            self.all.extend(order.iter().map(|place| unordered[place.index]));
            self.boxes.push(PatchBox::around(&self.all[start..], start));
            return;
        }
        let low = order.iter().fold(DVec3::INFINITY, |low, place| low.min(place.low));
        let high = order.iter().fold(DVec3::NEG_INFINITY, |high, place| high.max(place.high));
        let axis = (high - low).max_position();
        let compare = |i: &PatchPlace, j: &PatchPlace| {
            i.middle[axis].total_cmp(&j.middle[axis]).then(i.index.cmp(&j.index))
        };
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, compare);
        let (first, second) = order.split_at_mut(half);
        // A place for this node, before its children.
        self.boxes.push(PatchBox::around(&[], start));
        self.add(unordered, first);
        let second_box = self.boxes.len();
        self.add(unordered, second);
        self.boxes[this] = PatchBox::of_children(&self.boxes, this + 1, second_box);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// Right triangles with whole corners, parallel to the axes: sums of areas are exact in any order.
    fn pieces(count: usize, random: &mut SplitMix64) -> Vec<Triangle> {
        let mut below = |n: usize| random.below(n) as f64;
        let piece = |_| {
            let p = [below(40), below(40), below(40)];
            let (mut q, mut r) = (p, p);
            let axis = below(3) as usize;
            q[axis] += 1.0 + below(4);
            r[(axis + 1) % 3] += 1.0 + below(4);
            [p, q, r]
        };
        (0..count).map(piece).collect()
    }

    #[test]
    fn sums_are_those_of_all_patches() {
        let mut random = SplitMix64(3);
        let mut whole_boxes = 0;
        for count in [1, 7, 8, 9, 100, 1000] {
            let mut patches = Patches::new(&pieces(count, &mut random));
            assert_eq!(patches.all.len(), count);
            for _ in 0..200 {
                let centre = DVec3::from_array([0, 1, 2].map(|_| random.below(45) as f64));
                let reach = 1.0 + random.below(30) as f64;
                let is_new = |patch: &Patch| {
                    let is_near = |p: &DVec3| p.distance_squared(centre) <= reach * reach;
                    !patch.is_held && patch.corners.iter().all(is_near)
                };
                let want: Vec<usize> = (0..count).filter(|&i| is_new(&patches.all[i])).collect();
                let area = want.iter().map(|&i| patches.all[i].area.length()).sum();
                assert!(patches.gain(reach, centre) == Unheld { area, count: want.len() });
                assert_eq!(patches.near(reach, centre), want);
                whole_boxes += usize::from(want.len() > 8 * LEAF);
                // Few, so that most stay uncovered.
                if want.len() < count / 20 {
                    patches.hold(reach, centre);
                    assert!(patches.near(reach, centre).is_empty());
                }
            }
            assert_eq!(patches.next(0), patches.all.iter().position(|patch| !patch.is_held));
        }
        assert!(whole_boxes > 50, "{whole_boxes}");
    }
}
