//! The queries that every bare-metal program runs, on a tree and a cloud in its read-only memory.
#![no_std]

mod cloud;
pub mod cost;
pub mod memory;
pub mod points;
pub mod poses;
pub mod scene;

use core::fmt::Write;
use core::hint::black_box;
use simdop::hierarchy::StaticBvh;
use simdop::include_tree;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Pair, Query, QueryStats, Verdict, Verdict::*};

/// The baked tree, read in place. Its header was checked at compile time.
pub static RING: StaticBvh<Node16<18>> = include_tree!(concat!(env!("OUT_DIR"), "/ring.simdop"));

include!(concat!(env!("OUT_DIR"), "/expected.rs"));

/// Whether the ring meets itself at another pose, in one query: the size of a program with only this query is what
/// `Query::collide` adds to firmware.
// Inlined, so that programs which do not call it have no second caller of `collide`, which would change their counts.
#[inline]
pub fn crosses() -> bool {
    let (Ok(ring), Ok(pose)) = (RING.view(), Pose::from_rows(black_box(poses::POSES[1].1))) else {
        return false;
    };
    Query::new(Isa::detect()).collide(&ring, &ring, &pose).hit().is_some()
}

/// Runs every query and prints its answer. True if each has the verdict that geometry gives, and the host's query
/// statistics.
pub fn run(out: &mut impl Write) -> bool {
    match try_run(out) {
        Ok(good) => good,
        Err(what) => {
            let _ = writeln!(out, "FAILED: {what}");
            false
        }
    }
}

fn try_run(out: &mut impl Write) -> Result<bool, &'static str> {
    let isa = Isa::detect();
    let ring = RING.view().map_err(|_| "the tree is not one")?;
    let again = RING.view().map_err(|_| "the tree is one no longer")?;
    let mut good = true;
    let mut sums = [0; 6];
    for number in 0..poses::RANDOM {
        let pose = Pose::from_rows(poses::random(number)).map_err(|_| "the pose is not rigid")?;
        poses::tally(&mut sums, &Query::new(isa).collide(&ring, &again, &pose));
    }
    let agrees = sums == EXPECTED_RANDOM;
    let verdict = if agrees { "as expected" } else { "WRONG" };
    writeln!(out, "{} random poses: {sums:?}: {verdict}", isa.name()).map_err(|_| "no output")?;
    good &= agrees;
    for ((name, rows, meets), expected) in poses::POSES.iter().zip(EXPECTED) {
        let pose = Pose::from_rows(*rows).map_err(|_| "the pose is not rigid")?;
        let answer = Query::new(isa).collide(&ring, &again, &pose);
        let found = (answer.verdict, answer.stats);
        let agrees = found == expected && answer.hit().is_some() == *meets;
        let verdict = if agrees { "as expected" } else { "WRONG" };
        writeln!(out, "{} {name}: {found:?}: {verdict}", isa.name()).map_err(|_| "no output")?;
        good &= agrees;
    }
    let arm = memory::arm().map_err(|scene::Failed| "the scene is none")?;
    let (mut arm, waiting) = arm.ok_or("the scene's memory is taken")?;
    let answers =
        arm.answers(&Query::new(isa), waiting).map_err(|scene::Failed| "the scene does not answer")?;
    for ((found, expected), is_free) in answers.iter().zip(EXPECTED_SCENE).zip(scene::IS_FREE) {
        let agrees = *found == expected && found.0 == is_free;
        let verdict = if agrees { "as expected" } else { "WRONG" };
        writeln!(out, "{} scene: {found:?}: {verdict}", isa.name()).map_err(|_| "no output")?;
        good &= agrees;
    }
    Ok(cloud::run(out, isa)? && good)
}
