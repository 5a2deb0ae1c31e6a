//! The poses of `benches/support/suites.rs` have the stated distance from contact, by brute force over all
//! pairs of triangles.

#[path = "support/data.rs"]
mod data;
#[path = "support/rng.rs"]
mod rng;
#[path = "../benches/support/suites.rs"]
mod suites;

use data::MeshData;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use simdop::primitive::triangle::distance::separation;
use suites::{Approaching, DISTANCES, Distance, Method, Rows};

/// An elongated octahedron.
fn body() -> MeshData {
    let vertices = vec![
        [2.0, 0.0, 0.0],
        [-2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -0.5],
    ];
    let triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    MeshData { vertices, triangles: triangles.to_vec() }
}

/// The least distance over all pairs of triangles.
fn distance(mesh: &MeshData, rows: &Rows) -> f64 {
    let (moved, still) = (mesh.placed(rows), mesh.corners());
    let pairs = moved.iter().flat_map(|a| still.iter().map(move |b| separation(a, b).upper));
    pairs.fold(f64::INFINITY, f64::min)
}

#[test]
fn bodies_are_as_far_apart_as_said() {
    let mesh = body();
    let tree: Bvh<Node16<18>> =
        Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let pair = Approaching { a: &mesh, b: &mesh, tree_a: tree.view(), tree_b: tree.view() };
    for method in Method::ALL {
        let lines = pair.poses(&DISTANCES, method, 20, 1);
        assert_eq!(lines, pair.poses(&DISTANCES, method, 20, 1));
        for line in lines {
            for (rows, (name, wanted)) in line.iter().zip(DISTANCES) {
                match wanted {
                    Distance::Gap(gap) => {
                        let share = distance(&mesh, rows) / mesh.diagonal();
                        assert!(share > gap && share < 1.02 * gap, "{method:?}, {name}: {share}");
                    }
                    Distance::Deep(depth) => {
                        let way = (0..3).map(|i| (rows[i][3] - line[1][i][3]).powi(2)).sum::<f64>().sqrt();
                        let share = way / mesh.diagonal();
                        assert!(share > depth && share < depth + 0.01, "{method:?}, {name}: {share}");
                    }
                }
            }
        }
    }
}
