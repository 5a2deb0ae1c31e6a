//! The libraries compared, each with its bodies built.

use crate::data::{MeshData, notice};
use crate::driver::Driver;
use crate::suites::Rows;
use simdop::construct::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, QueryStats};
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

type Count = Box<dyn Fn(&Rows) -> QueryStats>;
type Measure = Box<dyn Fn(&Rows) -> f64>;

/// A library that holds the bodies of a scene.
pub(crate) struct Entrant {
    pub(crate) name: String,
    pub(crate) version: String,
    /// Build time of all bodies of the scene, in milliseconds.
    pub(crate) build_ms: f64,
    /// Memory of all bodies, if the library reports it.
    pub(crate) bytes: Option<usize>,
    /// Whether the bodies meet.
    pub(crate) collide: Box<dyn Fn(&Rows) -> bool>,
    /// The distance of the bodies, if the library measures it.
    pub(crate) distance: Option<Measure>,
    /// The work of a query, if the library counts it.
    pub(crate) count: Option<Count>,
}

/// The name of our entrant, which ratios refer to.
pub(crate) const OURS: &str = "simdop k 18";

/// FCL with its templates compiled for this machine.
pub(crate) const FCL_NATIVE: &str = "FCL native";

/// The peer in C++ that is fastest on most bodies.
pub(crate) const OPCODE: &str = "OPCODE";

/// A peer in C++, and its driver.
const DRIVERS: [(&str, &str); 9] = [
    (OPCODE, "opcode"),
    ("ODE", "ode"),
    ("PhysX", "physx"),
    ("FCL OBB", "fcl-OBB"),
    (FCL_NATIVE, "fcl-native"),
    ("FCL OBBRSS", "fcl-OBBRSS"),
    ("Coal OBB", "coal-OBB"),
    ("Coal OBBRSS", "coal-OBBRSS"),
    ("Embree", "embree"),
];

/// Peers that measure distances.
const MEASURING: [(&str, &str); 3] =
    [("FCL OBBRSS", "fcl-OBBRSS"), (FCL_NATIVE, "fcl-native-OBBRSS"), ("Coal OBBRSS", "coal-OBBRSS")];

/// All available libraries that measure distances.
pub(crate) fn measuring(meshes: &[MeshData], drivers: &Path) -> Vec<Entrant> {
    let mut entrants = vec![ours::<Node16<18>>(OURS, meshes)];
    entrants
        .extend(loaded(&MEASURING, drivers).into_iter().map(|(name, driver)| driven(name, driver, meshes)));
    entrants
}

/// All available libraries.
pub(crate) fn entrants(meshes: &[MeshData], drivers: &Path) -> Vec<Entrant> {
    let mut entrants = vec![ours::<Node16<18>>(OURS, meshes), ours::<Node16<14>>("simdop k 14", meshes)];
    entrants.extend(loaded(&DRIVERS, drivers).into_iter().map(|(name, driver)| driven(name, driver, meshes)));
    entrants.extend([parry_f32::entrant("parry f32", meshes), parry_f64::entrant("parry f64", meshes)]);
    entrants
}

/// Ours and FCL compiled here: for bodies too large for copies by every library.
pub(crate) fn beside_fcl(meshes: &[MeshData], drivers: &Path) -> Vec<Entrant> {
    let fcl = DRIVERS.iter().copied().filter(|(name, _)| *name == FCL_NATIVE).collect::<Vec<_>>();
    let mut entrants = vec![ours::<Node16<18>>(OURS, meshes)];
    entrants.extend(loaded(&fcl, drivers).into_iter().map(|(name, driver)| driven(name, driver, meshes)));
    entrants
}

/// Builds a body, drops it, and returns the build time in milliseconds.
pub(crate) type Build = Box<dyn Fn(&MeshData) -> f64>;

/// Everything available whose build is timed: our presets and Batch Neural Gas, then the peers.
pub(crate) fn builders(drivers: &Path) -> Vec<(String, Build)> {
    let gas = Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 0 };
    let own =
        [("fast", Builder::fast()), ("best", Builder::best()), ("neural gas", Builder::best().splitter(gas))];
    let ours = |(name, builder): (&str, Builder)| -> (String, Build) {
        let build = move |mesh: &MeshData| timed(|| tree::<Node16<18>>(builder, mesh)).1;
        (format!("simdop {name}"), Box::new(build))
    };
    let mut builders: Vec<_> = own.into_iter().map(ours).collect();
    for (name, driver) in loaded(&DRIVERS, drivers) {
        let build = move |mesh: &MeshData| timed(|| Driver::build(&driver, mesh)).1;
        builders.push((name.to_owned(), Box::new(build)));
    }
    builders.push(("parry f32".to_owned(), Box::new(|mesh| timed(|| parry_f32::body(mesh)).1)));
    builders.push(("parry f64".to_owned(), Box::new(|mesh| timed(|| parry_f64::body(mesh)).1)));
    builders
}

/// The drivers that load; warns about the others.
pub(crate) fn loaded(wanted: &[(&'static str, &str)], drivers: &Path) -> Vec<(&'static str, Rc<Driver>)> {
    let load = |&(name, file): &(&'static str, &str)| match Driver::load(&drivers.join(format!("{file}.so")))
    {
        Ok(driver) => Some((name, Rc::new(driver))),
        Err(error) => {
            notice(&format!("{name} IS LEFT OUT: {error}"));
            None
        }
    };
    wanted.iter().filter_map(load).collect()
}

pub(crate) fn tree<N: Lanes>(builder: Builder, mesh: &MeshData) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    builder.build_as(&mesh).expect("the data sets can be built")
}

fn timed<T>(build: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let built = build();
    (built, start.elapsed().as_secs_f64() * 1e3)
}

fn ours<N: Lanes + 'static>(name: &str, meshes: &[MeshData]) -> Entrant {
    let build = |mesh: &MeshData| tree::<N>(Builder::new(), mesh);
    let (trees, build_ms) = timed(|| meshes.iter().map(build).collect::<Vec<_>>());
    let bytes = trees.iter().map(|tree| tree.as_bytes().len()).sum();
    let query = Query::new(Isa::detect());
    let trees = Rc::new(trees);
    let measured = Rc::clone(&trees);
    let pose = |rows: &Rows| Pose::from_rows(*rows).expect("the poses are rigid");
    let answer = Rc::new(move |rows: &Rows| {
        query.collide(&trees[0].view(), &trees[trees.len() - 1].view(), &pose(rows))
    });
    let again = Rc::clone(&answer);
    Entrant {
        name: name.to_owned(),
        version: Isa::detect().name().to_owned(),
        build_ms,
        bytes: Some(bytes),
        collide: Box::new(move |rows| answer(rows).hit().is_some()),
        distance: Some(Box::new(move |rows| {
            let (a, b) = (measured[0].view(), measured[measured.len() - 1].view());
            query.distance(&a, &b, &pose(rows), 0.0).expect("zero is a tolerance").upper
        })),
        count: Some(Box::new(move |rows| again(rows).stats)),
    }
}

fn driven(name: &str, driver: Rc<Driver>, meshes: &[MeshData]) -> Entrant {
    let (bodies, build_ms) =
        timed(|| meshes.iter().map(|mesh| Driver::build(&driver, mesh)).collect::<Vec<_>>());
    let bytes: usize = bodies.iter().map(crate::driver::Body::bytes).sum();
    let bodies = Rc::new(bodies);
    let measured = Rc::clone(&bodies);
    let distance = move |rows: &Rows| {
        measured[0]
            .distance(&measured[measured.len() - 1], rows)
            .expect("asked of drivers that measure distances")
    };
    Entrant {
        name: name.to_owned(),
        version: driver.version(),
        build_ms,
        bytes: Some(bytes).filter(|bytes| *bytes > 0),
        collide: Box::new(move |rows| bodies[0].collides(&bodies[bodies.len() - 1], rows)),
        distance: driver.measures_distances().then(|| Box::new(distance) as Box<dyn Fn(&Rows) -> f64>),
        count: None,
    }
}

/// The version in Cargo.toml.
pub(crate) const PARRY_VERSION: &str = "0.31.1";

/// parry in the precision of a crate.
macro_rules! parry {
    ($module:ident, $parry:ident, $Real:ident) => {
        mod $module {
            use super::{Entrant, MeshData, PARRY_VERSION, timed};
            use $parry::math::{Matrix, Pose, Rotation, Vector};
            use $parry::query::intersection_test;
            use $parry::shape::TriMesh;

            fn vector(p: [f64; 3]) -> Vector {
                Vector::new(p[0] as $Real, p[1] as $Real, p[2] as $Real)
            }

            pub(super) fn body(mesh: &MeshData) -> TriMesh {
                let vertices = mesh.vertices.iter().map(|p| vector(*p)).collect();
                TriMesh::new(vertices, mesh.triangles.clone()).expect("there are triangles")
            }

            pub(super) fn entrant(name: &str, meshes: &[MeshData]) -> Entrant {
                let (bodies, build_ms) = timed(|| meshes.iter().map(body).collect::<Vec<_>>());
                Entrant {
                    name: name.to_owned(),
                    version: PARRY_VERSION.to_owned(),
                    build_ms,
                    bytes: Some(bodies.iter().map(TriMesh::total_memory_size).sum()),
                    collide: Box::new(move |rows| {
                        let column = |j: usize| vector([rows[0][j], rows[1][j], rows[2][j]]);
                        let matrix = Matrix::from_cols(column(0), column(1), column(2));
                        let pose = Pose::from_parts(column(3), Rotation::from_mat3(&matrix));
                        let (a, b) = (&bodies[0], &bodies[bodies.len() - 1]);
                        intersection_test(&pose, a, &Pose::IDENTITY, b)
                            .expect("meshes are supported")
                            .intersecting
                    }),
                    distance: None,
                    count: None,
                }
            }
        }
    };
}
parry!(parry_f32, parry3d, f32);
parry!(parry_f64, parry3d_f64, f64);
