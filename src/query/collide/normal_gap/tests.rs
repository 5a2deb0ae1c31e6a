//! Two children that share a point, or come within the margin, are never separated; and each of the four ways to
//! separate other children occurs.

use super::*;
use crate::construct::{Builder, Mesh};
use crate::directions::Directions;
use crate::frame::Frame;
use crate::hierarchy::{Bvh, BvhRef};
use crate::key::{Fixed, Key, Storage};
use crate::node::{Link, Node4, Node16};
use crate::primitive::triangle::distance::within;
use crate::primitive::triangle::overlap;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;

type Soup = Vec<[Point; 3]>;

/// Calls a generic function once for every node type.
macro_rules! for_each_node {
    // An emulated CPU takes a minute for all.
    ($function:ident) => {
        if cfg!(simdop_neon) {
            for_each_node!($function; Node16<18>, Node4<14>)
        } else {
            for_each_node!($function; Node16<6>, Node16<14>, Node16<18>, Node16<26>, Node16<32>,
                Node4<6>, Node4<14>, Node4<18>, Node4<26>, Node4<32>)
        }
    };
    ($function:ident; $($node:ty),*) => {{ $( $function::<$node>(); )* }};
}

/// The generator `SplitMix64`.
struct Random(u64);

impl Random {
    fn u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    /// In -1 ..= 1.
    fn signed(&mut self) -> f64 {
        (self.u64() as i64 >> 11) as f64 * power_of_two(-52)
    }

    fn rotation(&mut self) -> [[f64; 3]; 3] {
        let q = loop {
            let q: [f64; 4] = core::array::from_fn(|_| self.signed());
            let square: f64 = q.iter().map(|x| x * x).sum();
            if (0.01..1.0).contains(&square) {
                break q.map(|x| x / square.sqrt());
            }
        };
        let [x, y, z, w] = q;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// About one of the axes, and so close to a rotation that its deviation rounds to nothing.
    fn turn_without_skew(&mut self) -> [[f64; 3]; 3] {
        let (s, c) = loop {
            let (s, c) = libm::sincos(4.0 * self.signed());
            if s * s + c * c == 1.0 {
                break (s, c);
            }
        };
        let axis = self.u64() as usize % 3;
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut rows = [[0.0; 3]; 3];
        (rows[axis][axis], rows[i][i], rows[j][j]) = (1.0, c, c);
        (rows[i][j], rows[j][i]) = (-s, s);
        rows
    }
}

/// How a matrix deviates from a rotation.
#[derive(Copy, Clone, PartialEq, Debug)]
enum Deviation {
    /// By the rounding of `f64`.
    None,
    /// Its entries have five digits.
    Digits,
    /// It stretches or shrinks by nearly as much as is accepted.
    Stretch(f64),
}

fn pose_of(rotation: [[f64; 3]; 3], deviation: Deviation, t: Point) -> Pose {
    let entry = |x: f64| match deviation {
        Deviation::None => x,
        Deviation::Digits => libm::rint(x * 1e5) / 1e5,
        Deviation::Stretch(by) => x * by,
    };
    let row = |i: usize| {
        let [x, y, z] = rotation[i].map(entry);
        [x, y, z, t[i]]
    };
    Pose::from_rows([row(0), row(1), row(2)]).unwrap()
}

/// A saddle with corners at multiples of a quarter, whose triangles have many normals.
fn saddle(side: i32) -> Soup {
    let at = |i: i32, j: i32| [f64::from(i), f64::from(j), f64::from(i * i - j * j + i * j) / 4.0];
    let quads = (-side..side).flat_map(|i| (-side..side).map(move |j| (i, j)));
    let halves = |(i, j): (i32, i32)| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    quads.flat_map(halves).collect()
}

/// Flat, and not along any direction of a k-DOP.
fn sheet(side: i32) -> Soup {
    let lift = |[x, y, _]: Point| [x, y, 0.25 * x - 0.375 * y];
    saddle(side).into_iter().map(|t| t.map(lift)).collect()
}

fn map(soup: &Soup, f: impl Fn(Point) -> Point) -> Soup {
    soup.iter().map(|t| t.map(&f)).collect()
}

fn tree_of<N: Lanes>(soup: &Soup) -> Bvh<N> {
    let vertices: Vec<Point> = soup.iter().flatten().copied().collect();
    let triangles: Vec<[u32; 3]> = (0..soup.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Builder::fast().build_as(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap()
}

/// A lane, its slab, and the primitives below it, by their indices in leaf order.
struct Volume<N> {
    node: N,
    lane: usize,
    slab: NormalSlab,
    below: Vec<u32>,
}

impl<N> Volume<N> {
    const fn child(&self) -> NormalChild<'_, N> {
        NormalChild { node: &self.node, lane: self.lane, slab: self.slab }
    }
}

/// All used lanes of a tree.
fn volumes<N: Lanes>(tree: &BvhRef<'_, N>) -> Vec<Volume<N>> {
    let mut below: BTreeMap<(u32, usize), Vec<u32>> = BTreeMap::new();
    let mut walk = tree.walk();
    while let Some(lane) = walk.next() {
        let Link::Leaf { first, count } = lane.child.link() else { continue };
        for place in walk.path() {
            below.entry(place).or_default().extend(first..first + count);
        }
    }
    let volume = |((node, lane), below): ((u32, usize), Vec<u32>)| Volume {
        node: tree.nodes()[node as usize],
        lane,
        slab: tree.normal_slab(node, lane).unwrap(),
        below,
    };
    below.into_iter().map(volume).collect()
}

/// The thinnest slab with a given direction and low end, or with the low end a step higher, that `verify` accepts.
fn thinnest(slab: NormalSlab, frame: &Frame, corners: &[Point]) -> NormalSlab {
    let bits: u64 = bytemuck::cast(slab);
    let with = |low: i64, code: u64| -> NormalSlab {
        bytemuck::cast(bits & 0xff_ffff | code << 24 | (low as u64) << 40)
    };
    let sides = |slab: NormalSlab, end: usize| {
        corners.iter().map(move |p| frame.side(&slab.normal(), *p, slab.ends()[end]))
    };
    if slab == NormalSlab::EVERYWHERE {
        return slab;
    }
    let low = bits as i64 >> 40;
    let low = if sides(with(low + 1, 0), 0).all(|side| side >= 0) { low + 1 } else { low };
    let (mut short, mut enough) = (-1, 0x7c00);
    while enough - short > 1 {
        let middle = (short + enough) / 2;
        let holds = sides(with(low, middle as u64), 1).all(|side| side <= 0);
        if holds { enough = middle } else { short = middle }
    }
    with(low, enough as u64)
}

/// All used lanes of a tree, with slabs as thin as `verify` accepts.
fn thinnest_volumes<N: Lanes>(tree: &BvhRef<'_, N>) -> Vec<Volume<N>> {
    let mut all = volumes(tree);
    for volume in &mut all {
        let corners: Vec<Point> = volume.below.iter().flat_map(|&i| tree.primitive(i)).collect();
        volume.slab = thinnest(volume.slab, &tree.frame(), &corners);
    }
    all
}

/// The pairs that are separated.
fn apart<N: Lanes>(test: &NormalTest<'_>, a: &[Volume<N>], b: &[Volume<N>]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (i, x) in a.iter().enumerate() {
        for (first, four) in b.chunks(AT_ONCE).enumerate() {
            let of_a = [x.child(); AT_ONCE];
            let of_b = core::array::from_fn(|j| four[j.min(four.len() - 1)].child());
            let mask = test.apart(&of_a, &of_b);
            found.extend((0..four.len()).filter(|j| mask >> j & 1 != 0).map(|j| (i, AT_ONCE * first + j)));
        }
    }
    found
}

/// Requires that no two lanes are separated if primitives below them meet according to `meet`, which takes source
/// indices. Returns the number of separated lanes.
fn never_apart<N: Lanes>(
    what: &str,
    (a, volumes_a): (&BvhRef<'_, N>, &[Volume<N>]),
    (b, volumes_b): (&BvhRef<'_, N>, &[Volume<N>]),
    (pose, margin): (&Pose, f64),
    meet: &dyn Fn(usize, usize) -> bool,
) -> usize {
    let test = NormalTest::new(pose, &a.extent(), &b.extent(), margin);
    let found = apart(&test, volumes_a, volumes_b);
    for &(i, j) in &found {
        for &p in &volumes_a[i].below {
            for &q in &volumes_b[j].below {
                let (s, t) = (a.source(p) as usize, b.source(q) as usize);
                assert!(!meet(s, t), "k {} arity {}, {what}: triangles {s} and {t} meet", N::K, N::ARITY);
            }
        }
    }
    found.len()
}

/// A triangle `size` times as large as the bodies of these tests, and far from them: it makes a frame coarse.
fn stray(size: f64) -> [Point; 3] {
    [[8.0, 1.0, 9.0], [8.0, 9.0, 1.0], [1.0, 8.0, 9.0]].map(|p| p.map(|x| x * size))
}

/// B is A as moved by the pose, bit by bit: each triangle meets its own image in all corners and lies in the same
/// plane, so that slabs are as close as possible.
fn images_meet<N: Lanes>() {
    let mut random = Random(1);
    let turned = [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]];
    let (mut asked, mut found) = (0, 0);
    let units = [0, -20, 40].map(power_of_two);
    // Exponents of the strays in A and in B, which make the frame of one body that much coarser than the other's.
    let strays = [(0, 0), (2, 0), (0, 3), (20, 0), (0, 20), (40, 0), (0, 40)];
    let offsets = [0.0, 10.0, 1e9, power_of_two(40)];
    let deviations =
        [Deviation::None, Deviation::Digits, Deviation::Stretch(1.00004), Deviation::Stretch(0.99996)];
    // Every deviation with every offset and every stray.
    for round in 0..4 * 4 * 7 {
        let (deviation, offset) = (deviations[round % 4], offsets[round / 4 % 4]);
        let (in_a, in_b) = strays[round % 7];
        let unit = units[random.u64() as usize % 3];
        let centre: [Point; 2] =
            [(); 2].map(|()| [(); 3].map(|()| libm::rint(offset * random.signed()) * unit));
        let shape = if random.u64() & 1 == 0 { saddle(2) } else { sheet(2) };
        let mut soup = map(&shape, |p| core::array::from_fn(|i| p[i] * unit + centre[0][i]));
        let rotation = if round % 5 == 0 { turned } else { random.rotation() };
        let pose = pose_of(rotation, deviation, core::array::from_fn(|i| centre[1][i] - centre[0][i]));
        let mut image = map(&soup, |p| pose.apply(p));
        let count = soup.len();
        if in_a > 0 {
            soup.push(stray(power_of_two(in_a) * unit));
        }
        if in_b > 0 {
            image.push(stray(power_of_two(in_b) * unit));
        }
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&image));
        let (a, b) = (a.view(), b.view());
        let moved = |i: usize| soup[i].map(|p| pose.apply(p));
        // Where corners are not shared, exact arithmetic decides.
        let meet = |i: usize, j: usize| (i == j && i < count) || overlap(&moved(i), &image[j], &mut 0);
        let what = alloc::format!("{deviation:?}, offset {offset:e}, strays 2^{in_a} 2^{in_b}, {pose:?}");
        for thin in [volumes, thinnest_volumes] {
            let (of_a, of_b) = (thin(&a), thin(&b));
            found += never_apart(&what, (&a, &of_a), (&b, &of_b), (&pose, 0.0), &meet);
            asked += of_a.len() * of_b.len();
        }
    }
    assert!(found * 16 > asked, "{found} of {asked} were apart");
}

#[test]
fn what_shares_a_point_is_never_apart() {
    for_each_node!(images_meet);
}

/// B is A's image, moved along a normal by the margin, the greatest distance that still counts.
fn margins_reach<N: Lanes>() {
    let mut random = Random(2);
    for (round, size) in (0..6).flat_map(|r| [1e-6, 1e-3, 0.25, 4.0, 1e3].map(|size| (r, size))) {
        let soup = if round % 2 == 0 { sheet(2) } else { saddle(1) };
        let pose = pose_of(random.rotation(), Deviation::None, [random.signed(); 3]);
        let [p, q, r] =
            soup[random.u64() as usize % soup.len()].map(|p| glam::DVec3::from_array(pose.apply(p)));
        let step = (q - p).cross(r - p).normalize() * size * if round < 3 { 1.0 } else { -1.0 };
        let image = map(&soup, |p| (glam::DVec3::from_array(pose.apply(p)) + step).to_array());
        // Rounding may have moved it farther.
        let margin = size * (1.0 + 1e-12) + 1e-12;
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&image));
        let (a, b) = (a.view(), b.view());
        let moved = |i: usize| soup[i].map(|p| pose.apply(p));
        let meet = |i: usize, j: usize| i == j || within(&moved(i), &image[j], margin, &mut 0);
        let (of_a, of_b) = (thinnest_volumes(&a), thinnest_volumes(&b));
        let what = alloc::format!("margin {margin:e}, round {round}");
        never_apart(&what, (&a, &of_a), (&b, &of_b), (&pose, margin), &meet);
        let lower = never_apart(&what, (&a, &of_a), (&b, &of_b), (&pose, 1e-3 * margin), &|_, _| false);
        assert!(size < 0.25 || lower > 0, "{what}: with less of a margin, some are apart");
    }
}

#[test]
fn what_comes_within_the_margin_is_never_apart() {
    for_each_node!(margins_reach);
}

/// Corners that the pose moves to below the least coordinate become zero; B is there.
fn flushed_corners_meet<N: Lanes>() {
    let mut random = Random(3);
    for _ in 0..20 {
        let soup = map(&saddle(2), |p| p.map(|x| 4.0 * x * MIN_COORDINATE));
        let pose = pose_of(random.rotation(), Deviation::None, [0.0; 3]);
        let image = map(&soup, |p| pose.apply(p));
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&image));
        let (a, b) = (a.view(), b.view());
        let (of_a, of_b) = (thinnest_volumes(&a), thinnest_volumes(&b));
        never_apart("flushed", (&a, &of_a), (&b, &of_b), (&pose, 0.0), &|i, j| i == j);
    }
}

#[test]
fn corners_that_become_zero_are_met() {
    for_each_node!(flushed_corners_meet);
}

/// B is a point, which is a corner of A as moved by the pose; the planes of A and all slabs pass through it without
/// rounding, so that every rounding of the test itself shows. Keys lie halfway between two steps, and so do the corners
/// along the axes, but not along directions whose components have an even sum.
fn exact_corners_meet<N: Lanes>() {
    // With a step of 1: twice as much is above the greatest key.
    let w = 16_383.5;
    let corner = |x: f64, y: f64| [x * w, y * w, 0.0];
    let soup: Soup = alloc::vec![
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
        [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
    ];
    let mut random = Random(4);
    let mut poses = 0;
    while poses < 40 {
        // A pad for a deviation from a rotation would hide all other errors.
        let rotation = random.turn_without_skew();
        let (i, c) = (random.u64() as usize % soup.len(), random.u64() as usize % 3);
        let image = pose_of(rotation, Deviation::None, [0.0; 3]).apply(soup[i][c]);
        let target: Point = [(); 3].map(|()| libm::rint(8.0 * random.signed()));
        let pose = pose_of(rotation, Deviation::None, core::array::from_fn(|i| target[i] - image[i]));
        if pose.apply(soup[i][c]) != target {
            continue;
        }
        poses += 1;
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&alloc::vec![[target; 3]]));
        let (a, b) = (a.view(), b.view());
        let of_a = thinnest_volumes(&a);
        let plane = |j: usize| of_a[0].node.plane(j, of_a[0].lane);
        assert_eq!(
            [0, 1, 2, 3].map(|j| f64::from(Fixed::value(plane(j)))),
            [w; 4],
            "planes pass through the corners"
        );
        assert_eq!(of_a[0].slab.ends(), [0.0; 2]);
        let meet = |t: usize, _| soup[t].contains(&soup[i][c]);
        for _ in 0..10 {
            let normal = [(); 3].map(|()| random.signed());
            let of_b: Vec<Volume<N>> = volumes(&b)
                .into_iter()
                .map(|v| Volume {
                    slab: thinnest(NormalSlab::new(normal, |_| (0.0, 0.0)), &b.frame(), &[target]),
                    ..v
                })
                .collect();
            assert_eq!(of_b[0].slab.ends(), [0.0; 2]);
            never_apart("a corner", (&a, &of_a), (&b, &of_b), (&pose, 0.0), &meet);
        }
    }
}

#[test]
fn what_the_test_rounds_is_paid_for() {
    for_each_node!(exact_corners_meet; Node16<6>, Node4<6>);
}

/// Bodies of any shape at poses at which some of their triangles meet and most do not.
fn brute_force_agrees<N: Lanes>() {
    let mut random = Random(5);
    let (mut free, mut found) = (0, 0);
    for round in 0..12 {
        let [soup, still] = [(); 2].map(|()| -> Soup {
            let triangle = |_| {
                let centre: Point = [(); 3].map(|()| 4.0 * random.signed());
                [(); 3].map(|()| centre.map(|x| x + 1.5 * random.signed()))
            };
            (0..30).map(triangle).collect()
        });
        let factor = [1.0, 1e-2, 1e6, 1e-6][round % 4];
        let soup = map(&soup, |p| p.map(|x| x * factor));
        let t = [(); 3].map(|()| 2.0 * random.signed());
        let pose = pose_of(random.rotation(), Deviation::None, t);
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&still));
        let (a, b) = (a.view(), b.view());
        let meet = |i: usize, j: usize| overlap(&soup[i].map(|p| pose.apply(p)), &still[j], &mut 0);
        let (of_a, of_b) = (volumes(&a), volumes(&b));
        found += never_apart("soups", (&a, &of_a), (&b, &of_b), (&pose, 0.0), &meet);
        free += of_a.len() * of_b.len();
    }
    assert!(found * 4 > free, "{found} of {free} were apart");
}

#[test]
fn what_meets_is_never_apart() {
    for_each_node!(brute_force_agrees);
}

/// Each of the four ways to separate: a sheet, and a ball of triangles just above or just below its middle, which
/// neither k-DOPs nor the primitive slab of the ball's triangles separate.
fn each_side_separates<N: Lanes>() {
    let mut random = Random(6);
    let (flat, normal) = (map(&sheet(1), |p| p.map(|x| 8.0 * x)), glam::dvec3(-0.25, 0.375, 1.0).normalize());
    for round in 0..20 {
        let rotation = random.rotation();
        let turn = pose_of(rotation, Deviation::None, [0.0; 3]);
        for side in [-1.0, 1.0] {
            let ball: Soup = (0..4)
                .map(|_| {
                    [(); 3].map(|()| {
                        let p = glam::DVec3::from_array([(); 3].map(|()| random.signed())).normalize();
                        p.to_array()
                    })
                })
                .collect();
            let above = side * 3.0 * normal;
            // The ball as B, where the pose moves the sheet's plane.
            let centre = turn.apply(above.to_array());
            let still = map(&ball, |p| core::array::from_fn(|i| p[i] + centre[i]));
            let (sheet, ball_b) = (tree_of::<N>(&flat), tree_of::<N>(&still));
            assert!(
                roots_apart(&sheet.view(), &ball_b.view(), &turn),
                "round {round}, by a's normal, {side}"
            );
            // The ball as A, which the pose rotates and moves to the sheet.
            let (ball_a, there) = (tree_of::<N>(&ball), pose_of(rotation, Deviation::None, above.to_array()));
            assert!(
                roots_apart(&ball_a.view(), &sheet.view(), &there),
                "round {round}, by b's normal, {side}"
            );
        }
    }
}

/// Whether all pairs of lanes of two roots are separated.
fn roots_apart<N: Lanes>(a: &BvhRef<'_, N>, b: &BvhRef<'_, N>, pose: &Pose) -> bool {
    let (of_a, of_b) = (volumes(a), volumes(b));
    let test = NormalTest::new(pose, &a.extent(), &b.extent(), 0.0);
    apart(&test, &of_a, &of_b).len() == of_a.len() * of_b.len()
}

#[test]
fn a_sheet_is_told_from_what_lies_on_either_side() {
    for_each_node!(each_side_separates);
}

/// Unbounded planes bound nothing, and neither do unbounded slabs: touching bodies are not separated, whatever is
/// unbounded, and far bodies are not separated along an unbounded slab.
fn unbounded_is_never_apart<N: Lanes>() {
    let mut random = Random(7);
    let soup = saddle(2);
    for round in 0..20 {
        let pose = pose_of(random.rotation(), Deviation::None, [0.5; 3]);
        let image = map(&soup, |p| pose.apply(p));
        let (a, b) = (tree_of::<N>(&soup), tree_of::<N>(&image));
        let (a, b) = (a.view(), b.view());
        let (mut of_a, mut of_b) = (thinnest_volumes(&a), thinnest_volumes(&b));
        for volume in of_a.iter_mut().chain(&mut of_b) {
            for j in 0..N::K {
                if random.u64().is_multiple_of(4) || round == 0 {
                    volume.node.raise_plane(j, volume.lane, Key::GREATEST);
                }
            }
        }
        never_apart("planes", (&a, &of_a), (&b, &of_b), (&pose, 0.0), &|i, j| i == j);
        let far = pose_of(*pose.rows(), Deviation::None, [1e6; 3]);
        let test = NormalTest::new(&far, &a.extent(), &b.extent(), 0.0);
        for volume in if round % 2 == 0 { &mut of_a } else { &mut of_b } {
            volume.slab = NormalSlab::EVERYWHERE;
        }
        assert_eq!(apart(&test, &of_a, &of_b), [], "slabs");
        assert_eq!(apart(&test, &volumes(&a), &volumes(&b)).len(), of_a.len() * of_b.len(), "they are far");
    }
}

#[test]
fn unbounded_planes_and_slabs_never_separate() {
    for_each_node!(unbounded_is_never_apart);
}

/// The supports of children, computed from their planes, are never below those of the corners, and equal them along the
/// directions of the planes.
fn supports_bound<const K: usize, N: Lanes>() {
    let mut random = Random(8);
    let soup = saddle(2);
    let tree = tree_of::<N>(&soup);
    let (tree, frame) = (tree.view(), tree.view().frame());
    for volume in volumes(&tree) {
        let corners = || volume.below.iter().flat_map(|&i| tree.primitive(i));
        let along = |n: Point| {
            let x = corners()
                .map(|p| (0..3).map(|i| n[i] * (p[i] - frame.centre[i])).sum::<f64>() * frame.scale());
            x.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        for _ in 0..4 {
            let j = random.u64() as usize % K;
            let directions: [Point; AT_ONCE] = [
                Directions::<K>::VECTORS[j],
                [(); 3].map(|()| 2047.0 * random.signed()),
                [(); 3].map(|()| random.signed()),
                [0.0; 3],
            ];
            let columns = core::array::from_fn(|i| directions.map(|n| n[i]));
            let [low, high] = N::supports_of_children([(&volume.node, volume.lane); AT_ONCE], &columns);
            for (s, n) in directions.into_iter().enumerate() {
                let (least, greatest) = along(n);
                let slack = 1e-9 * n.iter().map(|x| x.abs()).sum::<f64>();
                assert!(low[s] <= least + slack && high[s] >= greatest - slack, "k {K}: {n:?}");
            }
            let plane =
                |j: usize| Key::<Fixed>::from_code(volume.node.plane(j, volume.lane)).unwrap().to_f64();
            assert!(
                (high[0] - plane(j)).abs() <= 1e-9 && (low[0] + plane(j ^ 1)).abs() <= 1e-9,
                "k {K}, {j}"
            );
            assert_eq!([low[3], high[3]], [0.0; 2]);
        }
    }
}

#[test]
fn supports_of_children_are_those_of_their_planes() {
    supports_bound::<6, Node16<6>>();
    supports_bound::<14, Node4<14>>();
    supports_bound::<18, Node16<18>>();
    supports_bound::<26, Node4<26>>();
    supports_bound::<32, Node16<32>>();
}
