//! The balls of a tree of spheres.

use super::corners_below::CornersBelow;
use super::enclosing::smallest_enclosing;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::Frame;
use crate::node::{Ball16, BoundingBall, Link, Node};
use crate::parallel;
use crate::primitive::{Primitive, Sphere, sphere};
use crate::vector::sqrt;
use alloc::vec::Vec;

/// The balls of all lanes, in the frame. Each is the smallest ball around the spheres below, up to rounding, which only
/// enlarges it.
pub(super) fn balls<N: Node, P: Primitive<Record: AsRef<[u32]>>>(
    nodes: &[N],
    frame: &Frame,
    half_width: [f32; 3],
    vertices: &[P::Double],
    records: &[P::Record],
) -> Vec<Ball16> {
    let volumes = volumes::<N, P>(nodes, frame, vertices, records);
    let spheres = CornersBelow::<P>::new(nodes, vertices, records);
    let mut balls = alloc::vec![Ball16::EMPTY; nodes.len()];
    parallel::for_each_chunk(&mut balls, NODES_PER_TASK, |task, balls| {
        let mut below = Vec::new();
        for (index, balls) in (task * NODES_PER_TASK..).zip(balls) {
            for (lane, child) in nodes[index].children().iter().enumerate() {
                below.clear();
                match child.link() {
                    Link::Empty => continue,
                    Link::Inner(node) => {
                        below.extend(
                            spheres.below(node).iter().flat_map(P::balls).map(|ball| in_frame(frame, &ball)),
                        );
                    }
                    Link::Leaf { first, count } => {
                        for record in &records[first as usize..][..count as usize] {
                            let vertices = record.as_ref().iter().map(|&vertex| &vertices[vertex as usize]);
                            below.extend(vertices.flat_map(P::balls).map(|ball| in_frame(frame, &ball)));
                        }
                    }
                }
                // The packer sums in `f64`, with a few dozen roundings.
                let volume = round_up_f32(volumes[index * N::ARITY + lane] * (1.0 + power_of_two(-40)));
                balls.set(lane, &BoundingBall { volume, ..around(&below, half_width) });
            }
        }
    });
    balls
}

const NODES_PER_TASK: usize = 16;

fn in_frame(frame: &Frame, ball: &Sphere) -> Sphere {
    let scale = frame.scale();
    let centre = core::array::from_fn(|i| (ball.centre[i] - frame.centre[i]) * scale);
    Sphere { centre, radius: ball.radius * scale }
}

/// A ball around some spheres, with its centre in single precision.
fn around(spheres: &[Sphere], half_width: [f32; 3]) -> BoundingBall {
    let smallest = smallest_enclosing(spheres);
    // The centre lies within the body, and must stay there after rounding.
    let centre: [f32; 3] =
        core::array::from_fn(|i| (smallest[i] as f32).clamp(-half_width[i], half_width[i]));
    let reach = |sphere: &Sphere| {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| sphere.centre[i] - f64::from(centre[i]));
        sqrt((x * x + y * y) + z * z) + sphere.radius
    };
    let radius = spheres.iter().map(reach).fold(0.0, f64::max);
    // Allowance for a few roundings of coordinates below 2^16.
    let rounding = power_of_two(-32);
    BoundingBall { centre, radius: round_up_f32(radius * (1.0 + rounding) + rounding), volume: 0.0 }
}

/// The total volume of the spheres below each lane, in the unit of the frame.
fn volumes<N: Node, P: Primitive<Record: AsRef<[u32]>>>(
    nodes: &[N],
    frame: &Frame,
    vertices: &[P::Double],
    records: &[P::Record],
) -> Vec<f64> {
    let mut volumes = alloc::vec![0.0; nodes.len() * N::ARITY];
    // Children come after their parents.
    for node in (0..nodes.len()).rev() {
        for (lane, child) in nodes[node].children().iter().enumerate() {
            volumes[node * N::ARITY + lane] = match child.link() {
                Link::Empty => 0.0,
                Link::Inner(below) => volumes[below as usize * N::ARITY..][..N::ARITY].iter().sum(),
                Link::Leaf { first, count } => {
                    let records = records[first as usize..][..count as usize].iter();
                    let used = records.flat_map(|record| record.as_ref());
                    let radii = |&vertex: &u32| P::balls(&vertices[vertex as usize]).map(|ball| ball.radius);
                    used.flat_map(radii).map(|radius| sphere::volume(radius * frame.scale())).sum()
                }
            };
        }
    }
    volumes
}
