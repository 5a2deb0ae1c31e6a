//! Many poses at once: the configurations that a planner samples, divided among threads.
//!
//! ```sh
//! cargo run --release --example poses_on_threads
//! ```
//!
//! Queries share nothing and allocate nothing, so threads need no locks and no workspaces: the trees are borrowed, and
//! a query, a view and a pose are `Copy`.

mod shapes;

use glam::{DAffine3, DQuat, DVec3};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::BvhRef;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Query, Verdict};
use std::thread;

type View<'t> = BvhRef<'t, Node16<18>>;

/// A planner has the world poses of a link and an obstacle; a query takes the link's pose in the obstacle's frame:
/// `inverse(world_b) * world_a`.
fn in_frame_of(world_b: &DAffine3, world_a: &DAffine3) -> Result<Pose, simdop::pose::PoseError> {
    Pose::try_from(world_b.inverse() * *world_a)
}

/// The verdict of each pose.
fn verdicts(link: &View<'_>, obstacle: &View<'_>, poses: &[Pose], threads: usize) -> Vec<Verdict> {
    let query = Query::new(Isa::detect());
    let mut verdicts = vec![Verdict::Free; poses.len()];
    let share = poses.len().div_ceil(threads);
    thread::scope(|scope| {
        for (poses, verdicts) in poses.chunks(share).zip(verdicts.chunks_mut(share)) {
            scope.spawn(move || {
                for (pose, verdict) in poses.iter().zip(verdicts) {
                    *verdict = query.collide(link, obstacle, pose).verdict;
                }
            });
        }
    });
    verdicts
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // A link 0.6 m long rotates about the z axis of the world, beside a table.
    let build = |(vertices, triangles): (Vec<_>, Vec<_>)| {
        Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })
    };
    let link = build(shapes::cuboid([0.0, -0.05, -0.05], [0.6, 0.05, 0.05]))?;
    let table = build(shapes::cuboid([-0.2, -0.2, 0.0], [0.2, 0.2, 0.4]))?;
    let world_table = DAffine3::from_rotation_translation(DQuat::IDENTITY, DVec3::new(0.5, 0.5, -0.2));

    let angles = (0..3600).map(|i| (f64::from(i) * 0.1).to_radians());
    let worlds = angles.map(DAffine3::from_rotation_z);
    let poses: Vec<Pose> = worlds.map(|world| in_frame_of(&world_table, &world)).collect::<Result<_, _>>()?;

    let threads = thread::available_parallelism().map_or(1, usize::from);
    let divided = verdicts(&link.view(), &table.view(), &poses, threads);

    // The same answers as on one thread, and as by geometry: the link's far corners reach 0.602 m, and the table
    // extends from 0.3 to 0.7 m along both axes, so the link meets it around 45 degrees.
    assert_eq!(divided, verdicts(&link.view(), &table.view(), &poses, 1));
    let hits: Vec<usize> = (0..3600).filter(|&i| matches!(divided[i], Verdict::Hit(_))).collect();
    let (first, last) = (hits[0], hits[hits.len() - 1]);
    println!(
        "{threads} threads, {} poses: the link meets the table from {} to {} degrees",
        poses.len(),
        first as f64 / 10.0,
        last as f64 / 10.0
    );
    assert_eq!(hits, (first..=last).collect::<Vec<_>>());
    assert_eq!(first + last, 900, "the scene is symmetric about 45 degrees");
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
