//! Margins: how close a motion comes to an obstacle, in two ways.
//!
//! ```sh
//! cargo run --release --example margin_sweep
//! ```
//!
//! A tool moves past a post. For a list of safety margins the sweep finds the part of the motion that is nearer than
//! each, with `Query::within`. One `Query::distance` at each pose, which costs more, answers all margins at once.

mod shapes;

use simdop::construct::{Builder, Mesh};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Hint, Query};

/// In metres, like all lengths here.
const MARGINS: [f64; 4] = [0.0, 0.01, 0.05, 0.2];

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let build = |(vertices, triangles): (Vec<_>, Vec<_>)| {
        Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })
    };
    let tool = build(shapes::cuboid([-0.05, -0.05, -0.05], [0.05, 0.05, 0.05]))?;
    let post = build(shapes::cuboid([-0.02, -0.02, -1.0], [0.02, 0.02, 1.0]))?;
    let (tool, post) = (tool.view(), post.view());

    // Along x, 0.1 m to the side: the smallest gap between the faces is 0.1 - 0.05 - 0.02 = 0.03 m.
    let steps = -200..=200;
    let at = |step: i32| {
        let x = f64::from(step) * 0.005;
        Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.1], [0.0, 0.0, 1.0, 0.0]])
    };

    let query = Query::new(Isa::detect());
    let mut distances = Vec::new();
    // Consecutive poses are similar, so the nearest pair of triangles at one is a good start for the next.
    let mut hint = Hint::NONE;
    for step in steps.clone() {
        let distance = query.with_hint(hint).distance(&tool, &post, &at(step)?, 0.0)?;
        hint = distance.hint;
        distances.push(distance);
    }

    for margin in MARGINS {
        let mut near = 0;
        for (step, distance) in steps.clone().zip(&distances) {
            let is_near = query.within(&tool, &post, &at(step)?, margin)?.hit().is_some();
            // The distance lies in lower ..= upper; for a margin in between, either answer would be right.
            assert!(if is_near { distance.lower <= margin } else { distance.upper > margin });
            near += u32::from(is_near);
        }
        println!("margin {margin} m: {near} of {} poses are nearer", distances.len());
        assert_eq!(near > 0, margin >= 0.03, "0.03 m is where it passes");
    }
    let nearest = distances.iter().map(|distance| distance.upper).fold(f64::INFINITY, f64::min);
    assert!((nearest - 0.03).abs() < 1e-12);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
