//! Random input of a trial: the same on every machine, using only correctly rounded operations.

use simdop::primitive::triangle::Triangle;
use simdop::range::Point;

/// A rotation by rows.
pub(super) type Turn = [[f64; 3]; 3];

pub(super) const NO_TURN: Turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `SplitMix64` (Steele, Lea & Flood, OOPSLA 2014), and the precision of the trial's bodies.
pub(super) struct Draw {
    state: u64,
    /// Whether coordinates of bodies are rounded to `f32`.
    pub(super) is_single: bool,
}

impl Draw {
    /// The input of a trial does not depend on that of other trials.
    pub(super) fn new(seed: u64, case: &str, trial: u64, is_single: bool) -> Self {
        let state = case.bytes().fold(seed, |state, byte| Self::mixed(state ^ u64::from(byte)));
        Self { state: Self::mixed(state ^ trial), is_single }
    }

    fn mixed(z: u64) -> u64 {
        let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn word(&mut self) -> u64 {
        let word = Self::mixed(self.state);
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        word
    }

    /// A number uniform in `0..n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.word()) * n as u128) >> 64) as usize
    }

    /// A number uniform in `low..=high`.
    pub(super) fn int(&mut self, low: i32, high: i32) -> i32 {
        low + self.below((high - low) as usize + 1) as i32
    }

    /// A number uniform in `[0, 1)`.
    pub(super) fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 * f64::EPSILON * 0.5
    }

    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(super) fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    pub(super) fn is_heads(&mut self) -> bool {
        self.below(2) == 0
    }

    /// A number from 2^low to twice 2^high, with an approximately uniform exponent.
    pub(super) fn size(&mut self, low: i32, high: i32) -> f64 {
        (1.0 + self.unit()) * power_of_two(self.int(low, high))
    }

    /// The same, of either sign.
    pub(super) fn signed(&mut self, low: i32, high: i32) -> f64 {
        let size = self.size(low, high);
        if self.is_heads() { size } else { -size }
    }

    /// The number one unit in the last place up or down, or unchanged.
    pub(super) fn nudged(&mut self, x: f64) -> f64 {
        match self.below(3) {
            0 => x.next_up(),
            1 => x.next_down(),
            _ => x,
        }
    }

    /// A unit vector, up to rounding.
    pub(super) fn direction(&mut self) -> Point {
        loop {
            let p: Point = core::array::from_fn(|_| self.range(-1.0, 1.0));
            let square = dot(&p, &p);
            if (0.01..1.0).contains(&square) {
                return scaled(&p, 1.0 / square.sqrt());
            }
        }
    }

    /// A direction along one axis.
    pub(super) fn axis(&mut self) -> Point {
        let (axis, sign) = (self.below(3), if self.is_heads() { 1.0 } else { -1.0 });
        core::array::from_fn(|i| if i == axis { sign } else { 0.0 })
    }

    /// Any rotation, from a quaternion in the four-dimensional ball.
    pub(super) fn turn(&mut self) -> Turn {
        let (q, square) = loop {
            let q: [f64; 4] = core::array::from_fn(|_| self.range(-1.0, 1.0));
            let square = (q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]);
            if (0.01..1.0).contains(&square) {
                break (q, square);
            }
        };
        let [x, y, z, w] = q.map(|c| c / square.sqrt());
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// A rotation that maps axes to axes, and so does not round.
    pub(super) fn quarter_turns(&mut self) -> Turn {
        let mut turn = NO_TURN;
        for _ in 0..3 {
            for _ in 0..self.below(4) {
                turn = product(&[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], &turn);
            }
            turn = [turn[1], turn[2], turn[0]];
        }
        turn
    }

    /// The point rounded to the body's precision.
    pub(super) fn rounded(&self, p: Point) -> Point {
        if self.is_single { p.map(|x| f64::from(x as f32)) } else { p }
    }

    /// The triangles rotated, moved, and rounded to the body's precision.
    pub(super) fn placed(&self, triangles: &[Triangle], turn: &Turn, shift: &Point) -> Vec<Triangle> {
        let place = |p| self.rounded(add(&turned(turn, &p), shift));
        triangles.iter().map(|t| t.map(place)).collect()
    }
}

/// A power of two, for exponents of normal numbers.
pub(super) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

pub(super) fn dot(p: &Point, q: &Point) -> f64 {
    (p[0] * q[0] + p[1] * q[1]) + p[2] * q[2]
}

pub(super) fn add(p: &Point, q: &Point) -> Point {
    [p[0] + q[0], p[1] + q[1], p[2] + q[2]]
}

pub(super) fn minus(p: &Point, q: &Point) -> Point {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

pub(super) fn scaled(p: &Point, by: f64) -> Point {
    p.map(|x| x * by)
}

pub(super) fn turned(turn: &Turn, p: &Point) -> Point {
    turn.each_ref().map(|row| dot(row, p))
}

pub(super) fn product(p: &Turn, q: &Turn) -> Turn {
    p.map(|row| core::array::from_fn(|j| (row[0] * q[0][j] + row[1] * q[1][j]) + row[2] * q[2][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_are_drawn_apart_and_again() {
        let words = |case, trial| -> Vec<u64> {
            let mut draw = Draw::new(1, case, trial, false);
            (0..4).map(|_| draw.word()).collect()
        };
        assert_eq!(words("a", 0), words("a", 0));
        assert_ne!(words("a", 0), words("a", 1));
        assert_ne!(words("a", 0), words("b", 0));
    }

    #[test]
    fn quarter_turns_are_exact_rotations() {
        let mut draw = Draw::new(2, "", 0, false);
        let mut found = std::collections::BTreeSet::new();
        for _ in 0..1000 {
            let turn = draw.quarter_turns();
            let columns: Turn = core::array::from_fn(|j| turn.map(|row| row[j]));
            assert_eq!(product(&turn, &columns), NO_TURN, "{turn:?}");
            found.insert(format!("{:?}", turn.map(|row| row.map(|x| x as i8))));
        }
        assert_eq!(found.len(), 24);
    }
}
