//! From the box of a node to its prototypes.

use super::*;

fn check_bounds<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    rig.write(Binding::Boxes, &vec![0_u32; 7 * SIZES.len()]);
    rig.run(Shader::Bounds);
    let got: Vec<[u32; 7]> = rig.read(Binding::Boxes, SIZES.len());
    let samples = nodes.samples();
    for (got, part) in got.iter().zip(nodes.parts()) {
        let [a, b, c, x, y, z, heaviest] = *got;
        let got = SampleBox { low: [!a, !b, !c], high: [x, y, z], heaviest };
        assert_eq!(got, samples.bounds(part));
    }
}

#[test]
fn bounds_of_4() {
    for_all::<4>(check_bounds);
}

#[test]
fn bounds_of_16() {
    for_all::<16>(check_bounds);
}

/// Boxes as the kernel `bounds` leaves them.
fn write_boxes<const N: usize>(rig: &Rig<'_, N>, nodes: &Nodes) {
    let samples = nodes.samples();
    let words = |part| {
        let SampleBox { low: [a, b, c], high: [x, y, z], heaviest } = samples.bounds(part);
        [!a, !b, !c, x, y, z, heaviest]
    };
    rig.write(Binding::Boxes, &nodes.parts().map(words).collect::<Vec<_>>());
}

/// `start` and `local_coordinates`, whose twin is one function.
fn check_frame<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    write_boxes(rig, nodes);
    rig.run(Shader::Start);
    rig.run(Shader::LocalCoordinates);
    let states: Vec<State> = rig.read(Binding::States, SIZES.len());
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    let got_places: Vec<[u32; 2]> = rig.read(Binding::Places, nodes.order.len());
    let clusters = clusters(nodes);
    let (want, want_places) = (starts::<N>(&clusters), places(nodes, &clusters));
    let mut unusable = 0;
    for (i, (usable, _)) in clusters.iter().enumerate() {
        assert_eq!((states[i].outcome, states[i].step), (if *usable { 0 } else { SMALL }, 0));
        unusable += usize::from(!usable);
        if *usable {
            assert_eq!(got[i * N..][..N], words(&want[i]));
            let range = rig.nodes[i].start as usize..(rig.nodes[i].start + rig.nodes[i].count) as usize;
            assert_eq!(got_places[range.clone()], want_places[range]);
        }
    }
    assert!(unusable > 0 && unusable < SIZES.len());
}

#[test]
fn start_and_local_coordinates_of_4() {
    for_all::<4>(check_frame);
}

#[test]
fn start_and_local_coordinates_of_16() {
    for_all::<16>(check_frame);
}

fn sum_words<const N: usize>(sums: &Sums<N>) -> Vec<u64> {
    sums.weight.iter().chain(sums.moments.iter().flatten()).copied().collect()
}

fn check_accumulate<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    if rig.level.large_nodes == 0 {
        return;
    }
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    for _ in 0..3 {
        let step = random.below(LIMITS.steps as u32);
        rig.write(Binding::States, &rig.states(step, |i| u32::from(i == 1)));
        rig.write(Binding::PartialSums, &vec![7_u64; rig.chunks.len() * 4 * N]);
        rig.run(Shader::Accumulate);
        let got: Vec<u64> = rig.read(Binding::PartialSums, rig.chunks.len() * 4 * N);
        assert!(
            got[rig.nodes[1].first_chunk as usize * 4 * N..][..4 * N].iter().all(|sum| *sum == 7),
            "settled"
        );
        for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(i, (usable, _))| *usable && *i != 1) {
            let node = &rig.nodes[i];
            let mut total = vec![0; 4 * N];
            for chunk in
                got[node.first_chunk as usize * 4 * N..][..node.chunks as usize * 4 * N].chunks(4 * N)
            {
                total.iter_mut().zip(chunk).for_each(|(total, sum)| *total += sum);
            }
            let want = accumulate(cluster, &prototypes[i], &schedule::<N>()[step as usize]);
            assert_eq!(total, sum_words(&want), "node {i}, step {step}");
        }
    }
}

#[test]
fn accumulate_of_4() {
    for_all::<4>(check_accumulate);
}

#[test]
fn accumulate_of_16() {
    for_all::<16>(check_accumulate);
}

/// Maximal sums, zero sums, moments with a remainder of one half, and any others.
fn any_sums<const N: usize>(random: &mut Random) -> Sums<N> {
    let mut sums = Sums { weight: [0; N], moments: [[0; N]; 3] };
    for lane in 0..N {
        let any = u64::from(random.next()) << 32 | u64::from(random.next());
        let weight = match random.below(5) {
            0 => 0,
            1 => (1 << 49) - 1 - u64::from(random.below(3)),
            2 => 1 + u64::from(random.below(4)),
            _ => any >> (15 + random.below(49)),
        };
        sums.weight[lane] = weight;
        for moments in &mut sums.moments {
            let most = weight * 32767;
            moments[lane] = match random.below(4) {
                0 => most,
                1 => (weight / 2 + weight * u64::from(random.below(32767))).min(most),
                2 => (weight.div_ceil(2) + weight * u64::from(random.below(32767))).min(most),
                _ => any.checked_rem(most).unwrap_or(0),
            };
        }
    }
    sums
}

fn check_update<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    if rig.level.large_nodes == 0 {
        return;
    }
    let mut prototypes = starts::<N>(&clusters(nodes));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(3, |i| u32::from(i == 1)));
    let mut partial = vec![0_u64; rig.chunks.len() * 4 * N];
    let mut moved = vec![false; SIZES.len()];
    for (i, node) in rig.nodes.iter().enumerate() {
        let mut sums = any_sums(random);
        if i == 2 {
            sums = Sums { weight: [0; N], moments: [[0; N]; 3] };
        }
        for (j, sum) in sum_words(&sums).into_iter().enumerate() {
            // Distributed over the chunks.
            let mut rest = sum;
            for chunk in 0..node.chunks as usize {
                let share = if chunk + 1 == node.chunks as usize { rest } else { rest / 3 };
                partial[(node.first_chunk as usize + chunk) * 4 * N + j] = share;
                rest -= share;
            }
        }
        moved[i] = i != 1 && prototypes[i].update(&sums);
    }
    rig.write(Binding::PartialSums, &partial);
    rig.run(Shader::Update);
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    assert_eq!(got, all_words(&prototypes));
    let states: Vec<State> = rig.read(Binding::States, SIZES.len());
    for (i, state) in states.iter().enumerate() {
        let want = (if i == 1 { 3 } else { 4 }, u32::from(!moved[i]));
        assert_eq!((state.step, state.outcome), want, "node {i}");
    }
}

#[test]
fn update_of_4() {
    for_all::<4>(check_update);
}

#[test]
fn update_of_16() {
    for_all::<16>(check_update);
}

fn check_cluster<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    if rig.level.large_nodes > 0 {
        return;
    }
    let clusters = clusters(nodes);
    let mut prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(0, |i| if clusters[i].0 { 0 } else { SMALL }));
    (0..LIMITS.steps.div_ceil(STEPS_AT_ONCE)).for_each(|_| rig.run(Shader::Cluster));
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(_, (usable, _))| *usable) {
        settle(cluster, &mut prototypes[i], &schedule::<N>());
        assert_eq!(got[i * N..][..N], words(&prototypes[i]), "node {i}");
    }
}

#[test]
fn cluster_of_4() {
    for_all::<4>(check_cluster);
}

#[test]
fn cluster_of_16() {
    for_all::<16>(check_cluster);
}
