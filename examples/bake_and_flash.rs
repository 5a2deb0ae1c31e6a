//! A tree as bytes: baked on a workstation, kept in flash, and read in place on the robot, without a copy and
//! without a heap.
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

/// Stands for the flash of a robot. Firmware would have its tree in a file and write
///
/// ```ignore
/// static GRIPPER: &Aligned<[u8]> = &Aligned(*include_bytes!("gripper.simdop"));
/// ```
///
/// where `Aligned` puts the bytes at a multiple of 64, which nodes that are read in place need.
type Flash = Aligned<[u8; 4096]>;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // On the workstation: build, and write the bytes to a file. `simdop build gripper.obj -k 14 -o
    // gripper.simdop` does the same.
    let (vertices, triangles) = shapes::cuboid([-0.04, -0.1, -0.02], [0.04, 0.1, 0.02]);
    let built = Builder::new().build_as::<Node>(&Mesh { vertices: &vertices, triangles: &triangles })?;
    let file: Vec<u8> = built.as_bytes().to_vec();

    let mut flash: Flash = Aligned([0xff; 4096]);
    flash.0[..file.len()].copy_from_slice(&file);
    println!("{} triangles in {} bytes of flash", triangles.len(), file.len());

    // On the robot, once at boot. Bytes are not trusted: those that are not a tree of this node type, or
    // could lead a query out of range, are refused.
    let gripper = BvhRef::<Node>::from_bytes(&flash.0[..file.len()])?;
    // Where the bytes come from somebody else: prove too, in exact arithmetic, that every volume holds the
    // triangles below it.
    gripper.verify()?;

    // From here on a query is what it is anywhere, and gives what it gives on the workstation.
    let query = Query::new(Isa::detect());
    let pose = Pose::from_rows([[0.0, -1.0, 0.0, 0.13], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    let on_robot = query.collide(&gripper, &gripper, &pose);
    assert_eq!(on_robot, query.collide(&built.view(), &built.view(), &pose));
    assert!(on_robot.hit().is_some());

    // What is wrong with bytes has a name.
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
