//! The first query: two bodies, one pose, one verdict.
//!
//! ```sh
//! cargo run --example first_query
//! ```

use simdop::construct::{Builder, Mesh};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Query, Verdict};

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // A mesh is a list of corners and a list of triangles with three indices each. This one is a tetrahedron. The unit
    // is a metre here; any other works if both bodies and the poses use the same.
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };

    // A body is the tree over a mesh, built once. The node type sets the number of planes of a k-DOP (k = 18) and the
    // number of children of a node (16). Both bodies of a query need the same node type.
    let body = Builder::new().build(&mesh)?;
    let (a, b) = (body.view(), body.view());

    // The best instruction set of this machine. It changes the speed, but no answer.
    let query = Query::new(Isa::detect());

    // A pose places body A in the frame of body B: the rows of the matrix [R|t].
    let overlapping = Pose::from_rows([[1.0, 0.0, 0.0, 0.9], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    let answer = query.collide(&a, &b, &overlapping);
    let Verdict::Hit(pair) = answer.verdict else { return Err("they overlap by a tenth of a metre".into()) };
    println!("triangle {} of A meets triangle {} of B", pair.a, pair.b);

    // Bodies are closed sets, so bodies that only touch do meet. Verdicts are exact: a gap of a nanometre is a gap.
    let touching = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    let apart = Pose::from_rows([[1.0, 0.0, 0.0, 1.0 + 1e-9], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    assert!(query.collide(&a, &b, &touching).hit().is_some());
    assert_eq!(query.collide(&a, &b, &apart).verdict, Verdict::Free);

    // How far apart are they, and where? Exact up to rounding.
    let distance = query.distance(&a, &b, &apart, 0.0)?;
    println!("1e-9 m apart by the pose, {:e} m by the query", distance.upper);
    assert!((distance.upper - 1e-9).abs() < 1e-15);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
