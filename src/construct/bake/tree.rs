//! The bytes of a tree: header, nodes and primitives in one run.

use super::balls::balls;
use super::normal_slabs::normal_slabs;
use super::parts::parts;
use super::shape::{InOrder, TreeShape};
use super::wrap::wrap;
use crate::construct::error::BuildError;
use crate::construct::input::{Checked, Geometry, Record, bounding_box, corners_of};
use crate::construct::split::Assignment;
use crate::exact::round_up_f32;
use crate::frame::Frame;
use crate::hierarchy::{Bvh, Header, MAGIC, MAX_DEPTH, VERSION, rotation_growth};
use crate::key::{EMPTY, Storage};
use crate::node::{Child, Dop, NormalSlab};
use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use alloc::vec::Vec;

/// What a tree stores besides its planes.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Contents {
    pub(in crate::construct) leaf_size: u32,
    pub(in crate::construct) has_normal_slabs: bool,
    pub(in crate::construct) has_balls: bool,
    pub(in crate::construct) is_solid: bool,
}

/// Bakes the tree of a checked geometry.
pub(in crate::construct) fn bake<N: Dop, G: Geometry>(
    table: &Checked<'_, G::Primitive>,
    assignment: &Assignment,
    Contents { leaf_size, has_normal_slabs, has_balls, is_solid }: Contents,
) -> Result<Bvh<N, G::Primitive>, BuildError> {
    let shape: TreeShape<N> = TreeShape::new(assignment, leaf_size);
    if shape.depth > MAX_DEPTH {
        return Err(BuildError::TooDeep);
    }
    let InOrder { vertices, records } = InOrder::of(&table.vertices, &table.primitives, &shape.sources);
    // Only vertices that primitives use: an unused one far away would cost the others precision.
    let (low, high) = if vertices.is_empty() {
        ([0.0; 3], [0.0; 3])
    } else {
        bounding_box(vertices.iter().flat_map(G::Primitive::balls))
    };
    let frame = Frame::around(low, high, N::DIRECTIONS);
    let half_width = half_width::<G::Primitive>(&frame, &vertices);
    let mut nodes = shape.nodes;
    wrap::<N, G::Primitive>(&mut nodes, &frame, &vertices, &records);

    let mut normal_slabs =
        if has_normal_slabs { normal_slabs::<N, G>(&nodes, &frame, &vertices, &records) } else { Vec::new() };
    // Spheres have no normals, so all their slabs are infinite.
    if G::Primitive::IS_ROUND && normal_slabs.iter().all(|slab| *slab == NormalSlab::EVERYWHERE) {
        normal_slabs = Vec::new();
    }
    let with_normal_slabs = has_normal_slabs && normal_slabs.len() == nodes.len() * N::ARITY;
    let balls = if has_balls && G::Primitive::HAS_BALLS && N::ARITY == 16 {
        balls::<N, G::Primitive>(&nodes, &frame, half_width, &vertices, &records)
    } else {
        Vec::new()
    };
    // Each sphere is a part, which need not be listed.
    let parts = if G::Primitive::ARE_PARTS {
        Vec::new()
    } else {
        parts(&records, vertices.len(), || {
            vertices.iter().flat_map(G::Primitive::balls).map(|ball| ball.centre).collect()
        })
    };
    let mut corners = Vec::new();
    let mut is_degenerate = |record: &&Record<G>| {
        let radius = corners_of::<G::Primitive>(&vertices, record, &mut corners);
        G::is_degenerate(&corners, radius)
    };
    let degenerate_count = records.iter().filter(&mut is_degenerate).count() as u32;
    let single: Option<Vec<_>> = vertices.iter().map(G::Primitive::narrow).collect();
    let header = Header {
        magic: MAGIC,
        version: VERSION,
        k: N::K as u16,
        arity: N::ARITY as u16,
        kind: G::Primitive::KIND.code(),
        leaf_size: leaf_size as u16,
        depth: shape.depth as u32,
        node_count: nodes.len() as u32,
        primitive_count: records.len() as u32,
        vertex_count: vertices.len() as u32,
        degenerate_count,
        centre: frame.centre,
        max_coordinate: max_coordinate(low, high, &frame),
        radius: radius::<G::Primitive>(&frame, &vertices),
        exponent: frame.exponent,
        half_width,
        max_plane: max_plane(&nodes),
        rotation_growth: rotation_growth(&nodes),
        root: Child::root(0, half_width),
        vertex_size: match single {
            Some(_) => size_of::<<G::Primitive as Primitive>::Single>() as u16,
            None => size_of::<<G::Primitive as Primitive>::Double>() as u16,
        },
        has_normal_slabs: with_normal_slabs.into(),
        has_balls: (!balls.is_empty()).into(),
        is_solid: (is_solid && G::Primitive::BOUNDS_SOLIDS).into(),
        part_count: parts.len() as u32,
        storage: N::Storage::CODE,
        reserved: [0; 3],
    };
    let vertex_bytes: &[u8] = match &single {
        Some(single) => bytemuck::cast_slice(single),
        None => bytemuck::cast_slice(&vertices),
    };
    // Each with its alignment, in the order in which `Layout` reads them.
    Ok(Bvh::assemble(&[
        (64, bytemuck::bytes_of(&header)),
        (64, bytemuck::cast_slice(&nodes)),
        (1, bytemuck::cast_slice(&balls)),
        (8, bytemuck::cast_slice(&normal_slabs)),
        (8, vertex_bytes),
        (4, bytemuck::cast_slice(&records)),
        (4, bytemuck::cast_slice(&shape.sources)),
        (4, bytemuck::cast_slice(&parts)),
    ]))
}

/// The largest magnitude of a coordinate of a box, or of the centre of the frame around it.
fn max_coordinate(low: Point, high: Point, frame: &Frame) -> f64 {
    low.into_iter().chain(high).chain(frame.centre).map(f64::abs).fold(0.0, f64::max)
}

fn half_width<P: Primitive>(frame: &Frame, vertices: &[P::Double]) -> [f32; 3] {
    core::array::from_fn(|i| {
        let width = |Sphere { centre, radius }: Sphere| {
            ((centre[i] - frame.centre[i]) * frame.scale()).abs() + radius * frame.scale()
        };
        round_up_f32(vertices.iter().flat_map(P::balls).map(width).fold(0.0, f64::max))
    })
}

fn radius<P: Primitive>(frame: &Frame, vertices: &[P::Double]) -> f64 {
    let reach = |Sphere { centre, radius }: Sphere| frame.reach(centre, radius);
    vertices.iter().flat_map(P::balls).map(reach).fold(0.0, f64::max)
}

/// The largest magnitude of a plane. Codes are ordered as their values, so the least or the greatest code has it.
fn max_plane<N: Dop>(nodes: &[N]) -> f32 {
    let (mut least, mut greatest) = (0, 0);
    for node in nodes {
        for j in 0..N::K {
            for code in (0..N::ARITY).map(|lane| node.plane(j, lane)) {
                if code != EMPTY {
                    (least, greatest) = (code.min(least), code.max(greatest));
                }
            }
        }
    }
    N::Storage::value(least).abs().max(N::Storage::value(greatest))
}
