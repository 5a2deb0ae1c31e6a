//! Bodies of spheres and their trees, and the shared volume of two balls.

use crate::cached;
use crate::support::rng::Rng;
use core::ops::ControlFlow;
use simdop::construct::{Builder, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::node::Dop;
use simdop::primitive::{Sphere, Spheres};
use simdop::range::Point;

/// A tree of spheres.
pub struct SphereBody<N> {
    pub tree: Bvh<N, Spheres>,
}

impl<N: Dop> SphereBody<N> {
    fn new(builder: Builder, spheres: &[Sphere]) -> Self {
        let set = SphereSet { spheres };
        Self { tree: builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap() }
    }
}

/// Bodies of spheres, of size about 1, near the origin, and a small one.
pub struct SphereBodies<N>(pub Vec<SphereBody<N>>);

/// The bodies of spheres of a node type.
pub fn sphere_bodies<N: Dop>() -> &'static SphereBodies<N> {
    cached(|| {
        let mut rng = Rng::new(3);
        let lattice: Vec<Sphere> = (0..27)
            .map(|i| Sphere {
                centre: [i % 3, i / 3 % 3, i / 9].map(|x| 0.5 * (f64::from(x) - 1.0)),
                radius: 0.25,
            })
            .collect();
        let unlike = disjoint(&mut rng, 40);
        let overlapping: Vec<Sphere> = (0..20)
            .map(|i| Sphere {
                centre: [(); 3].map(|()| rng.range(-0.7, 0.7)),
                radius: if i % 5 == 0 { 0.0 } else { rng.range(0.0, 0.4) },
            })
            .collect();
        let twice: Vec<Sphere> = overlapping.iter().chain(&overlapping[..4]).copied().collect();
        let small: Vec<Sphere> = disjoint(&mut rng, 20)
            .iter()
            .map(|s| Sphere { centre: s.centre.map(|x| 1e-9 * x), radius: 1e-9 * s.radius })
            .collect();
        let builder = Builder::new().leaf_size(1);
        SphereBodies(vec![
            SphereBody::new(builder, &lattice),
            SphereBody::new(builder.without_balls(), &lattice),
            SphereBody::new(builder, &unlike),
            SphereBody::new(Builder::new().leaf_size(3), &unlike),
            SphereBody::new(Builder::new().leaf_size(2), &twice),
            SphereBody::new(builder, &[Sphere { centre: [0.25, -0.5, 0.125], radius: 1.0 }]),
            SphereBody::new(builder, &small),
            SphereBody::new(builder, &[]),
        ])
    })
}

/// Spheres with radii from 10^-4 to 1/2 that do not overlap each other.
fn disjoint(rng: &mut Rng, count: usize) -> Vec<Sphere> {
    let mut spheres = vec![Sphere { centre: [0.1, -0.2, 0.0], radius: 0.5 }];
    while spheres.len() < count {
        let centre: Point = [(); 3].map(|()| rng.range(-1.0, 1.0));
        let room = spheres.iter().map(|s| distance(&s.centre, &centre) - s.radius).fold(f64::MAX, f64::min);
        let radius = f64::min(0.99 * room, 10_f64.powf(rng.range(-4.0, -0.5)));
        if radius >= 1e-4 {
            spheres.push(Sphere { centre, radius });
        }
    }
    spheres
}

/// The distance of two points.
pub fn distance(p: &Point, q: &Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| p[i] - q[i]);
    (x * x + y * y + z * z).sqrt()
}

/// The shared volume of two balls whose centres are `d` apart.
pub fn lens(r_a: f64, r_b: f64, d: f64) -> f64 {
    crate::lens::lens(r_a, r_b, d)
}
