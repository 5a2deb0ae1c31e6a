//! The upper bound of the depth: the shortest translation found after which the bodies are free.
//!
//! Along a direction, the search tests translations outwards from those known to be forbidden until one is free, and
//! bisects between it and the last one that is not. While the lower bound still grows and some way out is known, it
//! tests only two: a little more than what is forbidden, and a little less than the best. From the shortest free
//! translation along the direction, a descent approaches the bodies. At a translation t with
//! the gap g, let n be the unit vector from B's nearest point to A's. Of the translations at which the plane between
//! these points separates the bodies, `n (n . t - g)` is the nearest to the origin: for convex bodies it is free. For
//! others it may not be; then the descent goes only part of the way there, or straight towards the origin by g, which
//! is always free. The exact query tests every translation.

use super::cover::ForbiddenBall;
use super::interval::OutOfBudget;
use super::posed_pair::PosedPair;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, dot, length, sqrt, unit};

/// The best translation so far, and the directions still to be tried.
pub(super) struct WayOut {
    pub(super) upper: f64,
    pub(super) translation: Point,
    /// Number of fixed directions tried.
    fixed: usize,
    /// Number of directions tried about the best one since it changed, and their offset from it.
    beside: usize,
    reach: f64,
    /// Whether the bodies touch after the best translation.
    is_touching: bool,
}

/// A descent begins at this fraction of the best translation's length.
const SHORTER: f64 = 0.98;
const MOST_STEPS: usize = 24;
/// If nothing is known to be forbidden, the search along a direction begins at this fraction of the length that always
/// separates the bodies.
const LEAST: f64 = power_of_two(-12);
/// The first step beyond what is forbidden, as a fraction of it; the steps double.
const FIRST_AHEAD: f64 = power_of_two(-4);
const MOST_AHEAD: usize = 40;
/// While the lower bound still grows, bisections of the ratio of a free length to that of a hit.
const FEW_HALVINGS: usize = 3;
/// While the lower bound still grows, a free translation is refined only if its direction may allow one as short as
/// this multiple of the bound.
const PROMISING: f64 = 1.25;
const MOST_HALVINGS: usize = 8;
/// Relative tolerances of gaps during a descent, and in the last descent to contact.
const ROUGH: f64 = power_of_two(-3);
const FINE: f64 = power_of_two(-10);
/// A descent ends at a gap of this fraction of the translation.
const NEAR: f64 = power_of_two(-7);
/// The last descent, from the best translation of all, ends at this fraction.
const TOUCHING: f64 = power_of_two(-37);
/// The fraction of a gap that a step keeps: more than the rounding of the verdict.
const KEPT: f64 = power_of_two(-30);
/// Number of fixed directions: to the faces, edges and corners of a cube.
const FIXED: usize = 26;
const BESIDE: usize = 6;
const NEAREST: f64 = 0.02;

impl WayOut {
    pub(super) const fn new() -> Self {
        Self {
            upper: f64::INFINITY,
            translation: [0.0; 3],
            fixed: 0,
            beside: 0,
            reach: 0.4,
            is_touching: false,
        }
    }

    pub(super) const fn is_exhausted(&self) -> bool {
        self.fixed >= FIXED && self.reach < NEAREST && self.is_touching
    }

    fn accept(&mut self, t: &Point) {
        let upper = length(t) * (1.0 + 4.0 * f64::EPSILON);
        if upper < self.upper {
            (self.upper, self.translation) = (upper, *t);
            (self.beside, self.reach) = (0, f64::min(self.reach * 2.0, 0.4));
            self.is_touching = false;
        }
    }

    /// Tries a fixed direction, or when these are used up, one near the best.
    pub(super) fn try_next(
        &mut self,
        cover: &ForbiddenBall,
        bodies: &mut impl PosedPair,
    ) -> Result<(), OutOfBudget> {
        if self.fixed < FIXED {
            // The 27 cells of a cube without the middle one.
            let code = self.fixed + usize::from(self.fixed >= 13);
            let cell = [code % 3, code / 3 % 3, code / 9].map(|x| x as f64 - 1.0);
            self.try_along(&cell, cover, bodies)?;
            self.fixed += 1;
        } else if self.reach < NEAREST {
            self.touch(bodies)?;
        } else {
            let Some(best) = unit(&self.translation) else {
                self.reach = 0.0;
                return Ok(());
            };
            let axis = if best[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            let x = unit(&cross(&best, &axis)).unwrap_or(axis);
            let y = cross(&best, &x);
            // The corners of a hexagon.
            let (u, v) =
                [(1.0, 0.0), (-1.0, 0.0), (0.5, 0.866), (-0.5, -0.866), (-0.5, 0.866), (0.5, -0.866)]
                    [self.beside % BESIDE];
            let (u, v) = (u * self.reach, v * self.reach);
            let direction = core::array::from_fn(|i| best[i] + (u * x[i] + v * y[i]));
            let upper = self.upper;
            self.try_along(&direction, cover, bodies)?;
            if self.upper >= upper {
                self.beside += 1;
                if self.beside == BESIDE {
                    (self.beside, self.reach) = (0, 0.5 * self.reach);
                }
            }
        }
        Ok(())
    }

    /// Searches along a direction for a free translation, from what is known to be forbidden to a little less than the
    /// best translation, and descends from there if it is worth it.
    pub(super) fn try_along(
        &mut self,
        direction: &Point,
        cover: &ForbiddenBall,
        bodies: &mut impl PosedPair,
    ) -> Result<(), OutOfBudget> {
        let Some(along) = unit(direction) else { return Ok(()) };
        let most = if self.upper < f64::INFINITY { SHORTER * self.upper } else { bodies.far() };
        let forbidden = cover.along(&along);
        if forbidden >= most {
            return Ok(());
        }
        let forbidden = f64::max(forbidden, LEAST * bodies.far());
        let (mut hit, mut ahead) = (forbidden, FIRST_AHEAD * forbidden);
        for _ in 0..MOST_AHEAD {
            let far = f64::min(forbidden + ahead, most);
            if self.is_free_at(&along, far, bodies)? {
                return self.shorten(&along, [hit, far], cover, bodies);
            }
            if far >= most {
                break;
            }
            let is_thorough = cover.is_final || self.upper == f64::INFINITY;
            (hit, ahead) = (far, if is_thorough { 2.0 * ahead } else { most });
        }
        Ok(())
    }

    fn is_free_at(
        &mut self,
        along: &Point,
        far: f64,
        bodies: &mut impl PosedPair,
    ) -> Result<bool, OutOfBudget> {
        let t = along.map(|x| x * far);
        let is_free = bodies.is_free(&t)?;
        if is_free {
            self.accept(&t);
        }
        Ok(is_free)
    }

    /// Seeks a shorter translation between a hit and a free one along a direction.
    fn shorten(
        &mut self,
        along: &Point,
        [mut hit, mut free]: [f64; 2],
        cover: &ForbiddenBall,
        bodies: &mut impl PosedPair,
    ) -> Result<(), OutOfBudget> {
        if !cover.is_final {
            for _ in 0..FEW_HALVINGS {
                if free <= (1.0 + FIRST_AHEAD) * hit {
                    break;
                }
                let middle = sqrt(hit * free);
                if self.is_free_at(along, middle, bodies)? { free = middle } else { hit = middle }
            }
        }
        let is_worth = cover.is_final || hit <= PROMISING * cover.lower();
        if is_worth { self.approach(along, [hit, free], bodies) } else { Ok(()) }
    }

    /// Bisects between a hit and a free translation along a direction, and descends from there.
    fn approach(
        &mut self,
        along: &Point,
        [mut hit, mut free]: [f64; 2],
        bodies: &mut impl PosedPair,
    ) -> Result<(), OutOfBudget> {
        for _ in 0..MOST_HALVINGS {
            if free - hit <= NEAR * free {
                break;
            }
            let middle = 0.5 * (hit + free);
            if self.is_free_at(along, middle, bodies)? { free = middle } else { hit = middle }
        }
        self.descend(along.map(|x| x * free), NEAR, bodies)
    }

    /// Descends from the best translation until the bodies touch.
    pub(super) fn touch(&mut self, bodies: &mut impl PosedPair) -> Result<(), OutOfBudget> {
        if !self.is_touching && self.upper < f64::INFINITY {
            let (beside, reach) = (self.beside, self.reach);
            self.descend(self.translation, TOUCHING, bodies)?;
            (self.beside, self.reach) = (beside, reach);
        }
        self.is_touching = true;
        Ok(())
    }

    /// Descends from a free translation until the gap is at most the fraction `until` of its length.
    fn descend(&mut self, mut t: Point, until: f64, bodies: &mut impl PosedPair) -> Result<(), OutOfBudget> {
        for _ in 0..MOST_STEPS {
            let tolerance = if until < NEAR { FINE } else { ROUGH };
            let Some((gap, normal)) = bodies.gap(&t, tolerance)? else { break };
            let (far, gap) = (length(&t), gap * (1.0 - KEPT));
            let ahead = dot(&normal, &t) - gap;
            if gap <= until * far && ahead >= (1.0 - NEAR) * far {
                break;
            }
            let straight = t.map(|x| x * (1.0 - gap / far));
            let mut next = None;
            if ahead > 0.0 {
                for share in [1.0, 0.5, 0.2] {
                    let to =
                        core::array::from_fn(|i| straight[i] + share * (normal[i] * ahead - straight[i]));
                    if bodies.is_free(&to)? {
                        next = Some(to);
                        break;
                    }
                }
            }
            t = match next {
                Some(to) => to,
                None if bodies.is_free(&straight)? => straight,
                None => break,
            };
            self.accept(&t);
        }
        Ok(())
    }
}

/// The last hit along a direction, approached from outside.
pub(super) fn along(direction: &Point, bodies: &mut impl PosedPair) -> Result<f64, OutOfBudget> {
    let Some(along) = unit(direction) else { return Ok(f64::INFINITY) };
    let at = |far: f64| along.map(|x| x * far);
    let (mut far, mut best) = (bodies.far(), f64::INFINITY);
    let smallest = TOUCHING * far;
    // A step by the gap passes no hit.
    for _ in 0..4096 {
        if !bodies.is_free(&at(far))? {
            break;
        }
        best = far;
        let Some((gap, _)) = bodies.gap(&at(far), FINE)? else { break };
        if far == 0.0 || gap <= smallest {
            break;
        }
        far = f64::max(far - gap * (1.0 - KEPT), 0.0);
    }
    Ok(best)
}
