//! How long do configurations of the Panda take in Rust, by the C functions from Rust, and from C++?
//!
//! ```sh
//! cargo build --release -p simdop-capi
//! g++ -std=c++17 -O2 -DSIMDOP_URDF -DSIMDOP_PLANNING -Icapi/include capi/examples/configurations.cpp \
//!     target/release/libsimdop_capi.a -lpthread -lm -ldl -o target/configurations
//! cargo run --release -p simdop-capi --example configurations -- PANDA_FOLDER target/configurations
//! ```
//!
//! The folder has `panda.urdf`, `panda.srdf` and the meshes. All run in turn, fifteen times. Prints the median CPU time
//! of a configuration in microseconds, and the median ratio to Rust in the same round. All must find the same number of
//! free configurations.

use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::motion::LinkFrame;
use simdop::node::{Aabb16, Node16};
use simdop::planning::{PlanningScene, RobotFiles};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use simdop::scene::{Body, BodyId, Scene};
use simdop_capi::*;
use std::ffi::{CString, c_long};
use std::io::{BufRead, BufReader, Write};
use std::mem::MaybeUninit;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const COUNT: usize = 4096;
const ROUNDS: usize = 15;
/// Width of the cells of the bounds, in metres.
const CELL: f64 = 0.02;

type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn read_obj(path: &Path) -> Triangles {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => vertices.push([0; 3].map(|_| words.next().unwrap().parse().unwrap())),
            Some("f") => {
                let corner = |word: &str| word.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                triangles.push([0; 3].map(|_| corner(words.next().unwrap())));
            }
            _ => {}
        }
    }
    (vertices, triangles)
}

/// Boxes of a table and a shelf: side lengths and positions.
const OBSTACLES: [([f64; 3], [f64; 3]); 5] = [
    ([1.2, 0.6, 0.05], [0.7, 0.0, 0.2]),
    ([0.05, 0.6, 0.8], [0.9, 0.0, 0.6]),
    ([0.4, 0.6, 0.03], [0.75, 0.0, 0.6]),
    ([0.3, 0.3, 0.3], [0.0, 0.6, 0.15]),
    ([0.2, 0.2, 0.6], [-0.4, -0.4, 0.3]),
];

fn at([x, y, z]: [f64; 3]) -> simdop_pose {
    simdop_pose { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]] }
}

/// The value that a C function writes.
fn written<T>(ask: impl FnOnce(Option<&mut MaybeUninit<T>>) -> simdop_error) -> T {
    let mut place = MaybeUninit::uninit();
    assert_eq!(ask(Some(&mut place)), simdop_error::None);
    // SAFETY: written on success.
    unsafe { place.assume_init() }
}

/// Checks all configurations; returns how many are free.
type Run = Box<dyn FnMut() -> usize>;

/// The robot and the contents of its files. Never freed.
struct Panda {
    folder: &'static Path,
    urdf: String,
    robot: &'static Robot,
    pairs: Vec<(usize, usize)>,
    trees: &'static [Bvh<Node16<18>>],
}

impl Panda {
    fn read(folder: &'static Path) -> Self {
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
        let urdf = read("panda.urdf");
        let robot: &'static Robot =
            Box::leak(Box::new(Robot::from_urdf(&urdf, LinkShapes::Collision).unwrap()));
        let pairs = robot.pairs(&DisabledPair::from_srdf(&read("panda.srdf")).unwrap()).unwrap();
        let build = |shape: &LinkShape| {
            let LinkShape::Mesh { file, .. } = shape else { panic!("a link that is not a mesh") };
            let (vertices, triangles) = read_obj(&folder.join(file));
            let mesh = Mesh { vertices: &vertices, triangles: &triangles };
            Builder::new().solid().build_as(&mesh).or_else(|_| Builder::new().build_as(&mesh)).unwrap()
        };
        let trees: Vec<_> = robot.shapes.iter().map(build).collect();
        Self { folder, urdf, robot, pairs, trees: trees.leak() }
    }

    /// Random configurations: the same in `configurations.cpp`.
    fn values(&self) -> Vec<f64> {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 2_f64.powi(53)
        };
        let all = (0..COUNT).flat_map(|_| self.robot.limits.clone());
        all.map(|[low, high]| low + random() * (high - low)).collect()
    }

    fn scene(&self) -> (Scene<'static, Node16<18>>, Vec<BodyId>) {
        let mut scene = Scene::new();
        let bodies = self.trees.iter().map(|tree| Body::new(tree.view()));
        let ids: Vec<_> = bodies.map(|body| scene.insert(body, &Pose::IDENTITY).unwrap()).collect();
        for i in 0..ids.len() {
            for j in (i + 1..ids.len()).filter(|j| !self.pairs.contains(&(i, *j))) {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            }
        }
        for (sides, place) in OBSTACLES {
            let world = Pose::from_rows(at(place).rows).unwrap();
            scene.insert(Body::new(Shape::cuboid(sides).unwrap()).fixed(), &world).unwrap();
        }
        (scene, ids)
    }

    fn c_scene(&self) -> (Box<simdop_scene>, Vec<simdop_body_id>) {
        let mut scene = written(|scene| simdop_scene_create(scene)).unwrap();
        let role = simdop_role_default();
        let mut insert = |body: Option<Box<simdop_body>>, role: &simdop_role, world: &simdop_pose| {
            let body: &'static simdop_body = Box::leak(body.unwrap());
            written(|id| simdop_scene_insert(Some(&mut scene), Some(body), Some(role), Some(world), id))
        };
        let mut ids = Vec::new();
        for tree in self.trees {
            let bytes = tree.as_bytes();
            // SAFETY: the bytes are never freed.
            let body = written(|body| unsafe { simdop_body_open(bytes.as_ptr(), bytes.len(), body) });
            ids.push(insert(body, &role, &at([0.0; 3])));
        }
        for (sides, place) in OBSTACLES {
            let body = written(|body| simdop_body_build_shape(Some(&cuboid(sides)), body));
            insert(body, &simdop_role { is_fixed: 1, ..role }, &at(place));
        }
        for i in 0..ids.len() {
            for j in (i + 1..ids.len()).filter(|j| !self.pairs.contains(&(i, *j))) {
                let error = simdop_scene_allow_collision(Some(&mut scene), ids[i], ids[j]);
                assert_eq!(error, simdop_error::None);
            }
        }
        (scene, ids)
    }

    fn planner(&self) -> PlanningScene {
        let files = RobotFiles::new(self.folder.join("panda.urdf")).srdf(self.folder.join("panda.srdf"));
        let mut scene = PlanningScene::new(files.load().unwrap()).unwrap();
        for (sides, place) in OBSTACLES {
            let world = Pose::from_rows(at(place).rows).unwrap();
            scene.insert("", Body::new(Shape::cuboid(sides).unwrap()).fixed(), &world).unwrap();
        }
        scene
    }

    fn c_planner(&self) -> Box<simdop_planner> {
        let path = |name: &str| CString::new(self.folder.join(name).to_str().unwrap()).unwrap();
        let (urdf, srdf) = (path("panda.urdf"), path("panda.srdf"));
        // SAFETY: the paths end with a NUL.
        let planner = written(|to| unsafe { simdop_planner_load(urdf.as_ptr(), srdf.as_ptr(), 0.0, to) });
        let (mut planner, role) = (planner.unwrap(), simdop_role { is_fixed: 1, ..simdop_role_default() });
        for (sides, place) in OBSTACLES {
            let body = written(|body| simdop_body_build_shape(Some(&cuboid(sides)), body));
            let body: &'static simdop_body = Box::leak(body.unwrap());
            let (world, role) = (Some(&at(place)), Some(&role));
            let _ = written(|id| simdop_planner_insert(Some(&mut planner), Some(body), role, world, id));
        }
        planner
    }
}

fn cuboid([x, y, z]: [f64; 3]) -> simdop_shape {
    let kind = simdop_shape_kind::Cuboid as u32;
    simdop_shape { kind, numbers: [x, y, z, 0.0], radius: 0.0, pose: at([0.0; 3]) }
}

/// A scene: configurations one by one, and many in one call.
fn rust_scene(panda: &Panda, values: &'static [f64]) -> [Run; 2] {
    let (query, robot) = (Query::new(Isa::detect()), panda.robot);
    let (kinematics, variables) = (robot.kinematics().unwrap(), robot.limits.len());
    let [(mut one, ids), (mut many, same)] = [panda.scene(), panda.scene()];
    let mut links = vec![LinkFrame::EMPTY; kinematics.links()];
    let mut poses = vec![Pose::IDENTITY; 16 * ids.len()];
    let (mut links_too, mut poses_too) = (links.clone(), poses[..ids.len()].to_vec());
    let kinematics_too = robot.kinematics().unwrap();
    let one_by_one = move || {
        let mut free = 0;
        for values in values.chunks(variables) {
            kinematics_too.go_to(values, &mut links_too, &mut poses_too).unwrap();
            ids.iter().zip(&poses_too).for_each(|(id, pose)| one.place(*id, pose).unwrap());
            free += usize::from(one.collide(&query).unwrap().is_free());
        }
        free
    };
    let mut boxes = vec![Aabb16::EMPTY; many.room()];
    let at_once = move || {
        let mut free = 0;
        for values in values.chunks(16 * variables) {
            for (values, poses) in values.chunks(variables).zip(poses.chunks_mut(same.len())) {
                kinematics.go_to(values, &mut links, poses).unwrap();
            }
            let (mut bits, count) = ([0], values.len() / variables * same.len());
            let _ = many.check_states(&query, &same, &poses[..count], &mut boxes, &mut bits).unwrap();
            free += bits[0].count_ones() as usize;
        }
        free
    };
    [Box::new(one_by_one), Box::new(at_once)]
}

fn c_scene(panda: &Panda, values: &'static [f64]) -> [Run; 2] {
    let variables = panda.robot.limits.len();
    let build = || {
        let urdf = &panda.urdf;
        let description: Option<Box<simdop_description>> =
            // SAFETY: the length is that of the text.
            written(|to| unsafe { simdop_description_read(urdf.as_ptr().cast(), urdf.len(), 0, to) });
        let base = at([0.0; 3]);
        let robot = written(|to| simdop_description_build_robot(description.as_deref(), Some(&base), to));
        let robot: Box<simdop_robot> = robot.unwrap();
        (panda.c_scene(), robot)
    };
    let [((mut one, ids), mut robot), ((mut many, same), robot_too)] = [build(), build()];
    let mut poses = vec![at([0.0; 3]); ids.len()];
    let one_by_one = move || {
        let mut free = 0;
        for values in values.chunks(variables) {
            let (to, first) = (poses.as_mut_ptr(), values.as_ptr());
            // SAFETY: there is a value for each variable, and room for each body.
            let error = unsafe { simdop_robot_poses(Some(&mut robot), first, to) };
            assert_eq!(error, simdop_error::None);
            let (ids, count) = (ids.as_ptr(), ids.len());
            // SAFETY: there are as many of each.
            let error = unsafe { simdop_scene_place_all(Some(&mut one), ids, to, count) };
            assert_eq!(error, simdop_error::None);
            let answer = written(|answer| simdop_scene_collide(Some(&one), SIMDOP_NO_BUDGET, answer));
            free += usize::from(answer.verdict == simdop_verdict::Free);
        }
        free
    };
    let mut free = vec![0_u8; COUNT];
    let at_once = move || {
        let (ids, count, values, free) = (same.as_ptr(), same.len(), values.as_ptr(), free.as_mut_ptr());
        // SAFETY: the lengths are those of the vectors.
        let answer = written(|answer| unsafe {
            let (scene, robot, all) = (Some(&mut *many), Some(&*robot_too), SIMDOP_NO_BUDGET);
            simdop_scene_check_joint_states(scene, ids, count, robot, values, COUNT, all, free, answer)
        });
        answer.free
    };
    [Box::new(one_by_one), Box::new(at_once)]
}

/// A planner, without and with bounds.
fn rust_planners(panda: &Panda, values: &'static [f64]) -> [Run; 2] {
    [None, Some(CELL)].map(|cell| -> Run {
        let mut scene = panda.planner();
        if let Some(cell) = cell {
            scene.use_bounds(cell).unwrap();
        }
        let (mut workspace, mut free) = (scene.workspace(), vec![false; COUNT]);
        Box::new(move || {
            scene.check_states(&mut workspace, values, &mut free).unwrap();
            free.iter().filter(|free| **free).count()
        })
    })
}

fn c_planners(panda: &Panda, values: &'static [f64]) -> [Run; 2] {
    [None, Some(CELL)].map(|cell| -> Run {
        let mut planner = panda.c_planner();
        if let Some(cell) = cell {
            assert_eq!(simdop_planner_use_bounds(Some(&mut planner), cell), simdop_error::None);
        }
        let mut workspace = written(|to| simdop_workspace_create(Some(&planner), to)).unwrap();
        let mut free = vec![0_u8; COUNT];
        Box::new(move || {
            let (values, free, workspace) = (values.as_ptr(), free.as_mut_ptr(), Some(&mut *workspace));
            // SAFETY: the lengths are those of the vectors.
            written(|count| unsafe {
                simdop_planner_check_states(Some(&planner), workspace, values, COUNT, free, count)
            })
        })
    })
}

/// The C++ program, which waits for the number of a row.
struct Cpp {
    program: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Cpp {
    fn start(program: &str, folder: &Path) -> Self {
        let mut command = Command::new(program);
        let mut program = command.arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (program.stdin.take().unwrap(), program.stdout.take().unwrap());
        Self { program, to, from: BufReader::new(from) }
    }

    /// Closes the program's input, and waits for its end.
    fn end(mut self) {
        drop(self.to);
        assert!(self.program.wait().unwrap().success());
    }

    /// Returns seconds, and the number of free configurations.
    fn run(&mut self, row: usize) -> (f64, usize) {
        writeln!(self.to, "{row}").unwrap();
        let mut line = String::new();
        self.from.read_line(&mut line).unwrap();
        let mut words = line.split_whitespace();
        (words.next().unwrap().parse().unwrap(), words.next().unwrap().parse().unwrap())
    }
}

// C's clock, as in the C++ program: the CPU time of this process, since the machine may be busy.
unsafe extern "C" {
    safe fn clock() -> c_long;
}

fn timed(run: &mut Run) -> (f64, usize) {
    let start = clock();
    let free = run();
    // POSIX: a million ticks a second.
    ((clock() - start) as f64 * 1e-6, free)
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, program] = &arguments[..] else {
        panic!("usage: configurations PANDA_FOLDER C++_PROGRAM")
    };
    let panda = Panda::read(Path::new(String::leak(folder.clone())));
    let values: &'static [f64] = panda.values().leak();
    let mut rust =
        [rust_scene(&panda, values), rust_planners(&panda, values)].into_iter().flatten().collect::<Vec<_>>();
    let mut c =
        [c_scene(&panda, values), c_planners(&panda, values)].into_iter().flatten().collect::<Vec<_>>();
    let mut cpp = Cpp::start(program, panda.folder);
    let mut times = vec![[const { Vec::new() }; 3]; rust.len()];
    let mut free = 0;
    for _ in 0..ROUNDS {
        for (row, times) in times.iter_mut().enumerate() {
            let found = [timed(&mut rust[row]), timed(&mut c[row]), cpp.run(row)];
            free = found[0].1;
            assert!(found.iter().all(|found| found.1 == free), "row {row}: {found:?}");
            times.iter_mut().zip(found).for_each(|(times, found)| times.push(found.0 * 1e6 / COUNT as f64));
        }
    }
    cpp.end();
    println!("{free} of {COUNT} configurations are free; microseconds for each, and ratios to Rust:\n");
    println!("| configurations | Rust | C | C++ | C / Rust | C++ / Rust |\n|---|--:|--:|--:|--:|--:|");
    let names = ["scene, one by one", "scene, at once", "planner", "planner with bounds"];
    for (name, [rust, c, cpp]) in names.iter().zip(times) {
        let ratio = |to: &[f64]| median(to.iter().zip(&rust).map(|(to, rust)| to / rust).collect());
        let (by_c, by_cpp) = (ratio(&c), ratio(&cpp));
        let [rust, c, cpp] = [rust, c, cpp].map(median);
        println!("| {name} | {rust:.2} | {c:.2} | {cpp:.2} | {by_c:.2} | {by_cpp:.2} |");
    }
}
