//! The most expensive step: distances, ranks, sums.

use super::prototypes::Prototypes;
use super::samples::{BLOCK, Block, Cluster};
use super::schedule::ONE;
use super::sums::Sums;
use crate::parallel;
use alloc::vec::Vec;
use core::ops::Range;

/// Blocks per thread: about 0.2 ms.
const TASK: usize = 512;

/// Number of blocks whose sums for unit weights fit in 32 bits: 32 * 4095 * 32767 < 2^32.
const GROUP: usize = 32;

/// Distances, ranks and sums over a whole node.
pub(in crate::construct) fn accumulate<const N: usize>(
    cluster: &Cluster,
    prototypes: &Prototypes<N>,
    h: &[u16; N],
) -> Sums<N> {
    sums_of(cluster, prototypes, h, 0..cluster.block_count())
}

fn sums_of<const N: usize>(
    cluster: &Cluster,
    prototypes: &Prototypes<N>,
    h: &[u16; N],
    blocks: Range<usize>,
) -> Sums<N> {
    if blocks.len() > TASK {
        let middle = blocks.start + blocks.len() / 2;
        let (mut left, right) = parallel::join(
            || sums_of(cluster, prototypes, h, blocks.start..middle),
            || sums_of(cluster, prototypes, h, middle..blocks.end),
        );
        left.add(&right);
        return left;
    }
    let mut sums = Sums::ZERO;
    if h[1] == 0 {
        blocks.for_each(|index| add_nearest(&cluster.block(index), prototypes, &mut sums));
    } else if cluster.is_weighted() {
        blocks.for_each(|index| add_weighted(&cluster.block(index), prototypes, h, &mut sums));
    } else {
        for start in blocks.clone().step_by(GROUP) {
            let group = start..(start + GROUP).min(blocks.end);
            add_group(cluster, group, prototypes, h, &mut sums);
        }
    }
    sums
}

type PerLane<T, const N: usize> = [[T; BLOCK]; N];

/// Squared distances of a block's primitives to each prototype.
#[inline]
pub(in crate::construct) fn distances<const N: usize>(
    block: &Block<'_>,
    prototypes: &Prototypes<N>,
) -> PerLane<u32, N> {
    let mut distances = [[0; BLOCK]; N];
    for (lane, distances) in distances.iter_mut().enumerate() {
        let at = prototypes.coordinates.map(|c| c[lane] as i16);
        for (i, distance) in distances.iter_mut().enumerate() {
            // Differences of 15-bit numbers fit in 16 bits with a sign, squares in 30.
            let square = |axis: usize| {
                let difference = block.coordinates[axis][i] as i16 - at[axis];
                (i32::from(difference) * i32::from(difference)) as u32
            };
            *distance = square(0) + square(1) + square(2);
        }
    }
    distances
}

/// The number of prototypes that are nearer. Of equally near ones the lower index counts as nearer.
#[inline]
fn ranks<const N: usize>(distances: &PerLane<u32, N>) -> PerLane<u32, N> {
    // Each starts behind all that follow it, and advances past those that are farther.
    let mut ranks: PerLane<u32, N> = core::array::from_fn(|lane| [(N - 1 - lane) as u32; BLOCK]);
    for lane in 1..N {
        let mut own = ranks[lane];
        for other in 0..lane {
            for i in 0..BLOCK {
                let nearer = u32::from(distances[other][i] <= distances[lane][i]);
                own[i] += nearer;
                ranks[other][i] -= nearer;
            }
        }
        ranks[lane] = own;
    }
    ranks
}

/// h of each rank; 0 for padding, which must not contribute.
#[inline]
fn pulls<const N: usize>(block: &Block<'_>, prototypes: &Prototypes<N>, h: &[u16; N]) -> PerLane<u16, N> {
    let ranks = ranks(&distances(block, prototypes));
    let mut pulls = [[0; BLOCK]; N];
    for lane in 0..N {
        for i in 0..BLOCK {
            // A rank is below N, a power of two.
            pulls[lane][i] = h[ranks[lane][i] as usize & (N - 1)];
        }
    }
    if block.len < BLOCK {
        pulls.iter_mut().for_each(|pulls| pulls[block.len..].fill(0));
    }
    pulls
}

/// Unit weights: up to [`GROUP`] blocks in 32 bits.
fn add_group<const N: usize>(
    cluster: &Cluster,
    blocks: Range<usize>,
    prototypes: &Prototypes<N>,
    h: &[u16; N],
    sums: &mut Sums<N>,
) {
    let mut group = [[[0_u32; BLOCK]; 4]; N];
    for index in blocks {
        let block = cluster.block(index);
        let pulls = pulls(&block, prototypes, h);
        for (sums, pulls) in group.iter_mut().zip(&pulls) {
            for i in 0..BLOCK {
                sums[0][i] += u32::from(pulls[i]);
                for axis in 0..3 {
                    // Unsigned factors of 12 and 15 bits, both within 16.
                    sums[1 + axis][i] += u32::from(pulls[i]) * u32::from(block.coordinates[axis][i]);
                }
            }
        }
    }
    for (lane, group) in group.iter().enumerate() {
        sums.add_block(lane, group.map(|of| of.iter().copied().map(u64::from).sum()));
    }
}

fn add_weighted<const N: usize>(
    block: &Block<'_>,
    prototypes: &Prototypes<N>,
    h: &[u16; N],
    sums: &mut Sums<N>,
) {
    let pulls = pulls(block, prototypes, h);
    let weights = block.weights.unwrap_or(&[1; BLOCK]);
    for (lane, pulls) in pulls.iter().enumerate() {
        let mut own = [0; 4];
        for i in 0..BLOCK {
            let pull = u32::from(pulls[i]) * u32::from(weights[i]);
            own[0] += u64::from(pull);
            for axis in 0..3 {
                own[1 + axis] += u64::from(pull) * u64::from(block.coordinates[axis][i]);
            }
        }
        sums.add_block(lane, own);
    }
}

/// The prototype nearest to each primitive of a block.
#[inline]
fn nearest_of<const N: usize>(block: &Block<'_>, prototypes: &Prototypes<N>) -> [u32; BLOCK] {
    let distances = distances(block, prototypes);
    let (mut lanes, mut least) = ([0; BLOCK], distances[0]);
    for (lane, distances) in distances.iter().enumerate().skip(1) {
        for i in 0..BLOCK {
            let nearer = distances[i] < least[i];
            lanes[i] = if nearer { lane as u32 } else { lanes[i] };
            least[i] = if nearer { distances[i] } else { least[i] };
        }
    }
    lanes
}

/// If h(1) is 0, only the nearest prototype is pulled: the sums of [`add_weighted`] without ranks.
fn add_nearest<const N: usize>(block: &Block<'_>, prototypes: &Prototypes<N>, sums: &mut Sums<N>) {
    let lanes = nearest_of(block, prototypes);
    for i in 0..block.len {
        let pull = u64::from(ONE) * block.weights.map_or(1, |w| u64::from(w[i]));
        let [x, y, z] = block.coordinates.map(|c| pull * u64::from(c[i]));
        sums.add_block(lanes[i] as usize & (N - 1), [pull, x, y, z]);
    }
}

/// Assigns each primitive to its nearest prototype. Returns the number of primitives of each.
pub(in crate::construct) fn nearest<const N: usize>(
    cluster: &Cluster,
    prototypes: &Prototypes<N>,
    lanes: &mut Vec<u8>,
) -> [u32; N] {
    lanes.clear();
    for index in 0..cluster.block_count() {
        let block = cluster.block(index);
        lanes.extend(nearest_of(&block, prototypes).map(|lane| lane as u8).iter().take(block.len));
    }
    let mut sizes = [0; N];
    lanes.iter().for_each(|lane| sizes[usize::from(*lane)] += 1);
    sizes
}

#[cfg(test)]
mod tests {
    use super::super::samples::Samples;
    use super::super::schedule::schedule;
    use super::*;

    /// A generator that is the same on every machine.
    fn random(state: &mut u32) -> u32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *state >> 8
    }

    fn cluster(points: &[[f64; 3]], weights: Option<&[f64]>) -> Cluster {
        let samples = Samples::new(points, weights);
        let mut cluster = Cluster::default();
        assert!(cluster.local_coordinates(&samples, &(0..points.len() as u32).collect::<Vec<_>>()));
        cluster
    }

    /// The definition in 128 bits, one primitive at a time.
    fn by_definition<const N: usize>(
        cluster: &Cluster,
        prototypes: &Prototypes<N>,
        h: &[u16; N],
    ) -> Vec<[u128; 4]> {
        let mut sums = alloc::vec![[0; 4]; N];
        for index in 0..cluster.block_count() {
            let block = cluster.block(index);
            for i in 0..block.len {
                let x = block.coordinates.map(|c| i64::from(c[i]));
                let distance = |lane: usize| -> i64 {
                    (0..3).map(|a| (x[a] - i64::from(prototypes.coordinates[a][lane])).pow(2)).sum()
                };
                let mut ranking: Vec<usize> = (0..N).collect();
                ranking.sort_by_key(|&lane| (distance(lane), lane));
                for (rank, lane) in ranking.into_iter().enumerate() {
                    let pull = u128::from(h[rank]) * block.weights.map_or(1, |w| u128::from(w[i]));
                    sums[lane][0] += pull;
                    (0..3).for_each(|a| sums[lane][1 + a] += pull * x[a] as u128);
                }
            }
        }
        sums
    }

    fn check<const N: usize>(cluster: &Cluster, prototypes: &Prototypes<N>, h: &[u16; N]) {
        let got = accumulate(cluster, prototypes, h);
        for (lane, want) in by_definition(cluster, prototypes, h).iter().enumerate() {
            let [x, y, z] = got.moments.each_ref().map(|m| u128::from(m[lane]));
            assert_eq!([u128::from(got.weight[lane]), x, y, z], *want, "lane {lane} of {N}, {h:?}");
        }
    }

    fn check_all<const N: usize>(points: &[[f64; 3]], weights: &[f64]) {
        for weights in [None, Some(weights)] {
            let cluster = cluster(points, weights);
            for (step, h) in schedule::<N>().iter().enumerate() {
                check(&cluster, &Prototypes::<N>::start(cluster.extent(), 1, step as u32), h);
                // Corners of the box, some of them twice: the lower index wins.
                let at = |axis: usize, lane: usize| (lane >> axis & 1) as u16 * cluster.extent()[axis];
                let coordinates = core::array::from_fn(|axis| core::array::from_fn(|lane| at(axis, lane)));
                check(&cluster, &Prototypes::<N> { coordinates }, h);
            }
        }
    }

    #[test]
    fn sums_are_those_of_the_definition() {
        let mut state = 1;
        for count in [2, 7, 8, 9, 255, 257, 5000] {
            // Few places, so that distances tie.
            let points: Vec<[f64; 3]> =
                (0..count).map(|_| [(); 3].map(|()| f64::from(random(&mut state) % 5))).collect();
            let weights: Vec<f64> = (0..count).map(|_| f64::from(random(&mut state) % 1000)).collect();
            check_all::<4>(&points, &weights);
            check_all::<16>(&points, &weights);
        }
    }

    /// All values at their maximum: primitives in the far corner with maximal weights, in as many blocks as a 32-bit
    /// sum takes; then 2^24 times the contribution of one primitive, as in a tree of 16 million.
    #[test]
    fn nothing_overflows_at_the_extremes() {
        const TOP: u64 = (1 << 15) - 1;
        let mut points = alloc::vec![[1.0; 3]; GROUP * BLOCK * 3];
        points[0] = [0.0; 3];
        let weights = alloc::vec![1.0; points.len()];
        let h = [ONE; 16];
        for weights in [None, Some(&*weights)] {
            let cluster = cluster(&points, weights);
            let prototypes = Prototypes::<16> { coordinates: [[0; 16]; 3] };
            let block = cluster.block(1);
            assert_eq!(block.coordinates, [&[TOP as u16; BLOCK]; 3]);
            assert_eq!(u64::from(distances(&block, &prototypes)[15][7]), 3 * TOP * TOP);
            check(&cluster, &prototypes, &h);
            let only_nearest = core::array::from_fn(|rank| if rank == 0 { ONE } else { 0 });
            check(&cluster, &prototypes, &only_nearest);

            let share = u64::from(ONE) * block.weights.map_or(1, |w| u64::from(w[0]));
            assert_eq!(block.weights.map(|w| w[0]), weights.map(|_| (1 << 13) - 1));
            let weight = share.checked_mul((1 << 24) - 1).unwrap();
            let moment = weight.checked_mul(TOP).unwrap();
            let mut sums = Sums::<16> { weight: [weight; 16], moments: [[moment; 16]; 3] };
            let mut moved = Prototypes::<16> { coordinates: [[0; 16]; 3] };
            assert!(moved.update(&sums), "a rounding that overflows would panic here or move elsewhere");
            assert_eq!(moved.coordinates, [[TOP as u16; 16]; 3]);
            sums.add(&Sums::ZERO);
            assert!(!moved.update(&sums));
        }
    }
}
