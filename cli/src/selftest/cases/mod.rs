//! The hard cases by name, with the functions that draw bodies and poses for each.

mod contacts;
mod planes;
mod sizes;
mod spheres;

use super::draw::Draw;
use super::points::{self, Neighbourhood};
use super::trial::Trial;

/// A function that draws the trials of a case.
#[derive(Copy, Clone, Debug)]
pub(super) enum Maker {
    /// Bodies that are tested for collision.
    Bodies(fn(&mut Draw) -> Trial),
    /// Points whose neighbours are searched.
    Points(fn(&mut Draw) -> Neighbourhood),
}

#[derive(Copy, Clone, Debug)]
pub(super) struct HardCase {
    pub(super) name: &'static str,
    /// The case with which times are compared: an easy one of the same kind.
    pub(super) benign: &'static str,
    pub(super) maker: Maker,
    /// Its share of all pairs is this divided by the sum over all cases.
    pub(super) share: u64,
}

const TRIANGLES: &str = "benign";
const SPHERES: &str = "benign-spheres";
const SPHERES_ON_TRIANGLES: &str = "benign-spheres-on-triangles";
const POINTS: &str = "benign-points";

const fn case(name: &'static str, benign: &'static str, maker: fn(&mut Draw) -> Trial) -> HardCase {
    HardCase { name, benign, maker: Maker::Bodies(maker), share: 1000 }
}

/// All cases, each benign case before the others of its kind.
pub(super) const CASES: [HardCase; 20] = [
    case(TRIANGLES, TRIANGLES, contacts::benign),
    case("near-parallel", TRIANGLES, planes::near_parallel),
    case("coplanar-sheets", TRIANGLES, planes::coplanar_sheets),
    case("nested-copies", TRIANGLES, contacts::nested_copies),
    case("far-1e4", TRIANGLES, sizes::far_1e4),
    case("far-1e6", TRIANGLES, sizes::far_1e6),
    case("scale-ratio", TRIANGLES, sizes::scale_ratio),
    case("needle-fans", TRIANGLES, contacts::needle_fans),
    // A pose takes a thousand times as long as in other cases.
    HardCase { share: 2, ..case("coincident", TRIANGLES, contacts::coincident) },
    case("turns", TRIANGLES, planes::turns),
    case("knife-edge", TRIANGLES, contacts::knife_edge),
    case("denormal", TRIANGLES, sizes::denormal),
    case("key-overflow", TRIANGLES, sizes::key_overflow),
    case(SPHERES, SPHERES, spheres::benign),
    case("tangent-spheres", SPHERES, spheres::tangent),
    case("nested-spheres", SPHERES, spheres::nested),
    case(SPHERES_ON_TRIANGLES, SPHERES_ON_TRIANGLES, spheres::benign_on_triangles),
    case("spheres-on-faces", SPHERES_ON_TRIANGLES, spheres::on_faces),
    HardCase { name: POINTS, benign: POINTS, maker: Maker::Points(points::uniform), share: 1000 },
    HardCase {
        name: "points-at-radius",
        benign: POINTS,
        maker: Maker::Points(points::at_radius),
        share: 1000,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::oracle::Oracle;
    use crate::selftest::trial::POSES;

    /// Each case has both answers, and cases about borderline contacts have knife-edge poses: a suite whose bodies are
    /// all far apart would accept any library.
    #[test]
    fn cases_are_hard() {
        let on_the_edge = ["coplanar-sheets", "knife-edge", "tangent-spheres", "nested-spheres", "turns"];
        for case in CASES {
            let Maker::Bodies(make) = case.maker else { continue };
            let (mut hits, mut edges, mut poses) = (0, 0, 0);
            for trial in 0..24 {
                let drawn = make(&mut Draw::new(3, case.name, trial, trial % 2 == 1));
                assert!((1..=POSES).contains(&drawn.poses.len()), "{}", case.name);
                let oracle = Oracle::new(&drawn.a, &drawn.b);
                for rows in drawn.poses.iter().take(24) {
                    let truth = oracle.truth(rows);
                    hits += usize::from(truth.meets);
                    edges += usize::from(truth.is_knife_edge);
                    poses += 1;
                }
            }
            println!("{}: {hits} hits, {edges} on the edge, of {poses} poses", case.name);
            assert!(hits * 8 > poses && hits * 8 < poses * 7, "{}: {hits} hits of {poses}", case.name);
            assert!(edges * 8 > poses || !on_the_edge.contains(&case.name), "{}: {edges} edges", case.name);
        }
    }
}
