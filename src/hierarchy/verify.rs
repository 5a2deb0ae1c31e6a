//! Does every plane bound what is below it? Proved again, in exact arithmetic.

use super::{BvhRef, MAX_DEPTH};
use crate::key::Key;
use crate::node::{Link, Node};
use core::fmt;

/// A plane that cuts off a corner of a triangle below it: a collision could be missed.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct VerifyError {
    /// Index of the node.
    pub node: u32,
    /// Lane in the node.
    pub lane: u32,
    /// Index of the direction.
    pub plane: u32,
    /// Index of the triangle in the mesh that was built.
    pub triangle: u32,
}

impl fmt::Display for VerifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { node, lane, plane, triangle } = self;
        write!(f, "plane {plane} of node {node}, lane {lane} cuts off triangle {triangle} of the mesh")
    }
}

impl core::error::Error for VerifyError {}

impl<N: Node> BvhRef<'_, N> {
    /// Decides, for every triangle and every lane on the path to it, whether each plane is an upper bound of the exact support
    /// of the three corners. No rounding takes part: planes, corners, centre and direction are dyadic numbers, summed as
    /// expansions. Cost: triangles x depth x k.
    ///
    /// # Errors
    /// [`VerifyError`] names the first plane that is too low.
    pub fn verify(&self) -> Result<(), VerifyError> {
        if self.nodes().is_empty() {
            return Ok(());
        }
        let mut path = [(0_u32, 0_usize); MAX_DEPTH];
        let mut level = 1;
        while level > 0 {
            let (node, lane) = path[level - 1];
            let Some(child) = self.nodes()[node as usize].children().get(lane) else {
                level -= 1;
                continue;
            };
            path[level - 1].1 += 1;
            match child.link() {
                Link::Empty => {}
                Link::Inner(next) => {
                    path[level] = (next, 0);
                    level += 1;
                }
                Link::Leaf { first, count } => {
                    for triangle in first..first + count {
                        self.verify_path(&path[..level], triangle)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Checks one triangle against the lanes that lead to it. `path` holds the lane after the one taken.
    fn verify_path(&self, path: &[(u32, usize)], triangle: u32) -> Result<(), VerifyError> {
        let frame = self.frame();
        let corners = self.triangle(triangle);
        for &(node, next_lane) in path {
            let lane = next_lane - 1;
            for j in 0..N::K {
                // A code that is no plane bounds nothing: -0, NaN, or the mark of an unused lane.
                let key = Key::from_code(self.nodes()[node as usize].plane(j, lane));
                if !key.is_some_and(|key| corners.iter().all(|&p| N::bounds(&frame, j, p, key))) {
                    let (lane, plane) = (lane as u32, j as u32);
                    return Err(VerifyError { node, lane, plane, triangle: self.source(triangle) });
                }
            }
        }
        Ok(())
    }
}
