//! Robots and their queries: links, problems of MotionBenchMaker, and the poses of the links in these.

use super::data::MeshData;
use super::rng::Rng;
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use serde_json::Value;
use simdop::construct::OwnedMesh;
use simdop::primitive;
use std::collections::BTreeMap;
use std::path::Path;
use urdf_rs::{Geometry, JointType};

/// A robot, and which of its meshes are its links.
#[derive(Debug)]
pub(crate) struct Setting {
    pub(crate) name: &'static str,
    /// Name of its folder and files.
    pub(crate) robot: &'static str,
    /// Use the visual meshes instead of the collision meshes.
    pub(crate) is_drawn: bool,
}

/// The UR5's arm has no visual meshes here; in its gripper the collision meshes are the visual ones.
pub(crate) const SETTINGS: [Setting; 3] = [
    Setting { name: "Panda", robot: "panda", is_drawn: false },
    Setting { name: "Panda, drawn meshes", robot: "panda", is_drawn: true },
    Setting { name: "UR5", robot: "ur5", is_drawn: false },
];

impl Setting {
    pub(crate) fn robot(&self, data: &Path) -> Robot {
        Robot::read(&data.join("robots").join(self.robot), self.robot, self.is_drawn)
    }

    /// Every `step`-th problem of the robot, the same at each call.
    pub(crate) fn problems(&self, data: &Path, robot: &Robot, step: usize) -> Vec<Problem> {
        let text = std::fs::read_to_string(data.join(format!("planning/mbm_{}.jsonl", self.robot))).unwrap();
        let mut rng = Rng::new(7);
        text.lines().step_by(step).map(|line| Problem::new(line, robot, &mut rng)).collect()
    }
}

/// Values of the joints, by name.
pub(crate) type Configuration = BTreeMap<String, f64>;

/// The links of a robot that have a shape, and the joints between them.
#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) links: Vec<Link>,
    joints: Vec<Joint>,
    /// Pairs of links that are tested: all but those excluded by the SRDF.
    pub(crate) pairs: Vec<(usize, usize)>,
}

#[derive(Debug)]
pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) mesh: MeshData,
    /// The pose of the mesh in the link's frame.
    pub(crate) origin: DAffine3,
}

#[derive(Debug)]
struct Joint {
    name: String,
    parent: String,
    child: String,
    origin: DAffine3,
    axis: DVec3,
    kind: JointType,
    limits: (f64, f64),
}

fn affine(pose: &urdf_rs::Pose) -> DAffine3 {
    let [roll, pitch, yaw] = *pose.rpy;
    let turn = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
    DAffine3::from_rotation_translation(turn, DVec3::from_array(*pose.xyz))
}

impl Robot {
    /// Reads a folder with `NAME.urdf` and `NAME.srdf`, with the collision meshes or the visual ones.
    fn read(folder: &Path, name: &str, is_drawn: bool) -> Self {
        let urdf = urdf_rs::read_file(folder.join(format!("{name}.urdf"))).unwrap();
        let mut links = Vec::new();
        for link in &urdf.links {
            let drawn = link.visual.first().map(|part| (&part.geometry, &part.origin));
            let solid = link.collision.first().map(|part| (&part.geometry, &part.origin));
            let Some((geometry, origin)) = (if is_drawn { drawn } else { solid }) else { continue };
            let mesh = match geometry {
                Geometry::Mesh { filename, .. } if filename.ends_with(".stl") => stl(&folder.join(filename)),
                Geometry::Mesh { filename, .. } => MeshData::obj(&folder.join(filename)),
                Geometry::Box { size } => {
                    let OwnedMesh { vertices, triangles } = OwnedMesh::cuboid(**size).unwrap();
                    MeshData { vertices, triangles }
                }
                other => panic!("{} is {other:?}", link.name),
            };
            links.push(Link { name: link.name.clone(), mesh, origin: affine(origin) });
        }
        let joints = urdf.joints.iter().map(|joint| Joint {
            name: joint.name.clone(),
            parent: joint.parent.link.clone(),
            child: joint.child.link.clone(),
            origin: affine(&joint.origin),
            axis: DVec3::from_array(*joint.axis.xyz),
            kind: joint.joint_type.clone(),
            limits: (joint.limit.lower, joint.limit.upper),
        });
        let text = std::fs::read_to_string(folder.join(format!("{name}.srdf"))).unwrap();
        let srdf = roxmltree::Document::parse(&text).unwrap();
        let index = |name: &str| links.iter().position(|link| link.name == name);
        let disabled: Vec<_> = srdf
            .descendants()
            .filter(|node| node.has_tag_name("disable_collisions"))
            .filter_map(|node| Some((index(node.attribute("link1")?)?, index(node.attribute("link2")?)?)))
            .collect();
        let pairs = (0..links.len())
            .flat_map(|i| (i + 1..links.len()).map(move |j| (i, j)))
            .filter(|&(i, j)| !disabled.contains(&(i, j)) && !disabled.contains(&(j, i)))
            .collect();
        Self { joints: joints.collect(), pairs, links }
    }

    /// The poses of the links' meshes.
    pub(crate) fn poses(&self, configuration: &Configuration) -> Vec<DAffine3> {
        let mut frames: BTreeMap<&str, DAffine3> = BTreeMap::new();
        // Joints may come in any order.
        loop {
            let before = frames.len();
            for joint in &self.joints {
                let root = !self.joints.iter().any(|other| other.child == joint.parent);
                if root {
                    frames.entry(&joint.parent).or_insert(DAffine3::IDENTITY);
                }
                let Some(parent) = frames.get(joint.parent.as_str()).copied() else { continue };
                let value = configuration.get(&joint.name).copied().unwrap_or(0.0);
                let motion = match joint.kind {
                    JointType::Revolute | JointType::Continuous => {
                        DAffine3::from_axis_angle(joint.axis, value)
                    }
                    JointType::Prismatic => DAffine3::from_translation(joint.axis * value),
                    _ => DAffine3::IDENTITY,
                };
                frames.insert(&joint.child, parent * joint.origin * motion);
            }
            if frames.len() == before {
                break;
            }
        }
        self.links.iter().map(|link| frames[link.name.as_str()] * link.origin).collect()
    }

    /// A configuration within the limits of the moving joints.
    pub(crate) fn random(&self, rng: &mut Rng) -> Configuration {
        let moving = |joint: &&Joint| !matches!(joint.kind, JointType::Fixed);
        self.joints
            .iter()
            .filter(moving)
            .map(|joint| (joint.name.clone(), rng.range(joint.limits.0, joint.limits.1)))
            .collect()
    }
}

/// The triangles of a binary STL file; coincident corners become one vertex.
fn stl(path: &Path) -> MeshData {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (mut vertices, mut indices) = (Vec::new(), BTreeMap::new());
    let mut vertex = |corner: &[u8]| {
        let place: [[u8; 4]; 3] = core::array::from_fn(|i| corner[4 * i..][..4].try_into().unwrap());
        *indices.entry(place).or_insert_with(|| {
            vertices.push(place.map(|x| f64::from(f32::from_le_bytes(x))));
            vertices.len() as u32 - 1
        })
    };
    // After a header of 84 bytes, each triangle has 50: a normal, three corners, attributes.
    let triangles =
        bytes[84..].chunks_exact(50).map(|t| [12, 24, 36].map(|at| vertex(&t[at..at + 12]))).collect();
    MeshData { vertices, triangles }
}

/// A problem: the obstacles around the robot, and the poses of its links at the start, at a goal and in ten random
/// configurations.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) obstacles: Vec<Obstacle>,
    pub(crate) poses: Vec<Vec<DAffine3>>,
    /// The start and the goal.
    pub(crate) ends: [Configuration; 2],
}

#[derive(Debug)]
pub(crate) struct Obstacle {
    pub(crate) shape: Shape,
    pub(crate) at: DAffine3,
}

#[derive(Debug)]
pub(crate) enum Shape {
    /// Its side lengths.
    Cuboid([f64; 3]),
    Cylinder {
        radius: f64,
        height: f64,
    },
}

/// Maximum error of a prism around a cylinder, relative to the radius: sixteen sides.
const ERROR: f64 = 0.02;

impl Shape {
    pub(crate) fn shape(&self) -> primitive::Shape {
        match *self {
            Self::Cuboid(sides) => primitive::Shape::cuboid(sides),
            Self::Cylinder { radius, height } => primitive::Shape::cylinder(radius, height),
        }
        .unwrap()
    }

    pub(crate) fn mesh(&self) -> OwnedMesh {
        match *self {
            Self::Cuboid(sides) => OwnedMesh::cuboid(sides),
            Self::Cylinder { radius, height } => OwnedMesh::cylinder(radius, height, ERROR * radius),
        }
        .unwrap()
    }
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    core::array::from_fn(|i| value[i].as_f64().unwrap())
}

impl Obstacle {
    fn new(value: &Value) -> Self {
        let shape = match value["type"].as_str().unwrap() {
            "box" => Shape::Cuboid(numbers(&value["dims"])),
            "cylinder" => {
                let [height, radius] = numbers(&value["dims"]);
                Shape::Cylinder { radius, height }
            }
            other => panic!("an obstacle is no {other}"),
        };
        let turn = DQuat::from_array(numbers(&value["quat_xyzw"])).normalize();
        let at = DAffine3::from_rotation_translation(turn, DVec3::from_array(numbers(&value["pos"])));
        Self { shape, at }
    }
}

impl Problem {
    pub(crate) fn new(line: &str, robot: &Robot, rng: &mut Rng) -> Self {
        let line: Value = serde_json::from_str(line).unwrap();
        let given = |value: &Value| -> Configuration {
            value.as_object().unwrap().iter().map(|(name, x)| (name.clone(), x.as_f64().unwrap())).collect()
        };
        let ends = [&line["start"], &line["goals"][0]].map(given);
        let random = (0..10).map(|_| robot.random(rng));
        Self {
            obstacles: line["obstacles"].as_array().unwrap().iter().map(Obstacle::new).collect(),
            poses: ends.iter().cloned().chain(random).map(|q| robot.poses(&q)).collect(),
            ends,
        }
    }
}

/// Names everything once, so that a benchmark which uses only some of it compiles without a warning.
const _: () = {
    let _ = (Robot::poses, Robot::random, Setting::robot, Setting::problems, Problem::new);
    let _ = (Shape::mesh, Shape::shape);
    let _ = |robot: &Robot, problem: &Problem| {
        let _ = (
            &robot.pairs,
            robot.links.first().map(|link| (&link.name, &link.mesh)),
            &problem.poses,
            &problem.ends,
        );
        let _ = &SETTINGS[0].name;
    };
};
