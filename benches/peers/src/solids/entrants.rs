//! The libraries, each with the solids of a suite.

use super::cases::Suite;
use super::ours;
use crate::driver::{Driver, Kind, Pair, Solid};
use crate::suites::Rows;
use std::rc::Rc;

/// A distance, 0 or less where the solids meet, and the closest points of A and B.
#[derive(Copy, Clone, Debug)]
pub(super) struct Distance {
    pub(super) distance: f64,
    pub(super) points: [[f64; 3]; 2],
}

/// `None`: the library fails.
type Measure = Box<dyn Fn(usize) -> Option<Distance>>;

/// A library with the solids of a suite. Its functions take the index of a case.
pub(super) struct Entrant {
    pub(super) name: String,
    pub(super) version: String,
    pub(super) collide: Box<dyn Fn(usize) -> bool>,
    /// `None` if the library has no distance for such a pair.
    pub(super) distance: Option<Measure>,
}

/// Peers in C++, and their drivers. Excludes the packaged FCL, whose assertions end the process where shapes almost
/// touch.
pub(super) const DRIVERS: [(&str, &str); 2] =
    [("Coal", "coal-OBB"), (crate::entrants::FCL_NATIVE, "fcl-native")];

pub(super) fn entrants(suite: &Suite, drivers: &[(&'static str, Rc<Driver>)]) -> Vec<Entrant> {
    let mut entrants = ours::entrants(suite);
    entrants.extend(drivers.iter().map(|(name, driver)| driven(name, driver, suite)));
    entrants.push(parry::entrant(suite));
    entrants
}

fn driven(name: &str, driver: &Rc<Driver>, suite: &Suite) -> Entrant {
    let cases: Vec<(usize, Rows)> = suite.cases.iter().map(|case| (case.pair, case.rows)).collect();
    let pairs: Vec<Pair> = suite.pairs.iter().map(|[a, b]| Driver::pair(driver, a, b)).collect();
    let kept = Rc::new((cases, pairs));
    let measured = Rc::clone(&kept);
    let distance = move |i: usize| {
        let (cases, pairs) = &*measured;
        let (pair, rows) = &cases[i];
        let mut points = [[0.0; 3]; 2];
        let distance = pairs[*pair].distance(rows, &mut points);
        (!distance.is_nan()).then_some(Distance { distance, points })
    };
    let is_supported = distance(0).is_none_or(|found| found.distance != f64::NEG_INFINITY);
    Entrant {
        name: name.to_owned(),
        version: driver.version(),
        collide: Box::new(move |i| {
            let (cases, pairs) = &*kept;
            let (pair, rows) = &cases[i];
            pairs[*pair].collides(rows)
        }),
        distance: is_supported.then(|| Box::new(distance) as Measure),
    }
}

mod parry {
    use super::{Distance, Entrant, Kind, Rows, Solid, Suite};
    use parry3d_f64::math::{Matrix, Pose, Rotation, Vector};
    use parry3d_f64::query::{ClosestPoints, closest_points, intersection_test};
    use parry3d_f64::shape::{Ball, Capsule, Cone, Cuboid, Cylinder, HalfSpace, Shape};
    use std::rc::Rc;

    fn shape(solid: &Solid) -> Box<dyn Shape> {
        let [x, y, z] = solid.size;
        match solid.kind {
            Kind::Sphere => Box::new(Ball::new(x)),
            Kind::Capsule => Box::new(Capsule::new_z(0.5 * y, x)),
            Kind::Cuboid => Box::new(Cuboid::new(Vector::new(0.5 * x, 0.5 * y, 0.5 * z))),
            Kind::Cylinder => Box::new(Cylinder::new(0.5 * y, x)),
            Kind::Cone => Box::new(Cone::new(0.5 * y, x)),
            Kind::HalfSpace => Box::new(HalfSpace::new(Vector::Z)),
        }
    }

    /// The pose of a parry shape: parry's cylinders and cones have their axis along y.
    fn pose(rows: &Rows, kind: Kind) -> Pose {
        let column = |j: usize| Vector::new(rows[0][j], rows[1][j], rows[2][j]);
        let (x, y, z) = (column(0), column(1), column(2));
        let matrix = match kind {
            Kind::Cylinder | Kind::Cone => Matrix::from_cols(x, z, -y),
            _ => Matrix::from_cols(x, y, z),
        };
        Pose::from_parts(column(3), Rotation::from_mat3(&matrix))
    }

    pub(super) fn entrant(suite: &Suite) -> Entrant {
        let [kind, fixed] = suite.kinds;
        let cases: Vec<_> = suite.cases.iter().map(|case| (case.pair, pose(&case.rows, kind))).collect();
        let pairs: Vec<[Box<dyn Shape>; 2]> =
            suite.pairs.iter().map(|pair| [shape(&pair[0]), shape(&pair[1])]).collect();
        const STILL: Rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let still = pose(&STILL, fixed);
        let kept = Rc::new((cases, pairs));
        let measured = Rc::clone(&kept);
        Entrant {
            name: "parry f64".to_owned(),
            version: crate::entrants::PARRY_VERSION.to_owned(),
            collide: Box::new(move |i| {
                let (cases, pairs) = &*kept;
                let (pair, pose) = &cases[i];
                let [a, b] = &pairs[*pair];
                intersection_test(pose, &**a, &still, &**b).expect("the shapes are supported").intersecting
            }),
            distance: Some(Box::new(move |i| {
                let (cases, pairs) = &*measured;
                let (pair, pose) = &cases[i];
                let [a, b] = &pairs[*pair];
                match closest_points(pose, &**a, &still, &**b, f64::MAX).expect("the shapes are supported") {
                    ClosestPoints::Intersecting => Some(Distance { distance: 0.0, points: [[0.0; 3]; 2] }),
                    ClosestPoints::WithinMargin(p, q) => {
                        Some(Distance { distance: (p - q).length(), points: [p.to_array(), q.to_array()] })
                    }
                    ClosestPoints::Disjoint => None,
                }
            })),
        }
    }
}
