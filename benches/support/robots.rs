//! Robots and what they are asked: their links, where these stand, and the problems of MotionBenchMaker.

use super::data::MeshData;
use super::rng::Rng;
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use serde_json::Value;
use simdop::construct::OwnedMesh;
use std::collections::BTreeMap;
use std::path::Path;
use urdf_rs::{Geometry, JointType};

/// Values of the joints, by name.
pub(crate) type Configuration = BTreeMap<String, f64>;

/// A robot's links that have a mesh, and how they are joined.
#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) links: Vec<Link>,
    joints: Vec<Joint>,
    /// Links that are asked against each other: all pairs but those that the SRDF rules out.
    pub(crate) pairs: Vec<(usize, usize)>,
}

#[derive(Debug)]
pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) mesh: MeshData,
    /// Of the mesh in the link's frame.
    origin: DAffine3,
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
    /// Of a folder with `NAME.urdf` and `NAME.srdf`; the meshes of collision, or those that are drawn.
    pub(crate) fn read(folder: &Path, name: &str, is_visual: bool) -> Self {
        let urdf = urdf_rs::read_file(folder.join(format!("{name}.urdf"))).unwrap();
        let mut links = Vec::new();
        for link in &urdf.links {
            let drawn = link.visual.first().map(|part| (&part.geometry, &part.origin));
            let solid = link.collision.first().map(|part| (&part.geometry, &part.origin));
            let Some((Geometry::Mesh { filename, .. }, origin)) = (if is_visual { drawn } else { solid })
            else {
                continue;
            };
            let mesh = MeshData::obj(&folder.join(filename));
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

    /// Where the meshes of the links stand.
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

    /// A configuration within the limits of the joints that move.
    pub(crate) fn random(&self, rng: &mut Rng) -> Configuration {
        let moving = |joint: &&Joint| !matches!(joint.kind, JointType::Fixed);
        self.joints
            .iter()
            .filter(moving)
            .map(|joint| (joint.name.clone(), rng.range(joint.limits.0, joint.limits.1)))
            .collect()
    }
}

/// A problem: what stands around the robot, and where it shall start and end.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) obstacles: Vec<(OwnedMesh, DAffine3)>,
    pub(crate) configurations: Vec<Configuration>,
}

/// How far from the cylinder a prism around it may be, of the radius: sixteen sides.
const ERROR: f64 = 0.02;

/// Every so many problems of a file, one a line.
pub(crate) fn problems(file: &Path, step: usize) -> Vec<Problem> {
    let text = std::fs::read_to_string(file).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let configuration = |value: &Value| -> Configuration {
        value.as_object().unwrap().iter().map(|(name, x)| (name.clone(), x.as_f64().unwrap())).collect()
    };
    let problem = |line: &str| {
        let line: Value = serde_json::from_str(line).unwrap();
        let obstacle = |value: &Value| {
            let dims = numbers(&value["dims"]);
            let mesh = match value["type"].as_str().unwrap() {
                "box" => OwnedMesh::cuboid([dims[0], dims[1], dims[2]]),
                "cylinder" => OwnedMesh::cylinder(dims[1], dims[0], ERROR * dims[1]),
                other => panic!("an obstacle is no {other}"),
            };
            let mesh = mesh.unwrap();
            let (p, q) = (numbers(&value["pos"]), numbers(&value["quat_xyzw"]));
            let turn = DQuat::from_xyzw(q[0], q[1], q[2], q[3]).normalize();
            (mesh, DAffine3::from_rotation_translation(turn, DVec3::new(p[0], p[1], p[2])))
        };
        let obstacles = line["obstacles"].as_array().unwrap().iter().map(obstacle).collect();
        let goals = line["goals"].as_array().unwrap().iter();
        let configurations =
            core::iter::once(&line["start"]).chain(goals.take(1)).map(configuration).collect();
        Problem { obstacles, configurations }
    };
    text.lines().step_by(step).map(problem).collect()
}
