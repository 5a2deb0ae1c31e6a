//! From prototypes to the order of the primitives.

use super::*;

fn check_nearest<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.run(Shader::Nearest);
    let got: Vec<u32> = rig.read(Binding::Lanes, nodes.order.len());
    let got_counts: Vec<u32> = rig.read(Binding::Counts, rig.chunks.len() * N);
    for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(_, (usable, _))| *usable) {
        let (node, mut lanes) = (&rig.nodes[i], Vec::new());
        let sizes = nearest(cluster, &prototypes[i], &mut lanes);
        let own = &got[node.start as usize..][..node.count as usize];
        assert!(own.iter().copied().eq(lanes.iter().map(|&lane| u32::from(lane))), "node {i}");
        let mut total = [0; N];
        for counts in got_counts[node.first_chunk as usize * N..][..node.chunks as usize * N].chunks(N) {
            total.iter_mut().zip(counts).for_each(|(total, count)| *total += count);
        }
        assert_eq!(total, sizes, "node {i}");
    }
}

#[test]
fn nearest_of_4() {
    for_all::<4>(check_nearest);
}

#[test]
fn nearest_of_16() {
    for_all::<16>(check_nearest);
}

fn check_balance<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    if rig.level.large_nodes > 0 {
        return;
    }
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(0, |i| if clusters[i].0 { 1 } else { SMALL }));
    let (mut lanes, mut sizes) = (Vec::new(), Vec::new());
    for (i, (usable, cluster)) in clusters.iter().enumerate() {
        let (mut own, mut own_sizes) = (vec![0; nodes.sizes[i]], [0; N]);
        if *usable {
            own_sizes = nearest(cluster, &prototypes[i], &mut own);
        }
        lanes.push(own);
        sizes.push(own_sizes);
    }
    rig.write(Binding::Lanes, &lanes.iter().flatten().map(|&lane| lane.into()).collect::<Vec<u32>>());
    rig.write(Binding::Counts, sizes.as_flattened());
    rig.write(Binding::Ends, &vec![0_u32; SIZES.len() * N]);
    (0..balance_dispatches(N, LEAF_SIZE)).for_each(|_| rig.run(Shader::Balance));
    let got: Vec<u32> = rig.read(Binding::Lanes, nodes.order.len());
    let got_sizes: Vec<u32> = rig.read(Binding::Counts, SIZES.len() * N);
    let mut balance = Balance::<N>::default();
    for (i, (usable, cluster)) in clusters.iter().enumerate() {
        if *usable {
            balance.balance(cluster, &prototypes[i], LEAF_SIZE, &mut lanes[i], &mut sizes[i]);
        }
        let own = &got[rig.nodes[i].start as usize..][..nodes.sizes[i]];
        assert_eq!(got_sizes[i * N..][..N], sizes[i], "node {i}");
        assert!(own.iter().copied().eq(lanes[i].iter().map(|&lane| u32::from(lane))), "node {i}");
    }
}

#[test]
fn balance_of_4() {
    for_all::<4>(check_balance);
}

#[test]
fn balance_of_16() {
    for_all::<16>(check_balance);
}

/// `lane_ends`, `sort_by_lane` and `replace`, whose twin is one function.
fn check_sort<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    const UNTOUCHED: u32 = 123;
    // Node 1 was found to be small before, all of node 2 is in lane 3.
    let lane = |i: usize, random: &mut Random| if i == 2 { 3 } else { random.below(N as u32) as u8 };
    let lanes: Vec<Vec<u8>> = nodes
        .sizes
        .iter()
        .enumerate()
        .map(|(i, &size)| (0..size).map(|_| lane(i, random)).collect())
        .collect();
    let flat: Vec<u32> = lanes.iter().flatten().map(|&lane| lane.into()).collect();
    let counts: Vec<[u32; N]> = rig
        .chunks
        .iter()
        .map(|chunk| {
            let mut counts = [0; N];
            let own = &flat[chunk.start as usize..][..chunk.count as usize];
            own.iter().for_each(|&lane| counts[lane as usize] += 1);
            counts
        })
        .collect();
    rig.write(Binding::Lanes, &flat);
    rig.write(Binding::Counts, counts.as_flattened());
    rig.write(Binding::States, &rig.states(0, |i| if i == 1 { SMALL } else { 1 }));
    rig.write(Binding::Sorted, &vec![UNTOUCHED; nodes.order.len()]);
    [Shader::LaneEnds, Shader::SortByLane].iter().for_each(|&kernel| rig.run(kernel));
    let sorted: Vec<u32> = rig.read(Binding::Sorted, nodes.order.len());
    rig.run(Shader::Replace);
    let order: Vec<u32> = rig.read(Binding::Order, nodes.order.len());
    let ends: Vec<u32> = rig.read(Binding::Ends, SIZES.len() * N);
    for (i, part) in nodes.parts().enumerate() {
        let start = rig.nodes[i].start as usize;
        let (own, ends) = (&order[start..][..part.len()], &ends[i * N..][..N]);
        if i == 1 || i == 2 {
            assert_eq!(ends[0], if i == 1 { SMALL } else { ONE_LANE });
            assert!(own == part && sorted[start..][..part.len()].iter().all(|index| *index == UNTOUCHED));
            continue;
        }
        let (mut want, mut want_ends, mut sizes) = (part.to_vec(), [0; N], [0; N]);
        lanes[i].iter().for_each(|&lane| sizes[usize::from(lane)] += 1);
        sort_by_lane(&mut want, &lanes[i], &sizes, &mut Vec::new(), &mut want_ends);
        assert!(own == want && ends == want_ends, "node {i}");
        assert!(sorted[start..][..part.len()] == *own);
    }
}

#[test]
fn sort_by_lane_of_4() {
    for_all::<4>(check_sort);
}

#[test]
fn sort_by_lane_of_16() {
    for_all::<16>(check_sort);
}
