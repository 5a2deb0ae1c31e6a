//! Meshes, their trees, and poses.

use crate::support::data::MeshData;
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::{Input, Mode, cached};
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::node::Dop;
use simdop::pose::{Pose, PoseError};
use std::ops::Deref;

/// A mesh and its tree.
pub struct Body<N> {
    /// Corners of the triangles, in the order of the mesh.
    pub triangles: Vec<[[f64; 3]; 3]>,
    pub tree: Bvh<N>,
    /// The diagonal of its box.
    size: f64,
}

impl<N: Dop> Body<N> {
    fn new(mesh: &MeshData, leaf_size: u32) -> Self {
        let builder = Builder::new().leaf_size(leaf_size).splitter(Splitter::ExtendedLongestAxis);
        let tree = builder.build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
        Self { triangles: mesh.corners(), tree, size: mesh.diagonal() }
    }
}

/// Passes two bodies and a pose to a function: with [`Mode::Real`] every second time bodies of different size;
/// otherwise small ones, unless one is rejected.
pub fn with_pair<N: Dop>(
    input: &mut Input,
    mode: Mode,
    compare: impl FnOnce(&Body<N>, &Body<N>, &Pose, &mut Input),
) {
    if mode == Mode::Real && input.one_in(2) {
        let (a, b) = (unlike_body::<N>(input), unlike_body::<N>(input));
        return compare(a, b, &corner_pose(input, a, b), input);
    }
    if mode == Mode::Real {
        let bodies = &bodies::<N>().0;
        return compare(input.pick(bodies), input.pick(bodies), &pose(input, mode), input);
    }
    let (a, b) = (small_body::<N>(input, mode), small_body::<N>(input, mode));
    if let (Some(a), Some(b)) = (a, b) {
        compare(&a, &b, &pose(input, mode), input);
    }
}

/// Sizes of bodies, and their distances from the origin in diagonals.
const FACTORS: [f64; 7] = [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];
const OFFSETS: [f64; 4] = [0.0, 1e3, 1e6, 1e9];

/// Bodies of all these sizes at all these places, sorted by kind, then by size, then by place.
struct Unlike<N>(Vec<Body<N>>);

/// One of them: two differ in size by a factor of up to 10^12.
pub fn unlike_body<N: Dop>(input: &mut Input) -> &'static Body<N> {
    let all = cached(|| {
        let mut rng = Rng::new(2);
        let torus = shapes::torus(6, 4);
        let kinds = [
            shapes::soup(&mut rng, 18, 0.3),
            shapes::flat_grid(3),
            shapes::huge_among_tiny(&mut rng, 12),
            shapes::without_area(&torus, &mut rng, 6),
            torus,
        ];
        let sizes =
            kinds.iter().flat_map(|mesh| FACTORS.map(|factor| shapes::scaled(mesh, factor, [0.0; 3])));
        let places = |mesh: MeshData| {
            OFFSETS.map(|diagonals| {
                let away = diagonals * mesh.diagonal();
                Body::new(&shapes::scaled(&mesh, 1.0, [0.48, -0.6, 0.64].map(|x| x * away)), 1)
            })
        };
        Unlike(sizes.flat_map(places).collect())
    });
    input.pick(&all.0)
}

/// A pose that moves a corner of one body to a corner of the other, or near it.
pub fn corner_pose<N>(input: &mut Input, a: &Body<N>, b: &Body<N>) -> Pose {
    let rotation = turn(input);
    let [from, to] = [a, b].map(|body| {
        let corners = *input.pick(&body.triangles);
        corners[input.below(3)]
    });
    let reach = *input.pick(&[0.0, 1e-9, 1e-3, 1.0]) * a.size.min(b.size);
    let off = [(); 3].map(|()| reach * f64::from(input.u16() as i16) / 65536.0);
    let rows = core::array::from_fn(|i| {
        let [x, y, z] = rotation[i];
        [x, y, z, (to[i] + off[i]) - ((x * from[0] + y * from[1]) + z * from[2])]
    });
    Pose::from_rows(rows).expect("bodies are in range, and so are their differences")
}

/// The bodies of real trees: of size about 1, near the origin, so that they meet at most poses, and small.
pub struct Bodies<N>(pub Vec<Body<N>>);

/// Two triangles, and a ring of a ten-thousandth of their size at a corner of one of them.
fn with_a_detail() -> MeshData {
    let mut mesh = shapes::separate([
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, -0.5], [-1.0, 0.2, 0.3], [0.4, 0.5, 1.0]],
    ]);
    shapes::append(&mut mesh, &shapes::scaled(&shapes::torus(8, 5), 1e-4, [1.0, 0.0, 0.0]));
    mesh
}

/// The real bodies of a node type.
pub fn bodies<N: Dop>() -> &'static Bodies<N> {
    cached(|| {
        let mut rng = Rng::new(1);
        let torus = shapes::torus(6, 4);
        Bodies(vec![
            Body::new(&torus, 1),
            Body::new(&torus, 3),
            Body::new(&shapes::soup(&mut rng, 18, 0.3), 1),
            Body::new(&shapes::soup(&mut rng, 18, 1e-9), 1),
            Body::new(&shapes::flat_grid(3), 2),
            Body::new(&shapes::collinear(5), 1),
            Body::new(&shapes::coincident(5), 16),
            Body::new(&shapes::huge_among_tiny(&mut rng, 12), 1),
            Body::new(&shapes::without_area(&torus, &mut rng, 6), 2),
            Body::new(&with_a_detail(), 1),
            Body::new(&shapes::soup(&mut rng, 1, 1.0), 1),
            Body::new(&MeshData { vertices: Vec::new(), triangles: Vec::new() }, 1),
        ])
    })
}

/// A body of a few triangles: mostly one from a cache, as building one takes longer than a query.
pub enum Small<N: 'static> {
    Kept(&'static Body<N>),
    Made(Box<Body<N>>),
}

impl<N> Deref for Small<N> {
    type Target = Body<N>;

    fn deref(&self) -> &Body<N> {
        match self {
            Self::Kept(body) => body,
            Self::Made(body) => body,
        }
    }
}

/// The cached small bodies, with integer coordinates and with arbitrary bits.
struct Kept<N>([Vec<Body<N>>; 2]);

/// A body of a few triangles, built from the input one time in sixteen. Returns `None` if vertices are rejected, after
/// checking that this is right.
pub fn small_body<N: Dop>(input: &mut Input, mode: Mode) -> Option<Small<N>> {
    if input.one_in(16) {
        return make_body(input, mode).map(|body| Small::Made(Box::new(body)));
    }
    let kept = cached(|| {
        let make =
            |mode| (0..256_u32).filter_map(|i| make_body(&mut Input::new(&i.to_le_bytes()), mode)).collect();
        Kept([make(Mode::Grid), make(Mode::AnyBits)])
    });
    Some(Small::Kept(input.pick(&kept.0[usize::from(mode != Mode::Grid)])))
}

fn make_body<N: Dop>(input: &mut Input, mode: Mode) -> Option<Body<N>> {
    let count = input.below(if mode == Mode::Grid { 9 } else { 4 });
    let unit = unit(input, mode);
    let corners = (0..3 * count).map(|_| [(); 3].map(|()| coordinate(input, mode, unit)));
    let vertices: Vec<[f64; 3]> = corners.collect();
    let triangles: Vec<[u32; 3]> = (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let leaf_size = 1 + input.below(4) as u32;
    // False for NaN. A body that would collapse to a point is rejected, one that is a point is not.
    let in_range = vertices.as_flattened().iter().all(|x| x.abs() <= simdop::range::MAX_COORDINATE);
    let greatest = vertices.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let legal = in_range && (greatest == 0.0 || greatest >= simdop::range::MIN_COORDINATE);
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    let tree = Builder::new().leaf_size(leaf_size).build_as(&mesh);
    assert_eq!(tree.is_ok(), legal, "{vertices:?}: {:?}", tree.err());
    let flush = |x: f64| if x.abs() < simdop::range::MIN_COORDINATE { 0.0 } else { x };
    let tree = tree.ok()?;
    let mesh = MeshData { vertices: vertices.iter().map(|p| p.map(flush)).collect(), triangles };
    Some(Body { triangles: mesh.corners(), tree, size: mesh.diagonal() })
}

/// Typical magnitude of coordinates.
fn unit(input: &mut Input, mode: Mode) -> f64 {
    let exponent = if mode == Mode::AnyBits { 2 * input.int(-127, 127) } else { 0 };
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

fn coordinate(input: &mut Input, mode: Mode, unit: f64) -> f64 {
    if mode == Mode::Grid {
        return input.int(-3, 3).into();
    }
    match input.u8() {
        0 | 1 => f64::from_bits(input.u64()),
        2..128 => f64::from(input.int(-3, 3)) * unit,
        _ => f64::from(input.u16() as i16) * (unit / 16384.0),
    }
}

/// A pose at which bodies of size 1 can meet; with [`Mode::Grid`], one that maps integers to integers.
///
/// Invalid poses are rejected: the identity is returned then, after checking that this is right.
pub fn pose(input: &mut Input, mode: Mode) -> Pose {
    let rotation = if mode == Mode::Grid { axis_turn(input) } else { turn(input) };
    let unit = unit(input, mode);
    // Some bodies are far apart.
    let far =
        if mode == Mode::Real && input.one_in(16) { [30.0, 3e3, 1e6, 1e9][input.below(4)] } else { 1.0 };
    let t = [(); 3].map(|()| match mode {
        Mode::Grid => input.int(-4, 4).into(),
        Mode::AnyBits => coordinate(input, mode, unit),
        Mode::Real => far * f64::from(input.u16() as i16) / 20_000.0,
    });
    match Pose::from_rows(core::array::from_fn(|i| [rotation[i][0], rotation[i][1], rotation[i][2], t[i]])) {
        Ok(pose) => pose,
        Err(error) => {
            let too_far = t.iter().any(|x| x.abs() > simdop::range::MAX_COORDINATE);
            let not_finite = t.iter().any(|x| !x.is_finite());
            let right = if not_finite { PoseError::NotFinite } else { PoseError::TooFar };
            assert!((too_far || not_finite) && error == right, "{t:?}: {error}");
            Pose::IDENTITY
        }
    }
}

/// One of the 24 rotations that map axes to axes.
fn axis_turn(input: &mut Input) -> [[f64; 3]; 3] {
    let choice = input.below(24);
    let axis = choice % 3;
    // Orders of the axes: cyclic ones have an even number of negative signs, the others an odd one.
    let order = if choice.is_multiple_of(2) {
        [axis, (axis + 1) % 3, (axis + 2) % 3]
    } else {
        [axis, (axis + 2) % 3, (axis + 1) % 3]
    };
    let (x, y) = (choice / 6 % 2, choice / 12);
    let signs = [x, y, (x + y + choice) % 2];
    let mut rows = [[0.0; 3]; 3];
    for i in 0..3 {
        rows[i][order[i]] = if signs[i] == 0 { 1.0 } else { -1.0 };
    }
    rows
}

/// The rotation of a quaternion of four signed bytes.
fn turn(input: &mut Input) -> [[f64; 3]; 3] {
    let q = [(); 4].map(|()| f64::from(input.u8() as i8));
    let length = ((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3])).sqrt();
    let [x, y, z, w] = if length > 0.0 { q.map(|c| c / length) } else { [0.0, 0.0, 0.0, 1.0] };
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}
