//! Queries of two shapes.

use crate::pose::Pose;
use crate::primitive::Shape;
use crate::query::distance::Distance;
use crate::query::entry::{Answer, Query, ToleranceError, checked};

impl Query {
    /// Whether two shapes meet, the first placed by `pose` in the frame of the second. Touching counts as meeting. The
    /// indices of a hit are 0.
    ///
    /// ```
    /// use simdop::{Isa, Pose, Query, primitive::Shape};
    /// let (query, ball) = (Query::new(Isa::detect()), Shape::sphere(0.5)?);
    /// let ground = Shape::half_space([0.0, 0.0, 1.0], 0.0)?;
    /// let up = |z| Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]]);
    /// assert!(query.collide_shapes(&ball, &ground, &up(0.5)?).hit().is_some());
    /// let distance = query.distance_shapes(&ball, &ground, &up(2.0)?, 0.0, f64::INFINITY)?;
    /// assert!(distance.lower <= 1.5 && 1.5 <= distance.upper && distance.upper < 1.5 + 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline]
    pub fn collide_shapes(&self, a: &Shape, b: &Shape, pose: &Pose) -> Answer {
        self.shapes_within(a, pose, b, 0.0)
    }

    /// Whether two shapes come within `margin` of each other. As [`Query::collide_shapes`].
    ///
    /// # Errors
    /// [`ToleranceError`] if `margin` is negative, infinite or NaN.
    #[inline]
    pub fn within_shapes(
        &self,
        a: &Shape,
        b: &Shape,
        pose: &Pose,
        margin: f64,
    ) -> Result<Answer, ToleranceError> {
        Ok(self.shapes_within(a, pose, b, checked(margin)?))
    }

    /// The distance of two shapes, if it is at most `cutoff`. As [`Query::distance_shape`].
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN, or `cutoff` negative or NaN.
    #[inline]
    pub fn distance_shapes(
        &self,
        a: &Shape,
        b: &Shape,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, ToleranceError> {
        let cutoff = if cutoff == f64::INFINITY { cutoff } else { checked(cutoff)? };
        Ok(self.shapes_distance(a, pose, b, checked(tolerance)?, cutoff))
    }
}
