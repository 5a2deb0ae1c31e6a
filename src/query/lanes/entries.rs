//! Pending volumes of a distance query: bounds, with their lanes.

use crate::node::{Child, Link};

/// A bound and its lane in one number: entries order by bound, then by lane.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Entry(u32);

/// Bounds for up to 16 lanes.
pub(crate) type Entries = [Entry; 16];

const LANE_BITS: u32 = 15;
const SIGN: u32 = 1 << 31;

impl Entry {
    /// No lane, or one that is finished.
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// Initial value, to be overwritten.
    pub(in crate::query) const ZEROS: Self = Self(0);

    /// Rounds the bound down, to 20 bits.
    #[inline(always)]
    fn new(bound: f32, lane: usize) -> Self {
        let bits = bound.to_bits();
        let flip = ((bits as i32 >> 31) as u32) | SIGN;
        Self((bits ^ flip) & !LANE_BITS | lane as u32)
    }

    #[inline(always)]
    pub(crate) const fn lane(self) -> usize {
        (self.0 & LANE_BITS) as usize
    }

    /// The bound, rounded down: for negative bounds, the magnitude is rounded up.
    #[inline(always)]
    pub(crate) const fn bound(self) -> f32 {
        let bits = self.0 & !LANE_BITS;
        f32::from_bits(if self.0 >= SIGN { bits ^ SIGN } else { !bits })
    }
}

/// The entries of bounds, none of which is below [`f32::MIN`].
#[inline(always)]
pub(crate) fn entries<const W: usize>(bounds: &[f32; W], links: &[Child; W]) -> Entries {
    let mut entries = [Entry::NONE; 16];
    for lane in 0..W {
        let used = links[lane] != Child::EMPTY;
        entries[lane] = if used { Entry::new(bounds[lane], lane) } else { Entry::NONE };
    }
    entries
}

/// Raises each entry to the bound of its lane, if that is above zero.
#[inline(always)]
pub(crate) fn raise<const W: usize>(entries: &mut Entries, bounds: &[f32; W]) {
    for (lane, (entry, bound)) in entries.iter_mut().zip(bounds).enumerate() {
        let raised = Entry::new(*bound, lane);
        *entry = if *bound > 0.0 && *entry < raised { raised } else { *entry };
    }
}

/// The total weight of the children of a node whose bounds are at most `bound` ([`weight_of`]).
#[inline(always)]
pub(crate) fn weight(entries: &Entries, bound: f32, children: &[Child]) -> usize {
    let mut weight = 0;
    for (entry, child) in entries.iter().zip(children) {
        weight += if *entry != Entry::NONE && entry.bound() <= bound { weight_of(*child) } else { 0 };
    }
    weight
}

const WEIGHT_OF_INNER: usize = 8;

/// The weight of a child in a count of the leaves that a test may cull. A node counts as several leaves, since it would
/// cost a visit.
#[inline(always)]
pub(in crate::query) const fn weight_of(child: Child) -> usize {
    if let Link::Leaf { .. } = child.link() { 1 } else { WEIGHT_OF_INNER }
}

/// The least entry.
#[inline(always)]
pub(crate) fn least(entries: &Entries) -> Entry {
    let mut least = entries[0];
    for entry in entries {
        least = if *entry < least { *entry } else { least };
    }
    least
}

/// Removes an entry. It writes all of them: a store of one would delay the next load of all.
#[inline(always)]
pub(crate) fn remove(entries: &mut Entries, entry: Entry) {
    for other in entries {
        *other = if *other == entry { Entry::NONE } else { *other };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bounds_above_zero_raise_entries() {
        let links = [Child::ROOT, Child::ROOT, Child::ROOT, Child::EMPTY];
        let before = entries(&[-4.0, 1.0, 2.0, 0.0], &links);
        let mut raised = before;
        raise(&mut raised, &[0.0, 3.0, 1.0, 9.0]);
        assert_eq!(raised[0], before[0], "how deep volumes overlap says which is tried first");
        assert_eq!((raised[1].bound(), raised[1].lane()), (3.0, 1));
        assert_eq!(raised[2..], before[2..]);
        assert_eq!(weight(&raised, 2.0, &links), 2 * weight_of(Child::ROOT));
    }

    #[test]
    fn entries_order_and_round_down() {
        let bounds =
            [f32::MIN, -65536.0, -3.5, -1e-7, 0.0, 1e-7, 1.0, 1.0 + 1e-6, 99.9, 131_072.0_f32, f32::MAX];
        for (i, &x) in bounds.iter().enumerate() {
            for (lane, other) in [(0, 15), (15, 3)] {
                let entry = Entry::new(x, lane);
                assert_eq!(entry.lane(), lane);
                assert!(entry < Entry::NONE);
                assert!(entry.bound() <= x && entry.bound() >= x - x.abs() * 4e-6, "{x}");
                for &y in bounds[i + 1..].iter().filter(|y| (**y - x).abs() > 1e-5 * x.abs()) {
                    assert!(entry < Entry::new(y, other), "{x} {y}");
                }
            }
        }
    }
}
