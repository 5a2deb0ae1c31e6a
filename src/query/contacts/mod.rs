//! Where two bodies of triangles touch: the intersections of pairs of triangles that meet, and the patches that they
//! form.

mod contact;
mod patch;

pub use contact::{Contacts, TriangleContact};
pub use patch::{ContactPatch, TooManyPatches, patches};

use super::entry::{Completion, Query, QueryStats};
use super::lanes::Lanes;
use crate::hierarchy::{AsBvh, with_bvhs};
use crate::pose::Pose;
use crate::primitive::{Primitive, Triangles};
use core::ops::ControlFlow;

impl Query {
    /// The intersections of all pairs of triangles that meet, with body `a` placed by `pose` in the frame of body `b`:
    /// [`Query::for_each_pair`] with the points in which they meet. Writes the contacts to the start of `into`, in the
    /// order in which they are found. If there are more, the query ends with [`Completion::Stopped`].
    ///
    /// A body that is inside a solid and meets none of its triangles has no contacts.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// use simdop::query::{Completion, TriangleContact, ContactPatch, patches};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// // The base of one tetrahedron is a little below the tip of the other.
    /// let on_top = Pose::from_rows([[1.0, 0.0, 0.0, -0.25], [0.0, 1.0, 0.0, -0.25], [0.0, 0.0, 1.0, 0.9]])?;
    /// let mut room = [TriangleContact::default(); 16];
    /// let found = Query::new(Isa::detect()).contacts(&body, &body, &on_top, &mut room);
    /// assert_eq!((found.count, found.completion), (3, Completion::Complete));
    ///
    /// let contacts = &mut room[..found.count];
    /// let mut room = [ContactPatch::default(); 4];
    /// assert_eq!(patches(contacts, &mut room), Ok(1));
    /// assert!(room[0].normal[2] > 0.99); // A has to rise.
    /// let mut points = [[0.0; 3]; 3];
    /// assert_eq!(room[0].span(contacts, &mut points), 3);
    /// assert!(points.iter().all(|p| (p[2] - 0.9).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts<A, B>(&self, a: &A, b: &B, pose: &Pose, into: &mut [TriangleContact]) -> Contacts
    where
        A: AsBvh<Primitive = Triangles, Node: Lanes>,
        B: AsBvh<Primitive = Triangles, Node = A::Node>,
    {
        let mut count = 0;
        let (completion, stats) = self.for_each_contact(a, b, pose, |contact| {
            let Some(place) = into.get_mut(count) else { return ControlFlow::Break(()) };
            *place = contact;
            count += 1;
            ControlFlow::Continue(())
        });
        Contacts { count, completion, stats }
    }

    /// Calls `visit` with each of the [contacts](Query::contacts), until it breaks. Returns how the search ended, and
    /// the query statistics.
    pub fn for_each_contact<A, B>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        mut visit: impl FnMut(TriangleContact) -> ControlFlow<()>,
    ) -> (Completion, QueryStats)
    where
        A: AsBvh<Primitive = Triangles, Node: Lanes>,
        B: AsBvh<Primitive = Triangles, Node = A::Node>,
    {
        with_bvhs(a, b, |a, b| {
            self.for_each_found(a, b, pose, &mut |found| {
                let moved = Triangles::moved(&a.primitive(found.a), pose);
                // All pairs found here meet.
                match TriangleContact::of(found.pair(a, b), &moved, &b.primitive(found.b)) {
                    Some(contact) => visit(contact),
                    None => ControlFlow::Continue(()),
                }
            })
        })
    }
}
