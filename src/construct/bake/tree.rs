//! The bytes of a tree: header, nodes and primitives in one run.

use super::balls::balls;
use super::normal_slabs::normal_slabs;
use super::parts::parts;
use super::shape::{InOrder, TreeShape};
use super::wrap::wrap;
use crate::construct::error::BuildError;
use crate::construct::input::{Caps, Checked, Geometry, Record, bounding_box, corners_of};
use crate::construct::split::{Assignment, Items, Splitter};
use crate::exact::round_up_f32;
use crate::frame::Frame;
use crate::hierarchy::{Bvh, Header, MAGIC, MAX_DEPTH, VERSION, rotation_growth};
use crate::key::{EMPTY, Storage};
use crate::node::{Child, Dop, NormalSlab};
use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use bytemuck::Zeroable;
use core::ops::ControlFlow;

/// What a tree stores besides its planes.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Contents<'c> {
    pub(in crate::construct) leaf_size: u32,
    pub(in crate::construct) has_normal_slabs: bool,
    pub(in crate::construct) has_balls: bool,
    pub(in crate::construct) is_solid: bool,
    pub(in crate::construct) caps: &'c Caps,
}

/// The data that the tree of the caps takes from the solid's tree.
struct OfSolid<'c> {
    frame: Frame,
    /// For each cap, the index in the solid's leaf order of a primitive at the border of its hole.
    beside: Vec<u32>,
    /// For each cap, the number of its hole.
    holes: &'c [u32],
}

/// Bakes the tree of a checked geometry.
pub(in crate::construct) fn bake<N: Dop, G: Geometry>(
    table: &Checked<'_, G::Primitive>,
    assignment: &Assignment,
    contents: Contents<'_>,
) -> Result<Bvh<N, G::Primitive>, BuildError> {
    bake_tree::<N, G>(table, assignment, contents, None)
}

/// Bakes the tree of a body, or of a solid's caps.
fn bake_tree<N: Dop, G: Geometry>(
    table: &Checked<'_, G::Primitive>,
    assignment: &Assignment,
    Contents { leaf_size, has_normal_slabs, has_balls, is_solid, caps }: Contents<'_>,
    of_solid: Option<&OfSolid<'_>>,
) -> Result<Bvh<N, G::Primitive>, BuildError> {
    let shape: TreeShape<N> = TreeShape::new(assignment, leaf_size);
    if shape.depth > MAX_DEPTH {
        return Err(BuildError::TooDeep);
    }
    let InOrder { vertices, records } = InOrder::of(&table.vertices, &table.primitives, &shape.sources);
    let (low, high) = bounds::<G::Primitive>(&vertices);
    let frame = of_solid.map_or_else(|| Frame::around(low, high, N::DIRECTIONS), |solid| solid.frame);
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
    let parts = if let Some(solid) = of_solid {
        firsts(&shape.sources, solid.holes)
    } else if G::Primitive::ARE_PARTS {
        Vec::new()
    } else {
        parts(&records, vertices.len(), || {
            vertices.iter().flat_map(G::Primitive::balls).map(|ball| ball.centre).collect()
        })
    };
    let sources = match of_solid {
        Some(solid) => shape.sources.iter().map(|&cap| solid.beside[cap as usize]).collect(),
        None => shape.sources,
    };
    let tree_of_caps = if caps.triangles.is_empty() {
        None
    } else {
        Some(bake_caps::<N, G>(table, caps, frame, &sources, leaf_size)?)
    };
    let cap_bytes = tree_of_caps.as_ref().map_or(&[][..], Bvh::as_bytes);
    let Ok(cap_lines) = u16::try_from(cap_bytes.len() / 64) else {
        return Err(BuildError::TooLarge { count: caps.triangles.len() });
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
        has_packing: 0,
        part_count: parts.len() as u32,
        storage: N::Storage::CODE,
        cap_lines,
        cap_width: round_up_f32(caps.stats.width * frame.scale()),
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
        (4, bytemuck::cast_slice(&sources)),
        (4, bytemuck::cast_slice(&parts)),
        (64, cap_bytes),
    ]))
}

/// Bakes the tree of the caps of a solid, whose leaf order `sources` gives.
fn bake_caps<N: Dop, G: Geometry>(
    table: &Checked<'_, G::Primitive>,
    caps: &Caps,
    frame: Frame,
    sources: &[u32],
    leaf_size: u32,
) -> Result<Bvh<N, G::Primitive>, BuildError> {
    let mut leaves = alloc::vec![0; sources.len()];
    (0..).zip(sources).for_each(|(leaf, &source)| leaves[source as usize] = leaf);
    let record = |corners: &[u32; 3]| {
        let mut record = Record::<G>::zeroed();
        record.as_mut().copy_from_slice(corners);
        record
    };
    let records: Vec<_> = caps.triangles.iter().map(record).collect();
    let table = Checked { vertices: table.vertices.clone(), primitives: Cow::Owned(records) };
    let splitter = Splitter::ExtendedLongestAxis;
    let mut go_on = |_| ControlFlow::Continue(());
    let assignment = Items::new::<G>(&table, splitter).split(splitter, leaf_size, N::ARITY, &mut go_on)?;
    let none = Caps::default();
    let contents =
        Contents { leaf_size, has_normal_slabs: false, has_balls: false, is_solid: false, caps: &none };
    let beside = caps.beside.iter().map(|&source| leaves[source as usize]).collect();
    bake_tree::<N, G>(&table, &assignment, contents, Some(&OfSolid { frame, beside, holes: &caps.holes }))
}

/// The first cap of each hole in leaf order, ascending. Empty if there is one hole.
fn firsts(sources: &[u32], holes: &[u32]) -> Vec<u32> {
    let count = holes.iter().fold(0, |count, hole| count.max(*hole as usize + 1));
    let mut is_seen = alloc::vec![false; count];
    let mut firsts: Vec<u32> = Vec::with_capacity(count);
    for (index, &cap) in (0..).zip(sources) {
        if !core::mem::replace(&mut is_seen[holes[cap as usize] as usize], true) {
            firsts.push(index);
        }
    }
    if count > 1 { firsts } else { Vec::new() }
}

/// The box around the vertices that primitives use: an unused one far away would cost the others precision.
fn bounds<P: Primitive>(vertices: &[P::Double]) -> (Point, Point) {
    if vertices.is_empty() { ([0.0; 3], [0.0; 3]) } else { bounding_box(vertices.iter().flat_map(P::balls)) }
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
