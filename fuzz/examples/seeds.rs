//! Writes the seeds of every target; deterministic.

use simdop::node::{Dop, Node4, Node16};
use simdop_fuzz::bodies::bodies;
use simdop_fuzz::clouds::clouds;
use simdop_fuzz::spheres::sphere_bodies;
use simdop_fuzz::{Half, Input};
use std::io;
use std::path::Path;

const NAMES: [&str; 10] =
    ["k6", "k14", "k18", "k26", "k32", "half_k6", "half_k14", "half_k18", "half_k26", "half_k32"];

fn main() -> io::Result<()> {
    let targets = [
        "kernel_1v16",
        "kernel_4v4",
        "keys",
        "realign",
        "primitive_slab",
        "balls",
        "traverse",
        "distance",
        "from_bytes",
        "sphere_bytes",
        "points",
        "cloud_bytes",
        "shapes",
    ];
    for target in targets {
        // Each k, and the modes in turn; then random bytes. The byte for k also selects the storage of planes here.
        let has_storage = ["kernel_1v16", "kernel_4v4", "realign", "primitive_slab"].contains(&target);
        for k in 0..if has_storage { 10 } else { 5 } {
            let choice = [k];
            let mut input = Input::new(&choice);
            let mut seed = vec![k % 3, k, k];
            seed.extend((0..48).map(|_| input.u8()));
            write(target, NAMES[usize::from(k)], &seed)?;
        }
    }
    // Bodies of different sizes, the torus against the torus: at equal size, at the largest ratio in both orders, and
    // with one, the other or both far from the origin. Then a corner near a corner, and random bytes.
    let torus = |size: u8, place: u8| [4 * (4 * 7 + size) + place, 0];
    let pairs = [
        (torus(0, 0), torus(0, 0)),
        (torus(6, 0), torus(0, 0)),
        (torus(0, 0), torus(6, 0)),
        (torus(2, 3), torus(0, 0)),
        (torus(0, 0), torus(2, 3)),
        (torus(1, 3), torus(0, 3)),
    ];
    for (k, (a, b)) in (0..).zip(pairs) {
        let choice = [k, 1];
        let mut input = Input::new(&choice);
        let mut seed = vec![2, k % 5, k, 0];
        seed.extend([a, b].concat());
        seed.extend((0..48).map(|_| input.u8()));
        for target in ["traverse", "distance"] {
            write(target, &format!("sizes{k}"), &seed)?;
        }
    }
    // Each pair of kinds of shapes, on the lattice and in real numbers: the mode, the kind of the first, its numbers,
    // and the kind of the second, whose position depends on how many bytes the first takes.
    for (k, name) in (0..7).zip(["point", "segment", "triangle", "cuboid", "cylinder", "cone", "half_space"])
    {
        for (mode, numbers) in [(0, "lattice"), (1, "any_bits"), (2, "real")] {
            let choice = [k, mode, 2];
            let mut input = Input::new(&choice);
            let mut seed = vec![mode, k];
            seed.extend((0..64).map(|_| input.u8()));
            write("shapes", &format!("{name}_{numbers}"), &seed)?;
        }
    }
    write("from_bytes", "torus", tree::<Node16<18>>(0))?;
    write("from_bytes", "torus_of_halves", tree::<Node16<18, Half>>(0))?;
    write("from_bytes", "doubles", tree::<Node4<14>>(2))?;
    write("from_bytes", "coincident", tree::<Node4<32>>(6))?;
    write("from_bytes", "triangle", tree::<Node16<6>>(9))?;
    write("from_bytes", "nothing", tree::<Node4<6>>(10))?;
    write("sphere_bytes", "lattice", spheres::<Node16<18>>(0))?;
    write("sphere_bytes", "without_balls", spheres::<Node16<6>>(1))?;
    write("sphere_bytes", "unlike", spheres::<Node16<6>>(2))?;
    write("sphere_bytes", "leaves", spheres::<Node16<6>>(3))?;
    write("sphere_bytes", "overlapping", spheres::<Node4<6>>(4))?;
    write("sphere_bytes", "sphere", spheres::<Node16<26>>(5))?;
    write("sphere_bytes", "nothing", spheres::<Node16<6>>(7))?;
    // An even first number selects changes to bytes, an odd one selects points and operations on them. Seeds longer
    // than the fuzzer's inputs are left to the changes.
    let names = [
        (0, "lattice"),
        (1, "real"),
        (6, "coincident"),
        (7, "zeros"),
        (8, "huge"),
        (9, "point"),
        (10, "nothing"),
        (11, "emptied"),
    ];
    for (cloud, name) in names {
        write("cloud_bytes", name, &clouds()[cloud].view().to_bytes())?;
    }
    for mode in 0..3 {
        for points in [150, 60, 17] {
            let choice = [mode, points];
            let mut input = Input::new(&choice);
            let mut seed = vec![1, mode, points, 9];
            seed.extend((0..usize::from(points) * 9).map(|_| input.u8()));
            write("cloud_bytes", &format!("moved{mode}_{points}"), &seed)?;
        }
    }
    Ok(())
}

fn tree<N: Dop>(index: usize) -> &'static [u8] {
    bodies::<N>().0[index].tree.as_bytes()
}

fn spheres<N: Dop>(index: usize) -> &'static [u8] {
    sphere_bodies::<N>().0[index].tree.as_bytes()
}

fn write(target: &str, name: &str, seed: &[u8]) -> io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds").join(target);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join(name), seed)
}
