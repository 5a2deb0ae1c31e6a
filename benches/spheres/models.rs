//! Packings of real models, and their paths.

use crate::data::MeshData;
use crate::rng::Rng;
use simdop::construct::Mesh;
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::Sphere;
use std::path::Path;

/// A packed mesh, in a unit in which it is 1 to 2 wide: a power of two, so that scaling does not round.
pub(crate) struct Model {
    pub(crate) name: &'static str,
    /// In the order in which they were placed: the first n are the packing of n spheres.
    pub(crate) spheres: Vec<Sphere>,
    /// Shares of the mesh's volume covered by the first sphere, the first two, and so on.
    pub(crate) shares: Vec<f64>,
    /// The centre and half the diagonal of the mesh's box.
    centre: [f64; 3],
    half_diagonal: f64,
}

impl Model {
    /// # Panics
    /// If there is no such model, or it has no room for this many spheres.
    pub(crate) fn load(data: &Path, name: &'static str, count: usize) -> Self {
        let file = |extension| data.join("meshes").join(name).with_extension(extension);
        let ply = file("ply");
        let mut mesh = if ply.exists() { read_ply(&ply) } else { MeshData::obj(&file("obj")) };
        let scale = f64::powi(2.0, -(mesh.diagonal().log2().floor() as i32));
        mesh.vertices.iter_mut().flatten().for_each(|x| *x *= scale);
        let pack = |count| {
            let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
            Packer::new().spheres(count).pack(&mesh).unwrap_or_else(|e| panic!("{name}: {e}"))
        };
        let packing = pack(count);
        assert_eq!(packing.spheres.len(), count, "{name} has room for them");
        let few = count / 50;
        assert_eq!(pack(few).spheres, packing.spheres[..few], "{name}: the first are a packing of their own");
        let shares = packing.shares().collect();
        let (centre, half_diagonal) = (mesh.centre(), 0.5 * mesh.diagonal());
        Self { name, spheres: packing.spheres, shares, centre, half_diagonal }
    }
}

/// A little-endian binary PLY file of three floats a vertex and three indices a face.
fn read_ply(path: &Path) -> MeshData {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let end = b"end_header\n";
    let start = end.len() + bytes.windows(end.len()).position(|window| window == end).expect("a header");
    let header = String::from_utf8_lossy(&bytes[..start]);
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element)).expect("an element");
        line.trim().parse().expect("a number")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let body = &bytes[start..];
    assert!(header.contains("format binary_little_endian 1.0") && body.len() == 12 * vertices + 13 * faces);
    let words = |bytes: &[u8]| -> [[u8; 4]; 3] { core::array::from_fn(|i| bytes.as_chunks().0[i]) };
    let (vertices, faces) = body.split_at(12 * vertices);
    MeshData {
        vertices: vertices.chunks(12).map(|v| words(v).map(|x| f32::from_le_bytes(x).into())).collect(),
        triangles: faces.chunks(13).map(|face| words(&face[1..]).map(u32::from_le_bytes)).collect(),
    }
}

/// Key poses of a path, every other one far from the other body.
const KEYS: usize = 24;
/// A key pose: a unit quaternion, and the position of the centre.
type Key = [f64; 7];

/// A smooth motion of A through B, in and out: a spline through random poses. The same for packings with any number of
/// spheres and, since all operations are correctly rounded, on every machine.
pub(crate) fn path(a: &Model, b: &Model, poses: usize) -> Vec<Pose> {
    let mut rng = Rng::new(8);
    let reach = a.half_diagonal + b.half_diagonal;
    let mut keys: Vec<Key> = Vec::new();
    for i in 0..KEYS + 2 {
        let share = if i % 2 == 0 { 0.65 } else { rng.range(0.1, 0.4) };
        let [x, y, z] = rng.rotation()[0].map(|x| share * reach * x);
        let mut turn = quaternion(&mut rng);
        // Of the two quaternions of a rotation, take the one nearer to the last: no rotation exceeds half a turn.
        if let Some(last) = keys.last()
            && (0..4).map(|i| last[i] * turn[i]).sum::<f64>() < 0.0
        {
            turn = turn.map(|x| -x);
        }
        keys.push([turn[0], turn[1], turn[2], turn[3], x, y, z]);
    }
    let segments = keys.len() - 3;
    let at = |i: usize| {
        let t = i as f64 / poses as f64 * segments as f64;
        let first = t as usize;
        placed(&spline(&keys[first..first + 4], t - first as f64), a.centre, b.centre)
    };
    (0..poses).map(at).collect()
}

fn quaternion(rng: &mut Rng) -> [f64; 4] {
    loop {
        let q: [f64; 4] = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        let square = (q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]);
        if (0.01..1.0).contains(&square) {
            return q.map(|x| x / square.sqrt());
        }
    }
}

/// Catmull and Rom's spline between the second and the third of four keys.
fn spline(keys: &[Key], t: f64) -> Key {
    core::array::from_fn(|i| {
        let [p, q, r, s] = [0, 1, 2, 3].map(|key: usize| keys[key][i]);
        let square = 2.0 * p - 5.0 * q + 4.0 * r - s;
        let cube = 3.0 * (q - r) + (s - p);
        0.5 * (((cube * t + square) * t + (r - p)) * t + 2.0 * q)
    })
}

/// Rotated about the centre of A, which is then moved to the key's position relative to the centre of B.
fn placed(key: &Key, a: [f64; 3], b: [f64; 3]) -> Pose {
    let [x, y, z, w, way @ ..] = *key;
    let length = ((x * x + y * y) + (z * z + w * w)).sqrt();
    let [x, y, z, w] = [x, y, z, w].map(|c| c / length);
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let row = |i: usize| {
        let [p, q, r] = rows[i];
        [p, q, r, b[i] + way[i] - ((p * a[0] + q * a[1]) + r * a[2])]
    };
    Pose::from_rows([row(0), row(1), row(2)]).expect("rotations are rigid")
}
