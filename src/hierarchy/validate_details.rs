//! Are the details of these bytes safe to walk?

use super::validate::validate_target;
use super::{BvhRef, Detail, FormatError, Walk};
use crate::frame::MAX_EXPONENT;
use crate::node::{Child, Dop, Link};
use crate::primitive::{Primitive, radius_of};
use crate::range::MAX_COORDINATE;

impl<N: Dop, P: Primitive> BvhRef<'_, N, P> {
    /// After the body's own nodes, and the primitives, have been found right.
    pub(super) fn validate_details(&self) -> Result<(), FormatError> {
        // Details have no gaps between their nodes, and stand for ascending nodes.
        let (mut first, mut after) = (self.header.node_count, 1);
        for (index, detail) in (0_u32..).zip(self.details) {
            let error = |problem| FormatError::Detail { index, problem };
            let end = self.details.get(index as usize + 1).map_or(self.nodes.len() as u32, |next| next.first);
            if detail.first != first || end <= first || end as usize > self.nodes.len() {
                return Err(error("its nodes do not come after those of the detail before"));
            }
            if detail.node < after || detail.node >= first {
                return Err(error("it stands for no node, or for one before that of the detail before"));
            }
            detail.validate().map_err(error)?;
            self.validate_detail_nodes(detail, end).map_err(|(node, lane, problem)| FormatError::Node {
                node,
                lane: lane as u32,
                problem,
            })?;
            self.validate_shape(detail).map_err(error)?;
            (first, after) = (end, detail.node + 1);
        }
        Ok(())
    }

    /// That they are breadth-first, as the body's are, and their planes keys.
    fn validate_detail_nodes(&self, detail: &Detail, end: u32) -> Result<(), (u32, usize, &'static str)> {
        let mut next_node = detail.first + 1;
        for index in detail.first..end {
            let node = &self.nodes[index as usize];
            if index >= next_node {
                return Err((index, 0, "no link leads to this node"));
            }
            for (lane, child) in node.children().iter().enumerate() {
                let error = |problem| (index, lane, problem);
                self.validate_volume(index, lane, detail.max_plane).map_err(error)?;
                let Link::Inner(target) = child.link() else { continue };
                validate_target(node, lane, target, next_node..end).map_err(error)?;
                next_node += 1;
            }
        }
        if next_node == end { Ok(()) } else { Err((end - 1, 0, "links to nodes are missing")) }
    }

    /// That its nodes have the shape of those that it stands for, so that they are no deeper and no primitive is missing, and
    /// that the primitives are no larger than it says.
    fn validate_shape(&self, detail: &Detail) -> Result<(), &'static str> {
        let [mut own, mut originals] =
            [detail.first, detail.node].map(|node| Walk::below(self.nodes, Some(node)));
        loop {
            let (copy, original) = match (own.next(), originals.next()) {
                (None, None) => return Ok(()),
                (Some(copy), Some(original)) => (copy, original),
                _ => return Err("its nodes are not of the shape of those that it stands for"),
            };
            let is_alike = |a: Child, b: Child| match (a.link(), b.link()) {
                (Link::Inner(_), Link::Inner(_)) => true,
                (a, b) => a == b,
            };
            if (copy.lane, copy.level) != (original.lane, original.level)
                || !is_alike(copy.child, original.child)
            {
                return Err("its nodes are not of the shape of those that it stands for");
            }
            let Link::Leaf { first, count } = copy.child.link() else { continue };
            if !(first..first + count).all(|index| detail.has_inside::<P>(&self.primitive(index))) {
                return Err("a primitive is larger than it says");
            }
        }
    }
}

impl Detail {
    fn validate(&self) -> Result<(), &'static str> {
        let is_size = |x: f32| x >= 0.0 && x.is_finite();
        let checks = [
            (
                "its centre is too far",
                self.centre.iter().all(|c| c.abs() <= self.max_coordinate)
                    && self.max_coordinate <= MAX_COORDINATE,
            ),
            ("its exponent is out of range", (-MAX_EXPONENT..=MAX_EXPONENT).contains(&self.exponent)),
            ("its half width is no width", self.half_width.iter().all(|w| is_size(*w))),
            ("its greatest plane is none", is_size(self.max_plane)),
            ("it has more bytes than it needs", self.reserved == 0),
        ];
        checks.iter().find(|(_, ok)| !ok).map_or(Ok(()), |(problem, _)| Err(problem))
    }

    /// Whether the detail is at least as large as one of its primitives needs it to be.
    fn has_inside<P: Primitive>(&self, item: &P::Item) -> bool {
        let (scale, radius) = (self.frame().scale(), radius_of::<P>(item));
        P::corners(item).all(|p| {
            (0..3).all(|i| {
                p[i].abs() + radius <= self.max_coordinate
                    && ((p[i] - self.centre[i]) * scale).abs() + radius * scale
                        <= f64::from(self.half_width[i])
            })
        })
    }
}
