//! One triangle against four: the plane filter of the leaf test, one triangle per lane. The same operations as in
//! [`Probe::is_apart`].

use crate::isa::compiled_for_avx2;
use crate::primitive::triangle::{DETERMINANT_ERROR, Probe, Triangle};
use core::arch::x86_64::*;

/// Three coordinates of four points.
type Points = [__m256d; 3];

/// Planes of four triangles, or one plane in all lanes, as in [`crate::primitive::triangle::Plane`].
struct FourPlanes {
    origin: Points,
    normal: Points,
    magnitude: Points,
}

compiled_for_avx2! {
    #[inline(never)]
    pub(super) fn apart_4(probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16 {
        let corners = [corners(triangles, 0), corners(triangles, 1), corners(triangles, 2)];
        let plane = &probe.plane;
        let plane =
            FourPlanes {
                origin: splat(&plane.origin),
                normal: splat(&plane.normal),
                magnitude: splat(&plane.magnitude),
            };
        let away = _mm256_set1_pd(probe.away);
        let mut apart = strictly_one_side(&plane, &corners, away);
        if _mm256_movemask_pd(apart) != 0b1111 {
            let [p, q, r] = probe.triangle;
            let other = strictly_one_side(&planes_of(&corners), &[splat(p), splat(q), splat(r)], away);
            apart = _mm256_or_pd(apart, other);
        }
        _mm256_movemask_pd(apart) as u16
    }
}

compiled_for_avx2! {
    /// Corner `c` of each triangle.
    #[inline]
    fn corners([p, q, r, s]: &[Triangle; 4], c: usize) -> Points {
        [
            _mm256_setr_pd(p[c][0], q[c][0], r[c][0], s[c][0]),
            _mm256_setr_pd(p[c][1], q[c][1], r[c][1], s[c][1]),
            _mm256_setr_pd(p[c][2], q[c][2], r[c][2], s[c][2]),
        ]
    }
}

compiled_for_avx2! {
    #[inline]
    fn splat([x, y, z]: &[f64; 3]) -> Points {
        [_mm256_set1_pd(*x), _mm256_set1_pd(*y), _mm256_set1_pd(*z)]
    }
}

compiled_for_avx2! {
    #[inline]
    fn magnitude(x: __m256d) -> __m256d {
        _mm256_andnot_pd(_mm256_set1_pd(-0.0), x)
    }
}

compiled_for_avx2! {
    #[inline]
    fn difference(p: &Points, q: &Points) -> Points {
        [_mm256_sub_pd(p[0], q[0]), _mm256_sub_pd(p[1], q[1]), _mm256_sub_pd(p[2], q[2])]
    }
}

compiled_for_avx2! {
    /// A minor, and the same with absolute values.
    #[inline]
    fn minor(u: &Points, v: &Points, i: usize, j: usize) -> (__m256d, __m256d) {
        let (plus, minus) = (_mm256_mul_pd(u[i], v[j]), _mm256_mul_pd(u[j], v[i]));
        (_mm256_sub_pd(plus, minus), _mm256_add_pd(magnitude(plus), magnitude(minus)))
    }
}

compiled_for_avx2! {
    #[inline]
    fn planes_of([origin, p, q]: &[Points; 3]) -> FourPlanes {
        let (u, v) = (difference(p, origin), difference(q, origin));
        let (x, y, z) = (minor(&u, &v, 1, 2), minor(&u, &v, 2, 0), minor(&u, &v, 0, 1));
        FourPlanes { origin: *origin, normal: [x.0, y.0, z.0], magnitude: [x.1, y.1, z.1] }
    }
}

compiled_for_avx2! {
    /// `x[0] y[0] + x[1] y[1] + x[2] y[2]`, from left to right.
    #[inline]
    fn dot(x: &Points, y: &Points) -> __m256d {
        let two = _mm256_add_pd(_mm256_mul_pd(x[0], y[0]), _mm256_mul_pd(x[1], y[1]));
        _mm256_add_pd(two, _mm256_mul_pd(x[2], y[2]))
    }
}

compiled_for_avx2! {
    /// All ones where all three points are certainly on the same side of the plane, and off it.
    #[inline]
    fn strictly_one_side(planes: &FourPlanes, points: &[Points; 3], away: __m256d) -> __m256d {
        let mut above = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));
        let mut below = above;
        for p in points {
            let w = difference(p, &planes.origin);
            let determinant = dot(&planes.normal, &w);
            let far = |x: __m256d| _mm256_add_pd(magnitude(x), away);
            let magnitudes = [far(w[0]), far(w[1]), far(w[2])];
            let bound = _mm256_mul_pd(_mm256_set1_pd(DETERMINANT_ERROR), dot(&planes.magnitude, &magnitudes));
            let minus = _mm256_xor_pd(determinant, _mm256_set1_pd(-0.0));
            above = _mm256_and_pd(above, _mm256_cmp_pd::<_CMP_GT_OQ>(determinant, bound));
            below = _mm256_and_pd(below, _mm256_cmp_pd::<_CMP_GT_OQ>(minus, bound));
        }
        _mm256_or_pd(above, below)
    }
}
