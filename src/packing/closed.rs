//! Checks of meshes, and the volume that they enclose.

use super::PackError;
use crate::construct::{Mesh, OpenEdge, Unclosed, check_closed};
use glam::DVec3;

/// Checks that a mesh can be filled, except for its volume.
pub(super) fn check(mesh: &Mesh<'_>) -> Result<(), PackError> {
    if mesh.triangles.is_empty() {
        return Err(PackError::Empty);
    }
    check_closed(mesh).map_err(|error| match error {
        Unclosed::Mesh(error) => PackError::Mesh(error),
        Unclosed::Open(OpenEdge { edge, corners, forward, backward }) => {
            PackError::Open { edge, corners, forward, backward }
        }
    })
}

/// A volume below this fraction of the tetrahedra's total volume is rounding: 2^-40.
const ROUNDING: f64 = f64::EPSILON * 4096.0;

/// The volume that closed triangles enclose, for either orientation: the sum of the signed tetrahedra with apex
/// `middle`.
pub(super) fn volume(triangles: &[[DVec3; 3]], middle: DVec3) -> Option<f64> {
    let (mut sum, mut magnitude) = (0.0_f64, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|p| p - middle);
        let six_fold = a.dot(b.cross(c));
        sum += six_fold;
        magnitude += six_fold.abs();
    }
    (sum.abs() > ROUNDING * magnitude).then_some(sum.abs() / 6.0)
}
