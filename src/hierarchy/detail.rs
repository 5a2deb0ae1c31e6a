//! Details: parts of a body that are too fine for the body's frame.
//!
//! A step of the body's frame is the body's width over some 2^16. Where a part of it is so fine that its primitives are but
//! a few steps wide, or less than one, the planes of its nodes tell nothing apart, and every query that comes near it has to
//! test all of its primitives. So the nodes of such a part are in the tree twice: as part of the whole, for everything that
//! needs one frame for all; and once more in a frame of their own, where queries for collisions and distances go on.

use crate::frame::{BodyBounds, Frame};
use crate::node::Child;
use crate::range::Point;

/// A part of a body whose nodes are there once more, in a frame of their own.
///
/// Its nodes are of the shape of those below [`Detail::node`], and lead to the same leaves. They are breadth-first, from
/// [`Detail::first`] to the first node of the next detail.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Detail {
    /// Centre of the frame, in the body's unit.
    pub centre: Point,
    /// Largest absolute coordinate of a point of the detail or of the centre, in the body's unit. At least.
    pub max_coordinate: f64,
    /// Scale of the frame: `2^exponent`.
    pub exponent: i32,
    /// Largest `|x|`, `|y|`, `|z|` of a point of the detail in the frame. At least.
    pub half_width: [f32; 3],
    /// Largest absolute plane of its nodes.
    pub max_plane: f32,
    /// The node that it stands for: one of the body's, or of a detail before this one.
    pub node: u32,
    /// The first of its own nodes.
    pub first: u32,
    pub(crate) reserved: u32,
}

const _: () = assert!(size_of::<Detail>() == 64 && align_of::<Detail>() == 8, "a detail has 64 bytes");

impl Detail {
    /// The frame that its planes are written in.
    #[inline]
    #[must_use]
    pub const fn frame(&self) -> Frame {
        Frame { centre: self.centre, exponent: self.exponent }
    }

    /// How large the detail is.
    #[must_use]
    pub fn extent(&self) -> BodyBounds {
        let mut extent = BodyBounds {
            frame: self.frame(),
            max_coordinate: self.max_coordinate,
            radius: 0.0,
            half_width: self.half_width,
            max_plane: self.max_plane,
        };
        // More than the diagonal of half the box.
        extent.radius = extent.width_sum() / extent.frame.scale();
        extent
    }

    /// The link to the first of its own nodes.
    #[inline]
    pub(crate) const fn root(&self) -> Child {
        Child::root(self.first, self.half_width)
    }
}
