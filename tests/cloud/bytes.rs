//! Clouds as bytes: reading them gives the same cloud, or an error.

use crate::data::by_suite;
use crate::scenes::{self, Random};
use simdop::cloud::{CLOUD_MAGIC, CloudError, CloudRef, Neighbour, PointCloud, Queries, Radii, RangeSearch};
use simdop::construct::Splitter;
use simdop::hierarchy::{Aligned, FormatError};
use simdop::isa::Isa;
use simdop::node::{Aabb16, Bucket};

/// A copy of the bytes at an address that is a multiple of 64.
fn aligned(bytes: &[u8]) -> Vec<Bucket> {
    let mut lines = vec![Bucket::EMPTY; bytes.len().div_ceil(256)];
    bytemuck::cast_slice_mut::<_, u8>(&mut lines)[..bytes.len()].copy_from_slice(bytes);
    lines
}

fn read(bytes: &[u8]) -> Result<usize, FormatError> {
    let lines = aligned(bytes);
    CloudRef::from_bytes(&bytemuck::cast_slice(&lines)[..bytes.len()]).map(|view| view.len())
}

#[test]
fn a_cloud_comes_back_from_its_bytes() {
    for (name, points, radii) in scenes::all(by_suite(700, 120)) {
        let mut cloud = PointCloud::with_room(&points, 11, points.len() + 5).unwrap();
        cloud.remove(3).unwrap();
        cloud.insert(points.len() as u32 + 2, points[3]).unwrap();
        let bytes = cloud.view().to_bytes();
        let mut again = PointCloud::from_bytes(&bytes).unwrap();
        assert!(again.view().to_bytes() == bytes, "{name}");
        let lines = aligned(&bytes);
        let view = CloudRef::from_bytes(&bytemuck::cast_slice(&lines)[..bytes.len()]).unwrap();
        let count = |view: &CloudRef<'_>| {
            let mut counts = vec![0; view.capacity()];
            let search = RangeSearch::new(Isa::detect());
            search.count(view, &Queries::own(), Radii::Same(radii[1]), &mut counts).unwrap();
            counts
        };
        assert_eq!(count(&view), count(&cloud.view()), "{name}");
        // A cloud that was read can be changed like the original.
        for cloud in [&mut cloud, &mut again] {
            cloud.remove(0).unwrap();
            cloud.rebuild().unwrap();
        }
        assert!(again.view().to_bytes() == cloud.view().to_bytes(), "{name}");
    }
}

#[test]
fn bytes_that_are_no_cloud_are_refused() {
    let random = &mut Random(17);
    let points: Vec<_> = (0..400).map(|_| random.point()).collect();
    let bytes = PointCloud::new(&points).unwrap().view().to_bytes();
    assert_eq!(read(&bytes), Ok(400));
    assert_eq!(read(&bytes[..63]), Err(FormatError::Truncated { have: 63, need: 64 }));
    let (have, need) = (bytes.len() - 1, bytes.len());
    assert_eq!(read(&bytes[..have]), Err(FormatError::Truncated { have, need }));
    let longer = [&bytes[..], &[0]].concat();
    assert_eq!(read(&longer), Err(FormatError::TooLong { have: need + 1, need }));
    let mut shifted = Aligned([0; 65]);
    shifted.0[1..9].copy_from_slice(&CLOUD_MAGIC);
    assert_eq!(CloudRef::from_bytes(&shifted.0[1..]).unwrap_err(), FormatError::Version { found: 0 });

    let node = |lane: usize| 64 + 448 + 4 * lane;
    let with = |at: usize, word: u32| {
        let mut wrong = bytes.clone();
        wrong[at..at + 4].copy_from_slice(&word.to_le_bytes());
        read(&wrong).unwrap_err()
    };
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(with(0, 0), FormatError::NotATree);
    assert_eq!(with(8, 2), FormatError::Version { found: 2 });
    assert_eq!(with(12, 17), FormatError::Header { field: "bucket_size" });
    assert_eq!(with(12, 0), FormatError::Header { field: "bucket_size" });
    assert_eq!(with(16, 401), FormatError::Header { field: "capacity" });
    assert_eq!(with(16, 399), FormatError::Header { field: "points" });
    assert_eq!(with(20, u32::MAX), FormatError::Header { field: "capacity" });
    assert_eq!(with(24, 0), FormatError::Header { field: "nodes" });
    assert_eq!(with(60, 1), FormatError::Header { field: "reserved" });
    // The lower corner of the first box is no longer below the points.
    let inside = (f32::from_bits(word(64)) + 0.001).to_bits();
    assert!(matches!(with(64, inside), FormatError::Node { node: 0, lane: 0, .. }));
    assert!(matches!(with(64, f32::NAN.to_bits()), FormatError::Node { node: 0, lane: 0, .. }));
    // Two lanes link to one bucket; a node links to itself; a bucket does not exist.
    assert!(matches!(with(node(1), word(node(0))), FormatError::Node { node: 0, lane: 1, .. }));
    assert!(matches!(with(node(15), 0), FormatError::Node { node: 0, lane: 15, .. }));
    assert!(matches!(with(node(0), 1 << 31 | 25), FormatError::Node { node: 0, lane: 0, .. }));
    assert!(matches!(with(node(0), word(node(0)) | 1 << 27), FormatError::Node { node: 0, lane: 0, .. }));
    // Points.
    let bucket = bytes.len() - 25 * 256;
    assert_eq!(with(bucket + 192, 400), FormatError::Source { index: 0 });
    assert!(matches!(with(bucket + 192, u32::MAX), FormatError::Vertex { index: 0 }));
    // A point outside its box.
    assert!(matches!(with(bucket, 9.0_f32.to_bits()), FormatError::Node { .. }));
    // An index that occurs twice: only a change of the cloud needs to detect it.
    let mut twice = bytes.clone();
    twice[bucket + 192..bucket + 196].copy_from_slice(&word(bucket + 196).to_le_bytes());
    assert_eq!(read(&twice), Ok(400));
    assert_eq!(PointCloud::from_bytes(&twice).unwrap_err(), FormatError::Source { index: 1 });
}

/// A node that links to itself, and that no other node links to. The link is valid in itself: it leads to the
/// next node in order.
#[test]
fn nodes_that_nothing_leads_to_are_refused() {
    let points: Vec<_> = (0..10).map(|i| [i as f32, 0.0, 0.0]).collect();
    let mut bytes = PointCloud::new(&points).unwrap().view().to_bytes();
    let mut node = Aabb16::EMPTY;
    node.child[0] = bytemuck::cast(1_u32);
    for i in 0..3 {
        (node.lower[i][0], node.upper[i][0]) = (-1.0, 1.0);
    }
    bytes.splice(64 + 512..64 + 512, bytemuck::bytes_of(&node).iter().copied());
    bytes[24..28].copy_from_slice(&2_u32.to_le_bytes());
    assert_eq!(read(&bytes), Err(FormatError::Header { field: "nodes" }));
    bytes[24..28].copy_from_slice(&1_u32.to_le_bytes());
    bytes.drain(64 + 512..64 + 1024);
    assert_eq!(read(&bytes), Ok(10));
}

/// The header may state a greater capacity than there are points: the memory is allocated when points are
/// added.
#[test]
fn a_cloud_from_bytes_has_the_room_that_it_says() {
    let random = &mut Random(47);
    let mut points: Vec<_> = (0..40).map(|_| random.point()).collect();
    let mut bytes = PointCloud::with_room(&points, 11, points.len()).unwrap().view().to_bytes();
    bytes[20..24].copy_from_slice(&2000_u32.to_le_bytes());
    let mut cloud = PointCloud::from_bytes(&bytes).unwrap();
    assert_eq!(cloud.view().buckets().len(), 4);
    for index in 40..by_suite(2000, 200) as u32 {
        let point = random.point();
        points.push(point);
        if let Err(error) = cloud.insert(index, point) {
            assert_eq!(error, CloudError::Full);
            cloud.rebuild().unwrap();
            cloud.insert(index, point).unwrap();
        }
    }
    assert!(cloud.view().len() == points.len() && cloud.view().buckets().len() > 10);
    let mut counts = vec![0; 2000];
    let search = RangeSearch::new(Isa::detect());
    search.count(&cloud.view(), &Queries::own(), Radii::Same(0.2), &mut counts).unwrap();
    for (i, point) in points.iter().enumerate() {
        assert_eq!(counts[i] as usize, scenes::brute(&points, *point, 0.2).len(), "point {i}");
    }
}

/// Whatever the bytes, a cloud that is accepted can be searched safely.
#[test]
fn bytes_that_are_accepted_are_safe() {
    let random = &mut Random(19);
    let points: Vec<_> = (0..300).map(|_| random.point()).collect();
    let bytes = PointCloud::with_room(&points, 9, 310).unwrap().view().to_bytes();
    let mut accepted = 0;
    for _ in 0..by_suite(20_000, 300) {
        let mut wrong = bytes.clone();
        for _ in 0..1 + (random.next() * 3.0) as usize {
            let at = (random.next() * wrong.len() as f32) as usize;
            wrong[at.min(bytes.len() - 1)] ^= 1 << (random.next() * 8.0) as u32;
        }
        let lines = aligned(&wrong);
        let Ok(view) = CloudRef::from_bytes(&bytemuck::cast_slice(&lines)[..wrong.len()]) else { continue };
        accepted += 1;
        let (search, mut counts) = (RangeSearch::new(Isa::detect()), vec![0; view.capacity()]);
        search.count(&view, &Queries::own(), Radii::Same(0.2), &mut counts).unwrap();
        search.k_nearest(&view, [0.5; 3], &mut [Neighbour::NONE; 5]).unwrap();
    }
    assert!(accepted > 10, "{accepted}");
}

#[test]
fn every_splitter_makes_a_cloud() {
    let splitters = [
        Splitter::LongestAxis,
        Splitter::ExtendedLongestAxis,
        Splitter::SurfaceArea,
        Splitter::MeanWidth,
        Splitter::BatchNeuralGas { magnification: simdop::construct::Magnification::None, seed: 1 },
    ];
    for (name, points, radii) in scenes::all(by_suite(900, 100)) {
        let count = |cloud: &PointCloud| {
            let mut counts = vec![0; points.len()];
            let search = RangeSearch::new(Isa::detect());
            search.count(&cloud.view(), &Queries::own(), Radii::Same(radii[1]), &mut counts).unwrap();
            counts
        };
        let want = count(&PointCloud::new(&points).unwrap());
        for splitter in splitters {
            for bucket_size in [3, 16] {
                let mut cloud = PointCloud::split_by(&points, splitter, bucket_size).unwrap();
                cloud.view().validate().unwrap();
                assert_eq!(count(&cloud), want, "{name}, {splitter:?}");
                assert_eq!(cloud.refit(&points), Ok(1.0));
                cloud.rebuild().unwrap();
                assert_eq!(count(&cloud), want, "{name}, {splitter:?}");
            }
        }
    }
    for n in [0, 1, 16, 17] {
        let points = vec![[1.0, 2.0, 3.0]; n];
        assert_eq!(PointCloud::split_by(&points, Splitter::MeanWidth, 16).unwrap().view().len(), n);
    }
}
