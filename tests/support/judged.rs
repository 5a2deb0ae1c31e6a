//! Bodies at poses that brute force in exact arithmetic judges, and the answers that queries must give there on
//! every instruction set.

use crate::support::corners::{inverse, near_corners};
use crate::support::data::MeshData;
use crate::support::exact::{Tri, meeting_pairs};
use crate::support::exact_distance::mesh_distance;
use crate::support::rng::Rng;
use crate::support::shapes::{append, scaled, separate};
use crate::{Pairs, pairs_that_meet};
use simdop::construct::{BuildError, Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Answer, Lanes, Query, QueryStats};
use simdop::range::MIN_COORDINATE;

type Rows = [[f64; 4]; 3];

pub(crate) fn build<N: Lanes>(mesh: &MeshData) -> Result<Bvh<N>, BuildError> {
    Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles })
}

/// Two bodies, and the expected answers at some poses.
pub(crate) struct Scene {
    name: String,
    a: MeshData,
    b: MeshData,
    pub(crate) judged: Vec<Judged>,
}

pub(crate) struct Judged {
    rows: Rows,
    /// In ascending order.
    pairs: Pairs,
}

impl Scene {
    pub(crate) fn new(name: String, a: &MeshData, b: &MeshData, poses: Vec<Rows>) -> Self {
        let still = flushed(b.corners());
        let judge = |rows: Rows| {
            let pairs = meeting_pairs(&moved(a, &rows), &still);
            let pairs = pairs.into_iter().map(|(i, j)| (i as u32, j as u32)).collect();
            Judged { rows, pairs }
        };
        Self { name, a: a.clone(), b: b.clone(), judged: poses.into_iter().map(judge).collect() }
    }

    /// The small body near corners of the large one, in both orders, at `poses` poses each.
    pub(crate) fn both_ways(
        name: &str,
        small: &MeshData,
        large: &MeshData,
        corners: &MeshData,
        poses: u32,
    ) -> [Self; 2] {
        let rng = &mut Rng::new(small.diagonal().to_bits());
        let count = poses as usize;
        let mut poses = near_corners(small, corners, 0.5, count - count / 4, rng);
        // Corner on corner, up to rounding.
        poses.extend(near_corners(small, corners, 0.0, count / 4, rng));
        let back = poses.iter().map(inverse).collect();
        [
            Self::new(format!("{name}, small as A"), small, large, poses),
            Self::new(format!("{name}, small as B"), large, small, back),
        ]
    }

    /// The scene is `body` with a copy of itself, scaled by 1/1000, at one of its corners. Another such copy is
    /// posed near the corners of the first copy.
    pub(crate) fn both_ways_at_a_detail(name: &str, body: &MeshData, poses: u32) -> [Self; 2] {
        let small = scaled(body, 1e-3, [0.0; 3]);
        let corner = body.vertices[body.triangles[body.triangles.len() / 2][0] as usize];
        let detail = scaled(body, 1e-3, corner);
        let mut scene = body.clone();
        append(&mut scene, &detail);
        Self::both_ways(&format!("{name} with a detail"), &small, &scene, &detail, poses)
    }

    pub(crate) fn hits(&self) -> usize {
        self.judged.iter().filter(|judged| !judged.pairs.is_empty()).count()
    }

    /// Checks every query with three node types.
    pub(crate) fn check(&self) {
        self.check_nodes::<Node16<18>>();
        self.check_nodes::<Node4<14>>();
        self.check_nodes::<Node16<32>>();
    }

    fn check_nodes<N: Lanes>(&self) {
        let (a, b) = (build::<N>(&self.a).unwrap(), build::<N>(&self.b).unwrap());
        for Judged { rows, pairs } in &self.judged {
            let pose = Pose::from_rows(*rows).unwrap();
            let what = format!("{}, k {} arity {}, {rows:?}", self.name, N::K, N::ARITY);
            let mut first = None;
            for isa in Isa::available() {
                let got = Answers::of(isa, &a, &b, &pose);
                if first.is_none() {
                    assert_eq!(got.collide.is_free(), pairs.is_empty(), "{what}");
                    assert!(got.collide.hit().is_none_or(|pair| pairs.contains(&(pair.a, pair.b))), "{what}");
                    assert!(got.pairs == *pairs, "{what}: {} pairs, not {}", got.pairs.len(), pairs.len());
                }
                let want = first.get_or_insert_with(|| got.clone());
                assert!(got == *want, "{isa}, {what}: {:?} {:?}", got.collide, got.stats);
            }
        }
    }
}

/// The answers to all queries on a pair of bodies at a pose.
#[derive(Clone, PartialEq)]
pub(crate) struct Answers {
    collide: Answer,
    /// In ascending order.
    pairs: Pairs,
    /// The statistics of the enumeration.
    stats: QueryStats,
}

impl Answers {
    pub(crate) fn of<N: Lanes>(isa: Isa, a: &Bvh<N>, b: &Bvh<N>, pose: &Pose) -> Self {
        let query = Query::new(isa);
        let (pairs, stats) = pairs_that_meet(query, a, b, pose);
        Self { collide: query.collide(&a.view(), &b.view(), pose), pairs, stats }
    }
}

/// As documented for given and moved coordinates: those below [`MIN_COORDINATE`] become zero.
pub(crate) fn flushed(mut triangles: Vec<Tri>) -> Vec<Tri> {
    for x in triangles.as_flattened_mut().as_flattened_mut() {
        if x.abs() < MIN_COORDINATE {
            *x = 0.0;
        }
    }
    triangles
}

/// The corners of a built body at a pose.
pub(crate) fn moved(mesh: &MeshData, rows: &Rows) -> Vec<Tri> {
    let corners = flushed(mesh.corners());
    let built = separate(corners);
    flushed(built.placed(rows))
}

pub(crate) fn check_all(scenes: impl IntoIterator<Item = Scene>) {
    let (mut hits, mut poses) = (0, 0);
    for scene in scenes {
        scene.check();
        println!("{}: {} hits in {} poses", scene.name, scene.hits(), scene.judged.len());
        (hits, poses) = (hits + scene.hits(), poses + scene.judged.len());
    }
    assert!(hits * 20 > poses && hits * 20 < poses * 19, "both answers are frequent: {hits} hits of {poses}");
}

pub(crate) fn check_margins<N: Lanes>(scene: &Scene) {
    let (a, b) = (build::<N>(&scene.a).unwrap(), build::<N>(&scene.b).unwrap());
    let still = scene.b.corners();
    for Judged { rows, pairs } in scene.judged.iter().filter(|judged| judged.pairs.is_empty()) {
        let pose = Pose::from_rows(*rows).unwrap();
        let what = format!("{}, k {} arity {}, {rows:?}", scene.name, N::K, N::ARITY);
        let found = Query::new(Isa::detect()).distance(&a, &b, &pose, 0.0).unwrap();
        // If the distance is too great, this search finds a nearer pair; if it is too small, this search finds
        // none.
        let want = mesh_distance(&moved(&scene.a, rows), &still, found.upper * (1.0 + 1e-9));
        assert!(want > 0.0 && pairs.is_empty(), "{what}");
        assert!((found.upper - want).abs() <= 1e-9 * want, "{want:e} {found:?} {what}");
        assert!(found.lower <= want * (1.0 + 1e-15), "{want:e} {found:?} {what}");
        for (share, within) in
            [(1e-6, false), (0.5, false), (1.0 - 1e-9, false), (1.0 + 1e-9, true), (3.0, true)]
        {
            let mut first = None;
            for isa in Isa::available() {
                let answer = Query::new(isa).within(&a, &b, &pose, share * want).unwrap();
                assert_eq!(answer.hit().is_some(), within, "{share} of {want:e}, {isa}, {what}");
                assert_eq!(answer.is_free(), !within, "{share} of {want:e}, {isa}, {what}");
                assert_eq!(answer, *first.get_or_insert(answer), "{share} of {want:e}, {isa}, {what}");
            }
        }
    }
}
