//! Full nodes: clusters of sizes that leave no lane unused further down.
//!
//! A tree of arity w with m full nodes has 1 + (w - 1) m leaves. So each lane gets a capacity of this form, near its
//! cluster's size, and primitives move until no lane exceeds its capacity. The result is the assignment to the
//! prototypes with the least sum of squared distances, found as a minimum-cost flow by successive shortest paths. A
//! primitive that must leave a lane makes room by moving a neighbour to the next lane, and so on, instead of jumping
//! across the node.
//!
//! Without balancing, half of the nodes would hold clusters slightly larger than a leaf allows, with two used lanes.

use super::accumulate::distances;
use super::prototypes::Prototypes;
use super::samples::Cluster;
use alloc::vec::Vec;

/// Larger nodes are not balanced: they have few unused lanes below them.
pub(in crate::construct) const MAX_SIZE: usize = 2048;

/// Costs are squared distances, shifted to 26 bits: a path over 16 lanes fits in 31.
pub(in crate::construct) const COST_SHIFT: u32 = 6;

/// The cost of an impossible move: a path of these over 16 lanes still fits in 31 bits.
pub(in crate::construct) const NEVER: i32 = 1 << 26;

/// The cheapest primitive to move from one lane to another, and its cost.
#[derive(Copy, Clone, Debug)]
struct Move {
    cost: i32,
    primitive: u32,
}

/// Memory for balancing, reused for the next node.
#[derive(Default)]
pub(in crate::construct) struct Balance<const N: usize> {
    /// The cost of each primitive at each prototype.
    costs: Vec<[i32; N]>,
}

impl<const N: usize> Balance<N> {
    /// Moves primitives until no lane exceeds its capacity.
    pub(in crate::construct) fn balance(
        &mut self,
        cluster: &Cluster,
        prototypes: &Prototypes<N>,
        leaf_size: usize,
        lanes: &mut [u8],
        sizes: &mut [u32; N],
    ) {
        let room = rooms(sizes, leaf_size);
        if (0..N).all(|lane| sizes[lane] <= room[lane]) {
            return;
        }
        self.measure(cluster, prototypes);
        let mut moves = [[Move { cost: NEVER, primitive: 0 }; N]; N];
        let mut stale = u32::MAX;
        while (0..N).any(|lane| sizes[lane] > room[lane]) {
            self.renew(&mut moves, stale, lanes);
            let full = |lane: usize| sizes[lane] > room[lane];
            let (cost, from) = shortest_paths(&moves, full);
            let open = (0..N).filter(|&lane| sizes[lane] < room[lane]);
            // The total capacity exceeds the number of primitives, and any overfull lane can give to any other.
            let Some(end) = open.min_by_key(|&lane| cost[lane]) else { return };
            let mut lane = end;
            stale = 1 << end;
            while let Some(giver) = from[lane] {
                lanes[moves[giver][lane].primitive as usize] = lane as u8;
                stale |= 1 << giver;
                lane = giver;
            }
            sizes[end] += 1;
            sizes[lane] -= 1;
        }
    }

    fn measure(&mut self, cluster: &Cluster, prototypes: &Prototypes<N>) {
        self.costs.clear();
        for index in 0..cluster.block_count() {
            let block = cluster.block(index);
            let distances = distances(&block, prototypes);
            let costs = |i: usize| distances.map(|lane| (lane[i] >> COST_SHIFT) as i32);
            self.costs.extend((0..block.len).map(costs));
        }
    }

    /// Recomputes the cheapest moves out of the `stale` lanes.
    fn renew(&self, moves: &mut [[Move; N]; N], stale: u32, lanes: &[u8]) {
        for lane in (0..N).filter(|lane| stale >> lane & 1 != 0) {
            moves[lane] = [Move { cost: NEVER, primitive: 0 }; N];
        }
        for (primitive, (&lane, costs)) in (0..).zip(lanes.iter().zip(&self.costs)) {
            let lane = usize::from(lane);
            if stale >> lane & 1 == 0 {
                continue;
            }
            for (to, best) in moves[lane].iter_mut().enumerate() {
                let cost = costs[to] - costs[lane];
                if cost < best.cost && to != lane {
                    *best = Move { cost, primitive };
                }
            }
        }
    }
}

/// The capacity of each lane. Each additional node, which turns one leaf into N, goes to the lane with the greatest
/// deficit.
fn rooms<const N: usize>(sizes: &[u32; N], leaf_size: usize) -> [u32; N] {
    let leaf = leaf_size as u32;
    let count: u32 = sizes.iter().sum();
    let nodes = count.div_ceil(leaf).saturating_sub(N as u32).div_ceil(N as u32 - 1);
    let mut room = [leaf; N];
    for _ in 0..nodes {
        let lack = |lane: &usize| (i64::from(room[*lane]) - i64::from(sizes[*lane]), *lane);
        if let Some(lane) = (0..N).min_by_key(lack) {
            room[lane] += leaf * (N as u32 - 1);
        }
    }
    room
}

/// The cheapest paths from any of the overfull lanes to each lane, and the last giver of each lane. Bellman-Ford, since
/// moves back towards a primitive's nearest prototype have a negative cost. There is no cycle of negative cost, since
/// each flow so far was the cheapest.
fn shortest_paths<const N: usize>(
    moves: &[[Move; N]; N],
    full: impl Fn(usize) -> bool,
) -> ([i32; N], [Option<usize>; N]) {
    let mut cost: [i32; N] = core::array::from_fn(|lane| if full(lane) { 0 } else { i32::MAX });
    let mut from = [None; N];
    for _ in 1..N {
        let before = cost;
        for giver in 0..N {
            for taker in 0..N {
                let step = moves[giver][taker].cost;
                if cost[giver] != i32::MAX && step < NEVER && cost[giver] + step < cost[taker] {
                    cost[taker] = cost[giver] + step;
                    from[taker] = Some(giver);
                }
            }
        }
        if cost == before {
            break;
        }
    }
    (cost, from)
}

#[cfg(test)]
mod tests {
    use super::super::accumulate::nearest;
    use super::super::samples::Samples;
    use super::*;

    /// Points of a cluster, from a generator that is the same on every machine.
    fn points(count: usize, seed: u32) -> Vec<[f64; 3]> {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8)
        };
        (0..count).map(|_| [random(), random(), random()]).collect()
    }

    fn cost_of(costs: &[[i32; 4]], lanes: &[u8]) -> i32 {
        costs.iter().zip(lanes).map(|(costs, &lane)| costs[usize::from(lane)]).sum()
    }

    /// The least cost over all 4^n assignments that exceed no capacity.
    fn least_cost(costs: &[[i32; 4]], room: &[u32; 4]) -> i32 {
        let Some((first, rest)) = costs.split_first() else { return 0 };
        let take = |lane: usize| {
            let mut left = *room;
            left[lane] -= 1;
            first[lane] + least_cost(rest, &left)
        };
        (0..4).filter(|&lane| room[lane] > 0).map(take).min().unwrap()
    }

    #[test]
    fn balanced_lanes_cost_the_least_there_is() {
        let mut moved = 0;
        for seed in 0..60 {
            let count = 5 + seed as usize % 6;
            let points = points(count, seed);
            let samples = Samples::new(&points, None);
            let mut cluster = Cluster::default();
            assert!(cluster.local_coordinates(&samples, &(0..count as u32).collect::<Vec<_>>()));
            let prototypes = Prototypes::<4>::start(cluster.extent(), seed, 0);
            let mut lanes = Vec::new();
            let mut sizes = nearest(&cluster, &prototypes, &mut lanes);
            let (room, before) = (rooms(&sizes, 1), lanes.clone());
            let mut balance = Balance::default();
            balance.balance(&cluster, &prototypes, 1, &mut lanes, &mut sizes);
            moved += usize::from(lanes != before);

            balance.measure(&cluster, &prototypes);
            assert_eq!(cost_of(&balance.costs, &lanes), least_cost(&balance.costs, &room), "seed {seed}");
            for lane in 0..4_u8 {
                let size = lanes.iter().filter(|l| **l == lane).count() as u32;
                assert!(size == sizes[usize::from(lane)] && size <= room[usize::from(lane)]);
            }
        }
        assert!(moved > 40, "{moved} of 60 had something to move");
    }

    #[test]
    fn rooms_are_whole_nodes_and_enough() {
        for sizes in [[1024, 0, 0, 0], [256; 4], [1, 1, 1, 2], [5, 0, 0, 0], [300, 30, 3, 0]] {
            for leaf in [1, 3, 16] {
                let room: [u32; 4] = rooms(&sizes, leaf as usize);
                assert!(room.iter().all(|room| room % leaf == 0 && (room / leaf) % 3 == 1));
                let (room, count) = (room.iter().sum::<u32>(), sizes.iter().sum::<u32>());
                assert!(room >= count && room < (count + 3 * leaf).max(4 * leaf + 1), "{room} for {count}");
            }
        }
    }
}
