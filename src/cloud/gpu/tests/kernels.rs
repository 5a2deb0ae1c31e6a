//! Tests of each kernel alone.

use super::*;

/// The squared distance with products fused into sums.
fn fused([a, b]: &[[f32; 3]; 2]) -> u32 {
    let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a[i] - b[i]);
    libm::fmaf(z, z, libm::fmaf(y, y, x * x)).to_bits()
}

fn rounded([a, b]: &[[f32; 3]; 2]) -> u32 {
    let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a[i] - b[i]);
    ((x * x + y * y) + z * z).to_bits()
}

fn reordered([a, b]: &[[f32; 3]; 2]) -> u32 {
    let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a[i] - b[i]);
    (x * x + (y * y + z * z)).to_bits()
}

/// The pairs that a device must compute correctly before it may search.
#[test]
fn the_probes_tell_fused_and_reordered_operations() {
    let pairs = probes();
    for wrong in [fused, reordered] {
        let tell = pairs.iter().filter(|pair| wrong(pair) != rounded(pair)).count();
        assert!(tell > pairs.len() / 10, "{tell} of {}", pairs.len());
    }
    // Subnormal squares are not part of the probes.
    assert!(pairs.iter().all(|pair| f32::from_bits(rounded(pair)) > 1e-20));
}

#[test]
fn arithmetic_is_rounded_step_by_step() {
    let Some(gpu) = device() else { return };
    let mut on_device = DeviceCloud::new(gpu, &PointCloud::new(&[]).unwrap().view()).unwrap();
    let rng = &mut Rng::new(2);
    let coordinate = |rng: &mut Rng| {
        let exponent = 127 - 18 + (rng.u64() as u32) % 36;
        f32::from_bits((rng.u64() as u32) & 0x807f_ffff | exponent << 23)
    };
    let pairs: Vec<[[f32; 3]; 2]> =
        (0..20_000).map(|_| [(); 2].map(|()| [(); 3].map(|()| coordinate(rng)))).collect();
    let got = on_device.squares(&pairs).unwrap();
    for (pair, got) in pairs.iter().zip(got) {
        assert_eq!(got, rounded(pair), "{pair:?}");
    }
    assert!(pairs.iter().filter(|pair| fused(pair) != rounded(pair)).count() > 1000);
}

/// Buckets must be as the CPU's refit leaves them, and so must each level of nodes, given correct levels below.
#[test]
fn points_move_and_boxes_follow() {
    let Some(gpu) = device() else { return };
    let rng = &mut Rng::new(3);
    let before = points(rng, 900);
    let mut cloud = PointCloud::with_room(&before, 3, 903).unwrap();
    for index in 40..100 {
        cloud.remove(index).unwrap();
    }
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let old = cloud.view().nodes().to_vec();
    let after = points(rng, 903);
    cloud.refit(&after).unwrap();

    on_device.memory.write(gpu, CloudBinding::Positions, &after).unwrap();
    let groups = (4 * on_device.members.len()).div_ceil(WORKGROUP as usize);
    on_device.submit(&[(CloudShader::MovePoints, 0, groups)]).unwrap();
    let mut got = vec![Bucket::EMPTY; on_device.members.len()];
    on_device.memory.read(gpu, CloudBinding::Buckets, 0, &mut got).unwrap();
    let want = cloud.view().buckets();
    assert!(bytemuck::cast_slice::<_, u32>(&got) == bytemuck::cast_slice::<_, u32>(want));

    assert!(on_device.levels.len() > 2, "{:?}", on_device.levels);
    for number in 0..on_device.levels.len() {
        // The levels below are correct, and this one is outdated.
        let mut nodes = cloud.view().nodes().to_vec();
        let level = on_device.levels[number].clone();
        nodes[level.clone()].copy_from_slice(&old[level.clone()]);
        on_device.memory.write(gpu, CloudBinding::Nodes, &nodes).unwrap();
        let groups = (16 * level.len()).div_ceil(WORKGROUP as usize);
        on_device.submit(&[(CloudShader::Refit, number, groups + 1)]).unwrap();
        let got = on_device.nodes().unwrap();
        let want = cloud.view().nodes();
        assert!(bytemuck::cast_slice::<_, u32>(&nodes) != bytemuck::cast_slice::<_, u32>(want));
        assert!(
            bytemuck::cast_slice::<_, u32>(&got) == bytemuck::cast_slice::<_, u32>(want),
            "level {number}"
        );
    }
}

#[test]
fn seats_are_where_the_scalar_descent_ends() {
    let Some(gpu) = device() else { return };
    let rng = &mut Rng::new(4);
    let cloud = PointCloud::with_room(&points(rng, 1000), 7, 1000).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    // Inside, outside, and points of the cloud.
    let mut asked: Vec<[f32; 3]> = (0..500).map(|_| any_point(rng).map(|x| 3.0 * x - 1.0)).collect();
    asked.extend((0..500).map(|_| any_point(rng)));
    asked.extend(cloud.view().buckets().iter().map(|bucket| bucket.point(0)));
    let mut want = vec![Seat::default(); asked.len()];
    scalar().find_buckets(&cloud.view(), &asked, &mut want);

    let asks: Vec<[u32; 4]> =
        asked.iter().map(|p| [p[0].to_bits(), p[1].to_bits(), p[2].to_bits(), 0]).collect();
    on_device.memory.write(gpu, CloudBinding::Asks, &asks).unwrap();
    on_device.memory.make_room(gpu, CloudBinding::Seats, asks.len()).unwrap();
    let data = SearchData { count: asks.len() as u32, ..SearchData::default() };
    on_device.memory.write(gpu, CloudBinding::Search, &[data]).unwrap();
    on_device.submit(&[(CloudShader::Seat, 0, asks.len().div_ceil(WORKGROUP as usize))]).unwrap();
    let mut got = vec![0; asks.len()];
    on_device.memory.read(gpu, CloudBinding::Seats, 0, &mut got).unwrap();
    for ((got, want), point) in got.iter().zip(&want).zip(&asked) {
        assert_eq!(*got, want.bucket, "{point:?}");
    }
}

/// Two boxes so close to a query that a device cannot decide which is nearer.
#[test]
fn a_device_says_where_it_is_not_sure() {
    let Some(gpu) = device() else { return };
    let tiny = |i: usize| (i as f32 - 20.0) * 1e-15;
    let near: Vec<[f32; 3]> = (0..40).map(|i| [tiny(i), 0.0, 0.0]).collect();
    let cloud = PointCloud::with_room(&near, 1, 40).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let asked: Vec<[f32; 3]> = (0..40).map(|i| [tiny(i) + 4e-16, 1e-16, 0.0]).collect();
    let (mut seats, mut want) = (vec![Seat::default(); 40], vec![Seat::default(); 40]);
    scalar().seat(&cloud.view(), &asked, &mut want).unwrap();
    on_device.seat(&asked, &mut seats).unwrap();
    assert_eq!(seats, want);
    assert!(want.iter().any(|seat| seat.bucket != want[0].bucket));
    let mut got = vec![0; 40];
    on_device.memory.read(gpu, CloudBinding::Seats, 0, &mut got).unwrap();
    assert!(got.contains(&shader::UNSURE));
}

/// Sums saturate at the largest number.
#[test]
fn scans_add_up_all_before() {
    let Some(gpu) = device() else { return };
    let rng = &mut Rng::new(6);
    for (packets, shift) in
        [(1_usize, 20), (2, 20), (63, 20), (64, 20), (65, 20), (4097, 24), (5000, 20), (300, 4)]
    {
        let mut on_device = DeviceCloud::new(gpu, &PointCloud::new(&[]).unwrap().view()).unwrap();
        let counts: Vec<u32> = (0..16 * packets).map(|_| (rng.u64() as u32) >> shift).collect();
        let own: Vec<[u32; 4]> = (0..16 * packets as u32).map(|i| [0, 0, 0, i ^ 1]).collect();
        let ranges: Vec<[u32; 2]> = (0..packets as u32).map(|packet| [16 * packet, 16]).collect();
        let memory = &mut on_device.memory;
        memory.write(gpu, CloudBinding::Counts, &counts).unwrap();
        memory.write(gpu, CloudBinding::Asks, &own).unwrap();
        memory.write(gpu, CloudBinding::Packets, &ranges).unwrap();
        let groups = packets.div_ceil(WORKGROUP as usize);
        memory.make_room(gpu, CloudBinding::Starts, packets).unwrap();
        memory.make_room(gpu, CloudBinding::Totals, groups).unwrap();
        memory.make_room(gpu, CloudBinding::Lists, 16 * packets).unwrap();
        let data = SearchData { count: packets as u32, own: NO_BUCKET, ..SearchData::default() };
        memory.write(gpu, CloudBinding::Search, &[data]).unwrap();
        let what = format!("{packets} packets");

        // Sums within groups of as many packets as a workgroup has threads.
        on_device.submit(&[(CloudShader::Scan, 0, groups)]).unwrap();
        let before = |counts: &[u32]| -> Vec<u32> {
            let mut sum = 0_u32;
            let step = |&count: &u32| {
                let before = sum;
                sum = before.saturating_add(count);
                before
            };
            counts.iter().map(step).collect()
        };
        let mut got = vec![0; 16 * packets];
        on_device.memory.read(gpu, CloudBinding::Starts, 0, &mut got).unwrap();
        let chunks = counts.chunks(16 * WORKGROUP as usize);
        let want: Vec<u32> = chunks.clone().flat_map(before).collect();
        assert!(got == want, "{what}: scan");
        let totals: Vec<u32> =
            chunks.map(|counts| counts.iter().fold(0_u32, |sum, &count| sum.saturating_add(count))).collect();
        let mut got = vec![0; groups];
        on_device.memory.read(gpu, CloudBinding::Totals, 0, &mut got).unwrap();
        assert!(got == totals, "{what}: totals");

        on_device.submit(&[(CloudShader::ScanTotals, 0, 1)]).unwrap();
        on_device.memory.read(gpu, CloudBinding::Totals, 0, &mut got).unwrap();
        assert!(got == before(&totals), "{what}: scan_totals");

        let threads = (16 * packets).div_ceil(WORKGROUP as usize);
        on_device.submit(&[(CloudShader::WriteLists, 0, threads + 1)]).unwrap();
        let (mut lists, starts) = (vec![[0_u32; 2]; 16 * packets], before(&counts));
        on_device.memory.read(gpu, CloudBinding::Lists, 0, &mut lists).unwrap();
        let want = (0..16 * packets).map(|i| [starts[i ^ 1], counts[i ^ 1]]);
        assert!(lists.into_iter().eq(want), "{what}: write_lists");
        assert_eq!(starts.last() == Some(&u32::MAX), shift == 4, "{what}");
    }
}

/// Runs `count` alone, and `fill` alone with starts computed on the CPU.
#[test]
fn packets_count_and_fill_as_the_scalar_search() {
    let Some(gpu) = device() else { return };
    let rng = &mut Rng::new(7);
    let cloud = PointCloud::with_room(&points(rng, 3000), 11, 3000).unwrap();
    let view = cloud.view();
    let others = points(rng, 300);
    let mut seats = vec![Seat::default(); others.len()];
    let packed = scalar().seat(&view, &others, &mut seats).unwrap();
    let each: Vec<f32> = (0..3000).map(|i| 0.02 + (i % 5) as f32 * 0.05).collect();
    let mut on_device = DeviceCloud::new(gpu, &view).unwrap();
    for (queries, room) in [(&Queries::own(), 3000), (&packed, others.len())] {
        // The largest radius makes packets process their candidates in several rounds.
        for radii in [Radii::Same(0.05), Radii::Each(&each), Radii::Same(0.6)] {
            let what =
                format!("{radii:?}, {room} queries").chars().take(60).collect::<alloc::string::String>();
            let mut lists = vec![List::default(); room];
            let mut want = vec![0; 40_000_000];
            let work = scalar().fill(&view, queries, radii, &mut lists, &mut want).unwrap();
            let asked = on_device.ask(queries, &radii).unwrap();
            on_device.run_packets(CloudShader::Count, &asked, 0..asked.packets, 0).unwrap();
            let mut counts = vec![0_u32; 16 * asked.packets];
            on_device.memory.read(gpu, CloudBinding::Counts, 0, &mut counts).unwrap();
            let mut starts = vec![0_u32; 16 * asked.packets];
            for (i, &query) in asked.queries.as_flattened().iter().enumerate() {
                let list = lists.get(query as usize).copied().unwrap_or_default();
                assert_eq!(counts[i], list.count, "{what}: query {query}");
                starts[i] = list.start;
            }
            // Start after the first packet.
            let first = asked.packets / 3;
            let start = starts[16 * first..].iter().copied().find(|start| *start > 0).unwrap() as usize;
            let total = work.neighbours as usize;
            on_device.memory.write(gpu, CloudBinding::Starts, &starts).unwrap();
            on_device.memory.write(gpu, CloudBinding::Indices, &vec![u32::MAX; total - start]).unwrap();
            on_device.run_packets(CloudShader::Fill, &asked, first..asked.packets, start).unwrap();
            let mut got = vec![0; total - start];
            on_device.memory.read(gpu, CloudBinding::Indices, 0, &mut got).unwrap();
            assert!(got[..] == want[start..total], "{what}");
        }
    }
    assert!(matches!(packed.0, Asking::Others { .. }));
}
