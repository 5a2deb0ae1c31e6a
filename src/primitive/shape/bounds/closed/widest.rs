//! The axis along which two cuboids are farthest apart.

use super::products::{BlockPlaces, EdgeProducts, Zonotope, clamped, inverse};
use crate::vector::{cross, dot, sqrt};
use core::array::from_fn;

/// The axis of two cuboids along which they are farthest apart.
#[derive(Copy, Clone, Debug)]
pub(super) enum WidestAxis {
    /// They overlap along all axes.
    None,
    A(usize),
    B(usize),
    Edges(usize, usize),
}

impl<const N: usize, const M: usize> EdgeProducts<N, M> {
    /// The axis with the widest gap, among the half edges of two cuboids and their cross products, up to rounding and
    /// the angles of the edges (Gottschalk, Lin and Manocha 1996).
    #[inline(always)]
    pub(super) fn widest(&self) -> WidestAxis {
        let (a, b) = (self.squares_a.map(sqrt), self.squares_b.map(sqrt));
        let (inverse_a, inverse_b) = (a.map(inverse), b.map(inverse));
        let cosines: [[f64; M]; N] =
            from_fn(|i| from_fn(|j| self.mixed[i][j] * (inverse_a[i] * inverse_b[j])));
        let (mut best, mut axis) = (0.0, WidestAxis::None);
        for i in 0..N {
            let mut gap = self.along_a[i].abs() * inverse_a[i] - a[i];
            for j in 0..M {
                gap -= b[j] * cosines[i][j].abs();
            }
            if gap > best {
                (best, axis) = (gap, WidestAxis::A(i));
            }
        }
        for j in 0..M {
            let mut gap = self.along_b[j].abs() * inverse_b[j] - b[j];
            for i in 0..N {
                gap -= a[i] * cosines[i][j].abs();
            }
            if gap > best {
                (best, axis) = (gap, WidestAxis::B(j));
            }
        }
        let mut best = best * best;
        for i in 0..N {
            let (k, l) = ((i + 1) % N, (i + 2) % N);
            let (near, far) = (self.along_a[k] * inverse_a[k], self.along_a[l] * inverse_a[l]);
            for j in 0..M {
                let (m, n) = ((j + 1) % M, (j + 2) % M);
                let (u, v) = (cosines[k][j], cosines[l][j]);
                let reach_a = a[k] * v.abs() + a[l] * u.abs();
                let reach_b = b[m] * cosines[i][n].abs() + b[n] * cosines[i][m].abs();
                let gap = (far * u - near * v).abs() - (reach_a + reach_b);
                let square = 1.0 - cosines[i][j] * cosines[i][j];
                // Nearly parallel edges give no axis.
                if gap > 0.0 && square > 1e-6 && gap * gap > best * square {
                    (best, axis) = (gap * gap / square, WidestAxis::Edges(i, j));
                }
            }
        }
        axis
    }

    /// The closest points of the features of two cuboids that are farthest along an axis.
    #[inline(always)]
    pub(super) fn on_axis(
        &self,
        a: &Zonotope<'_, N>,
        b: &Zonotope<'_, M>,
        axis: &WidestAxis,
    ) -> BlockPlaces<N, M> {
        let mixed = &self.mixed;
        let (mut x, mut y);
        match *axis {
            WidestAxis::None => return self.near_centre(),
            WidestAxis::A(i) => {
                let sign = 1.0_f64.copysign(self.along_a[i]);
                y = from_fn(|j| 1.0_f64.copysign(sign * mixed[i][j]));
                x = self.to_a(&y).map(|x| clamped(x, 1.0));
            }
            WidestAxis::B(j) => {
                let sign = 1.0_f64.copysign(self.along_b[j]);
                x = from_fn(|i| 1.0_f64.copysign(-sign * mixed[i][j]));
                y = from_fn(|j| clamped(self.along_of_b(j, &x) * self.inverse_b[j], 1.0));
            }
            WidestAxis::Edges(i, j) => {
                let normal = cross(&a.half[i], &b.half[j]);
                let sign = 1.0_f64.copysign(dot(&normal, &self.between));
                x = from_fn(|i| 1.0_f64.copysign(-sign * dot(&normal, &a.half[i])));
                y = from_fn(|j| 1.0_f64.copysign(sign * dot(&normal, &b.half[j])));
                (x[i], y[j]) = (0.0, 0.0);
                let (of_a, of_b) = (self.to_a(&y)[i], self.along_of_b(j, &x));
                let share = mixed[i][j] * self.inverse_a[i];
                let bend = self.squares_b[j] - share * mixed[i][j];
                y[j] = clamped((of_b + mixed[i][j] * of_a) / bend, 1.0);
                x[i] = clamped(of_a + share * y[j], 1.0);
                y[j] = clamped((of_b + mixed[i][j] * x[i]) * self.inverse_b[j], 1.0);
            }
        }
        BlockPlaces { x, y, free_x: x }
    }
}
