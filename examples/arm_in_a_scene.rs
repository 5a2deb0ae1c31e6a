//! A planner's validity check: does the arm collide, and how near does it come to its surroundings?
//!
//! ```sh
//! cargo run --release --example arm_in_a_scene
//! ```
//!
//! An arm of two capsules holds a can, a cylinder, and rotates about its shoulder beside a shelf on a table. All bodies
//! are shapes, not meshes, so the answers hold for the round bodies themselves.

use simdop::glam::{DAffine3, DVec3};
use simdop::primitive::Shape;
use simdop::scene::Body;
use simdop::{Isa, Node16, Pose, Query, Scene};

/// In metres, like all lengths here.
const UPPER_ARM: f64 = 0.4;
const FOREARM: f64 = 0.3;

/// The poses of the upper arm and the forearm: capsules along z, about their centres.
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
    let at = |x: f64, z: f64| Pose::try_from(DAffine3::from_translation(DVec3::new(x, 0.0, z)));

    // No body has a tree, so any node type will do.
    let mut scene: Scene<'_, Node16<18>> = Scene::new();
    let rest = arm(0.0, 0.0);
    let upper = scene.insert(Body::new(Shape::capsule(0.06, UPPER_ARM)?), &Pose::try_from(rest[0])?)?;
    let fore = scene.insert(Body::new(Shape::capsule(0.05, FOREARM)?), &Pose::try_from(rest[1])?)?;
    let can = scene.insert(Body::new(Shape::cylinder(0.03, 0.14)?), &at(UPPER_ARM + FOREARM, 0.3)?)?;
    scene.insert(Body::new(Shape::cuboid([3.0, 3.0, 0.1])?).fixed(), &at(0.0, -0.05)?)?;
    let shelf = scene.insert(Body::new(Shape::cuboid([0.2, 0.6, 0.5])?).fixed(), &at(0.75, 0.25)?)?;
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
