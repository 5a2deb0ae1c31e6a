//! Clouds find what loops over their points find, and meet bodies in scenes.

mod support;

use simdop_capi::*;
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use support::{BALL, IDENTITY, Rng, answer, handle, shape};

const COUNT: usize = 300;

fn points(rng: &mut Rng, count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|_| [0; 3].map(|_| rng.range(-1.0, 1.0) as f32)).collect()
}

fn built(points: &[[f32; 3]]) -> Box<simdop_cloud> {
    // SAFETY: the length is that of the slice.
    handle(|cloud| unsafe { simdop_cloud_build(points.as_ptr().cast(), points.len(), cloud) }).unwrap()
}

/// The squared distance, rounded as the interface promises.
fn square(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y) + z * z
}

/// The indices of the points within a radius of a point, by a loop.
fn near(points: &[[f32; 3]], query: [f32; 3], radius: f32) -> Vec<u32> {
    (0..).zip(points).filter(|(_, p)| square(**p, query) <= radius * radius).map(|(i, _)| i).collect()
}

/// The lists of a search, sorted, and how many indices it needs.
fn lists(
    queries: usize,
    room: usize,
    search: impl FnOnce(&mut simdop_neighbour_lists) -> simdop_error,
) -> (simdop_error, Vec<Vec<u32>>, u64) {
    let mut lists = vec![simdop_list { start: 0, count: 0 }; queries];
    let mut indices = vec![0; room.max(1)];
    let mut into = simdop_neighbour_lists {
        lists: lists.as_mut_ptr(),
        list_count: queries,
        indices: indices.as_mut_ptr(),
        room,
        needed: 0,
    };
    let (error, needed) = (search(&mut into), into.needed);
    if error != simdop_error::None {
        return (error, Vec::new(), needed);
    }
    let list = |list: &simdop_list| {
        let mut found = indices[list.start as usize..][..list.count as usize].to_vec();
        found.sort_unstable();
        found
    };
    (error, lists.iter().map(list).collect(), needed)
}

#[test]
fn searches_find_what_a_loop_finds() {
    let mut rng = Rng::new(21);
    let (own, others) = (points(&mut rng, COUNT), points(&mut rng, 70));
    let cloud = built(&own);
    let each: Vec<f32> = (0..COUNT).map(|_| rng.range(0.0, 0.5) as f32).collect();
    for radii in [&each[..1], &each[..]] {
        let radius = |i: usize| radii[i % radii.len()];
        let expected: Vec<_> = (0..COUNT).map(|i| near(&own, own[i], radius(i))).collect();
        let total = expected.iter().map(Vec::len).sum::<usize>();
        let mut stats = MaybeUninit::uninit();
        let mut search = |into: &mut simdop_neighbour_lists| {
            // SAFETY: the lengths are those of the vectors.
            unsafe {
                simdop_cloud_neighbours(
                    Some(&cloud),
                    radii.as_ptr(),
                    radii.len(),
                    Some(into),
                    Some(&mut stats),
                )
            }
        };
        let (error, found, needed) = lists(COUNT, total, &mut search);
        assert_eq!((error, needed), (simdop_error::None, total as u64));
        assert_eq!(found, expected);
        // Too little room: it says how much is needed.
        let (error, _, needed) = lists(COUNT, total - 1, &mut search);
        assert_eq!((error, needed), (simdop_error::Buffer, total as u64));

        let mut counts = vec![0; COUNT];
        // SAFETY: the lengths are those of the vectors.
        let found = answer(|stats| unsafe {
            let (radii, len) = (radii.as_ptr(), radii.len());
            simdop_cloud_count(Some(&cloud), radii, len, counts.as_mut_ptr(), COUNT, stats)
        });
        assert_eq!(found.unwrap().neighbours, total as u64);
        assert!(counts.iter().zip(&expected).all(|(count, list)| *count as usize == list.len()));

        let radii = &radii[..radii.len().min(others.len())];
        let expected: Vec<_> =
            others.iter().enumerate().map(|(i, p)| near(&own, *p, radii[i % radii.len()])).collect();
        let mut memory = vec![0_u64; others.len()];
        let (error, found, _) = lists(others.len(), COUNT * others.len(), |into| {
            let (points, radii, len) = (others.as_ptr().cast(), radii.as_ptr(), radii.len());
            let mut stats = MaybeUninit::uninit();
            let (cloud, memory, stats) = (Some(&*cloud), memory.as_mut_ptr(), Some(&mut stats));
            // SAFETY: the lengths are those of the vectors.
            unsafe {
                simdop_cloud_neighbours_of(cloud, points, others.len(), radii, len, memory, Some(into), stats)
            }
        });
        assert_eq!((error, found), (simdop_error::None, expected));
    }
    simdop_cloud_destroy(Some(cloud));
}

unsafe extern "C" fn collect(user: *mut c_void, index: u32) -> c_int {
    // SAFETY: such a list is passed below.
    let (list, most) = unsafe { &mut *user.cast::<(Vec<u32>, usize)>() };
    list.push(index);
    c_int::from(list.len() == *most)
}

#[test]
fn single_searches_find_what_a_loop_finds() {
    let mut rng = Rng::new(22);
    let own = points(&mut rng, COUNT);
    let cloud = built(&own);
    for _ in 0..50 {
        let (centre, radius) = ([0; 3].map(|_| rng.range(-1.5, 1.5) as f32), rng.range(0.0, 0.4) as f32);
        let expected = near(&own, centre, radius);
        // SAFETY: there are three numbers.
        let is_any = answer(|is_any| unsafe {
            simdop_cloud_any_within(Some(&cloud), centre.as_ptr(), radius, is_any)
        });
        assert_eq!(is_any.unwrap() != 0, !expected.is_empty());
        for most in [usize::MAX, 2] {
            let mut found = (Vec::new(), most);
            // SAFETY: there are three numbers; the list is what the callback expects.
            let stats = answer(|stats| unsafe {
                let user = (&raw mut found).cast();
                simdop_cloud_each_within(Some(&cloud), centre.as_ptr(), radius, Some(collect), user, stats)
            });
            assert_eq!(stats.unwrap().neighbours, found.0.len() as u64);
            assert_eq!(found.0.len(), expected.len().min(most));
            found.0.sort_unstable();
            assert!(found.0.iter().all(|index| expected.contains(index)));
        }
    }
    let k = COUNT + 1;
    let none = simdop_neighbour { index: 0, square: 0.0 };
    let mut nearest = vec![none; 2 * k];
    // SAFETY: there are two points, and room for k of each.
    let error =
        unsafe { simdop_cloud_nearest(Some(&cloud), own.as_ptr().cast(), 2, k, nearest.as_mut_ptr()) };
    assert_eq!(error, simdop_error::None);
    for (query, nearest) in own.iter().zip(nearest.chunks(k)) {
        let mut expected: Vec<_> = (0..).zip(&own).map(|(i, p)| (square(*p, *query), i)).collect();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let found: Vec<_> = nearest[..COUNT].iter().map(|found| (found.square, found.index)).collect();
        assert_eq!(found, expected);
        assert_eq!((nearest[COUNT].index, nearest[COUNT].square), (u32::MAX, f32::INFINITY));
    }
    simdop_cloud_destroy(Some(cloud));
}

#[test]
fn points_move_come_and_go() {
    let mut rng = Rng::new(23);
    let mut own = points(&mut rng, 100);
    // SAFETY: the length is that of the vector.
    let cloud =
        handle(|cloud| unsafe { simdop_cloud_build_with_room(own.as_ptr().cast(), 100, 8, 120, cloud) });
    let mut cloud = cloud.unwrap();
    let size = |cloud: &simdop_cloud| answer(|size| simdop_cloud_get_size(Some(cloud), size)).unwrap();
    assert_eq!(size(&cloud), simdop_cloud_size { points: 100, capacity: 120 });
    own.resize(120, [9.0; 3]);
    own[110] = [0.5, 0.5, 0.5];
    // SAFETY: there are three numbers.
    let inserted = unsafe { simdop_cloud_insert(Some(&mut cloud), 110, own[110].as_ptr()) };
    assert_eq!(inserted, simdop_error::None);
    assert_eq!(simdop_cloud_remove(Some(&mut cloud), 3), simdop_error::None);
    assert_eq!(size(&cloud).points, 100);
    own.iter_mut().take(111).for_each(|p| p[1] += 10.0);
    // SAFETY: the length is that of the vector.
    let ratio =
        answer(|ratio| unsafe { simdop_cloud_refit(Some(&mut cloud), own.as_ptr().cast(), 120, ratio) });
    assert!(ratio.unwrap() > 0.9);
    assert_eq!(simdop_cloud_rebuild(Some(&mut cloud)), simdop_error::None);
    let mut counts = vec![7; 120];
    // SAFETY: the lengths are those of the vectors.
    let _ = answer(|stats| unsafe {
        simdop_cloud_count(Some(&cloud), [0.5].as_ptr(), 1, counts.as_mut_ptr(), 120, stats)
    })
    .unwrap();
    let is_there = |i: usize| i < 100 && i != 3 || i == 110;
    for i in 0..120 {
        let near = |j: &usize| is_there(*j) && square(own[*j], own[i]) <= 0.25;
        let expected = if is_there(i) { (0..120).filter(near).count() } else { 0 };
        assert_eq!(counts[i] as usize, expected, "{i}");
    }
    simdop_cloud_destroy(Some(cloud));
}

#[test]
fn a_cloud_in_a_scene_meets_bodies() {
    let cloud: &'static simdop_cloud = Box::leak(built(&[[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]));
    let ball: &'static simdop_body = Box::leak(shape(&BALL).unwrap());
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let (role, at) = (simdop_role { radius: 0.5, ..simdop_role_default() }, Some(&IDENTITY));
    let scan =
        answer(|id| simdop_scene_insert_cloud(Some(&mut scene), Some(cloud), Some(&role), at, id)).unwrap();
    let plain = simdop_role_default();
    let id = answer(|id| simdop_scene_insert(Some(&mut scene), Some(ball), Some(&plain), at, id)).unwrap();
    let near = answer(|near| simdop_scene_clearance(Some(&scene), 0.0, 9.0, SIMDOP_NO_BUDGET, near)).unwrap();
    assert!((near.upper - 1.5).abs() < 1e-9, "3 to the point, less 1 and 0.5: {}", near.upper);
    let mut there = IDENTITY;
    there.rows[1][3] = 2.500_001;
    assert_eq!(simdop_scene_place(Some(&mut scene), id, Some(&there)), simdop_error::None);
    let hit = answer(|answer| simdop_scene_collide(Some(&scene), SIMDOP_NO_BUDGET, answer)).unwrap();
    assert_eq!(hit.verdict, simdop_verdict::Hit);
    let point = if hit.hit.a == scan { hit.hit.pair.a } else { hit.hit.pair.b };
    assert_eq!(point, 1);
    simdop_scene_destroy(Some(scene));
}
