//! Caps: triangles that close the holes of a mesh.
//!
//! Vertices with equal coordinates are joined. The weight of an edge is the number of triangles that run along it in
//! one direction, minus those in the other. The edges with their weights are a 1-chain, the border of the surface. The
//! border of a border is zero, so as many edges lead to each vertex as away from it, and the chain decomposes into
//! loops that pass no vertex twice. The border of a fan of triangles, from one vertex of a loop to its edges, is the
//! loop. So the surface together with the opposite of all fans has no border, and its winding number around a point is
//! an integer that does not depend on the ray by which it is counted. This holds for any surface: an edge of three
//! triangles, or of two with opposite orientations, simply is part of the border.

use super::closed::first_at_place;
use super::geometry::Mesh;
use super::ranges::{check_records, check_vertices};
#[cfg(doc)]
use crate::construct::Builder;
use crate::construct::error::BuildError;
use crate::frame::scale_to_one;
use crate::hierarchy::CapStats;
use crate::primitive::Triangles;
use crate::range::Point;
use crate::vector::{cross, difference, length};
use alloc::vec::Vec;
use core::cmp::Ordering;

/// Maximum number of triangles in the caps of a mesh.
const MOST: usize = 1 << 14;

/// Triangles that close the holes of a mesh: [`Mesh::caps`].
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Caps {
    /// Indices of the corners; of vertices with equal coordinates, the first.
    pub triangles: Vec<[u32; 3]>,
    /// What was capped.
    pub stats: CapStats,
    /// For each cap, the first triangle of the mesh at an edge of its hole.
    pub(in crate::construct) beside: Vec<u32>,
    /// For each cap, the number of its hole.
    pub(in crate::construct) holes: Vec<u32>,
}

impl Mesh<'_> {
    /// The triangles that close the holes of this mesh, if no hole is wider than `width`. The width of a hole is the
    /// greatest distance between two corners of its border, in the mesh's unit. A closed mesh gives no triangles.
    /// [`Builder::solid_with_caps`] defines holes and caps.
    ///
    /// Together with the triangles of this mesh they are a closed mesh, which may be packed or covered.
    ///
    /// ```
    /// use simdop::construct::{Mesh, OwnedMesh};
    /// use simdop::packing::{PackError, Packer};
    ///
    /// let mut cube = OwnedMesh::cuboid([1.0; 3])?;
    /// cube.triangles.truncate(10);
    /// assert!(matches!(Packer::new().pack(&cube.as_mesh()), Err(PackError::Open { .. })));
    ///
    /// let caps = cube.as_mesh().caps(1.5)?;
    /// assert_eq!((caps.stats.holes, caps.stats.width, caps.triangles.len()), (1, 2.0_f64.sqrt(), 2));
    /// cube.triangles.extend(caps.triangles);
    /// assert_eq!(Packer::new().spheres(1).pack(&cube.as_mesh())?.volume, 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError::Hole`], [`BuildError::TooManyCaps`]; other [`BuildError`]s if the mesh is invalid.
    pub fn caps(&self, width: f64) -> Result<Caps, BuildError> {
        check_vertices::<Triangles>(self.vertices)?;
        check_records(self.triangles, self.vertices.len())?;
        caps(self.vertices, self.triangles.iter().copied(), width)
    }
}

/// The caps of valid triangles.
pub(in crate::construct) fn caps(
    vertices: &[Point],
    triangles: impl Iterator<Item = [u32; 3]>,
    width: f64,
) -> Result<Caps, BuildError> {
    let loops = Border::of(vertices, triangles).loops();
    let widths = widths(vertices, &loops, width)?;
    let mut caps = Caps::default();
    for ((hole, around), width) in (0..).zip(&loops).zip(widths) {
        let apex = best_apex(vertices, around, width);
        let corner = |i: usize| around[(apex + i) % around.len()];
        for i in 1..around.len() - 1 {
            let edge = corner(i);
            caps.triangles.push([corner(0).from, edge.from, edge.to]);
            caps.beside.push(edge.beside);
            caps.holes.push(hole);
        }
        caps.stats.width = caps.stats.width.max(width);
    }
    (caps.stats.holes, caps.stats.triangles) = (loops.len(), caps.triangles.len());
    Ok(caps)
}

/// A directed edge of the border of the caps.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct BorderEdge {
    from: u32,
    to: u32,
    /// The first triangle of the surface along it.
    beside: u32,
}

/// The border that caps must have, sorted. An edge occurs as many times as its weight.
struct Border(Vec<BorderEdge>);

/// A closed path along edges, which passes no vertex twice.
type Loop = Vec<BorderEdge>;

impl Border {
    fn of(vertices: &[Point], triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let first = first_at_place(vertices);
        // Each edge with the direction in which a triangle runs along it, and the triangle.
        let mut along: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(3 * triangles.size_hint().0);
        for (index, corners) in (0..).zip(triangles) {
            let t = corners.map(|v| first[v as usize]);
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                match a.cmp(&b) {
                    Ordering::Less => along.push(([a, b], true, index)),
                    Ordering::Greater => along.push(([b, a], false, index)),
                    // An edge of a degenerate triangle: it has no direction.
                    Ordering::Equal => {}
                }
            }
        }
        along.sort_unstable();
        let mut edges = Vec::new();
        for run in along.chunk_by(|x, y| x.0 == y.0) {
            let forward = run.iter().filter(|(_, is_forward, _)| *is_forward).count();
            let (weight, [low, high]) = (2 * forward as isize - run.len() as isize, run[0].0);
            // Caps run in the opposite direction.
            let (from, to) = if weight > 0 { (high, low) } else { (low, high) };
            let beside = run.iter().fold(u32::MAX, |beside, (_, _, index)| beside.min(*index));
            edges.extend(core::iter::repeat_n(BorderEdge { from, to, beside }, weight.unsigned_abs()));
        }
        edges.sort_unstable();
        Self(edges)
    }

    /// Loops whose sum is the border. At a vertex with several outgoing edges they follow the lowest first.
    fn loops(&self) -> Vec<Loop> {
        const NOWHERE: usize = usize::MAX;
        let edges = &self.0;
        let starts = |vertex: u32| edges.partition_point(|edge| edge.from < vertex);
        let mut is_taken = alloc::vec![false; edges.len()];
        // For each vertex, by the number of its first edge, the place on the path of the edge that leaves it.
        let mut places = alloc::vec![NOWHERE; edges.len()];
        let (mut loops, mut path): (Vec<Loop>, Vec<usize>) = (Vec::new(), Vec::new());
        for start in 0..edges.len() {
            let mut next = (!is_taken[start]).then_some(start);
            while let Some(edge) = next {
                is_taken[edge] = true;
                places[starts(edges[edge].from)] = path.len();
                path.push(edge);
                let here = starts(edges[edge].to);
                if places[here] != NOWHERE {
                    // The path returns to one of its vertices: the part since then is a loop.
                    let around: Loop = path.drain(places[here]..).map(|edge| edges[edge]).collect();
                    around.iter().for_each(|edge| places[starts(edge.from)] = NOWHERE);
                    loops.push(around);
                    if path.is_empty() {
                        break;
                    }
                }
                // As many edges lead to a vertex as away from it, so an edge is left unless the path is back at its
                // start.
                let of_vertex = |edge: &usize| edges[*edge].from == edges[here].from;
                next = (here..edges.len()).take_while(of_vertex).find(|&edge| !is_taken[edge]);
            }
        }
        loops
    }
}

/// The widths of loops, if none is too wide.
fn widths(vertices: &[Point], loops: &[Loop], limit: f64) -> Result<Vec<f64>, BuildError> {
    let named = |around: &Loop| {
        let edge = [around[0].from.min(around[0].to), around[0].from.max(around[0].to)];
        (edge, edge.map(|v| vertices[v as usize]))
    };
    let count = loops.iter().map(|around| around.len() - 2).sum();
    if count > MOST {
        let longest = loops.iter().reduce(|most, next| if next.len() > most.len() { next } else { most });
        let (edge, corners) = longest.map_or(([0; 2], [[0.0; 3]; 2]), named);
        return Err(BuildError::TooManyCaps { count, edge, corners });
    }
    let widths: Vec<f64> = loops.iter().map(|around| width_of(vertices, around)).collect();
    let widest = (0..loops.len()).reduce(|most, next| if widths[next] > widths[most] { next } else { most });
    match widest {
        Some(widest) if widths[widest] > limit || limit.is_nan() => {
            let (edge, corners) = named(&loops[widest]);
            Err(BuildError::Hole { edge, corners, width: widths[widest], limit })
        }
        _ => Ok(widths),
    }
}

/// The greatest distance between two corners of a loop.
fn width_of(vertices: &[Point], around: &[BorderEdge]) -> f64 {
    let corner = |edge: &BorderEdge| vertices[edge.from as usize];
    let distances = around.iter().enumerate().flat_map(|(i, first)| {
        around[i + 1..].iter().map(move |second| length(&difference(&corner(first), &corner(second))))
    });
    distances.fold(0.0, f64::max)
}

/// The vertex of a loop whose fan has the least area; the first of several.
fn best_apex(vertices: &[Point], around: &[BorderEdge], width: f64) -> usize {
    let scale = scale_to_one(width);
    let origin = vertices[around[0].from as usize];
    let local = |edge: &BorderEdge| difference(&vertices[edge.from as usize], &origin).map(|x| x * scale);
    let corners: Vec<Point> = around.iter().map(local).collect();
    let area = |apex: usize| -> f64 {
        let ways =
            (1..corners.len()).map(|i| difference(&corners[(apex + i) % corners.len()], &corners[apex]));
        let ways: Vec<Point> = ways.collect();
        ways.windows(2).map(|pair| length(&cross(&pair[0], &pair[1]))).sum()
    };
    let mut best = (0, area(0));
    for apex in 1..corners.len() {
        let area = area(apex);
        if area < best.1 {
            best = (apex, area);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn edge(from: u32, to: u32) -> BorderEdge {
        BorderEdge { from, to, beside: 0 }
    }

    /// Every edge is in one loop, and no loop passes a vertex twice.
    fn check_loops(mut edges: Vec<BorderEdge>) -> Vec<usize> {
        edges.sort_unstable();
        let border = Border(edges);
        let loops = border.loops();
        let mut all: Vec<BorderEdge> = loops.concat();
        all.sort_unstable();
        assert_eq!(all, border.0);
        for around in &loops {
            for (i, edge) in around.iter().enumerate() {
                assert_eq!(edge.to, around[(i + 1) % around.len()].from);
                assert!(around[..i].iter().all(|before| before.from != edge.from));
            }
        }
        let mut lengths: Vec<usize> = loops.iter().map(Vec::len).collect();
        lengths.sort_unstable();
        lengths
    }

    #[test]
    fn borders_fall_into_loops() {
        assert!(check_loops(Vec::new()).is_empty());
        let ring = |vertices: &[u32]| -> Vec<BorderEdge> {
            (0..vertices.len()).map(|i| edge(vertices[i], vertices[(i + 1) % vertices.len()])).collect()
        };
        let one = ring(&[3, 9, 4, 7]);
        assert_eq!(check_loops(one.clone()), [4]);
        // The same loop twice, as around a triangle with the wrong orientation.
        assert_eq!(check_loops([one.clone(), one.clone()].concat()), [4, 4]);
        // A figure eight, whose common vertex is the first, the last, or another one.
        for common in [0, 5, 100] {
            assert_eq!(check_loops([ring(&[common, 1, 2]), ring(&[common, 7, 6, 8])].concat()), [3, 4]);
        }
        // A chain of loops, each with one vertex of the next.
        let chain = [ring(&[0, 1, 2]), ring(&[2, 3, 4, 5]), ring(&[4, 6, 7, 8, 9]), ring(&[20, 21, 22])];
        assert_eq!(check_loops(chain.concat()), [3, 3, 4, 5]);
        // Loops with two common vertices.
        let lengths = check_loops([ring(&[0, 1, 2, 3]), ring(&[0, 4, 2, 5])].concat());
        assert_eq!(lengths.iter().sum::<usize>(), 8);
    }

    #[test]
    fn random_borders_fall_into_loops() {
        let mut rng = crate::rng::Rng::new(3);
        for _ in 0..2000 {
            // Closed walks without pairs of opposite edges.
            let count = 4 + rng.below(9) as u32;
            let mut edges: Vec<BorderEdge> = Vec::new();
            for _ in 0..1 + rng.below(4) {
                let mut walk = alloc::vec![rng.below(u64::from(count)) as u32];
                for _ in 0..3 + rng.below(12) {
                    let next = rng.below(u64::from(count)) as u32;
                    if walk.last() != Some(&next) {
                        walk.push(next);
                    }
                }
                if walk[0] != walk[walk.len() - 1] {
                    walk.push(walk[0]);
                }
                edges.extend(walk.windows(2).map(|pair| edge(pair[0], pair[1])));
            }
            let _ = check_loops(without_opposites(edges));
        }
    }

    fn without_opposites(mut edges: Vec<BorderEdge>) -> Vec<BorderEdge> {
        let pair = |edges: &[BorderEdge]| {
            (0..edges.len()).find_map(|i| {
                let is_back = |e: &BorderEdge| (e.from, e.to) == (edges[i].to, edges[i].from);
                edges.iter().position(is_back).map(|j| [i.min(j), i.max(j)])
            })
        };
        while let Some([i, j]) = pair(&edges) {
            edges.remove(j);
            edges.remove(i);
        }
        edges
    }

    #[test]
    fn the_fan_of_least_area_is_chosen() {
        // A square with a notch at vertex 4, which sees all of it.
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [3.0, 2.0]];
        for scale in [1.0, 1e-60, 1e80] {
            for bend in [0.0, 0.5] {
                let corner = |i: usize| {
                    let [x, y] = square[i];
                    [x * scale, y * scale, if i == 4 { bend * scale } else { 0.0 }]
                };
                let vertices: Vec<Point> = (0..5).map(corner).collect();
                let around: Vec<BorderEdge> = (0..5).map(|i| edge(i, (i + 1) % 5)).collect();
                let width = width_of(&vertices, &around);
                assert!((width / scale - 32.0_f64.sqrt()).abs() < 1e-12);
                assert_eq!(best_apex(&vertices, &around, width), 4, "{scale} {bend}");
            }
        }
    }
}
