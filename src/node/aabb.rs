//! Nodes of boxes, and buckets of points, for trees over moving points.
//!
//! The boxes are `f32`, like the points, and need no frame: the least and the greatest coordinates of points are exact,
//! so nothing is rounded, and a tree is equally tight far from the origin and in a cluster a millionth of the scene's
//! size.

use super::Child;
use crate::vector::sqrt;

/// An axis-aligned box, closed: a point if `lower` equals `upper`.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Box3 {
    /// The least coordinates.
    pub lower: [f32; 3],
    /// The greatest coordinates.
    pub upper: [f32; 3],
}

/// The boxes and links of sixteen children. 512 bytes.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Aabb16 {
    /// `lower[i]`: the least coordinate i below each lane; NaN in unused lanes.
    pub lower: [[f32; 16]; 3],
    /// `upper[i]`: the greatest coordinate i below each lane; NaN in unused lanes.
    pub upper: [[f32; 16]; 3],
    /// The fourth root of the [volume](Box3::fourth_root_of_volume) that each lane's box had when the tree was built.
    pub built: [f32; 16],
    /// The links of the lanes: to a node, or to one bucket, which [`Link::Leaf`](super::Link::Leaf) counts as one.
    pub child: [Child; 16],
}

/// Up to sixteen points, by coordinate. 256 bytes.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Bucket {
    /// `coordinates[i][slot]`: coordinate i of the points; NaN in unused slots, which are within no distance of
    /// anything.
    pub coordinates: [[f32; 16]; 3],
    /// The indices of the points; [`Bucket::UNUSED`] in unused slots.
    pub indices: [u32; 16],
}

const _: () = assert!(size_of::<Aabb16>() == 512, "a node of boxes is eight cache lines");
const _: () = assert!(size_of::<Bucket>() == 256, "a bucket of points is four cache lines");

impl Box3 {
    /// The empty box.
    pub const EMPTY: Self = Self { lower: [f32::NAN; 3], upper: [f32::NAN; 3] };

    /// The box of one point.
    #[inline(always)]
    #[must_use]
    pub const fn of_point(point: [f32; 3]) -> Self {
        Self { lower: point, upper: point }
    }

    /// Whether the box is empty.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.lower[0].is_nan()
    }

    /// Extends the box to contain another.
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for i in 0..3 {
            // Empty boxes are NaN, with which comparisons are false, so NaN is neither kept nor taken over.
            let (lower, upper) = (other.lower[i], other.upper[i]);
            self.lower[i] = if self.lower[i] <= lower || lower.is_nan() { self.lower[i] } else { lower };
            self.upper[i] = if self.upper[i] >= upper || upper.is_nan() { self.upper[i] } else { upper };
        }
    }

    /// The fourth root of the volume, rounded up. For the volume, no side counts as shorter than a 1024th of the
    /// longest, so that boxes of flat sets have one too. The root fits `f32` whatever the unit. 0 for a point and for
    /// the empty box.
    #[must_use]
    pub fn fourth_root_of_volume(&self) -> f32 {
        let volume = self.volume();
        let root = sqrt(sqrt(volume)) as f32;
        let square = f64::from(root) * f64::from(root);
        if square * square < volume { root.next_up() } else { root }
    }

    /// The volume of [`Box3::fourth_root_of_volume`], in the unit cubed.
    pub(crate) fn volume(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let sides =
            core::array::from_fn::<f64, 3, _>(|i| f64::from(self.upper[i]) - f64::from(self.lower[i]));
        let least = f64::max(f64::max(sides[0], sides[1]), sides[2]) / 1024.0;
        f64::max(sides[0], least) * f64::max(sides[1], least) * f64::max(sides[2], least)
    }
}

impl Aabb16 {
    /// A node of unused lanes.
    pub const EMPTY: Self = Self {
        lower: [[f32::NAN; 16]; 3],
        upper: [[f32::NAN; 16]; 3],
        built: [0.0; 16],
        child: [Child::EMPTY; 16],
    };

    /// The box of a lane (modulo 16).
    #[inline(always)]
    #[must_use]
    pub const fn lane(&self, lane: usize) -> Box3 {
        let ([a, b, c], [d, e, f], lane) = (&self.lower, &self.upper, lane & 15);
        Box3 { lower: [a[lane], b[lane], c[lane]], upper: [d[lane], e[lane], f[lane]] }
    }

    /// Sets the box of a lane (modulo 16).
    #[inline(always)]
    pub(crate) const fn set_lane(&mut self, lane: usize, of: &Box3) {
        let lane = lane & 15;
        let mut i = 0;
        while i < 3 {
            self.lower[i][lane] = of.lower[i];
            self.upper[i][lane] = of.upper[i];
            i += 1;
        }
    }

    /// The box around all lanes.
    #[must_use]
    pub fn bounds(&self) -> Box3 {
        Box3 { lower: self.lower.map(|x| least(&x)), upper: self.upper.map(|x| greatest(&x)) }
    }
}

impl Bucket {
    /// The index of an unused slot.
    pub const UNUSED: u32 = u32::MAX;
    /// No points.
    pub const EMPTY: Self = Self { coordinates: [[f32::NAN; 16]; 3], indices: [Self::UNUSED; 16] };

    /// The point in a slot (modulo 16).
    #[inline(always)]
    #[must_use]
    pub const fn point(&self, slot: usize) -> [f32; 3] {
        let ([x, y, z], slot) = (&self.coordinates, slot & 15);
        [x[slot], y[slot], z[slot]]
    }

    /// Puts a point into a slot (modulo 16).
    #[inline(always)]
    pub(crate) const fn set(&mut self, slot: usize, point: [f32; 3], index: u32) {
        let slot = slot & 15;
        let mut i = 0;
        while i < 3 {
            self.coordinates[i][slot] = point[i];
            i += 1;
        }
        self.indices[slot] = index;
    }

    /// The used slots, one bit each.
    #[inline(always)]
    #[must_use]
    pub fn used(&self) -> u16 {
        (0..16).filter(|&slot| self.indices[slot] != Self::UNUSED).fold(0, |mask, slot| mask | 1 << slot)
    }

    /// The box around the points.
    #[inline(always)]
    #[must_use]
    pub fn bounds(&self) -> Box3 {
        Box3 { lower: self.coordinates.map(|x| least(&x)), upper: self.coordinates.map(|x| greatest(&x)) }
    }
}

/// The least of sixteen numbers, ignoring NaN; NaN if all are. By halves, which compilers vectorise.
#[inline(always)]
fn least(x: &[f32; 16]) -> f32 {
    let lesser = |a: f32, b: f32| if a < b || b.is_nan() { a } else { b };
    let mut folded = *x;
    for width in [8, 4, 2, 1] {
        for i in 0..width {
            folded[i] = lesser(folded[i], folded[i + width]);
        }
    }
    folded[0]
}

/// The greatest of sixteen numbers, ignoring NaN; NaN if all are.
#[inline(always)]
fn greatest(x: &[f32; 16]) -> f32 {
    let greater = |a: f32, b: f32| if a > b || b.is_nan() { a } else { b };
    let mut folded = *x;
    for width in [8, 4, 2, 1] {
        for i in 0..width {
            folded[i] = greater(folded[i], folded[i + width]);
        }
    }
    folded[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_points_there_are() {
        for used in [0_u16, 1, 0x8000, 0x0180, 0xfffe, 0xffff, 0x5a5a] {
            let mut bucket = Bucket::EMPTY;
            let mut want: Option<Box3> = None;
            for slot in (0..16).filter(|slot| used >> slot & 1 != 0) {
                let point = [slot as f32 * 0.5 - 3.0, -(slot as f32), ((slot * 7) % 16) as f32];
                bucket.set(slot, point, slot as u32);
                let held = want.get_or_insert(Box3::of_point(point));
                for (i, x) in point.into_iter().enumerate() {
                    held.lower[i] = held.lower[i].min(x);
                    held.upper[i] = held.upper[i].max(x);
                }
            }
            assert_eq!(bucket.used(), used);
            match want {
                Some(want) => assert_eq!(bucket.bounds(), want, "{used:#x}"),
                None => assert!(bucket.bounds().is_empty()),
            }
        }
    }

    #[test]
    fn nothing_is_added_by_what_is_empty() {
        let unit = Box3 { lower: [0.0; 3], upper: [1.0; 3] };
        let mut held = Box3::EMPTY;
        held.add(&Box3::EMPTY);
        assert!(held.is_empty());
        held.add(&unit);
        held.add(&Box3::EMPTY);
        assert_eq!(held, unit);
        held.add(&Box3::of_point([-1.0, 0.5, 2.0]));
        assert_eq!(held, Box3 { lower: [-1.0, 0.0, 0.0], upper: [1.0, 1.0, 2.0] });
    }

    #[test]
    fn flat_boxes_have_a_volume_and_points_have_none() {
        let flat = Box3 { lower: [0.0; 3], upper: [8.0, 1.0, 0.0] };
        assert_eq!(flat.volume(), 8.0 * 1.0 * 8.0 / 1024.0);
        assert_eq!(flat.fourth_root_of_volume(), 0.5);
        let box_of = |x: f32| Box3 { lower: [0.0; 3], upper: [x, 2.0, 3.0] };
        for x in (1..100).map(|i| i as f32 * 0.1) {
            let root = f64::from(box_of(x).fourth_root_of_volume());
            assert!((root * root) * (root * root) >= box_of(x).volume(), "rounded up");
        }
        assert_eq!(Box3::of_point([3.0; 3]).volume(), 0.0);
        assert_eq!(Box3::EMPTY.volume(), 0.0);
        let widest = Box3 { lower: [-f32::MAX; 3], upper: [f32::MAX; 3] };
        assert!(widest.fourth_root_of_volume().is_finite());
    }
}
