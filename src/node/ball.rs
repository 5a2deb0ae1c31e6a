//! Bounding balls of the lanes of 16-ary nodes, for trees of spheres.
//!
//! Balls suit spheres: a leaf's is the sphere itself, and a rotation moves only its centre. With the volume of the
//! spheres below, they give an upper bound of the volume that two bodies of spheres have in common.

/// The balls of sixteen lanes, in the tree's frame. A lane's ball contains all spheres below it, though not necessarily
/// the balls of the lanes below (a wrapped hierarchy). 320 bytes.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Ball16 {
    /// `centre[i]`: coordinate i of the centres; NaN in unused lanes, which meet nothing.
    pub centre: [[f32; 16]; 3],
    /// The radii; 0 in unused lanes.
    pub radius: [f32; 16],
    /// Upper bounds of the total volume of the spheres below; 0 in unused lanes.
    pub volume: [f32; 16],
}

/// The ball of a lane.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct BoundingBall {
    /// The centre.
    pub centre: [f32; 3],
    /// The radius.
    pub radius: f32,
    /// Upper bound of the total volume of the spheres in it.
    pub volume: f32,
}

const _: () = assert!(size_of::<Ball16>() == 320, "the balls of a node are five cache lines");

impl BoundingBall {
    /// The ball of an unused lane.
    pub const EMPTY: Self = Self { centre: [f32::NAN; 3], radius: 0.0, volume: 0.0 };

    /// Whether it is the ball of an unused lane, bit by bit.
    pub(crate) const fn is_empty(&self) -> bool {
        let [x, y, z] = self.centre;
        let nan = f32::NAN.to_bits();
        (x.to_bits() == nan && y.to_bits() == nan && z.to_bits() == nan)
            && (self.radius.to_bits() == 0 && self.volume.to_bits() == 0)
    }
}

impl Ball16 {
    /// The balls of unused lanes.
    pub const EMPTY: Self = Self { centre: [[f32::NAN; 16]; 3], radius: [0.0; 16], volume: [0.0; 16] };

    /// The ball of a lane (modulo 16).
    #[inline(always)]
    #[must_use]
    pub const fn lane(&self, lane: usize) -> BoundingBall {
        let [x, y, z] = &self.centre;
        let lane = lane & 15;
        BoundingBall {
            centre: [x[lane], y[lane], z[lane]],
            radius: self.radius[lane],
            volume: self.volume[lane],
        }
    }

    /// Puts a ball into a lane (modulo 16).
    #[inline(always)]
    pub const fn set(&mut self, lane: usize, ball: &BoundingBall) {
        let lane = lane & 15;
        let mut i = 0;
        while i < 3 {
            self.centre[i][lane] = ball.centre[i];
            i += 1;
        }
        self.radius[lane] = ball.radius;
        self.volume[lane] = ball.volume;
    }
}
