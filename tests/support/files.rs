//! Meshes in every file format that the command reads.

use crate::support::data::MeshData;

/// A tetrahedron whose corners are the origin and the unit vectors.
pub(crate) fn tetrahedron() -> MeshData {
    MeshData {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

pub(crate) fn lines<T>(items: &[T], line: impl Fn(&T) -> String) -> String {
    items.iter().map(|item| line(item) + "\n").collect()
}

pub(crate) fn xyz(p: &[f64; 3]) -> String {
    format!("{:?} {:?} {:?}", p[0], p[1], p[2])
}

pub(crate) fn obj(mesh: &MeshData) -> String {
    lines(&mesh.vertices, |p| format!("v {}", xyz(p)))
        + &lines(&mesh.triangles, |t| format!("f {}/7 {}//2 {}", t[0] + 1, t[1] + 1, t[2] + 1))
}

pub(crate) fn off(mesh: &MeshData) -> String {
    format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len())
        + &lines(&mesh.vertices, xyz)
        + &lines(&mesh.triangles, |t| format!("3 {} {} {}", t[0], t[1], t[2]))
}

pub(crate) fn ply_head(mesh: &MeshData, format: &str) -> String {
    let (vertices, faces) = (mesh.vertices.len(), mesh.triangles.len());
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
         property double z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

pub(crate) fn ply_ascii(mesh: &MeshData) -> String {
    ply_head(mesh, "ascii")
        + &lines(&mesh.vertices, xyz)
        + &lines(&mesh.triangles, |t| format!("3 {} {} {}", t[0], t[1], t[2]))
}

pub(crate) fn ply_binary(mesh: &MeshData, big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ply_head(mesh, format).into_bytes();
    let coordinates = mesh.vertices.iter().flatten();
    bytes.extend(coordinates.flat_map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() }));
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|i| if big { i.to_be_bytes() } else { i.to_le_bytes() }));
    }
    bytes
}

pub(crate) fn stl_ascii(mesh: &MeshData) -> String {
    let facet = |t: &[[f64; 3]; 3]| {
        let corners = lines(t, |p| format!("vertex {}", xyz(p)));
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet")
    };
    format!("solid strewn\n{}endsolid strewn\n", lines(&mesh.corners(), facet))
}

/// Coordinates are rounded to `f32`.
pub(crate) fn stl_binary(mesh: &MeshData) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in mesh.corners() {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
