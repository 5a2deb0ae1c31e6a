//! Where the parts of a baked tree are.

use super::{FormatError, Header, MAGIC, VERSION};
use crate::key::Storage;
use crate::node::{Ball16, Node, NormalSlab};
use crate::primitive::{Primitive, Spheres, Store};
use core::mem::offset_of;

/// `?` for `Result` in constants, which do not support it.
macro_rules! attempt {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}

/// Offset and length of each part, computed from the header once.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Layout {
    pub(super) nodes: Part,
    pub(super) balls: Part,
    pub(super) normal_slabs: Part,
    pub(super) vertices: Part,
    pub(super) records: Part,
    /// The source indices of the primitives, then one primitive of each part.
    pub(super) indices: Part,
    /// The tree of the caps, then that of the packing.
    pub(super) attached: Part,
    pub(super) vertex_size: u16,
    /// Total length, a multiple of 64.
    pub(super) end: usize,
}

/// The counts in a header that determine the layout.
#[derive(Copy, Clone)]
pub(super) struct Counts {
    pub(super) nodes: u32,
    pub(super) has_normal_slabs: u16,
    pub(super) has_balls: u16,
    pub(super) vertices: u32,
    pub(super) vertex_size: u16,
    pub(super) primitives: u32,
    pub(super) parts: u32,
    pub(super) cap_lines: u16,
}

/// A range of bytes.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Part {
    start: usize,
    len: usize,
}

impl Part {
    /// `None` if the bytes end before the part does.
    #[inline(always)]
    pub(super) fn of(self, bytes: &[u8]) -> Option<&[u8]> {
        bytes.get(self.start..)?.get(..self.len)
    }

    /// The next part, of `count` items: after this one, at a multiple of `align`. On a 32-bit machine a tree may be too
    /// large to address.
    const fn then(self, count: u32, size: usize, align: usize) -> Result<Self, FormatError> {
        const TOO_LARGE: FormatError = FormatError::Header { field: "counts overflow the address space" };
        let Some(end) = self.start.checked_add(self.len) else { return Err(TOO_LARGE) };
        let Some(start) = end.checked_next_multiple_of(align) else { return Err(TOO_LARGE) };
        let Some(len) = (count as usize).checked_mul(size) else { return Err(TOO_LARGE) };
        if start.checked_add(len).is_none() { Err(TOO_LARGE) } else { Ok(Self { start, len }) }
    }
}

impl Layout {
    /// The layout of bytes that must be exactly one tree of these nodes and primitives. Also used in constants, so it
    /// reads the header byte by byte.
    pub(super) const fn of<N: Node, P: Primitive>(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut layout = attempt!(Self::without_packing::<N, P>(bytes));
        match bytes[offset_of!(Header, has_packing)] {
            0 => {}
            1 => {
                let own = layout.end;
                // The header of the packing has its length.
                let need = own.saturating_add(size_of::<Header>());
                if bytes.len() < need {
                    return Err(FormatError::Truncated { have: bytes.len(), need });
                }
                let packing = bytes.split_at(own).1;
                let len = match Self::without_packing::<N, Spheres>(packing) {
                    Ok(layout) if packing[offset_of!(Header, has_packing)] == 0 => layout.end,
                    _ => {
                        return Err(FormatError::Packing {
                            problem: "it is no tree of spheres of the same node type",
                        });
                    }
                };
                let Some(end) = own.checked_add(len) else {
                    return Err(FormatError::Header { field: "counts overflow the address space" });
                };
                layout.attached.len += len;
                layout.end = end;
            }
            _ => return Err(FormatError::Header { field: "has_packing" }),
        }
        let end = layout.end;
        if bytes.len() < end {
            return Err(FormatError::Truncated { have: bytes.len(), need: end });
        }
        if bytes.len() > end {
            return Err(FormatError::TooLong { have: bytes.len(), need: end });
        }
        Ok(layout)
    }

    /// The layout of the tree at the start of some bytes. Only its header must be present.
    const fn without_packing<N: Node, P: Primitive>(bytes: &[u8]) -> Result<Self, FormatError> {
        attempt!(begins_as_a_tree(bytes));
        let kind = u16_at(bytes, offset_of!(Header, kind));
        if kind != P::KIND.code() {
            return Err(FormatError::OtherPrimitive { kind });
        }
        let (k, arity) = (u16_at(bytes, offset_of!(Header, k)), u16_at(bytes, offset_of!(Header, arity)));
        if k as usize != N::K || arity as usize != N::ARITY {
            return Err(FormatError::OtherNode { k, arity });
        }
        let storage = u16_at(bytes, offset_of!(Header, storage));
        if storage != <N::Storage as Storage>::CODE {
            return Err(FormatError::OtherStorage { storage });
        }
        let vertex_size = u16_at(bytes, offset_of!(Header, vertex_size));
        if !Store::<P>::takes_vertices_of(vertex_size) {
            return Err(FormatError::Header { field: "vertex_size" });
        }
        // Checked here, since the following alignment holds only for nodes that can have balls.
        let has_balls = u16_at(bytes, offset_of!(Header, has_balls));
        if has_balls > 1 || has_balls == 1 && !(P::HAS_BALLS && N::ARITY == 16) {
            return Err(FormatError::Header { field: "has_balls" });
        }
        Self::of_counts::<N, P>(Counts {
            nodes: u32_at(bytes, offset_of!(Header, node_count)),
            has_normal_slabs: u16_at(bytes, offset_of!(Header, has_normal_slabs)),
            has_balls,
            vertices: u32_at(bytes, offset_of!(Header, vertex_count)),
            vertex_size,
            primitives: u32_at(bytes, offset_of!(Header, primitive_count)),
            parts: u32_at(bytes, offset_of!(Header, part_count)),
            cap_lines: u16_at(bytes, offset_of!(Header, cap_lines)),
        })
    }

    /// The layout of a tree with these counts, with or without normal slabs and balls; without a packing.
    pub(super) const fn of_counts<N: Node, P: Primitive>(counts: Counts) -> Result<Self, FormatError> {
        let Counts { nodes, has_normal_slabs, has_balls, vertices, vertex_size, .. } = counts;
        let Counts { primitives, parts, cap_lines, .. } = counts;
        let header = Part { start: 0, len: size_of::<Header>() };
        let with_slabs = if has_normal_slabs != 0 { nodes } else { 0 };
        let with_balls = if has_balls != 0 { nodes } else { 0 };
        let nodes = attempt!(header.then(nodes, size_of::<N>(), 64));
        // Nodes of sixteen lanes end at a multiple of 64.
        let balls = attempt!(nodes.then(with_balls, size_of::<Ball16>(), 1));
        let normal_slabs = attempt!(balls.then(with_slabs, N::ARITY * size_of::<NormalSlab>(), 8));
        let vertices = attempt!(normal_slabs.then(vertices, vertex_size as usize, 8));
        let records = attempt!(vertices.then(primitives, size_of::<P::Record>(), 4));
        let mut indices = attempt!(records.then(primitives, 4, 4));
        // No gap between the two.
        let parts = attempt!(indices.then(parts, 4, 4));
        indices.len += parts.len;
        let attached = attempt!(indices.then(cap_lines as u32, 64, 64));
        let end = attached.start + attached.len;
        Ok(Self { nodes, normal_slabs, balls, vertices, records, indices, attached, vertex_size, end })
    }
}

impl Header {
    /// The header of a baked tree of any node type; it gives the node type.
    ///
    /// # Errors
    /// [`FormatError`] if the bytes are misaligned, too short, no tree or of another version.
    pub fn read(bytes: &[u8]) -> Result<&Self, FormatError> {
        node_type(bytes)?;
        if bytes.as_ptr().align_offset(64) != 0 {
            return Err(FormatError::Misaligned);
        }
        bytemuck::try_from_bytes(&bytes[..size_of::<Self>()]).map_err(|_| FormatError::Misaligned)
    }
}

/// k, arity, and the codes of the storage and of the kind of primitive, from bytes of any alignment.
///
/// # Errors
/// As [`Header::read`].
pub(super) fn node_type(bytes: &[u8]) -> Result<[u16; 4], FormatError> {
    attempt!(begins_as_a_tree(bytes));
    let field = |at| u16_at(bytes, at);
    Ok([
        field(offset_of!(Header, k)),
        field(offset_of!(Header, arity)),
        field(offset_of!(Header, storage)),
        field(offset_of!(Header, kind)),
    ])
}

/// Magic number, length and version.
const fn begins_as_a_tree(bytes: &[u8]) -> Result<(), FormatError> {
    let need = size_of::<Header>();
    if !begins_with_magic(bytes) {
        return Err(FormatError::NotATree);
    }
    if bytes.len() < need {
        return Err(FormatError::Truncated { have: bytes.len(), need });
    }
    let version = u32_at(bytes, offset_of!(Header, version));
    if version != VERSION { Err(FormatError::Version { found: version }) } else { Ok(()) }
}

const fn begins_with_magic(bytes: &[u8]) -> bool {
    let mut i = 0;
    while i < MAGIC.len() {
        if i >= bytes.len() || bytes[i] != MAGIC[i] {
            return false;
        }
        i += 1;
    }
    true
}

const fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

const fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
