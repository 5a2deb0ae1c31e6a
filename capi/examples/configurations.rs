//! How long do configurations take in Rust, and through the C functions? `configurations PANDA_FOLDER`: the folder has
//! `panda.urdf`, `panda.srdf` and the meshes. Prints microseconds for each configuration, the least of five runs.

use simdop::construct::{Builder, Mesh};
use simdop::isa::Isa;
use simdop::motion::LinkFrame;
use simdop::node::{Aabb16, Node16};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use simdop::scene::{Body, Scene};
use simdop_capi::*;
use std::mem::MaybeUninit;
use std::path::Path;
use std::time::Instant;

const COUNT: usize = 4096;

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

/// Boxes of a table and a shelf: sides and places.
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

/// What a C function writes.
fn written<T>(ask: impl FnOnce(Option<&mut MaybeUninit<T>>) -> simdop_error) -> T {
    let mut place = MaybeUninit::uninit();
    assert_eq!(ask(Some(&mut place)), simdop_error::None);
    // SAFETY: written on success.
    unsafe { place.assume_init() }
}

/// Microseconds for each configuration.
fn timed(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e6 / COUNT as f64
    };
    (0..5).map(once).fold(f64::INFINITY, f64::min)
}

fn main() {
    let folder = std::env::args().nth(1).expect("usage: configurations PANDA_FOLDER");
    let (folder, read) = (Path::new(&folder), |path: &Path| std::fs::read_to_string(path).unwrap());
    let (urdf, srdf) = (read(&folder.join("panda.urdf")), read(&folder.join("panda.srdf")));
    let robot = Robot::from_urdf(&urdf, LinkShapes::Collision).unwrap();
    let pairs = robot.pairs(&DisabledPair::from_srdf(&srdf).unwrap()).unwrap();
    let meshes: Vec<Triangles> = robot
        .shapes
        .iter()
        .map(|shape| match shape {
            LinkShape::Mesh { file, .. } => read_obj(&folder.join(file)),
            LinkShape::Shape(_) => panic!("a link that is not a mesh"),
        })
        .collect();
    let built = |(vertices, triangles): &Triangles| {
        let mesh = Mesh { vertices, triangles };
        Builder::new().solid().build_as(&mesh).or_else(|_| Builder::new().build_as(&mesh)).unwrap()
    };
    let trees: Vec<simdop::hierarchy::Bvh<Node16<18>>> = meshes.iter().map(built).collect();

    let mut rust = Scene::new();
    let mut c: Box<simdop_scene> = written(|scene| simdop_scene_create(scene)).unwrap();
    let (role, mut ids, mut c_ids) = (simdop_role_default(), Vec::new(), Vec::new());
    let insert = |c: &mut simdop_scene, bytes: Option<&'static [u8]>, shape: Option<simdop_shape>, fixed| {
        let role = simdop_role { is_fixed: fixed, ..role };
        let body = match (bytes, &shape) {
            (Some(bytes), _) => written(|body| {
                // SAFETY: the bytes are never freed.
                unsafe { simdop_body_open(bytes.as_ptr(), bytes.len(), body) }
            }),
            (None, shape) => written(|body| simdop_body_build_shape(shape.as_ref(), body)),
        };
        let body: &'static simdop_body = Box::leak(body.unwrap());
        let world = Some(&at([0.0; 3]));
        written(|id| simdop_scene_insert(Some(c), Some(body), Some(&role), world, id))
    };
    let trees: &'static [_] = trees.leak();
    for tree in trees {
        ids.push(rust.insert(Body::new(tree.view()), &Pose::IDENTITY).unwrap());
        c_ids.push(insert(&mut c, Some(tree.as_bytes()), None, 0));
    }
    for i in 0..ids.len() {
        for j in i + 1..ids.len() {
            if !pairs.contains(&(i, j)) {
                rust.allow_collision(ids[i], ids[j]).unwrap();
                assert_eq!(
                    simdop_scene_allow_collision(Some(&mut c), c_ids[i], c_ids[j]),
                    simdop_error::None
                );
            }
        }
    }
    for (sides, place) in OBSTACLES {
        let world = Pose::from_rows(at(place).rows).unwrap();
        rust.insert(Body::new(Shape::cuboid(sides).unwrap().moved(&world)).fixed(), &Pose::IDENTITY).unwrap();
        let numbers = [sides[0], sides[1], sides[2], 0.0];
        let kind = simdop_shape_kind::Cuboid as u32;
        insert(&mut c, None, Some(simdop_shape { kind, numbers, radius: 0.0, pose: at(place) }), 1);
    }
    ask(&robot, (&mut rust, &ids), (&mut c, &c_ids), &urdf);
}

fn ask(
    robot: &Robot,
    (rust, ids): (&mut Scene<'_, Node16<18>>, &[simdop::scene::BodyId]),
    (c, c_ids): (&mut simdop_scene, &[simdop_body_id]),
    urdf: &str,
) {
    let (query, kinematics) = (Query::new(Isa::detect()), robot.kinematics().unwrap());
    let variables = robot.limits.len();
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2_f64.powi(53)
    };
    let values: Vec<f64> = (0..COUNT)
        .flat_map(|_| robot.limits.clone())
        .map(|[low, high]| low + random() * (high - low))
        .collect();
    let description: Box<simdop_description> =
        // SAFETY: the length is that of the text.
        written(|to| unsafe { simdop_description_read(urdf.as_ptr().cast(), urdf.len(), 0, to) }).unwrap();
    let mut c_robot: Box<simdop_robot> =
        written(|to| simdop_description_build_robot(Some(&description), Some(&at([0.0; 3])), to)).unwrap();

    let mut links = vec![LinkFrame::EMPTY; kinematics.links()];
    let mut poses = vec![Pose::IDENTITY; 16 * ids.len()];
    let mut one_by_one = 0;
    let rust_one = timed(|| {
        one_by_one = 0;
        for values in values.chunks(variables) {
            kinematics.go_to(values, &mut links, &mut poses[..ids.len()]).unwrap();
            ids.iter().zip(&poses).for_each(|(id, pose)| rust.place(*id, pose).unwrap());
            one_by_one += usize::from(rust.collide(&query).unwrap().is_free());
        }
    });
    let (mut boxes, mut together) = (vec![Aabb16::EMPTY; rust.room()], 0);
    let rust_many = timed(|| {
        together = 0;
        for values in values.chunks(16 * variables) {
            for (values, poses) in values.chunks(variables).zip(poses.chunks_mut(ids.len())) {
                kinematics.go_to(values, &mut links, poses).unwrap();
            }
            let (mut bits, count) = ([0], values.len() / variables * ids.len());
            let _ = rust.check_states(&query, ids, &poses[..count], &mut boxes, &mut bits).unwrap();
            together += bits[0].count_ones() as usize;
        }
    });
    let mut c_poses = vec![at([0.0; 3]); ids.len()];
    let mut c_one_by_one = 0;
    let c_one = timed(|| {
        c_one_by_one = 0;
        for values in values.chunks(variables) {
            // SAFETY: there is a value for each variable, and room for each body.
            let error =
                unsafe { simdop_robot_poses(Some(&mut c_robot), values.as_ptr(), c_poses.as_mut_ptr()) };
            assert_eq!(error, simdop_error::None);
            let (ids, poses) = (c_ids.as_ptr(), c_poses.as_ptr());
            // SAFETY: there are as many of each.
            let error = unsafe { simdop_scene_place_all(Some(c), ids, poses, c_ids.len()) };
            assert_eq!(error, simdop_error::None);
            let answer = written(|answer| simdop_scene_collide(Some(c), SIMDOP_NO_BUDGET, answer));
            c_one_by_one += usize::from(answer.verdict == simdop_verdict::Free);
        }
    });
    let (mut free, mut c_together) = (vec![0_u8; COUNT], 0);
    let c_many = timed(|| {
        let (ids, values, free) = (c_ids.as_ptr(), values.as_ptr(), free.as_mut_ptr());
        // SAFETY: the lengths are those of the vectors.
        let answer = written(|answer| unsafe {
            let (c, robot, all) = (Some(&mut *c), Some(&*c_robot), SIMDOP_NO_BUDGET);
            simdop_scene_check_joint_states(c, ids, c_ids.len(), robot, values, COUNT, all, free, answer)
        });
        c_together = answer.free;
    });
    assert_eq!([one_by_one, one_by_one, one_by_one], [together, c_one_by_one, c_together]);
    println!("{one_by_one} of {COUNT} configurations are free; microseconds for each:");
    println!("one by one  Rust {rust_one:.2}  C {c_one:.2}  ratio {:.2}", c_one / rust_one);
    println!("in one call Rust {rust_many:.2}  C {c_many:.2}  ratio {:.2}", c_many / rust_many);
}
