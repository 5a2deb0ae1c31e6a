//! t
#[path = "support/mod.rs"]
mod support;
use simdop::construct::{Builder, Mesh};
use support::data::MeshData;
fn build(mesh: &MeshData) -> simdop::hierarchy::Bvh<simdop::node::Node16<6>> {
    Builder::new().leaf_size(1).build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}
#[path = "queries/reject.rs"]
mod reject;
