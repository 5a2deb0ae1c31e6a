//! Real meshes, read without the library, and poses at given distances from contact.

use super::rng::Rng;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// A mesh, independent of the library's types.
#[derive(Clone, Debug)]
pub(crate) struct MeshData {
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Writes `*** PROGRAM, TEST: WHAT ***` to standard error, once, even from a test that passes: the harness
/// captures `println!` and `eprintln!`, but not writes to the stream itself.
pub(crate) fn notice(what: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let thread = std::thread::current();
    // The harness names a test's thread after the test.
    let test = thread.name().filter(|name| *name != "main").map_or(String::new(), |name| format!(", {name}"));
    let line = format!("*** {}{test}: {what} ***\n", env!("CARGO_CRATE_NAME"));
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(line.clone()) {
        // One write, because other tests write too.
        std::io::stderr().write_all(line.as_bytes()).unwrap();
    }
}

/// The folder of the data sets, if it exists: `$SIMDOP_DATA`, or `../shared/data` beside the project. If not,
/// prints a notice.
///
/// # Panics
/// If it does not exist and `SIMDOP_REQUIRE_DATA` is set, as in CI.
pub(crate) fn directory() -> Option<PathBuf> {
    // The root of the project is this package or its parent folder.
    let package = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = if package.join("Cargo.lock").exists() { package.to_owned() } else { package.join("..") };
    let path = std::env::var_os("SIMDOP_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    if path.join("meshes").is_dir() {
        return Some(path);
    }
    let required = std::env::var_os("SIMDOP_REQUIRE_DATA").is_some();
    assert!(!required, "SIMDOP_REQUIRE_DATA is set, and there are no data sets in {}", path.display());
    notice(&format!(
        "SKIPPED on real meshes: no data sets in {} ($SIMDOP_DATA, else ../shared/data)",
        path.display()
    ));
    None
}

/// The step through the cases: every eighth, or every one if `SIMDOP_SUITE` is `full`, as in `.ci/sweep`.
pub(crate) fn suite_step() -> usize {
    match suite().as_deref() {
        Some("full") => 1,
        _ => 8,
    }
}

/// A further step through the cases of tests that take long: 4 if `SIMDOP_SUITE` is `emulator`, as for NEON in
/// `.ci/run`. What an oracle says is the same on every machine.
pub(crate) fn emulator_step() -> usize {
    match suite().as_deref() {
        Some("emulator") => 4,
        _ => 1,
    }
}

fn suite() -> Option<String> {
    let suite = std::env::var("SIMDOP_SUITE").ok()?;
    assert!(["full", "emulator"].contains(&&*suite), "SIMDOP_SUITE is absent, full or emulator, not {suite}");
    Some(suite)
}

/// The first value in the full suite, else the second.
pub(crate) fn by_suite<T>(full: T, short: T) -> T {
    if suite_step() == 1 { full } else { short }
}

impl MeshData {
    /// Reads the `v` and `f` lines of an OBJ file. A polygon becomes a fan of triangles.
    pub(crate) fn obj(path: &std::path::Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut mesh = Self { vertices: Vec::new(), triangles: Vec::new() };
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let number = |i: usize| words[i].parse::<f64>().unwrap();
            let index = |i: usize| words[i].split('/').next().unwrap().parse::<u32>().unwrap() - 1;
            match words.first() {
                Some(&"v") => mesh.vertices.push([number(1), number(2), number(3)]),
                Some(&"f") => {
                    for i in 2..words.len() - 1 {
                        mesh.triangles.push([index(1), index(i), index(i + 1)]);
                    }
                }
                _ => {}
            }
        }
        assert!(!mesh.triangles.is_empty(), "{} has triangles", path.display());
        mesh
    }

    /// The corners of every triangle at a pose: an independent implementation of the arithmetic that the
    /// library documents for a moved corner.
    pub(crate) fn placed(&self, pose: &[[f64; 4]; 3]) -> Vec<[[f64; 3]; 3]> {
        let place = |p: &[f64; 3]| pose.map(|r| ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + r[3]);
        let moved: Vec<[f64; 3]> = self.vertices.iter().map(place).collect();
        self.triangles.iter().map(|t| t.map(|v| moved[v as usize])).collect()
    }

    /// The corners of every triangle.
    pub(crate) fn corners(&self) -> Vec<[[f64; 3]; 3]> {
        self.triangles.iter().map(|t| t.map(|v| self.vertices[v as usize])).collect()
    }

    /// The lowest and the highest corner of the bounding box.
    pub(crate) fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let fold = |f: fn(f64, f64) -> f64, start: f64| {
            core::array::from_fn(|i| self.vertices.iter().fold(start, |m, p| f(m, p[i])))
        };
        (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
    }

    /// The length of the bounding box's diagonal.
    pub(crate) fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt()
    }

    /// The centre of the bounding box.
    pub(crate) fn centre(&self) -> [f64; 3] {
        let (low, high) = self.bounds();
        core::array::from_fn(|i| 0.5 * (low[i] + high[i]))
    }
}

/// A pair of meshes.
pub(crate) struct Suite {
    pub(crate) name: &'static str,
    pub(crate) a: MeshData,
    pub(crate) b: MeshData,
}

/// The four pairs of meshes whose verdicts are all checked.
pub(crate) fn suites() -> Option<Vec<Suite>> {
    let data = directory()?;
    let pair = |name, a: &str, b: &str| Suite {
        name,
        a: MeshData::obj(&data.join(a)),
        b: MeshData::obj(&data.join(b)),
    };
    Some(vec![
        pair("hand", "meshes/hand.obj", "meshes/hand.obj"),
        pair("cow", "meshes/cow.obj", "meshes/cow.obj"),
        pair("pinion", "meshes/pinion.obj", "meshes/pinion.obj"),
        pair("unc", "planning/unc_rob.obj", "planning/unc_env.obj"),
    ])
}

/// The straight line along which a rotated body approaches.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Approach {
    /// The rotation of the body, by rows.
    pub(crate) rotation: [[f64; 3]; 3],
    /// The body's centre at distance 0.
    pub(crate) target: [f64; 3],
    /// The unit vector from the target towards the start.
    pub(crate) towards: [f64; 3],
    /// The centre of the body in its own frame.
    pub(crate) centre: [f64; 3],
}

impl Approach {
    /// The pose with the centre `distance` in front of the target.
    pub(crate) fn at(&self, distance: f64) -> [[f64; 4]; 3] {
        core::array::from_fn(|i| {
            let (r, c) = (self.rotation[i], self.centre);
            let turned = (r[0] * c[0] + r[1] * c[1]) + r[2] * c[2];
            [r[0], r[1], r[2], self.target[i] - turned + distance * self.towards[i]]
        })
    }
}

/// Gaps (positive) and depths (negative) of the poses, as fractions of the diagonal.
pub(crate) const GAPS: [f64; 8] = [1e-2, -1e-2, 1e-4, -1e-4, 1e-6, -1e-6, 1e-8, -1e-8];

impl Suite {
    /// For each of 25 random rotations and directions, finds where A, coming from outside, first touches B
    /// according to `meets`, and returns the eight poses before and behind that place. Deterministic if the
    /// answers are exact.
    pub(crate) fn poses<F>(&self, step: usize, meets: F) -> Vec<[[f64; 4]; 3]>
    where
        F: Fn(&[[f64; 4]; 3]) -> bool,
    {
        let mut rng = Rng::new(0x5eed);
        let (size_a, size_b) = (self.a.diagonal(), self.b.diagonal());
        let mut poses = Vec::new();
        for _ in (0..25).step_by(step) {
            let rotation = rng.rotation();
            let towards = rng.rotation()[0];
            let line = Approach { rotation, target: self.b.centre(), towards, centre: self.a.centre() };
            let at = |distance: f64| line.at(distance);
            // From far away inwards in steps to the first pose that meets. In an open scene A may pass B: then
            // the target is used.
            let far = size_a + size_b;
            let first = (0..=200).find(|i| meets(&at(far * (1.0 - f64::from(*i) / 200.0))));
            let mut inside = far * first.map_or(0.0, |i| 1.0 - f64::from(i) / 200.0);
            let mut outside = inside + far / 200.0;
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if meets(&at(middle)) { inside = middle } else { outside = middle }
            }
            poses.extend(GAPS.iter().map(|gap| at(inside + gap * size_a)));
        }
        poses
    }
}

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (
        notice,
        directory,
        suite_step,
        emulator_step,
        by_suite::<()>,
        MeshData::placed,
        MeshData::corners,
        suites,
        GAPS,
    );
    let _ = (MeshData::bounds, MeshData::centre, Approach::at);
    let _ = Suite::poses::<fn(&[[f64; 4]; 3]) -> bool>;
    let _ = |suite: &Suite| suite.name;
};
