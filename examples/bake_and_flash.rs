//! A tree as bytes: baked on a workstation, stored in flash, and read in place on the robot, without a copy and without
//! a heap.
//!
//! ```sh
//! cargo run --example bake_and_flash
//! ```

mod shapes;

use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::{Aligned, BvhRef, FormatError};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;

/// k = 14 instead of 18: a fifth less flash, and nearly as fast.
type Node = Node16<14>;

/// Stands for the flash of a robot. Firmware would include the tree from a file:
///
/// ```ignore
/// static GRIPPER: &Aligned<[u8]> = &Aligned(*include_bytes!("gripper.simdop"));
/// ```
///
/// where `Aligned` aligns the bytes to 64, which reading nodes in place requires.
type Flash = Aligned<[u8; 4096]>;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // On the workstation: build, and write the bytes to a file. `simdop build gripper.obj -k 14 -o gripper.simdop` does
    // the same.
    let (vertices, triangles) = shapes::cuboid([-0.04, -0.1, -0.02], [0.04, 0.1, 0.02]);
    let built = Builder::new().build_as::<Node>(&Mesh { vertices: &vertices, triangles: &triangles })?;
    let file: Vec<u8> = built.as_bytes().to_vec();

    let mut flash: Flash = Aligned([0xff; 4096]);
    flash.0[..file.len()].copy_from_slice(&file);
    println!("{} triangles in {} bytes of flash", triangles.len(), file.len());

    // On the robot, once at boot. The bytes need not be trusted: they are rejected if they are not a tree of this node
    // type, or if they could lead a query out of bounds.
    let gripper = BvhRef::<Node>::from_bytes(&flash.0[..file.len()])?;
    // For bytes from an untrusted source, also verify in exact arithmetic that every k-DOP bounds the triangles below
    // it.
    gripper.verify()?;

    // From here on queries work as usual, and give the same answers as on the workstation.
    let query = Query::new(Isa::detect());
    let pose = Pose::from_rows([[0.0, -1.0, 0.0, 0.13], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    let on_robot = query.collide(&gripper, &gripper, &pose);
    assert_eq!(on_robot, query.collide(&built.view(), &built.view(), &pose));
    assert!(on_robot.hit().is_some());

    // Each kind of invalid bytes has an error of its own.
    let other_k = BvhRef::<Node16<18>>::from_bytes(&flash.0[..file.len()]);
    assert!(matches!(other_k, Err(FormatError::OtherNode { k: 14, arity: 16 })));
    let cut_short = BvhRef::<Node>::from_bytes(&flash.0[..256]);
    assert!(matches!(cut_short, Err(FormatError::Truncated { have: 256, .. })));
    flash.0[0] ^= 1;
    assert!(matches!(BvhRef::<Node>::from_bytes(&flash.0[..file.len()]), Err(FormatError::NotATree)));
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
