//! Sets of points that are hard for a tree, and the loop that decides what is near.

/// A generator of numbers in [0, 1), the same on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1_u32 << 24) as f32
    }

    pub(crate) fn point(&mut self) -> [f32; 3] {
        [self.next(), self.next(), self.next()]
    }
}

/// The definition of a neighbour: exactly these operations, in `f32`.
pub(crate) fn is_near(p: [f32; 3], q: [f32; 3], r: f32) -> bool {
    square(p, q) <= r * r
}

pub(crate) fn square(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|i| p[i] - q[i]);
    (x * x + y * y) + z * z
}

/// The neighbours of a query by ascending index.
pub(crate) fn brute(points: &[[f32; 3]], q: [f32; 3], r: f32) -> Vec<u32> {
    (0..points.len() as u32).filter(|&i| is_near(points[i as usize], q, r)).collect()
}

/// A name, points and radii.
pub(crate) type Scene = (&'static str, Vec<[f32; 3]>, Vec<f32>);

/// Named sets of about `n` points, each with radii that are critical for it.
pub(crate) fn all(n: usize) -> Vec<Scene> {
    let random = &mut Random(7);
    let side = (n as f32).cbrt().ceil() as usize;
    let grid = |scale: f32| -> Vec<[f32; 3]> {
        let cell = |i: usize| [i % side, i / side % side, i / side / side].map(|c| c as f32 * scale);
        (0..n).map(cell).collect()
    };
    let uniform: Vec<_> = (0..n).map(|_| random.point()).collect();
    let far: Vec<_> = uniform.iter().map(|p| p.map(|x| x + 1e6)).collect();
    let planar: Vec<_> = uniform.iter().map(|&[x, y, _]| [x, 0.25, y]).collect();
    let line: Vec<_> = uniform.iter().map(|&[x, ..]| [x, x, -x]).collect();
    let twice: Vec<_> = (0..n).map(|i| uniform[i / 2]).collect();
    let zeros: Vec<_> = (0..n).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { 0.0 } else { -0.0 })).collect();
    let clustered: Vec<_> = (0..n)
        .map(|i| {
            let (centre, width) = (uniform[i % 5], 10.0_f32.powi(-((i % 5) as i32)));
            let offset = random.point();
            [0, 1, 2].map(|k| centre[k] + width * offset[k])
        })
        .collect();
    let tiny: Vec<_> = uniform.iter().map(|p| p.map(|x| x * 1e-22)).collect();
    let huge: Vec<_> = uniform.iter().map(|p| p.map(|x| (x - 0.5) * f32::MAX)).collect();
    vec![
        ("uniform", uniform, vec![0.0, 0.05, 0.1, 0.5, 2.0]),
        // Ties: the radii are the distances of many pairs.
        ("grid", grid(1.0), vec![0.0, 1.0, 2.0_f32.sqrt(), 2.0, 3.0]),
        ("grid of tenths", grid(0.1), vec![0.1, 0.2, 0.3, 0.141_421_36]),
        ("a million from the origin", far, vec![0.0, 0.0625, 0.125, 0.25]),
        ("planar", planar, vec![0.0, 0.03, 0.2]),
        ("a line", line, vec![0.0, 1e-4, 0.1]),
        ("each twice", twice, vec![0.0, 0.1]),
        ("coincident", vec![[1.5, -2.0, 3.25]; n], vec![0.0, 1.0]),
        ("zeros of both signs", zeros, vec![0.0, 1e-30]),
        ("clusters of all sizes", clustered, vec![1e-5, 1e-3, 0.05]),
        ("near the least numbers", tiny, vec![0.0, 1e-23, 3e-23, 1e-22]),
        ("near the greatest numbers", huge, vec![0.0, 1e18, 1e20, 1e38]),
    ]
}
