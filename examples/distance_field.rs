//! A distance field on a grid, from points with normals: negative inside, defined in a narrow band around the surface.
//!
//! ```sh
//! cargo run --release --example distance_field
//! ```
//!
//! Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017, section 5.2, figure 16.
//! Every node of the grid searches the points within four cells; the nearest of them gives the distance, and its normal
//! the sign. Where no point is near, the field is undefined. The queries are not points of the cloud, so they are
//! sorted into its order first: queries that are close together then traverse the tree together.

mod points;

use core::ops::ControlFlow;
use glam::Vec3;
use points::{Random, torus};
use simdop::cloud::{PointCloud, Radii, RangeSearch, Seat};
use simdop::isa::Isa;

/// Nodes along each side of the grid.
const NODES: usize = 49;
/// Side of a cell.
const CELL: f32 = 3.2 / (NODES - 1) as f32;
/// Half width of the band.
const BAND: f32 = 4.0 * CELL;

/// Points of a surface and their normals.
type Surface = (Vec<[f32; 3]>, Vec<Vec3>);

/// The positions of the nodes; x varies fastest.
fn grid() -> Vec<[f32; 3]> {
    let node = |i: usize| [i % NODES, i / NODES % NODES, i / NODES / NODES].map(|c| c as f32 * CELL - 1.6);
    (0..NODES * NODES * NODES).map(node).collect()
}

/// The squared distance, computed in the same order of operations as in the search.
fn square(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y) + z * z
}

/// The field at a node: the distance to its nearest point, negative on the inner side.
fn signed(node: [f32; 3], nearest: usize, (points, normals): &Surface) -> f32 {
    let side = (Vec3::from(node) - Vec3::from(points[nearest])).dot(normals[nearest]);
    square(points[nearest], node).sqrt().copysign(side)
}

fn field(surface: &Surface, nodes: &[[f32; 3]]) -> Result<Vec<Option<f32>>, Box<dyn core::error::Error>> {
    let points = &surface.0;
    let (cloud, search) = (PointCloud::new(points)?, RangeSearch::new(Isa::detect()));
    let mut seats = vec![Seat::default(); nodes.len()];
    let queries = search.seat(&cloud.view(), nodes, &mut seats)?;

    // The nearest point so far. Among equally near points the lowest index counts, whatever the order of the list.
    let mut nearest: Vec<Option<u32>> = vec![None; nodes.len()];
    search.visit(&cloud.view(), &queries, Radii::Same(BAND), |query, point| {
        let query = query as usize;
        let order = |point: u32| (square(points[point as usize], nodes[query]), point);
        if nearest[query].is_none_or(|before| order(point) < order(before)) {
            nearest[query] = Some(point);
        }
        ControlFlow::Continue(())
    })?;
    let value = |(node, nearest): (&[f32; 3], Option<u32>)| Some(signed(*node, nearest? as usize, surface));
    Ok(nodes.iter().zip(nearest).map(value).collect())
}

fn surface(count: usize) -> Surface {
    let random = &mut Random(2);
    (0..count).map(|_| torus::point(random)).map(|(point, normal)| (point.to_array(), normal)).unzip()
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let field = field(&surface(20_000), &grid())?;
    let known = field.iter().flatten().count();
    println!("the field is known at {known} of {} nodes; a cut through the middle:", field.len());
    let middle = NODES / 2 * NODES * NODES;
    for row in field[middle..middle + NODES * NODES].chunks(NODES).step_by(2) {
        let sign = |value: &Option<f32>| value.map_or(' ', |d| if d < 0.0 { '-' } else { '+' });
        println!("{}", row.iter().map(sign).collect::<String>().trim_end());
    }
    Ok(())
}

/// Equals a loop over all points, bit by bit.
#[test]
fn the_field_is_that_of_a_loop() {
    // More points would not improve the test, and the loop has 235 million pairs already.
    let (surface, nodes) = (surface(2_000), grid());
    let field = field(&surface, &nodes).unwrap();
    for (node, value) in nodes.iter().zip(&field) {
        let squares = surface.0.iter().map(|p| square(*p, *node));
        let (nearest, least) = squares.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let want = (least <= BAND * BAND).then(|| signed(*node, nearest, &surface));
        assert_eq!(value.map(f32::to_bits), want.map(f32::to_bits), "at {node:?}");
    }
}

/// The sign is right, and the distance is that of the torus, up to the density of the points.
#[test]
fn the_field_is_that_of_the_torus() {
    let (surface, nodes) = (surface(20_000), grid());
    let mut known = 0;
    for (node, value) in nodes.iter().zip(field(&surface, &nodes).unwrap()) {
        let want = torus::distance(Vec3::from(*node));
        let Some(value) = value else {
            assert!(want.abs() > BAND - CELL, "at {node:?} the surface is {want} away");
            continue;
        };
        known += 1;
        if want.abs() > CELL {
            assert!((value - want).abs() < 0.5 * CELL, "at {node:?}: {value}, and not {want}");
        }
    }
    assert!(known > 20_000, "{known}");
}

#[test]
fn it_runs() {
    main().unwrap();
}
