//! Bakes the body into `$OUT_DIR/ring.simdop` and writes the host's answers to `$OUT_DIR/expected.rs`; likewise the
//! points into `points.simdop`, and the range statistics of their searches to `expected_work.rs`.

#[path = "src/points.rs"]
mod points;
#[path = "src/poses.rs"]
mod poses;
#[path = "src/scene.rs"]
mod scene;

use simdop::cloud::{PointCloud, Queries, Radii, RangeSearch};
use simdop::construct::{Builder, Mesh};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{MotionHit, Scene};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// Corners around the ring, and around its tube.
const AROUND: (u32, u32) = (32, 12);

fn main() {
    println!("cargo:rerun-if-changed=src/points.rs");
    println!("cargo:rerun-if-changed=src/poses.rs");
    println!("cargo:rerun-if-changed=src/scene.rs");
    let folder = std::path::PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    bake_points(&folder);
    let (vertices, triangles) = ring();
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    let tree = Builder::new().build(&mesh).expect("a ring is a mesh");
    std::fs::write(folder.join("ring.simdop"), tree.as_bytes()).expect("OUT_DIR is writable");

    let mut source = format!(
        "/// What the host answered.\nconst EXPECTED: [(Verdict, QueryStats); {}] = [\n",
        poses::POSES.len()
    );
    for (_, rows, _) in poses::POSES {
        let pose = Pose::from_rows(rows).expect("the poses are rigid");
        let answer = Query::new(Isa::detect()).collide(&tree.view(), &tree.view(), &pose);
        // The Debug output of these is the expression that creates them.
        writeln!(source, "    {:?},", (answer.verdict, answer.stats)).expect("a String takes everything");
    }
    source.push_str("];\n");
    let mut sums = [0; 6];
    for number in 0..poses::RANDOM {
        let pose = Pose::from_rows(poses::random(number)).expect("the poses are rigid");
        poses::tally(&mut sums, &Query::new(Isa::detect()).collide(&tree.view(), &tree.view(), &pose));
    }
    writeln!(source, "const EXPECTED_RANDOM: [u64; 6] = {sums:?};").expect("a String takes everything");
    let mut arm = scene::Arm::new(Scene::new(), tree.view()).expect("the scene is one");
    let mut waiting = [MotionHit::EMPTY; scene::WAITING];
    assert_eq!(arm.scene.ids().count(), scene::BODIES, "there is a slot for each");
    let answers = arm.answers(&Query::new(Isa::detect()), &mut waiting).expect("the host answers");
    assert_eq!(answers.map(|(is_free, ..)| is_free), scene::IS_FREE, "geometry gives these");
    writeln!(source, "const EXPECTED_SCENE: [scene::Found; {}] = {answers:?};", scene::ANSWERS)
        .expect("a String takes everything");
    std::fs::write(folder.join("expected.rs"), source).expect("OUT_DIR is writable");
}

/// The cloud, and the statistics of its searches: a constant of the consumer.
fn bake_points(folder: &Path) {
    let all: Vec<_> = (0..points::COUNT).map(|i| points::point(i, 0)).collect();
    let cloud = PointCloud::new(&all).expect("the points are finite");
    std::fs::write(folder.join("points.simdop"), cloud.view().to_bytes()).expect("OUT_DIR is writable");
    let works = points::RADII.map(|radius| {
        let mut counts = [0; points::COUNT];
        let search = RangeSearch::new(Isa::detect());
        search.count(&cloud.view(), &Queries::own(), Radii::Same(radius), &mut counts).expect("a radius")
    });
    // The Debug output is the expression that creates it.
    let source = format!(
        "/// What the host's searches cost.\nconst EXPECTED_WORK: [RangeStats; {}] = {works:?};\n",
        works.len()
    );
    std::fs::write(folder.join("expected_work.rs"), source).expect("OUT_DIR is writable");
}

/// A torus around the z axis.
fn ring() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (around, tube) = AROUND;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..tube {
            let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(tube));
            let r = poses::RING_RADIUS + poses::TUBE_RADIUS * b.cos();
            vertices.push([r * a.cos(), r * a.sin(), poses::TUBE_RADIUS * b.sin()]);
            let at = |i: u32, j: u32| (i % around) * tube + j % tube;
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (vertices, triangles)
}
