//! Half floats and fixed point: the same verdicts, and bytes that are read in their own storage.

use crate::build;
use crate::support::data::{MeshData, by_suite, directory};
use crate::support::rng::Rng;
use crate::support::shapes;
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::hierarchy::{AnyBvh, Bvh, BvhRef, FormatError, Header};
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::{Completion, Lanes, Pair, Query};

/// Trees of one mesh in both storages.
struct Both<F: Lanes, H: Lanes> {
    fixed: Bvh<F>,
    half: Bvh<H>,
}

impl<F: Lanes, H: Lanes> Both<F, H> {
    fn new(mesh: &MeshData) -> Self {
        let (fixed, half) = (build::<F>(mesh), build::<H>(mesh));
        for result in [fixed.view().verify(), half.view().verify()] {
            assert_eq!(result, Ok(()));
        }
        assert_eq!(fixed.as_bytes().len(), half.as_bytes().len());
        Self { fixed, half }
    }
}

/// The answers of queries of two bodies.
struct Answers {
    /// Whether they are free, and farther apart than the margin.
    verdicts: [bool; 2],
    lower: f64,
    upper: f64,
    pairs: Vec<Pair>,
}

impl Answers {
    fn of<N: Lanes>(query: &Query, a: &Bvh<N>, b: &Bvh<N>, pose: &Pose, margin: f64) -> Self {
        let mut pairs = Vec::new();
        let (completion, _) = query.for_each_pair(a, b, pose, |pair| {
            pairs.push(pair);
            ControlFlow::Continue(())
        });
        assert_eq!(completion, Completion::Complete);
        pairs.sort_unstable();
        let distance = query.distance(a, b, pose, 0.0).unwrap();
        let near = query.within(a, b, pose, margin).unwrap();
        Self {
            verdicts: [query.collide(a, b, pose).is_free(), near.is_free()],
            lower: distance.lower,
            upper: distance.upper,
            pairs,
        }
    }
}

/// Verdicts, pairs, margins and distances do not depend on the storage.
fn alike<F: Lanes, H: Lanes>(a: &MeshData, b: &MeshData, reach: f64, poses: usize) {
    let corners = [&a.vertices, &b.vertices];
    let (a, b) = (Both::<F, H>::new(a), Both::<F, H>::new(b));
    let mut rng = Rng::new(40);
    let mut hits = 0;
    for i in 0..poses {
        let turn = rng.rotation();
        let mut rows: [[f64; 4]; 3] =
            core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], reach * rng.range(-1.0, 1.0)]);
        let mut pose = Pose::from_rows(rows).unwrap();
        if i % 2 == 0 {
            // A corner of A at a corner of B.
            let [p, q] = [pose.apply(*rng.pick(corners[0])), *rng.pick(corners[1])];
            (0..3).for_each(|i| rows[i][3] += q[i] - p[i]);
            pose = Pose::from_rows(rows).unwrap();
        }
        let margin = 0.05 * reach;
        for isa in Isa::available() {
            let query = Query::new(isa);
            let fixed = Answers::of(&query, &a.fixed, &b.fixed, &pose, margin);
            let half = Answers::of(&query, &a.half, &b.half, &pose, margin);
            assert_eq!((fixed.verdicts, &fixed.pairs), (half.verdicts, &half.pairs), "{isa}, pose {i}");
            let apart = (fixed.upper - half.upper).abs();
            assert!(apart <= 1e-9 * fixed.upper, "{isa}, pose {i}: {} {}", fixed.upper, half.upper);
            assert!(fixed.lower <= half.upper && half.lower <= fixed.upper, "{isa}, pose {i}");
            hits += usize::from(!fixed.verdicts[0]);
        }
    }
    assert!(hits > 0, "some poses meet");
}

#[test]
fn verdicts_are_those_of_fixed_point() {
    let (torus, soup) = (shapes::torus(24, 16), shapes::soup(&mut Rng::new(3), 200, 0.3));
    alike::<Node16<18>, Node16<18, Half>>(&torus, &soup, 3.0, by_suite(200, 20));
    alike::<Node4<14>, Node4<14, Half>>(&soup, &soup, 2.0, by_suite(60, 5));
    #[cfg(simdop_all_nodes)]
    {
        alike::<Node16<14>, Node16<14, Half>>(&soup, &soup, 2.0, by_suite(60, 5));
        alike::<Node4<18>, Node4<18, Half>>(&torus, &torus, 4.0, by_suite(60, 5));
    }
    if let Some(data) = directory() {
        let cow = MeshData::obj(&data.join("meshes/cow.obj"));
        alike::<Node16<18>, Node16<18, Half>>(&cow, &cow, cow.diagonal(), by_suite(60, 5));
    }
}

/// A million poses, most of them near contact, of pairs of real meshes of similar and different sizes.
#[test]
#[ignore = "a minute"]
fn a_million_verdicts_are_those_of_fixed_point() {
    let Some(data) = directory() else { return };
    let mesh = |name: &str| MeshData::obj(&data.join("meshes").join(name).with_extension("obj"));
    let meshes = ["cow", "camel", "armadillo", "bunny75k"].map(mesh);
    let trees = meshes.each_ref().map(Both::<Node16<18>, Node16<18, Half>>::new);
    let (query, mut rng, mut hits) = (Query::new(Isa::detect()), Rng::new(41), 0);
    for i in 0..1_000_000 {
        let [m, n] = [i % 4, (i / 4) % 4];
        let turn = rng.rotation();
        let rows = |t: [f64; 3]| core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]]);
        // A corner of A is at a corner of B, or a hundredth of the diagonal beside it.
        let [p, q] = [
            Pose::from_rows(rows([0.0; 3])).unwrap().apply(*rng.pick(&meshes[m].vertices)),
            *rng.pick(&meshes[n].vertices),
        ];
        let away = if i % 3 == 0 { 0.0 } else { 0.01 * meshes[n].diagonal() };
        let pose = Pose::from_rows(rows(core::array::from_fn(|i| q[i] - p[i] + away * rng.range(-1.0, 1.0))))
            .unwrap();
        let (a, b) = (&trees[m], &trees[n]);
        let fixed = query.collide(&a.fixed, &b.fixed, &pose).is_free();
        assert_eq!(fixed, query.collide(&a.half, &b.half, &pose).is_free(), "pose {i}");
        hits += usize::from(!fixed);
    }
    println!("{hits} of 1,000,000 poses hit");
    assert!((100_000..990_000).contains(&hits), "{hits}");
}

/// A half float ends at 65,504 steps, so that planes of a body a million times larger become unbounded.
#[test]
fn bodies_of_unlike_size_meet_where_they_do_in_fixed_point() {
    let torus = shapes::torus(24, 16);
    for factor in [1e-6, 1e-4, 1e4, 1e6] {
        let other = shapes::scaled(&torus, factor, [0.0; 3]);
        // About where the surface of the larger one is.
        alike::<Node16<18>, Node16<18, Half>>(&torus, &other, 2.0 * f64::max(1.0, factor), by_suite(60, 6));
        alike::<Node16<18>, Node16<18, Half>>(&other, &torus, 2.0 * f64::max(1.0, factor), by_suite(60, 6));
    }
}

#[test]
fn bytes_of_another_storage_are_refused() {
    let mesh = shapes::torus(12, 8);
    let (fixed, half) = (build::<Node16<18>>(&mesh), build::<Node16<18, Half>>(&mesh));
    let wrong = |storage| Some(FormatError::OtherStorage { storage });
    assert_eq!(BvhRef::<Node16<18, Half>>::from_bytes(fixed.as_bytes()).err(), wrong(Fixed::CODE));
    assert_eq!(BvhRef::<Node16<18>>::from_bytes(half.as_bytes()).err(), wrong(Half::CODE));
    let mut unknown = half.as_bytes().to_vec();
    unknown[offset_of!(Header, storage)] = 7;
    assert_eq!(AnyBvh::<Triangles>::from_bytes(&unknown).err(), wrong(7));
    for storage in [Fixed::CODE, Half::CODE, 7] {
        assert!(!FormatError::OtherStorage { storage }.to_string().is_empty());
    }

    // Codes that are no planes: -0, infinity, and NaN.
    for code in [-1, Half::INFINITY, !Half::INFINITY, i16::MAX, -32_000] {
        let mut bytes = half.as_bytes().to_vec();
        bytes[128..130].copy_from_slice(&code.to_le_bytes());
        let error = Bvh::<Node16<18, Half>>::from_bytes(&bytes).unwrap_err();
        assert!(matches!(error, FormatError::Node { node: 0, lane: 0, .. }), "{code}: {error}");
    }
}

/// Planes are tight: the next lower code does not bound the primitives below.
#[test]
fn planes_are_the_least_halves() {
    let tree = build::<Node16<18, Half>>(&shapes::soup(&mut Rng::new(7), 40, 0.3));
    let mut bytes = tree.as_bytes().to_vec();
    let node = tree.view().nodes()[0];
    for lane in (0..16).filter(|&lane| node.planes[0][lane] != i16::MIN) {
        for j in 0..18 {
            let code = node.planes[j][lane];
            let lower = if code == 0 { -2 } else { code - 1 };
            let at = 128 + (j * 16 + lane) * 2;
            bytes[at..at + 2].copy_from_slice(&lower.to_le_bytes());
            match Bvh::<Node16<18, Half>>::from_bytes(&bytes) {
                Ok(lowered) => {
                    let error = lowered.view().verify().unwrap_err();
                    assert_eq!((error.node, error.lane as usize, error.plane as usize), (0, lane, j));
                }
                // The lowest plane of all, lowered, has a greater magnitude than the header states.
                Err(error) => assert!(matches!(error, FormatError::Node { .. }), "{error}"),
            }
            bytes[at..at + 2].copy_from_slice(&code.to_le_bytes());
        }
    }
}
