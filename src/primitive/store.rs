//! Primitives as a baked tree stores them, read in place.

use super::Primitive;

/// A table of vertices: in single precision where that is exact, else in double.
#[derive(Debug)]
enum Vertices<'a, P: Primitive> {
    Single(&'a [P::Single]),
    Double(&'a [P::Double]),
}

/// The vertices of a tree, and a record for each primitive that lists its vertices.
#[derive(Debug)]
pub struct Store<'a, P: Primitive> {
    vertices: Vertices<'a, P>,
    records: &'a [P::Record],
}

impl<P: Primitive> Copy for Vertices<'_, P> {}
impl<P: Primitive> Clone for Vertices<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P: Primitive> Copy for Store<'_, P> {}
impl<P: Primitive> Clone for Store<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

/// Why a store is invalid.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Fault {
    /// A vertex is not accepted.
    Vertex { index: u32 },
    /// A primitive refers to a vertex that does not exist.
    Primitive { index: u32 },
}

impl<'a, P: Primitive> Store<'a, P> {
    /// Whether `size` is a valid size of a vertex in bytes.
    pub(crate) const fn takes_vertices_of(size: u16) -> bool {
        size as usize == size_of::<P::Single>() || size as usize == size_of::<P::Double>()
    }

    /// Reads a store in place. `None` if the bytes are misaligned or not a whole number of vertices and records.
    #[inline(always)]
    pub(crate) fn read(vertex_size: u16, vertices: &'a [u8], records: &'a [u8]) -> Option<Self> {
        let vertices = if usize::from(vertex_size) == size_of::<P::Single>() {
            Vertices::Single(bytemuck::try_cast_slice(vertices).ok()?)
        } else {
            Vertices::Double(bytemuck::try_cast_slice(vertices).ok()?)
        };
        Some(Self { vertices, records: bytemuck::try_cast_slice(records).ok()? })
    }

    /// Checks that every primitive's vertices exist, and that `accepts` holds for all vertices.
    pub(crate) fn check(&self, accepts: impl Fn(&P::Double) -> bool) -> Result<(), Fault> {
        let count = match self.vertices {
            Vertices::Single(all) => all.len(),
            Vertices::Double(all) => all.len(),
        } as u32;
        if let Some(index) = (0..count).find(|&index| !accepts(&self.vertex(index))) {
            return Err(Fault::Vertex { index });
        }
        match self.records.iter().position(|record| !P::is_among(record, count)) {
            Some(index) => Err(Fault::Primitive { index: index as u32 }),
            None => Ok(()),
        }
    }

    /// The record of primitive `index`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    #[must_use]
    pub const fn record(&self, index: u32) -> &'a P::Record {
        &self.records[index as usize]
    }

    /// Applies one function or the other to the vertex at `index`, depending on its stored precision.
    #[inline(always)]
    pub(crate) fn vertex_by<R>(
        &self,
        index: u32,
        single: impl Fn(&P::Single) -> R,
        double: impl Fn(&P::Double) -> R,
    ) -> R {
        match self.vertices {
            Vertices::Single(all) => single(&all[index as usize]),
            Vertices::Double(all) => double(&all[index as usize]),
        }
    }

    /// The vertex at `index`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    #[must_use]
    pub fn vertex(&self, index: u32) -> P::Double {
        match self.vertices {
            Vertices::Single(all) => P::widen(all[index as usize]),
            Vertices::Double(all) => all[index as usize],
        }
    }
}
