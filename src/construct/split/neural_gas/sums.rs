//! Sums over the primitives of a node.

/// Contributions to each prototype: sum of h v, and sums of h v x for the three axes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::construct) struct Sums<const N: usize> {
    pub(in crate::construct) weight: [u64; N],
    pub(in crate::construct) moments: [[u64; N]; 3],
}

impl<const N: usize> Sums<N> {
    pub(super) const ZERO: Self = Self { weight: [0; N], moments: [[0; N]; 3] };

    pub(super) fn add(&mut self, other: &Self) {
        let add = |to: &mut [u64; N], from: &[u64; N]| to.iter_mut().zip(from).for_each(|(a, b)| *a += b);
        add(&mut self.weight, &other.weight);
        self.moments.iter_mut().zip(&other.moments).for_each(|(to, from)| add(to, from));
    }

    /// Sums of a block of primitives for prototype `lane`.
    pub(super) fn add_block(&mut self, lane: usize, [weight, x, y, z]: [u64; 4]) {
        self.weight[lane] += weight;
        self.moments[0][lane] += x;
        self.moments[1][lane] += y;
        self.moments[2][lane] += z;
    }
}
