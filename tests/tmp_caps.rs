//! x
extern crate alloc;
#[path = "queries/caps.rs"]
mod caps;
#[path = "support/mod.rs"]
mod support;
use simdop::construct::Mesh;
use support::data::MeshData;
fn mesh_of(mesh: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }
}
#[derive(Copy, Clone, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);
fn aligned(bytes: &[u8]) -> Vec<Line> {
    let mut lines = vec![Line([0; 64]); bytes.len().div_ceil(64) + 1];
    bytemuck::cast_slice_mut(&mut lines)[..bytes.len()].copy_from_slice(bytes);
    lines
}
