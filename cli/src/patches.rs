//! Where two meshes touch, for `simdop collide --contacts`.

use super::body::{Body, SAME};
use serde::Serialize;
use simdop::pose::Pose;
use simdop::query::{Completion, ContactPatch, Query, TriangleContact, patches};
use std::io::Write;

/// Maximum number of points that span a patch.
const POINTS: usize = 4;

#[derive(Serialize)]
pub(super) struct PatchReport {
    /// Number of pairs of triangles.
    contacts: usize,
    /// The direction in which A moves out of B, in B's frame.
    normal: [f64; 3],
    /// How far A must move in that direction. Null without a direction.
    depth: Option<f64>,
    /// Total length of the segments in which triangles meet.
    length: f64,
    /// Area of the polygons of triangles in one plane; otherwise the area that the segments enclose.
    area: f64,
    /// Points that span the patch.
    points: Vec<[f64; 3]>,
}

/// The patches at a pose, the one with the most contacts first.
pub(super) fn find(query: &Query, [a, b]: &[Body; 2], pose: &Pose) -> Vec<PatchReport> {
    let (a, b) = (a.tree.view(), b.tree.view());
    let mut contacts = vec![TriangleContact::default(); 1024];
    let mut found = query.contacts_any(&a, &b, pose, &mut contacts).expect(SAME);
    while found.completion == Completion::Stopped {
        contacts = vec![TriangleContact::default(); 4 * contacts.len()];
        found = query.contacts_any(&a, &b, pose, &mut contacts).expect(SAME);
    }
    let contacts = &mut contacts[..found.count];
    // There are at most as many patches as contacts.
    let mut all = vec![ContactPatch::default(); contacts.len()];
    let count = patches(contacts, &mut all).unwrap_or(0);
    let report = |patch: &ContactPatch| {
        let mut points = [[0.0; 3]; POINTS];
        let spanned = patch.span(contacts, &mut points);
        let (depth, _) = query.depth_along_any(&a, &b, pose, patch.normal).expect(SAME);
        PatchReport {
            contacts: patch.count,
            normal: patch.normal,
            depth: depth.is_finite().then_some(depth),
            length: patch.length,
            area: patch.area,
            points: points[..spanned].to_vec(),
        }
    };
    all[..count].iter().map(report).collect()
}

impl PatchReport {
    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        let Self { contacts, normal, depth, length, area, points } = self;
        // Avoids a minus sign in front of a printed zero.
        let [x, y, z] = normal.map(|x| if x.abs() < 5e-7 { 0.0 } else { x });
        write!(out, "        {contacts} pairs, normal {x:.6} {y:.6} {z:.6}, ")?;
        if let Some(depth) = depth {
            write!(out, "depth {depth:.6e}, ")?;
        }
        write!(out, "length {length:.6e}, area {area:.6e}, at")?;
        for [x, y, z] in points {
            write!(out, " ({x:.9} {y:.9} {z:.9})")?;
        }
        writeln!(out)
    }
}
