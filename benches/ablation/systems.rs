//! The systems compared: the library's first, beginning with the default on the best instruction set, then the
//! benchmark's own.

#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::bytes::Bytes;
use super::plain::{EarlyExit, Vectorised};
use super::split::{Measure, split};
use super::traverse::{System, Work, collide};
use super::tree::{K, Shape, Tree};
#[cfg(target_arch = "x86_64")]
use super::wide;
use crate::data::MeshData;
use simdop::construct::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::{Bvh, BvhRef};
#[cfg(target_arch = "x86_64")]
use simdop::isa::Avx2;
use simdop::isa::{Isa, Scalar};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};
use std::cell::RefCell;

/// Verdict at a pose, and the work of the query.
type Collide = Box<dyn Fn(&Pose) -> (bool, Work)>;

/// One system with the mesh's tree.
pub(crate) struct Entrant {
    pub(crate) name: String,
    /// Bytes of the nodes.
    pub(crate) bytes: usize,
    pub(crate) collide: Collide,
}

const OTHERS: [(&str, Splitter); 4] = [
    ("longest axis", Splitter::LongestAxis),
    ("extended longest axis", Splitter::ExtendedLongestAxis),
    ("surface area", Splitter::SurfaceArea),
    ("neural gas", Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 0 }),
];

/// All systems, the library's default first.
pub(crate) fn entrants(mesh: &MeshData) -> Vec<Entrant> {
    let best = Isa::detect();
    let tree = build::<Node16<K>>(mesh, Splitter::MeanWidth);
    let four = build::<Node4<K>>(mesh, Splitter::MeanWidth);
    let isas: Vec<Isa> = Isa::available().collect();
    let mut entrants: Vec<Entrant> =
        isas.iter().rev().map(|&isa| library(format!("1vs16, {isa}"), tree, isa)).collect();
    entrants.extend(isas.iter().rev().map(|&isa| library(format!("4vs4, {isa}"), four, isa)));
    for (name, splitter) in OTHERS {
        let tree = build::<Node16<K>>(mesh, splitter);
        entrants.push(library(format!("1vs16, {best}, {name}"), tree, best));
    }
    own_systems(mesh, tree, &mut entrants);
    entrants
}

fn own_systems(mesh: &MeshData, baked: BvhRef<'_, Node16<K>>, entrants: &mut Vec<Entrant>) {
    let plain = Scalar::new();
    let shapes =
        [Measure::MeanWidth, Measure::Area, Measure::LongestAxis].map(|measure| split(mesh, measure));
    let [shape, by_area, by_axis] = &shapes;
    let wide = Shape::of(baked);
    entrants.extend([
        own("binary, scalar, early exit", EarlyExit(plain), mesh, shape, baked),
        own("binary, scalar, surface area", EarlyExit(plain), mesh, by_area, baked),
        own("binary, scalar, longest axis", EarlyExit(plain), mesh, by_axis, baked),
        own("binary, compiler", Vectorised(plain), mesh, shape, baked),
        own("1vs16, scalar, this traversal, 8-bit planes", Bytes(plain), mesh, &wide, baked),
    ]);
    #[cfg(target_arch = "x86_64")]
    if let Some(isa) = Avx2::detect() {
        entrants.extend([
            own("binary, compiler for avx2", Vectorised(isa), mesh, shape, baked),
            own("binary, by hand, avx2", avx2::Floats(isa), mesh, shape, baked),
            own("binary, by hand, avx2, surface area", avx2::Floats(isa), mesh, by_area, baked),
            own("binary, by hand, avx2, longest axis", avx2::Floats(isa), mesh, by_axis, baked),
            own("binary, by hand, avx2, keys", avx2::Keys(isa), mesh, shape, baked),
            own("1vs16, avx2, this traversal, keys", wide::Keys(isa), mesh, &wide, baked),
            own("1vs16, avx2, this traversal, ordered halves", wide::OrderedHalves(isa), mesh, &wide, baked),
            own("1vs16, avx2, this traversal, paper's halves", wide::PapersHalves(isa), mesh, &wide, baked),
            own("1vs16, avx2, this traversal, 8-bit planes", Bytes(isa), mesh, &wide, baked),
            own("1vs16, avx2, this traversal, floats", wide::Floats(isa), mesh, &wide, baked),
        ]);
    }
}

/// A view that lives as long as the benchmark, so that a query looks nothing up, as for a real caller.
fn build<N: Lanes>(mesh: &MeshData, splitter: Splitter) -> BvhRef<'static, N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let tree: &'static Bvh<N> =
        Box::leak(Box::new(Builder::new().splitter(splitter).build_as(&mesh).unwrap()));
    tree.view()
}

fn library<N: Lanes>(name: String, tree: BvhRef<'static, N>, isa: Isa) -> Entrant {
    let query = Query::new(isa);
    let collide = move |pose: &Pose| {
        let answer = query.collide(&tree, &tree, pose);
        let stats = answer.stats;
        // Each kernel call tests 16 pairs: 1vs16, 16vs1 or 4vs4.
        let mut work =
            Work { visits: stats.visits, primitive_pairs: stats.primitive_pairs, ..Work::default() };
        work.in_all_slabs(16 * stats.kernels);
        (answer.hit().is_some(), work)
    };
    Entrant { name, bytes: size_of_val(tree.nodes()), collide: Box::new(collide) }
}

fn own<const W: usize, S: System<W> + 'static>(
    name: &str,
    system: S,
    mesh: &MeshData,
    shape: &Shape<W>,
    baked: BvhRef<'_, Node16<K>>,
) -> Entrant {
    let tree: Tree<W, S> = Tree::new(mesh, shape, baked);
    let stack = RefCell::new(Vec::with_capacity(256));
    let bytes = tree.bytes();
    let collide = move |pose: &Pose| collide(system, [&tree, &tree], pose, &mut stack.borrow_mut());
    Entrant { name: name.to_owned(), bytes, collide: Box::new(collide) }
}
