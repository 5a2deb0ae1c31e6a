use super::*;
use crate::random::Random;
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::mesh_io::MeshData;
use simdop::node::{Node4, Node16};

/// Triangles scattered in a cube of side 2.
fn strewn(random: &mut Random, count: u32) -> MeshData {
    let mut mesh = MeshData::default();
    for i in 0..count {
        let centre: [f64; 3] = core::array::from_fn(|_| 2.0 * random.unit() - 1.0);
        for _ in 0..3 {
            mesh.vertices.push(centre.map(|c| c + 0.3 * (random.unit() - 0.5)));
        }
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

fn build<N: Dop>(mesh: &MeshData, leaf_size: u32) -> Bvh<N> {
    let builder = Builder::new().splitter(Splitter::ExtendedLongestAxis).leaf_size(leaf_size);
    builder.build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

/// The keys of a leaf's planes, and its triangles.
type Leaf = (Vec<i16>, Vec<Triangle>);

fn leaves<N: Dop>(tree: &BvhRef<'_, N>) -> Vec<Leaf> {
    let leaf = |lane: Lane| {
        let Link::Leaf { first, count } = lane.child.link() else { return None };
        let node = &tree.nodes()[lane.node as usize];
        let planes = (0..N::K).map(|j| node.plane(j, lane.lane)).collect();
        Some((planes, (first..first + count).map(|index| tree.primitive(index)).collect()))
    };
    tree.walk().filter_map(leaf).collect()
}

/// Compares all pairs of leaves by the inequality in ARCHITECTURE.md, with numbers instead of keys.
fn by_brute_force<N: Dop, const K: usize>(a: &BvhRef<'_, N>, b: &BvhRef<'_, N>, pose: &Pose) -> Meetings {
    let map = Realignment::<K, N::Storage>::new(pose, &a.extent(), &b.frame());
    let mut found = Meetings::default();
    for (planes_a, triangles_a) in leaves(a) {
        let turned: Vec<f32> = (0..K).map(|j| map.plane(j, |source| planes_a[source]).to_f32()).collect();
        for (planes_b, triangles_b) in leaves(b) {
            if (0..K).any(|j| -turned[j ^ 1] > N::Storage::value(planes_b[j])) {
                continue;
            }
            found.volumes += 1;
            let mut meet = false;
            for moved in triangles_a.iter().map(|triangle| triangle.map(|corner| pose.apply(corner))) {
                meet |= triangles_b.iter().any(|other| overlap(&moved, other, &mut 0));
            }
            found.triangles += u64::from(meet);
        }
    }
    found
}

#[test]
fn false_positives_are_those_of_brute_force() {
    fn check<N: Dop, const K: usize>(meshes: &[MeshData; 2], leaf_size: u32, poses: &[Pose]) -> Meetings
    where
        AnyBvh: From<Bvh<N>>,
    {
        let [a, b] = meshes.each_ref().map(|mesh| build::<N>(mesh, leaf_size));
        let [of_a, of_b] = [a.clone(), b.clone()].map(|tree| Volumes::of(&tree.into()));
        let mut sum = Meetings::default();
        for pose in poses {
            let found = meetings(&of_a, &of_b, pose);
            assert_eq!(found, by_brute_force::<N, K>(&a.view(), &b.view(), pose), "k {K}, {pose:?}");
            sum.volumes += found.volumes;
            sum.triangles += found.triangles;
        }
        assert!(sum.triangles > 0 && sum.false_positives() > 0, "{sum:?}");
        sum
    }
    let mut random = Random::new(5);
    let meshes = [strewn(&mut random, 90), strewn(&mut random, 120)];
    let turned = |x| [[0.6, -0.8, 0.0, x], [0.48, 0.36, -0.8, 0.1], [0.64, 0.48, 0.6, -0.2]];
    let poses = [0.0, 0.5, 1.3, 9.0].map(|x| Pose::from_rows(turned(x)).unwrap());
    let coarse = check::<Node16<6>, 6>(&meshes, 1, &poses);
    let fine = check::<Node16<18>, 18>(&meshes, 1, &poses);
    // The same triangles meet, and tighter k-DOPs separate more pairs.
    assert!(fine.triangles == coarse.triangles && fine.volumes < coarse.volumes, "{fine:?}, {coarse:?}");
    check::<Node16<14>, 14>(&meshes, 3, &poses);
    check::<Node4<18>, 18>(&meshes, 2, &poses);
    check::<Node4<18>, 18>(&meshes, 1, &poses);
    check::<Node16<26>, 26>(&meshes, 4, &poses);
    let half = check::<Node16<18, Half>, 18>(&meshes, 1, &poses);
    assert_eq!(half.triangles, fine.triangles);
    check::<Node16<26, Half>, 26>(&meshes, 4, &poses);
}

/// The support of a k-DOP: the maximum over its corners, where three planes meet and no other plane is exceeded.
fn support_of_corners<const K: usize>(planes: &[f64], u: [f64; 3]) -> f64 {
    let n = Directions::<K>::VECTORS;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let mut greatest = f64::NEG_INFINITY;
    for (i, j, l) in (0..K).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |l| (i, j, l)))) {
        let (jl, li, ij) = (cross(n[j], n[l]), cross(n[l], n[i]), cross(n[i], n[j]));
        let volume = dot(n[i], jl);
        if volume.abs() < 1e-9 {
            continue;
        }
        let corner =
            core::array::from_fn(|c| (planes[i] * jl[c] + planes[j] * li[c] + planes[l] * ij[c]) / volume);
        let size = planes.iter().fold(0.0, |size: f64, plane| size.max(plane.abs()));
        if (0..K).all(|m| dot(n[m], corner) <= planes[m] + 1e-9 * size) {
            greatest = greatest.max(dot(u, corner));
        }
    }
    greatest
}

/// Compares with the corners of the k-DOPs: realignment bounds the support from above, and exactly for boxes.
#[test]
fn overestimates_are_those_of_the_corners() {
    fn check<N: Dop, const K: usize>(mesh: &MeshData, leaf_size: u32, slack: f64) -> Overestimate
    where
        AnyBvh: From<Bvh<N>>,
    {
        let tree = build::<N>(mesh, leaf_size);
        let view = tree.view();
        let (centre, scale) = (view.frame().centre, view.frame().scale());
        let mut want = Overestimate::default();
        for (planes, triangles) in leaves(&view) {
            let planes: Vec<f64> =
                planes.iter().map(|&code| f64::from(N::Storage::value(code)) / scale).collect();
            for u in directions() {
                let support = |p: &[f64; 3]| (0..3).map(|i| u[i] * (p[i] - centre[i])).sum::<f64>();
                let exact = triangles.iter().flatten().map(support).reduce(f64::max).unwrap();
                let excess = support_of_corners::<K>(&planes, u) - exact;
                assert!(excess > -1e-9, "{excess}");
                want.sum += excess;
                want.count += 1;
                want.greatest = want.greatest.max(excess);
            }
        }
        let mut found = Overestimate::default();
        Volumes::of(&tree.clone().into()).measure(&mut found);
        assert_eq!(found.count, want.count);
        for (found, want) in [(found.mean(), want.mean()), (found.greatest, want.greatest)] {
            assert!((want - 1e-9..(1.0 + slack) * want + 1e-9).contains(&found), "k {K}: {found} for {want}");
        }
        found
    }
    let mesh = strewn(&mut Random::new(9), 20);
    let boxes = check::<Node16<6>, 6>(&mesh, 1, 0.0);
    let fine = check::<Node16<18>, 18>(&mesh, 1, 0.6);
    assert!(fine.mean() < 0.7 * boxes.mean() && fine.greatest < boxes.greatest, "{fine:?}, {boxes:?}");
    let half = check::<Node16<18, Half>, 18>(&mesh, 1, 0.6);
    assert!(half.mean() < 0.7 * boxes.mean() && half.mean() != fine.mean(), "{half:?}, {fine:?}");
    let four = check::<Node4<18>, 18>(&mesh, 4, 0.6);
    assert!(four.mean() > boxes.mean());
}

#[test]
fn directions_are_unit_vectors_that_cancel() {
    let all = directions();
    assert_eq!(all.len(), 96);
    let mut sum = [0.0; 3];
    for u in &all {
        assert!((u.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
        sum = core::array::from_fn(|i| sum[i] + u[i]);
    }
    assert!(sum.iter().all(|x| x.abs() < 1e-12), "{sum:?}");
}
