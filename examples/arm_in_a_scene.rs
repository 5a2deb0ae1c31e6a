//! A planner's validity check: does the arm collide, and how near does it come to its surroundings?
//!
//! ```sh
//! cargo run --release --example arm_in_a_scene
//! ```
//!
//! An arm of two capsules holds a can, and rotates about its shoulder beside a shelf on a table. The shelf and the
//! table are solids: a body inside them is a hit, too.

use simdop::construct::{Builder, OwnedMesh};
use simdop::glam::{DAffine3, DVec3};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{Body, Scene};

/// In metres, like all lengths here.
const UPPER_ARM: f64 = 0.4;
const FOREARM: f64 = 0.3;

/// The poses of the upper arm and the forearm: segments along z, about their centres.
fn arm(shoulder: f64, elbow: f64) -> [DAffine3; 2] {
    let along_x = DAffine3::from_rotation_y(core::f64::consts::FRAC_PI_2);
    let lifted = DAffine3::from_translation(DVec3::new(0.0, 0.0, 0.3)) * DAffine3::from_rotation_z(shoulder);
    let upper = lifted * DAffine3::from_translation(DVec3::new(0.5 * UPPER_ARM, 0.0, 0.0));
    let bent = lifted
        * DAffine3::from_translation(DVec3::new(UPPER_ARM, 0.0, 0.0))
        * DAffine3::from_rotation_z(elbow);
    let fore = bent * DAffine3::from_translation(DVec3::new(0.5 * FOREARM, 0.0, 0.0));
    [upper * along_x, fore * along_x]
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let solid = |mesh: OwnedMesh| Builder::new().solid().build(&mesh.as_mesh());
    let segment = |long: f64| -> Result<Bvh<Node16<18>>, Box<dyn core::error::Error>> {
        Ok(Builder::new().build_as(&OwnedMesh::segment(long)?.as_mesh())?)
    };
    let (upper, fore) = (segment(UPPER_ARM)?, segment(FOREARM)?);
    let (table, shelf) =
        (solid(OwnedMesh::cuboid([3.0, 3.0, 0.1])?)?, solid(OwnedMesh::cuboid([0.2, 0.6, 0.5])?)?);
    // Larger than the can by at most a tenth of a millimetre.
    let can = solid(OwnedMesh::cylinder(0.03, 0.14, 1e-4)?)?;
    let at = |x: f64, z: f64| Pose::try_from(DAffine3::from_translation(DVec3::new(x, 0.0, z)));

    let mut scene = Scene::new();
    let rest = arm(0.0, 0.0);
    let upper = scene.insert(Body::new(upper.view()).with_radius(0.06), &Pose::try_from(rest[0])?)?;
    let fore = scene.insert(Body::new(fore.view()).with_radius(0.05), &Pose::try_from(rest[1])?)?;
    let can = scene.insert(Body::new(can.view()), &at(UPPER_ARM + FOREARM, 0.3)?)?;
    scene.insert(Body::new(table.view()).fixed(), &at(0.0, -0.05)?)?;
    let shelf = scene.insert(Body::new(shelf.view()).fixed(), &at(0.75, 0.25)?)?;
    // Adjacent links always touch, and the hand holds the can.
    scene.allow_collision(upper, fore)?;
    scene.allow_collision(fore, can)?;
    scene.attach(can, fore)?;

    let query = Query::new(Isa::detect());
    let (mut free, mut nearest) = (0, f64::INFINITY);
    for degrees in (0..360).step_by(2) {
        let [to, bent] = arm(f64::from(degrees).to_radians(), 0.0);
        scene.place(upper, &Pose::try_from(to)?)?;
        scene.place(fore, &Pose::try_from(bent)?)?;
        let answer = scene.collide(&query)?;
        if let Some(hit) = answer.hit() {
            assert!(hit.b == shelf && (hit.a == fore || hit.a == can));
        }
        if answer.is_free() {
            free += 1;
            let near = scene.clearance(&query, 0.01, 0.5)?;
            nearest = near.upper.min(nearest);
        }
    }
    println!(
        "{free} of 180 places are free; the arm comes as near as {:.1} mm to something",
        1000.0 * nearest
    );
    // Behind the shelf there is only the table, 0.3 - 0.07 below the can.
    assert!((100..170).contains(&free) && nearest < 0.23);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
