//! The frames that a traversal, or a search for the nearest, is in: those of the bodies, or of details of theirs
//! ([`Detail`]).
//!
//! The planes of a detail are written in a frame of its own, so that the map between the frames is made anew where one gets
//! to a detail, or back to what waits outside of it. Both go down depth first, so they seldom do. Nothing but volumes is in
//! these frames: primitives are tested in the bodies' coordinates.

use super::bounds::Bounds;
use super::frontier::{Side, VolumeA, VolumeB};
use super::nearest::Search;
use super::placing::Margin;
use super::stack::{ABOVE_ROOT, Volumes};
use super::traverse::Traversal;
use super::turning::set_up;
use super::{Lanes, PrimitivePair};
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::{BvhRef, Detail};
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::primitive::Primitive;

impl<N, P, Q, E, M> Traversal<'_, N, P, Q, E, M>
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    E: Kernel,
    M: Margin,
{
    pub(super) fn extent_a(&self) -> BodyBounds {
        extent_of(self.a, self.details[0])
    }

    pub(super) fn extent_b(&self) -> BodyBounds {
        extent_of(self.b, self.details[1])
    }

    /// Whether the frames that the traversal is in are those of two nodes.
    pub(super) fn is_in_frames_of(&self, node_a: u32, node_b: u32) -> bool {
        is_same(self.details[0], self.a.detail_of(node_a))
            && is_same(self.details[1], self.b.detail_of(node_b))
    }

    /// Takes details instead of the nodes that they stand for, and gets into the frames of two volumes.
    // Not a part of the loop, since most bodies have no details. Volumes by value: as a reference they would have to be in memory,
    // which every visit would wait for.
    #[cold]
    #[inline(never)]
    pub(super) fn change_frames(&mut self, mut volumes: Volumes) -> Volumes {
        // The planes of a leaf of a are made in the frame of b.
        let mut detail_a = self.details[0];
        if let Link::Inner(_) = volumes.a.link() {
            (volumes.a, detail_a) = enter(self.a, volumes.a);
        }
        let detail_b = if let Link::Inner(_) = volumes.b.link() {
            let (child, detail) = enter(self.b, volumes.b);
            if child != volumes.b {
                (volumes.b, volumes.holder_b) = (child, ABOVE_ROOT);
            }
            detail
        } else {
            self.b.detail_of(volumes.holder_b)
        };
        if is_same(detail_a, self.details[0]) && is_same(detail_b, self.details[1]) {
            return volumes;
        }
        self.details = [detail_a, detail_b];
        let (extent, frame, placing) = (self.extent_a(), frame_of(self.b, detail_b), self.placing);
        self.units = frame.exponent - extent.frame.exponent;
        self.kernel.run(
            #[inline(always)]
            || set_up::<N, P>(self.map, placing, &extent, &frame),
        );
        (self.turned.node, self.turned.whole) = (Child::EMPTY, 0);
        (self.aimed, self.cutter, self.thin.test) = (None, None, None);
        volumes
    }
}

impl<'t, N: Lanes, P: Primitive, Q: Primitive> Search<'t, N, P, Q> {
    /// Before volume `a` or `b` is opened: takes the detail instead of a node that it stands for, and gets into the frames of
    /// what is compared, which are the children of that node, and the other volume as a lane of the node that holds it.
    #[cold]
    #[inline(never)]
    pub(super) fn change_frames(
        &mut self,
        mut a: VolumeA,
        mut b: VolumeB,
        opened: Side,
    ) -> (VolumeA, VolumeB) {
        let [detail_before, other_before] = self.details.unwrap_or_default();
        let (mut detail_a, detail_b);
        if opened == Side::A {
            (a.child, detail_a) = enter(&self.a, a.child);
            detail_b = if b.parent == ABOVE_ROOT { None } else { self.b.detail_of(b.parent) };
        } else {
            (b.child, detail_b) = enter(&self.b, b.child);
            detail_a = detail_before;
            // The planes of a leaf of A are made in the frame of B.
            if let (Link::Inner(_), Link::Inner(parent)) = (a.child.link(), a.parent.link()) {
                detail_a = self.a.detail_of(parent);
            }
        }
        if !(is_same(detail_a, detail_before) && is_same(detail_b, other_before)) {
            self.details = Some([detail_a, detail_b]);
            self.leaf.forget_planes();
            self.primitive_gaps = None;
            let extent = extent_of(&self.a, detail_a);
            let frame = frame_of(&self.b, detail_b);
            if let Bounds::Near(near) = &mut self.bounds {
                near.change_frames::<P>(self.pose, &extent, &frame);
            }
        }
        (a, b)
    }

    /// What takes widths of children of a node of A or of B into one unit.
    #[inline(always)]
    pub(super) fn growth(&self, body: Side, node: u32) -> f32 {
        if self.details.is_some() {
            self.growth_among_details(body, node)
        } else {
            self.growths[body as usize]
        }
    }

    #[cold]
    #[inline(never)]
    fn growth_among_details(&self, body: Side, node: u32) -> f32 {
        let frame = match body {
            Side::A => frame_of(&self.a, self.a.detail_of(node)),
            Side::B => frame_of(&self.b, self.b.detail_of(node)),
        };
        if let Bounds::Near(near) = &self.bounds { near.growth_in(&frame) } else { 0.0 }
    }
}

/// The detail that stands for a node, if there is one, and the detail in whose frame that is.
fn enter<'t, N: Lanes, P: Primitive>(tree: &BvhRef<'t, N, P>, child: Child) -> (Child, Option<&'t Detail>) {
    let Link::Inner(node) = child.link() else { return (child, None) };
    match tree.detail_at(node) {
        Some(detail) => (detail.root(), Some(detail)),
        None => (child, tree.detail_of(node)),
    }
}

/// How large a detail is, or else the tree.
pub(super) fn extent_of<N: Lanes, P: Primitive>(
    tree: &BvhRef<'_, N, P>,
    detail: Option<&Detail>,
) -> BodyBounds {
    detail.map_or_else(|| tree.extent(), Detail::extent)
}

/// The frame of a detail, or else that of the tree.
#[inline(always)]
pub(super) fn frame_of<N: Lanes, P: Primitive>(tree: &BvhRef<'_, N, P>, detail: Option<&Detail>) -> Frame {
    detail.map_or_else(|| tree.frame(), Detail::frame)
}

fn is_same(one: Option<&Detail>, other: Option<&Detail>) -> bool {
    one.map(|detail| detail.first) == other.map(|detail| detail.first)
}
