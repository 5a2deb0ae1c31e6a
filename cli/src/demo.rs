//! The built-in scenes, so that the first run needs no file: two generated bodies with a sweep of poses, and a cloud.

use core::f64::consts::TAU;
use simdop::mesh_io::MeshData;
use simdop::pose::Pose;

/// A tube around a (2, 3) torus knot: 10,240 triangles.
pub(super) fn knot() -> MeshData {
    let (along, around) = (320, 16);
    let centre = |i: u32| {
        let t = TAU * f64::from(i) / f64::from(along);
        let r = 1.0 + 0.4 * (3.0 * t).cos();
        [r * (2.0 * t).cos(), r * (2.0 * t).sin(), 0.4 * (3.0 * t).sin()]
    };
    grid(along, around, |i, j| {
        let (p, before, after) = (centre(i), centre((i + along - 1) % along), centre((i + 1) % along));
        let tangent = unit(sub(after, before));
        let normal = unit(cross(tangent, [0.0, 0.0, 1.0]));
        let binormal = cross(tangent, normal);
        let angle = TAU * f64::from(j) / f64::from(around);
        let (s, c) = (0.15 * angle.sin(), 0.15 * angle.cos());
        core::array::from_fn(|k| p[k] + c * normal[k] + s * binormal[k])
    })
}

/// A torus with twelve teeth: 7,680 triangles.
pub(super) fn gear() -> MeshData {
    let (along, around) = (240, 16);
    grid(along, around, |i, j| {
        let (u, v) = (TAU * f64::from(i) / f64::from(along), TAU * f64::from(j) / f64::from(around));
        let tooth = 1.0 + 0.25 * (12.0 * u).sin().signum() * (12.0 * u).sin().abs().sqrt();
        let r = 0.9 + 0.3 * tooth * v.cos();
        [r * u.cos(), r * u.sin(), 0.2 * v.sin()]
    })
}

/// The rotating knot flies past the gear: far away, grazing, through it, and away again.
pub(super) fn sweep() -> Vec<Pose> {
    let poses = (0..64_u32).map(|i| {
        let s = f64::from(i) / 63.0;
        let (turn, tilt) = (0.5 * TAU * s, 0.3 + 0.2 * s);
        let (st, ct, sp, cp) = (turn.sin(), turn.cos(), tilt.sin(), tilt.cos());
        let x = 6.0 * (s - 0.5);
        let rows = [[ct, -st * cp, st * sp, x], [st, ct * cp, -ct * sp, 0.4], [0.0, sp, cp, 0.75]];
        Pose::from_rows(rows.map(|row| row.map(snap)))
    });
    poses.map(|pose| pose.unwrap_or(Pose::IDENTITY)).collect()
}

/// Points uniform in the unit cube.
pub(super) fn cube() -> Vec<[f32; 3]> {
    // A 64-bit linear congruential generator (Knuth's MMIX); its upper 24 bits are used.
    let mut state = 1_u64;
    let mut coordinate = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u32 << 24) as f32
    };
    (0..1 << 17).map(|_| [coordinate(), coordinate(), coordinate()]).collect()
}

/// A surface closed in both directions.
fn grid(along: u32, around: u32, point: impl Fn(u32, u32) -> [f64; 3]) -> MeshData {
    let mut mesh = MeshData::default();
    for i in 0..along {
        for j in 0..around {
            mesh.vertices.push(point(i, j).map(snap));
            let at = |i: u32, j: u32| (i % along) * around + j % around;
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.push([quad[0], quad[1], quad[2]]);
            mesh.triangles.push([quad[0], quad[2], quad[3]]);
        }
    }
    mesh
}

/// The nearest multiple of 2^-30, so that the scene is the same everywhere: math libraries differ in the last bits of a
/// sine.
fn snap(x: f64) -> f64 {
    const STEPS: f64 = (1_u32 << 30) as f64;
    (x * STEPS).round() / STEPS
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sweep_is_of_rigid_poses() {
        assert_eq!(sweep().iter().filter(|pose| **pose == Pose::IDENTITY).count(), 0);
        assert_eq!((knot().triangles.len(), gear().triangles.len()), (10_240, 7_680));
    }
}
