//! Nodes, maps and slabs of real trees.

use crate::support::rng::Rng;
use crate::turned::{turned_4, turned_16};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Turned;
use simdop::low_level::key::{Fixed, Storage};
use simdop::low_level::realign::{PrimitiveSlab, Realignment, primitive_slabs};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::Lanes;

/// The nodes of two trees of one mesh, maps for poses where the trees meet, and slabs of triangles near them.
pub(crate) struct Trees<const K: usize, S: Storage = Fixed> {
    pub(crate) wide: Bvh<Node16<K, S>>,
    pub(crate) narrow: Bvh<Node4<K, S>>,
    pub(crate) maps: Vec<Realignment<K, S>>,
    pub(crate) slabs: Vec<PrimitiveSlab>,
}

/// A torus with a wave: curved in both directions, and not symmetric.
fn shape(n: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // A rational parametrisation of the circle, because sines differ between machines.
    let circle = |i: u32| {
        let t = f64::from(i % n) / f64::from(n) * 4.0 - 2.0;
        let (t, turn) = if t.abs() <= 1.0 { (t, 1.0) } else { (t - 2.0_f64.copysign(t), -1.0) };
        [turn * (1.0 - t * t) / (1.0 + t * t), turn * 2.0 * t / (1.0 + t * t)]
    };
    let grid = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let vertices = grid().map(|(i, j)| {
        let ([c, s], [u, v]) = (circle(i), circle(j));
        let r = 2.0 + (0.7 + 0.2 * c) * u;
        [r * c, r * s, (0.7 + 0.2 * c) * v + 0.3 * s * c]
    });
    let at = |i: u32, j: u32| i % n * n + j % n;
    let triangles = grid().flat_map(|(i, j)| {
        [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    (vertices.collect(), triangles.collect())
}

impl<const K: usize, S: Storage> Trees<K, S>
where
    Node16<K, S>: Lanes,
    Node4<K, S>: Lanes,
{
    pub(crate) fn new(rng: &mut Rng) -> Self {
        let (vertices, triangles) = shape(24);
        let mesh = Mesh { vertices: &vertices, triangles: &triangles };
        let (wide, narrow) =
            (Builder::new().build_as(&mesh).unwrap(), Builder::new().build_as(&mesh).unwrap());
        let extent = Bvh::<Node16<K, S>>::view(&wide).extent();
        let mut pose = || {
            let rotation = rng.rotation();
            let shift = rng.rotation()[0].map(|x| x * 2.0);
            let rows = core::array::from_fn(|i| [rotation[i][0], rotation[i][1], rotation[i][2], shift[i]]);
            Pose::from_rows(rows).unwrap()
        };
        let poses: Vec<_> = (0..64).map(|_| pose()).collect();
        let maps = poses.iter().map(|pose| Realignment::new(pose, &extent, &extent.frame)).collect();
        let mut corner = || [(); 3].map(|()| rng.range(-2.0, 2.0));
        let mut triangle = || [corner(), corner(), corner()];
        let slabs = poses.iter().flat_map(|pose| {
            let posed = primitive_slabs::<Triangles, K, S>(&triangle(), 0.0, &extent, Some(pose));
            let still = primitive_slabs::<Triangles, K, S>(&triangle(), 0.01, &extent, None);
            posed.into_iter().chain(still)
        });
        let slabs = slabs.collect();
        Self { wide, narrow, maps, slabs }
    }

    pub(crate) fn node_16(&self, rng: &mut Rng) -> &Node16<K, S> {
        upper(rng, self.wide.view().nodes())
    }

    pub(crate) fn node_4(&self, rng: &mut Rng) -> &Node4<K, S> {
        upper(rng, self.narrow.view().nodes())
    }

    pub(crate) fn query_16(&self, rng: &mut Rng) -> Turned<16, K> {
        turned_16(Scalar::new(), rng.pick(&self.maps), self.node_16(rng))
    }

    pub(crate) fn query_4(&self, rng: &mut Rng) -> Turned<4, K> {
        turned_4(Scalar::new(), rng.pick(&self.maps), self.node_4(rng))
    }
}

/// A random node; the upper nodes, which come first, are larger and overlap more, and are drawn more often.
fn upper<'a, N>(rng: &mut Rng, nodes: &'a [N]) -> &'a N {
    let end = 1 + rng.below(nodes.len() as u64) as usize;
    let end = 1 + rng.below(end as u64) as usize;
    rng.pick(&nodes[..end])
}
