//! Verification: proves again, in exact arithmetic, that every volume bounds what is below it.

use super::{BvhRef, Lane, Walk};
use crate::frame::Frame;
use crate::key::Key;
use crate::node::{BoundingBall, Dop, Link};
use crate::primitive::{Primitive, radius_of, sphere};
use crate::range::Point;
use crate::vector::sqrt;
use core::fmt;

/// A plane that cuts off part of a primitive below it: a collision could be missed.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct VerifyError {
    /// Index of the node. The nodes of the caps are numbered after those of the primitives, and then those of the
    /// packing.
    pub node: u32,
    /// Lane in the node.
    pub lane: u32,
    /// Index of the direction; k and k + 1 for the low and the high end of the normal slab; k + 2 for the ball; k + 3
    /// for the sum of volumes stored with it, where `primitive` is the first one below the lane; k + 4 for a cap that
    /// does not close the surface at one of its edges; k + 5 for a sphere of the packing that is not inside the solid.
    pub plane: u32,
    /// Index of the primitive in the geometry that the tree was built from. For a cap, its [source
    /// index](BvhRef::caps); for the packing, that of a sphere.
    pub primitive: u32,
}

impl fmt::Display for VerifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { node, lane, plane, primitive } = self;
        write!(f, "plane {plane} of node {node}, lane {lane} cuts off primitive {primitive}")
    }
}

impl core::error::Error for VerifyError {}

impl<N: Dop, P: Primitive> BvhRef<'_, N, P> {
    /// Decides, for every primitive and every lane on the path to it, whether each plane is an upper bound of the exact
    /// support of the primitive, and whether the primitive lies within the lane's normal slab or ball. Nothing is
    /// rounded: planes, corners, centre and direction are dyadic numbers, summed as expansions; for primitives with a
    /// radius, integers compare squares. (The volumes below a lane are summed in `f64`, in the packer's order.) Cost:
    /// primitives x depth x k.
    ///
    /// Proves the same for the tree of the [caps](Self::caps), and that as many triangles and caps run along each edge
    /// of a cap in one direction as in the other. Cost: caps x (caps + primitives).
    ///
    /// Proves the same for the tree of the [packing](Self::packing), and that each of its spheres is inside the solid:
    /// no triangle or cap has a point in the open ball, and the surface winds around its centre. Cost: spheres x
    /// (primitives + caps).
    ///
    /// Does not prove that the triangles of a solid form a closed surface elsewhere, nor which primitives are
    /// connected. Bytes with wrong parts or a wrong solid flag may give a wrong answer to whether a body is inside
    /// another.
    ///
    /// # Errors
    /// [`VerifyError`] describes the first plane that is too low.
    pub fn verify(&self) -> Result<(), VerifyError> {
        self.verify_below(&self.frame(), self.walk())?;
        self.verify_volumes()?;
        let mut before = self.header.node_count;
        if let Some(caps) = self.caps() {
            caps.verify_below(&caps.frame(), caps.walk())
                .map_err(|error| VerifyError { node: error.node + before, ..error })?;
            self.verify_caps(&caps)?;
            before += caps.header.node_count;
        }
        if let Some(packing) = self.packing() {
            packing
                .verify_below(&packing.frame(), packing.walk())
                .and_then(|()| packing.verify_volumes())
                .map_err(|error| VerifyError { node: error.node + before, ..error })?;
            if let Some(index) = self.first_outside(&packing) {
                let plane = N::K as u32 + 5;
                return Err(VerifyError { node: before, lane: 0, plane, primitive: packing.source(index) });
            }
        }
        Ok(())
    }

    /// Whether the caps close the surface along their edges.
    fn verify_caps(&self, caps: &Self) -> Result<(), VerifyError> {
        let items = |tree: &Self| {
            let tree = *tree;
            (0..tree.len() as u32).map(move |index| tree.primitive(index))
        };
        for index in 0..caps.len() as u32 {
            for [p, q] in edges::<P>(&caps.primitive(index)) {
                let along = |item: P::Item| -> i64 {
                    let runs = |[u, v]: [Point; 2]| i64::from(u == p && v == q) - i64::from(u == q && v == p);
                    edges::<P>(&item).map(runs).sum()
                };
                if p != q && items(self).chain(items(caps)).map(along).sum::<i64>() != 0 {
                    let (node, plane) = (self.header.node_count, N::K as u32 + 4);
                    return Err(VerifyError { node, lane: 0, plane, primitive: caps.source(index) });
                }
            }
        }
        Ok(())
    }

    /// Verifies the lanes of a walk, whose planes are in a frame.
    fn verify_below(&self, frame: &Frame, mut walk: Walk<'_, N>) -> Result<(), VerifyError> {
        while let Some(Lane { child, .. }) = walk.next() {
            let Link::Leaf { first, count } = child.link() else { continue };
            for index in first..first + count {
                let item = self.primitive(index);
                for (node, lane) in walk.path() {
                    let wrong = self.too_low(frame, node, lane, &item);
                    let wrong = wrong.or_else(|| self.too_thin(frame, node, lane, &item));
                    if let Some(plane) = wrong.or_else(|| self.too_round(frame, node, lane, &item)) {
                        let lane = lane as u32;
                        return Err(VerifyError { node, lane, plane, primitive: self.source(index) });
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether the volume stored with each ball is at least that of the spheres below its lane.
    fn verify_volumes(&self) -> Result<(), VerifyError> {
        for (node, balls) in (0..).zip(self.balls) {
            for (lane, child) in (0..).zip(self.nodes()[node as usize].children()) {
                let volume = self.volume_below(child.link());
                if volume > f64::from(balls.lane(lane as usize).volume) {
                    let (plane, first) = (N::K as u32 + 3, self.first_below(child.link()));
                    return Err(VerifyError { node, lane, plane, primitive: self.source(first) });
                }
            }
        }
        Ok(())
    }

    /// The volume of the primitives below a link, in the unit of the frame, summed in the packer's order.
    fn volume_below(&self, link: Link) -> f64 {
        match link {
            Link::Empty => 0.0,
            Link::Inner(node) => self.nodes()[node as usize]
                .children()
                .iter()
                .map(|child| self.volume_below(child.link()))
                .sum(),
            Link::Leaf { first, count } => {
                let scale = self.frame().scale();
                let volume = |index| sphere::volume(radius_of::<P>(&self.primitive(index)) * scale);
                (first..first + count).map(volume).sum()
            }
        }
    }

    fn first_below(&self, link: Link) -> u32 {
        match link {
            Link::Leaf { first, .. } => first,
            Link::Inner(node) => self.first_below(self.nodes()[node as usize].children()[0].link()),
            Link::Empty => 0,
        }
    }

    /// Whether the ball of a lane excludes part of a primitive. `None` if the tree has no balls.
    fn too_round(&self, frame: &Frame, node: u32, lane: usize, item: &P::Item) -> Option<u32> {
        let BoundingBall { centre, radius, .. } = self.balls.get(node as usize)?.lane(lane);
        let (centre, reach) = (centre.map(f64::from), radius_of::<P>(item));
        let is_in = |p| frame.is_in_ball(&centre, radius.into(), p, reach);
        (!P::corners(item).all(is_in)).then_some(N::K as u32 + 2)
    }

    /// The first plane of a lane that does not bound a primitive.
    fn too_low(&self, frame: &Frame, node: u32, lane: usize, item: &P::Item) -> Option<u32> {
        let node = &self.nodes()[node as usize];
        let is_too_low = |(j, direction): &(u32, &Point)| {
            // A code that is not a plane (-0, NaN, or the mark of an unused lane) bounds nothing.
            let key = Key::<N::Storage>::from_code(node.plane(*j as usize, lane));
            !key.is_some_and(|key| P::is_bounded(item, frame, direction, key))
        };
        (0..).zip(N::DIRECTIONS).find(is_too_low).map(|(j, _)| j)
    }

    /// The end of a lane's normal slab that a primitive exceeds, if the tree has such slabs.
    fn too_thin(&self, frame: &Frame, node: u32, lane: usize, item: &P::Item) -> Option<u32> {
        let slab = self.normal_slab(node, lane)?;
        let (n, ends) = (slab.normal(), slab.ends());
        let radius = radius_of::<P>(item);
        // Rounded up, by less than the packer's allowance.
        let reach = sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2])
            * (radius * frame.scale())
            * (1.0 + 4.0 * f64::EPSILON);
        let is_beyond = |end: usize| {
            let outwards = if end == 0 { -1 } else { 1 };
            let inside = match end {
                _ if radius == 0.0 => ends[end],
                0 => (ends[end] + reach).next_up(),
                _ => (ends[end] - reach).next_down(),
            };
            ends[end].is_finite() && P::corners(item).any(|p| frame.side(&n, p, inside) == outwards)
        };
        (0..2).find(|&end| is_beyond(end)).map(|end| (N::K + end) as u32)
    }
}

/// The edges between successive corners of a primitive.
fn edges<P: Primitive>(item: &P::Item) -> impl Iterator<Item = [Point; 2]> + '_ {
    let after = P::corners(item).skip(1).chain(P::corners(item).take(1));
    P::corners(item).zip(after).map(|(p, q)| [p, q])
}
