//! Trees with an assignment that the caller has chosen, and the weight of a sphere in a cluster.

use crate::mesh_of;
use crate::support::rng::Rng;
use crate::support::shapes::torus;
use core::ops::ControlFlow;
use simdop::construct::{
    Assignment, BuildError, Builder, Clustering, Geometry, Magnification, SphereSet, Splitter,
};
use simdop::hierarchy::{Bvh, MAX_DEPTH};
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Lanes, Query};
use std::collections::VecDeque;

/// Few large and many small spheres, in single precision, so that the centre of a sphere's box is its centre.
fn spheres(rng: &mut Rng, count: usize) -> Vec<Sphere> {
    let single = |x: f64| f64::from(x as f32);
    (0..count)
        .map(|i| Sphere {
            centre: [(); 3].map(|()| single(rng.range(-1.0, 1.0))),
            radius: single(0.5 / (1.0 + i as f64).cbrt()),
        })
        .collect()
}

/// A random assignment with unused lanes.
fn any_shape(rng: &mut Rng, count: usize, arity: usize, leaf_size: usize) -> Assignment {
    let mut order: Vec<u32> = (0..count as u32).collect();
    for i in (1..count).rev() {
        order.swap(i, rng.below(i as u64 + 1) as usize);
    }
    let mut ends = Vec::new();
    let mut waiting = VecDeque::new();
    if count > 0 {
        waiting.push_back((0, count));
    }
    while let Some((start, end)) = waiting.pop_front() {
        let size = end - start;
        let cuts = loop {
            let mut cuts: Vec<usize> =
                (1..arity).map(|_| start + rng.below(size as u64 + 1) as usize).collect();
            cuts.push(end);
            cuts.sort_unstable();
            let starts = [start].into_iter().chain(cuts.iter().copied());
            if size <= leaf_size || starts.zip(&cuts).all(|(from, to)| to - from < size) {
                break cuts;
            }
        };
        let mut from = start;
        for to in cuts {
            ends.push(to as u32);
            if to - from > leaf_size {
                waiting.push_back((from, to));
            }
            from = to;
        }
    }
    Assignment { order, ends }
}

fn any_shapes<N: Lanes>(rng: &mut Rng) {
    for count in [0, 1, 2, 3, 15, 16, 17, 60, 200] {
        let spheres = spheres(rng, count);
        let set = SphereSet { spheres: &spheres };
        let usual: Bvh<N, Spheres> =
            Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
        let aside =
            Pose::from_rows([[1.0, 0.0, 0.0, 0.3], [0.0, 0.0, -1.0, 0.1], [0.0, 1.0, 0.0, 0.0]]).unwrap();
        let want = Query::new(Isa::detect()).penetration(&usual, &usual, &aside);
        for leaf_size in [1, 3] {
            let shape = any_shape(rng, count, N::ARITY, leaf_size);
            let tree: Bvh<N, Spheres> =
                Builder::new().leaf_size(leaf_size as u32).build_assigned(&set, &shape).unwrap();
            tree.view().validate().unwrap();
            tree.view().verify().unwrap();
            assert_eq!(tree.view().len(), count);
            let got = Query::new(Isa::detect()).penetration(&tree, &tree, &aside);
            assert_eq!((got.volume.to_bits(), got.pairs), (want.volume.to_bits(), want.pairs), "{shape:?}");
        }
    }
}

#[test]
fn any_shape_is_a_tree_with_the_same_answers() {
    let mut rng = Rng::new(40);
    any_shapes::<Node4<14>>(&mut rng);
    any_shapes::<Node16<18>>(&mut rng);
}

#[test]
fn what_is_no_shape_is_refused() {
    let spheres = spheres(&mut Rng::new(41), 6);
    let check = |order: &[u32], ends: &[u32]| {
        let shape = Assignment { order: order.into(), ends: ends.into() };
        let tree: Result<Bvh<Node4<6>, Spheres>, _> =
            Builder::new().build_assigned(&SphereSet { spheres: &spheres }, &shape);
        tree.map(|tree| tree.view().validate().unwrap())
    };
    let order = [5, 0, 1, 2, 3, 4];
    let ends = [1, 3, 6, 6, 2, 3, 3, 3, 4, 5, 6, 6];
    assert_eq!(check(&order, &ends), Ok(()));

    let refused = |order: &[u32], ends: &[u32], why: &str| {
        let Err(BuildError::Assignment { problem }) = check(order, ends) else {
            panic!("{order:?} {ends:?}: {:?}", check(order, ends))
        };
        assert!(problem.contains(why), "{order:?} {ends:?}: {problem}");
    };
    refused(&[5, 0, 1, 2, 3, 5], &ends, "twice");
    refused(&[5, 0, 1, 2, 3, 6], &ends, "there is not");
    refused(&[5, 0, 1, 2, 3, 4, 4], &ends, "twice");
    refused(&order[..5], &ends, "lacks");
    refused(&order, &[], "fewer nodes");
    refused(&order, &ends[..8], "fewer nodes");
    refused(&order, &ends[..11], "do not end");
    refused(&order, &[&ends[..], &[6; 4]].concat(), "more nodes");
    refused(&order, &[3, 1, 6, 6, 2, 3, 3, 3, 4, 5, 6, 6], "before it begins");
    refused(&order, &[1, 3, 7, 7, 2, 3, 3, 3, 4, 5, 6, 6], "outside");
    refused(&order, &[1, 3, 6, 6, 2, 3, 3, 4, 4, 5, 6, 6], "outside");
    refused(&order, &[1, 3, 5, 5, 2, 3, 3, 3, 4, 5, 6, 6], "do not end");
    refused(&order, &[0, 6, 6, 6, 1, 3, 6, 6, 2, 3, 3, 3, 4, 5, 6, 6], "one part");
}

/// A leaf and the rest, at each level.
#[test]
fn a_shape_may_be_as_deep_as_trees_are() {
    let chain = |count: u32| {
        let spheres = spheres(&mut Rng::new(42), count as usize);
        let ends = (1..count).flat_map(|first| [first, count, count, count]).collect();
        let shape = Assignment { order: (0..count).collect(), ends };
        Builder::new().build_assigned::<Node4<6>, _>(&SphereSet { spheres: &spheres }, &shape)
    };
    let deepest = MAX_DEPTH as u32 + 1;
    chain(deepest).unwrap().view().verify().unwrap();
    assert_eq!(chain(deepest + 1).unwrap_err(), BuildError::TooDeep);
}

/// Batch Neural Gas has the same bytes as the assignment that it computes from these points and weights.
fn check_weights<N: Lanes, G: Geometry>(
    geometry: &G,
    magnification: Magnification,
    points: &[[f64; 3]],
    weights: Option<&[f64]>,
) {
    let mut go_on = |_| ControlFlow::Continue(());
    for (seed, leaf_size) in [(0, 1), (9, 3)] {
        let clustering = Clustering { arity: N::ARITY, leaf_size: leaf_size as usize, seed };
        let builder = Builder::new().leaf_size(leaf_size);
        let shape = clustering.assign(points, weights, &mut go_on).unwrap();
        let want: Bvh<N, G::Primitive> = builder.build_assigned(geometry, &shape).unwrap();
        let by_gas = builder.splitter(Splitter::BatchNeuralGas { magnification, seed });
        let got: Bvh<N, G::Primitive> = by_gas.build_geometry(geometry, &mut go_on).unwrap();
        assert!(got.as_bytes() == want.as_bytes(), "{magnification:?}, {clustering:?}");
    }
}

/// The weight is the volume and no other power of the radius, as in section 3.1.1 of the BNG paper.
#[test]
fn a_sphere_weighs_its_volume() {
    let spheres = spheres(&mut Rng::new(43), 700);
    let set = SphereSet { spheres: &spheres };
    let centres: Vec<_> = spheres.iter().map(|sphere| sphere.centre).collect();
    let volumes: Vec<_> = spheres.iter().map(|Sphere { radius: r, .. }| r * r * r).collect();
    check_weights::<Node4<6>, _>(&set, Magnification::Area, &centres, Some(&volumes));
    check_weights::<Node16<6>, _>(&set, Magnification::Area, &centres, Some(&volumes));
    check_weights::<Node4<6>, _>(&set, Magnification::None, &centres, None);
    let shape = |weights| {
        let clustering = Clustering { arity: 4, leaf_size: 1, seed: 0 };
        clustering.assign(&centres, weights, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    let areas: Vec<_> = spheres.iter().map(|sphere| sphere.radius * sphere.radius).collect();
    assert!(shape(Some(&volumes)) != shape(Some(&areas)), "weights matter");
    assert!(shape(Some(&volumes)) != shape(None), "weights matter");
}

#[test]
fn a_mesh_takes_the_shape_of_its_clusters() {
    let mesh = torus(30, 20);
    let middle = |t: &[[f64; 3]; 3]| {
        let end = |fold: fn(f64, f64) -> f64, i: usize| fold(fold(t[0][i], t[1][i]), t[2][i]);
        core::array::from_fn(|i| 0.5 * (end(f64::min, i) + end(f64::max, i)))
    };
    let middles: Vec<[f64; 3]> = mesh.corners().iter().map(middle).collect();
    check_weights::<Node16<6>, _>(&mesh_of(&mesh), Magnification::None, &middles, None);
}
