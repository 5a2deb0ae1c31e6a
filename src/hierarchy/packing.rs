//! The packing of a solid: spheres inside it, for penetration depth queries.
//!
//! They form a separate tree of the same node type, whose bytes follow those of the solid's tree and of its caps.

use super::BvhRef;
use super::layout::Layout;
use crate::node::Node;
use crate::primitive::{Primitive, Sphere, Spheres, sphere_against_triangle};

impl<'a, N: Node, P: Primitive> BvhRef<'a, N, P> {
    /// Whether the bytes have a packing.
    #[inline(always)]
    pub(crate) const fn has_packing(&self) -> bool {
        self.header.has_packing != 0
    }

    /// The bytes of the tree of the packing; empty without one.
    pub(super) fn packing_bytes(&self) -> &'a [u8] {
        self.attached.get(self.cap_bytes().len()..).unwrap_or_default()
    }

    /// The tree of the spheres inside the solid, if it has a packing: see
    /// [`Builder::add_packing`](crate::construct::Builder::add_packing). [`Query::depth`](crate::query::Query::depth)
    /// uses it.
    #[must_use]
    pub fn packing(&self) -> Option<BvhRef<'a, N, Spheres>> {
        if self.has_packing() { self.tree_of_packing() } else { None }
    }

    #[cold]
    fn tree_of_packing(&self) -> Option<BvhRef<'a, N, Spheres>> {
        let bytes = self.packing_bytes();
        // Validation accepts no bytes without a layout.
        BvhRef::of_layout(bytes, &Layout::of::<N, Spheres>(bytes).ok()?)
    }

    /// The index, in leaf order, of the first sphere that is not inside the solid: a triangle or a cap has a point in
    /// the open ball, or the surface does not wind around the centre. Exact.
    pub(crate) fn first_outside(&self, packing: &BvhRef<'_, N, Spheres>) -> Option<u32> {
        (0..packing.len() as u32).find(|&index| !self.contains(&packing.primitive(index)))
    }

    fn contains(&self, sphere: &Sphere) -> bool {
        let (mut winding, mut exact) = (0_i64, 0);
        let caps = self.caps();
        for tree in [Some(*self), caps].into_iter().flatten() {
            for index in 0..tree.len() as u32 {
                let item = tree.primitive(index);
                let mut corners = P::corners(&item);
                let (Some(p), Some(q), Some(r)) = (corners.next(), corners.next(), corners.next()) else {
                    return false;
                };
                if sphere_against_triangle::has_point_inside(sphere, &[p, q, r], &mut exact) {
                    return false;
                }
                winding += i64::from(P::crossing(&item, &sphere.centre, &mut exact));
            }
        }
        self.is_solid() && winding != 0
    }
}
