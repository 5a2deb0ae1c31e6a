//! Validation: whether bytes are safe to traverse. Baked trees are untrusted input.

use super::layout::Layout;
use super::{BvhRef, FormatError, Header, MAX_DEPTH};
use crate::exact::power_of_two;
use crate::frame::{BodyBounds, MAX_EXPONENT};
use crate::key::{EMPTY, Key, Storage};
use crate::node::{Ball16, BoundingBall, Child, Dop, Link, MAX_LEAF_SIZE, NormalSlab, Width};
use crate::primitive::{Fault, Primitive, Sphere, Store};
use crate::range::{MAX_COORDINATE, MAX_MOVED, flush};
use core::ops::Range;

impl<N: Dop, P: Primitive> BvhRef<'_, N, P> {
    /// Proves that no query can read out of range, loop, or overflow its stack, and that the header's bounds hold. In
    /// one pass, without memory:
    ///
    /// * nodes are in breadth-first order, so the links to nodes are 1, 2, 3 .. in the order of the lanes: each node
    ///   has one parent and is reachable, there are no cycles, and the levels can be counted;
    /// * primitives are in the order of the leaves, so the leaves' ranges follow each other likewise;
    /// * source indices are below the number of primitives, and the indices of the parts' primitives are valid and
    ///   ascend;
    /// * each plane of a used lane is a finite key, each plane of an unused one is [`Key::EMPTY`]; balls are finite and
    ///   no larger than the body;
    /// * the same holds for the tree of the caps, which is in the same frame, and whose vertices are in the same box;
    /// * the same holds for the tree of the packing, whose spheres are in the body's box.
    ///
    /// [`BvhRef::verify`] proves that the planes really bound the primitives.
    ///
    /// # Errors
    /// [`FormatError`] describes the first fault.
    pub fn validate(&self) -> Result<(), FormatError> {
        self.validate_tree(self.header.primitive_count)?;
        if self.has_caps() {
            self.validate_caps()?;
        }
        if self.has_packing() { self.validate_packing() } else { Ok(()) }
    }

    fn validate_packing(&self) -> Result<(), FormatError> {
        let wrong = |problem| Err(FormatError::Packing { problem });
        // Its node type and length are those of the layout.
        let Some(packing) = self.packing() else {
            return wrong("it is misaligned");
        };
        if packing.balls.is_empty() {
            return wrong("it has no balls, or is empty");
        }
        if packing.validate_tree(packing.header.primitive_count).is_err() {
            return wrong("its contents are invalid");
        }
        // Both boxes are rounded up, and their centres to nearest.
        let rounding = power_of_two(-48) * self.header.max_coordinate;
        let [(inner, width), (outer, most)] = [packing.header, self.header]
            .map(|h| (h.centre, h.half_width.map(|x| f64::from(x) / h.extent().frame.scale())));
        let is_in_box = (0..3).all(|i| {
            (inner[i] - outer[i]).abs() + width[i] <= most[i] * (1.0 + power_of_two(-20)) + rounding
        });
        if is_in_box { Ok(()) } else { wrong("its box is not in the solid's") }
    }

    fn validate_caps(&self) -> Result<(), FormatError> {
        let wrong = |problem| Err(FormatError::Caps { problem });
        let bytes = self.cap_bytes();
        let Ok(layout) = Layout::of::<N, P>(bytes) else {
            return wrong("it is no tree of the same node type and length");
        };
        let Some(caps) = Self::of_layout(bytes, &layout) else { return wrong("it is misaligned") };
        let (own, whole) = (caps.header, self.header);
        if own.is_solid != 0 || own.cap_lines != 0 || own.has_packing != 0 || own.primitive_count == 0 {
            return wrong("it is a solid, or empty");
        }
        if own.centre != whole.centre || own.exponent != whole.exponent {
            return wrong("it has another frame");
        }
        if caps.validate_tree(whole.primitive_count).is_err() {
            return wrong("its contents are invalid");
        }
        // The inside test casts rays no longer than the solid's box is wide.
        if self.validate_vertices(&caps.store).is_err() {
            return wrong("a vertex is outside of the solid's box");
        }
        Ok(())
    }

    /// Validates all but the caps and the packing. Source indices must be below `source_count`.
    fn validate_tree(&self, source_count: u32) -> Result<(), FormatError> {
        validate_header(self.header, P::BOUNDS_SOLIDS, P::ARE_PARTS)?;
        let Self { header, nodes, normal_slabs, balls, .. } = *self;
        NodeParts { header, nodes, normal_slabs, balls }.validate()?;
        self.validate_vertices(&self.store)?;
        let (sources, parts) = self.indices.split_at(self.len());
        if let Some(index) = sources.iter().position(|&source| source >= source_count) {
            return Err(FormatError::Source { index: index as u32 });
        }
        let mut next = 0;
        for (index, &part) in (0..).zip(parts) {
            if part < next || part >= self.header.primitive_count {
                return Err(FormatError::Part { index });
            }
            next = part + 1;
        }
        Ok(())
    }

    /// Validates a store, whose vertices must be within the bounds of the body.
    fn validate_vertices(&self, store: &Store<'_, P>) -> Result<(), FormatError> {
        let BodyBounds { frame, max_coordinate, half_width, .. } = self.extent();
        let scale = frame.scale();
        let is_inside = |Sphere { centre: p, radius }: Sphere| {
            let reach = radius * scale;
            // Comparisons with NaN are false.
            (radius >= 0.0 && flush(radius) == radius)
                && p.iter().all(|&x| x.abs() + radius <= max_coordinate && flush(x) == x)
                && (0..3)
                    .all(|i| ((p[i] - frame.centre[i]) * scale).abs() + reach <= f64::from(half_width[i]))
                && frame.is_in_reach(p, radius, self.header.radius)
        };
        store.check(|vertex| P::balls(vertex).all(is_inside)).map_err(|fault| match fault {
            Fault::Vertex { index } => FormatError::Vertex { index },
            Fault::Primitive { index } => FormatError::Primitive { index },
        })
    }
}

/// Not generic, so that it is compiled once.
fn validate_header(h: &Header, bounds_solids: bool, are_parts: bool) -> Result<(), FormatError> {
    let checks = [
        ("leaf_size", (1..=MAX_LEAF_SIZE).contains(&h.leaf_size.into())),
        ("primitive_count", h.primitive_count <= Child::MAX_PRIMITIVES),
        ("node_count", (h.node_count == 0) == (h.primitive_count == 0) && h.node_count <= h.primitive_count),
        ("depth", h.depth as usize <= MAX_DEPTH),
        ("degenerate_count", h.degenerate_count <= h.primitive_count),
        ("centre", h.centre.iter().all(|c| c.abs() <= MAX_COORDINATE)),
        (
            "max_coordinate",
            h.max_coordinate <= MAX_COORDINATE && h.centre.iter().all(|c| c.abs() <= h.max_coordinate),
        ),
        ("radius", (0.0..=MAX_MOVED).contains(&h.radius)),
        ("exponent", (-MAX_EXPONENT..=MAX_EXPONENT).contains(&h.exponent)),
        ("half_width", h.half_width.iter().all(|w| *w >= 0.0 && w.is_finite())),
        ("max_plane", h.max_plane >= 0.0 && h.max_plane.is_finite()),
        // Any such number is safe: it affects only speed.
        ("rotation_growth", h.rotation_growth >= 0.0 && h.rotation_growth.is_finite()),
        ("root", h.root == Child::root(0, h.half_width)),
        ("has_normal_slabs", h.has_normal_slabs <= 1),
        ("is_solid", h.is_solid == 0 || h.is_solid == 1 && bounds_solids),
        ("has_packing", h.has_packing == 0 || h.has_packing == 1 && h.is_solid == 1),
        ("part_count", h.part_count == 0 || !are_parts && (2..=h.primitive_count).contains(&h.part_count)),
        ("cap_lines", h.cap_lines == 0 || h.is_solid == 1),
        (
            "cap_width",
            if h.cap_lines == 0 {
                h.cap_width.to_bits() == 0
            } else {
                h.cap_width > 0.0 && h.cap_width.is_finite()
            },
        ),
    ];
    match checks.iter().find(|(_, ok)| !ok) {
        Some((field, _)) => Err(FormatError::Header { field }),
        None => Ok(()),
    }
}

/// The parts of a tree that do not depend on its kind of primitive, to compile their validation once for all kinds.
struct NodeParts<'a, N> {
    header: &'a Header,
    nodes: &'a [N],
    normal_slabs: &'a [NormalSlab],
    balls: &'a [Ball16],
}

impl<N: Dop> NodeParts<'_, N> {
    fn validate(&self) -> Result<(), FormatError> {
        let (mut next_node, mut next_primitive) = (1, 0);
        let (mut levels, mut level_end) = (0, 0);
        for (index, node) in (0_u32..).zip(self.nodes) {
            let error = |lane: usize, problem| FormatError::Node { node: index, lane: lane as u32, problem };
            if index == level_end {
                levels += 1;
                level_end = next_node;
            }
            if index >= next_node {
                return Err(error(0, "no link leads to this node"));
            }
            for (lane, child) in node.children().iter().enumerate() {
                self.validate_volume(index, lane, self.header.max_plane)
                    .map_err(|problem| error(lane, problem))?;
                if !self.is_ball_valid(index, lane, *child) {
                    return Err(error(lane, "a ball is not finite, or larger than the body"));
                }
                match child.link() {
                    Link::Empty => {}
                    Link::Inner(target) => {
                        let unlinked = next_node..self.header.node_count;
                        validate_target(node, lane, target, unlinked)
                            .map_err(|problem| error(lane, problem))?;
                        next_node += 1;
                    }
                    Link::Leaf { first, count } => {
                        let fits = count <= self.header.leaf_size.into();
                        if first != next_primitive || count > self.header.primitive_count - first || !fits {
                            return Err(error(lane, "the leaf's range is out of order or too large"));
                        }
                        next_primitive += count;
                    }
                }
            }
        }
        let all_nodes = self.nodes.is_empty() || next_node == self.header.node_count;
        if !all_nodes || next_primitive != self.header.primitive_count {
            return Err(FormatError::Header { field: "node_count or primitive_count: not all are linked" });
        }
        if levels == self.header.depth { Ok(()) } else { Err(FormatError::Header { field: "depth" }) }
    }

    /// Validates the planes of a lane and its normal slab.
    fn validate_volume(&self, index: u32, lane: usize, max_plane: f32) -> Result<(), &'static str> {
        let node = &self.nodes[index as usize];
        let empty = node.children()[lane] == Child::EMPTY;
        for j in 0..N::K {
            let code = node.plane(j, lane);
            if empty {
                if code != EMPTY {
                    return Err("an unused lane has a plane");
                }
            } else if Key::<N::Storage>::from_code(code).is_none() {
                return Err("a plane is infinite, or has the code of unused lanes");
            } else if N::Storage::value(code).abs() > max_plane {
                return Err("a plane is beyond max_plane");
            }
        }
        if self.normal_slabs.get(index as usize * N::ARITY + lane).is_some_and(|slab| !slab.is_valid()) {
            return Err("a normal slab has no direction, or no thickness");
        }
        Ok(())
    }

    /// Whether the ball of a lane is no larger than the body, or empty if the lane is unused. True for trees without
    /// balls.
    fn is_ball_valid(&self, node: u32, lane: usize, child: Child) -> bool {
        let Some(balls) = self.balls.get(node as usize) else { return true };
        let ball = balls.lane(lane);
        if child == Child::EMPTY {
            return ball.is_empty();
        }
        let BoundingBall { centre, radius, volume } = ball;
        // Comparisons with NaN are false. The term 2^-30 is for bodies that consist of one point: rounding makes their
        // radius positive.
        let most = self.header.extent().width_sum() * (1.0 + power_of_two(-10)) + power_of_two(-30);
        centre.iter().zip(self.header.half_width).all(|(x, most)| x.abs() <= most)
            && (radius >= 0.0 && f64::from(radius) <= most)
            && (volume >= 0.0 && volume.is_finite())
    }
}

/// Validates that a lane's link leads to the next node in breadth-first order, and has the width of the lane's volume.
pub(super) fn validate_target<N: Dop>(
    node: &N,
    lane: usize,
    target: u32,
    unlinked: Range<u32>,
) -> Result<(), &'static str> {
    if target != unlinked.start || target >= unlinked.end {
        return Err("the link to a node is out of breadth-first order");
    }
    let child = node.children()[lane];
    if child.width() != Width::of_lane(node, lane) {
        return Err("the width in a link is not that of its planes");
    }
    Ok(())
}
