//! The pairs of meshes that simdop is compared on.

use crate::data::MeshData;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use std::path::Path;

/// Two meshes of the data sets, or one, which is tested against a copy of itself.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    files: &'static [&'static str],
}

pub(crate) const SCENES: [Scene; 6] = [
    Scene { name: "cow", files: &["meshes/cow.obj"] },
    Scene { name: "armadillo", files: &["meshes/armadillo.obj"] },
    Scene { name: "bunny75k", files: &["meshes/bunny75k.obj"] },
    Scene { name: "brain_pia_lh", files: &["meshes/brain_pia_lh.ply"] },
    Scene {
        name: "panda",
        files: &["robots/panda/meshes/visual_link6.obj", "robots/panda/meshes/visual_link5.obj"],
    },
    Scene { name: "unc", files: &["planning/unc_rob.obj", "planning/unc_env.obj"] },
];

impl Scene {
    /// One or two meshes: A is the first, B the last.
    pub(crate) fn meshes(&self, data: &Path) -> Vec<MeshData> {
        self.files.iter().map(|file| read(&data.join(file))).collect()
    }
}

fn read(path: &Path) -> MeshData {
    if path.extension().is_some_and(|extension| extension == "ply") { ply(path) } else { MeshData::obj(path) }
}

/// A PLY file with `float` coordinates and triangles.
fn ply(path: &Path) -> MeshData {
    let file = std::fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let ply = Parser::<DefaultElement>::new().read_ply(&mut std::io::BufReader::new(file));
    let ply = ply.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let vertex = |element: &DefaultElement| {
        ["x", "y", "z"].map(|axis| match element[axis] {
            Property::Float(x) => f64::from(x),
            ref other => panic!("{}: {axis} is {other:?}", path.display()),
        })
    };
    let triangle = |element: &DefaultElement| match &element["vertex_indices"] {
        Property::ListInt(corners) if corners.len() == 3 => {
            [corners[0], corners[1], corners[2]].map(|i| i as u32)
        }
        other => panic!("{}: a face is {other:?}", path.display()),
    };
    MeshData {
        vertices: ply.payload["vertex"].iter().map(vertex).collect(),
        triangles: ply.payload["face"].iter().map(triangle).collect(),
    }
}
