//! The class of a pair over all joint values: random values confirm it.

use crate::support::rng::Rng;
use crate::support::shapes;
use core::f64::consts::PI;
use glam::{DQuat, DVec3};
use simdop::cloud::PointCloud;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::motion::{Joint, JointKind, Kinematics, LinkBody, LinkFrame};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{Body, BodyId, PairClass, PairReport, Scene, SceneError};

type Tree = Bvh<Node16<18>>;

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Tree {
    let mesh = shapes::cuboid(low, high, true);
    Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::try_from((DQuat::IDENTITY, DVec3::new(x, y, z))).unwrap()
}

/// A base and three links, with a joint about z between each two.
struct Arm {
    joints: [Joint; 3],
    bodies: [LinkBody; 4],
}

impl Arm {
    fn new() -> Self {
        let joint = |i: u32| {
            Joint::new(
                JointKind::Revolute,
                i,
                at(if i == 0 { 0.0 } else { 0.5 }, 0.0, 0.0),
                [0.0, 0.0, 1.0],
                i,
            )
        };
        let body = |link: u32| LinkBody { link, at: Pose::IDENTITY };
        Self { joints: [0, 1, 2].map(|i| joint(i).unwrap()), bodies: [0, 1, 2, 3].map(body) }
    }

    fn robot<'r>(&'r self, limits: &'r [[f64; 2]]) -> Kinematics<'r> {
        Kinematics::new(&self.joints, &self.bodies, limits).unwrap()
    }
}

/// Classifies two bodies of an arm with these trees and radii, and checks the result at random values.
fn classified(
    trees: [(&Tree, f64); 4],
    limits: &[[f64; 2]],
    pair: (usize, usize),
    boxes: usize,
) -> PairReport {
    let (arm, query) = (Arm::new(), Query::new(Isa::detect()));
    let robot = arm.robot(limits);
    let mut scene = Scene::new();
    let ids: [BodyId; 4] = trees.map(|(tree, radius)| {
        scene.insert(Body::new(tree.view()).with_radius(radius), &Pose::IDENTITY).unwrap()
    });
    let report = scene.classify_pair(&query, &ids, robot, (ids[pair.0], ids[pair.1]), boxes).unwrap();
    for id in ids {
        assert_eq!(scene.world_pose(id), Ok(&Pose::IDENTITY), "bodies stand where they stood");
    }
    for i in 0..4 {
        for j in i + 1..4 {
            if (i, j) == pair || (j, i) == pair {
                scene.forbid_collision(ids[i], ids[j]).unwrap();
            } else {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            };
        }
    }
    let (mut links, mut poses) = ([LinkFrame::EMPTY; 4], [Pose::IDENTITY; 4]);
    let mut meets = |values: &[f64]| {
        robot.go_to(values, &mut links, &mut poses).unwrap();
        for (id, pose) in ids.iter().zip(&poses) {
            scene.place(*id, pose).unwrap();
        }
        !scene.collide(&query).unwrap().is_free()
    };
    assert!(report.meeting.as_ref().is_none_or(|values| meets(values)), "{report:?}");
    assert!(report.free.as_ref().is_none_or(|values| !meets(values)), "{report:?}");
    let mut rng = Rng::new(190);
    for _ in 0..2000 {
        let values: Vec<f64> = limits.iter().map(|&[from, to]| rng.range(from, to)).collect();
        let is_meeting = meets(&values);
        assert!(report.class != PairClass::Never || !is_meeting, "{values:?}");
        assert!(report.class != PairClass::Always || is_meeting, "{values:?}");
    }
    report
}

#[test]
fn classes_hold_at_random_values() {
    let link = cuboid([0.05, -0.03, -0.03], [0.45, 0.03, 0.03]);
    let long = cuboid([-0.06, -0.03, -0.03], [0.56, 0.03, 0.03]);
    let tall = cuboid([-0.06, -0.02, -0.07], [0.56, 0.02, 0.07]);
    let high = cuboid([0.05, -0.03, 0.1], [0.45, 0.03, 0.2]);
    let links = [(&link, 0.0); 4];
    let wide = [[-PI, PI]; 3];
    let narrow = [[-0.3, 0.3]; 3];
    // One above the other for all joint values.
    let report = classified([(&high, 0.0), (&link, 0.0), (&link, 0.0), (&link, 0.0)], &wide, (0, 2), 100_000);
    assert_eq!((report.class, report.meeting), (PairClass::Never, None));
    // The joints cannot fold the arm that far.
    assert_eq!(classified(links, &narrow, (1, 3), 100_000).class, PairClass::Never);
    assert_eq!(classified(links, &wide, (1, 3), 100_000).class, PairClass::Sometimes);
    // One body penetrates the other near their joint.
    let report = classified([(&link, 0.0), (&long, 0.0), (&tall, 0.0), (&link, 0.0)], &wide, (1, 2), 100_000);
    assert_eq!((report.class, report.free), (PairClass::Always, None));
    // Bodies of equal height touch only along lines.
    assert_eq!(classified([(&long, 0.0); 4], &wide, (2, 1), 1000).class, PairClass::Undecided);
    // Points with radii.
    let point = Mesh { vertices: &[[0.0; 3]], triangles: &[[0; 3]] };
    let point: Tree = Builder::new().build_as(&point).unwrap();
    let points = |r: f64| [(&point, r), (&point, r), (&point, r), (&point, r)];
    assert_eq!(classified(points(0.26), &wide, (1, 2), 1000).class, PairClass::Always);
    assert_eq!(classified(points(0.24), &wide, (1, 2), 1000).class, PairClass::Never);
    assert_eq!(classified(points(0.24), &wide, (1, 3), 1000).class, PairClass::Sometimes);
}

#[test]
fn what_boxes_do_not_show_is_undecided() {
    let link = cuboid([0.05, -0.03, -0.03], [0.45, 0.03, 0.03]);
    let links = [(&link, 0.0); 4];
    let narrow = [[-1.2, 1.2]; 3];
    let whole = classified(links, &narrow, (1, 3), 100_000).boxes;
    assert!(whole > 2);
    for boxes in [0, 1, whole - 1] {
        let report = classified(links, &narrow, (1, 3), boxes);
        assert_eq!((report.class, report.boxes), (PairClass::Undecided, boxes));
    }
    assert_eq!(classified(links, &narrow, (1, 3), whole).class, PairClass::Never);
}

#[test]
fn bodies_of_one_link_and_others_that_stand_still() {
    let link = cuboid([0.05, -0.03, -0.03], [0.45, 0.03, 0.03]);
    let arm = Arm::new();
    let bodies = [1, 1, 2].map(|link| LinkBody { link, at: Pose::IDENTITY });
    let limits = [[-PI, PI]; 3];
    let robot = Kinematics::new(&arm.joints, &bodies, &limits).unwrap();
    let query = Query::new(Isa::detect());
    let points = PointCloud::new(&[[0.0; 3], [0.1, 0.0, 0.0]]).unwrap();
    let mut scene = Scene::new();
    let ids = [0, 1, 2].map(|_| scene.insert(Body::new(link.view()), &Pose::IDENTITY).unwrap());
    let far = scene.insert(Body::new(link.view()), &at(2.0, 0.0, 0.0)).unwrap();
    let near = scene.insert(Body::new(link.view()), &at(0.4, 0.0, 0.0)).unwrap();
    let mut class = |a, b| scene.classify_pair(&query, &ids, robot, (a, b), 10_000).unwrap().class;
    assert_eq!(class(ids[0], ids[1]), PairClass::Always);
    assert_eq!(class(ids[2], far), PairClass::Never);
    assert_eq!(class(ids[2], near), PairClass::Sometimes);
    assert_eq!(class(far, near), PairClass::Never);
    let refused = scene.classify_pair(&query, &ids, robot, (far, far), 10).unwrap_err();
    assert_eq!(refused, SceneError::NoPair { id: far });
    // A cloud may come first; two clouds are not a pair.
    let [scan, other] = [9.0, 0.0].map(|x| scene.insert(Body::new(points.view()), &at(x, 0.0, 0.0)).unwrap());
    let mut class =
        |a, b| scene.classify_pair(&query, &ids, robot, (a, b), 10_000).map(|report| report.class);
    assert_eq!((class(scan, ids[2]), class(ids[2], scan)), (Ok(PairClass::Never), Ok(PairClass::Never)));
    assert_eq!(class(scan, other), Err(SceneError::TwoClouds { id: scan }));
    let refused = scene.classify_pair(&query, &ids[..1], robot, (far, near), 10).unwrap_err();
    assert_eq!(refused, SceneError::Motion { bodies: 3, given: 1, poses: 6 });
}
