//! A picture of the first level of a tree: the mesh or the spheres, one colour for each child of the root, as in figure
//! 3 of the SIMDop paper.

use super::body;
use super::error::Error;
use simdop::hierarchy::{AnyBvh, BvhRef};
use simdop::node::Node16;
use simdop::primitive::{Sphere, Spheres};
use std::path::Path;

mod parts;
#[cfg(feature = "png")]
mod png;
mod svg;

use parts::{Outline, Part};

type Vector = [f64; 3];

/// Pixels along the longer side of the mesh, without the margins.
const SIZE: f64 = 800.0;
const MARGIN: f64 = 20.0;
/// The view is rotated by this angle to the left and from above, so that three sides of a box are visible.
const TURN: f64 = 0.35;
const TILT: f64 = 0.25;

/// The format of an image file.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Format {
    Svg,
    #[cfg(feature = "png")]
    Png,
}

impl Format {
    /// The format by the file's extension.
    pub(super) fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let problem = |problem| {
            Err(Error::Option { option: "--picture", problem: format!("{}: {problem}", path.display()) })
        };
        match extension.as_str() {
            "svg" => Ok(Self::Svg),
            #[cfg(feature = "png")]
            "png" => Ok(Self::Png),
            #[cfg(not(feature = "png"))]
            "png" => problem("needs the feature `png`: `cargo install --path cli --features png`"),
            _ => problem("a picture's name ends in .svg or .png"),
        }
    }
}

/// The image of a mesh: orthographic, painted from back to front.
pub(super) fn paint(tree: &AnyBvh, title: &str, format: Format) -> Vec<u8> {
    let clusters = body::clusters(tree);
    let camera = Camera::for_balls(clusters.iter().flat_map(|(_, t)| t).map(|p| (*p, 0.0)));
    let parts = clusters.iter().map(|(lane, t)| part_of_triangle(&camera, *lane, t)).collect();
    image(parts, &camera, title, format)
}

/// The image of spheres. The order of painting is right if they are disjoint: of two spheres on a line of sight, the
/// one with the nearer centre is nearer.
pub(super) fn paint_spheres(tree: &BvhRef<'_, Node16<18>, Spheres>, title: &str, format: Format) -> Vec<u8> {
    let clusters = body::primitives_by_root_lane(tree);
    let camera = Camera::for_balls(clusters.iter().map(|(_, sphere)| (sphere.centre, sphere.radius)));
    let disc = |(lane, sphere): &(usize, Sphere)| Part {
        depth: dot(&camera.back, &sphere.centre),
        outline: Outline::Disc {
            centre: camera.project(&sphere.centre),
            radius: sphere.radius * camera.scale,
        },
        // Darker than the paper, against which pale hues would be invisible.
        colour: colour(*lane).map(|x| (x * 235.0) as u8),
    };
    image(clusters.iter().map(disc).collect(), &camera, title, format)
}

fn image(mut parts: Vec<Part>, camera: &Camera, title: &str, format: Format) -> Vec<u8> {
    parts.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let size = camera.extent.map(|x| x * camera.scale + 2.0 * MARGIN);
    match format {
        Format::Svg => svg::image(&parts, size, title).into_bytes(),
        #[cfg(feature = "png")]
        Format::Png => png::image(&parts, size),
    }
}

/// Looks along the axis in which the mesh is thinnest.
struct Camera {
    right: Vector,
    up: Vector,
    back: Vector,
    /// Smallest coordinates along `right` and `up`, and their ranges, in the mesh's unit.
    low: [f64; 2],
    extent: [f64; 2],
    /// Pixels per unit.
    scale: f64,
}

impl Camera {
    /// Centres and radii of the visible balls.
    fn for_balls(balls: impl Iterator<Item = (Vector, f64)> + Clone) -> Self {
        let range = |direction: Vector| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for (x, radius) in balls.clone().map(|(p, radius)| (dot(&direction, &p), radius)) {
                (low, high) = (low.min(x - radius), high.max(x + radius));
            }
            if low <= high { (low, high - low) } else { (0.0, 0.0) }
        };
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [wide, high, deep] = [x, y, z].map(|axis| range(axis).1);
        // Right-handed: right x up points at the viewer. Up is z, or y if the view is along z.
        let (right, up, back) = if deep <= wide && deep <= high {
            (x, y, z)
        } else if wide <= high {
            (y, z, x)
        } else {
            (x, z, [0.0, -1.0, 0.0])
        };
        let (right, back) = turned(right, back, TURN);
        let (back, up) = turned(back, up, TILT);
        let [(left, width), (bottom, height)] = [range(right), range(up)];
        let longer = width.max(height);
        let scale = if longer > 0.0 { SIZE / longer } else { 1.0 };
        Self { right, up, back, low: [left, bottom], extent: [width, height], scale }
    }

    /// Projects a point to pixels from the left and from the top.
    fn project(&self, p: &Vector) -> [f64; 2] {
        let x = dot(&self.right, p) - self.low[0];
        let y = self.low[1] + self.extent[1] - dot(&self.up, p);
        [x * self.scale + MARGIN, y * self.scale + MARGIN]
    }
}

fn part_of_triangle(camera: &Camera, lane: usize, triangle: &[Vector; 3]) -> Part {
    let [a, b, c] = triangle;
    let (u, v): (Vector, Vector) =
        (core::array::from_fn(|i| b[i] - a[i]), core::array::from_fn(|i| c[i] - a[i]));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = dot(&normal, &normal).sqrt();
    // Lit from behind the viewer's left shoulder, on both sides: the orientation of triangles is not guaranteed.
    let light: Vector = core::array::from_fn(|i| camera.back[i] - 0.5 * camera.right[i] + 0.5 * camera.up[i]);
    let facing = dot(&normal, &light).abs() / (length * dot(&light, &light).sqrt());
    let shade = if length > 0.0 { 0.45 + 0.55 * facing } else { 1.0 };
    let depth = triangle.iter().map(|p| dot(&camera.back, p)).sum::<f64>();
    let colour = colour(lane).map(|x| (x * shade * 255.0) as u8);
    Part { depth, outline: Outline::Triangle(triangle.each_ref().map(|p| camera.project(p))), colour }
}

/// Hues a golden angle apart, so that neighbouring lanes differ; every second turn of the circle is paler.
fn colour(lane: usize) -> Vector {
    let hue = (lane as f64 * 0.618_033_988_75).fract() * 6.0;
    let floor = [0.15, 0.45, 0.0][lane % 3];
    core::array::from_fn(|i| {
        // Red, green and blue are a third of the circle apart.
        let away = (hue + 2.0 * i as f64) % 6.0 - 3.0;
        floor + (1.0 - floor) * (away.abs() - 1.0).clamp(0.0, 1.0)
    })
}

/// Rotates two perpendicular unit vectors, the first towards the second.
fn turned(a: Vector, b: Vector, angle: f64) -> (Vector, Vector) {
    let (s, c) = angle.sin_cos();
    (core::array::from_fn(|i| c * a[i] + s * b[i]), core::array::from_fn(|i| c * b[i] - s * a[i]))
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_colours_differ() {
        for i in 0..16 {
            for j in 0..i {
                let (a, b) = (colour(i), colour(j));
                let far = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
                assert!(far > 0.1, "{i} {a:?} {j} {b:?}");
            }
        }
    }

    #[test]
    fn the_camera_is_an_orthonormal_frame_that_sees_everything() {
        let boxes = [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0], [0.0, 0.0, 0.0]];
        for size in boxes {
            let corners = [[0.0; 3], size];
            let camera = Camera::for_balls(corners.iter().map(|p| (*p, 0.0)));
            let Camera { right, up, back, .. } = &camera;
            for (a, b) in [(right, up), (up, back), (back, right)] {
                assert!(dot(a, b).abs() < 1e-15 && (dot(a, a) - 1.0).abs() < 1e-15);
            }
            let cross = [
                right[1] * up[2] - right[2] * up[1],
                right[2] * up[0] - right[0] * up[2],
                right[0] * up[1] - right[1] * up[0],
            ];
            assert!((dot(&cross, back) - 1.0).abs() < 1e-15, "right-handed");
            for p in &corners {
                assert!(camera.project(p).iter().all(|x| (MARGIN - 1e-9..=SIZE + MARGIN + 1e-9).contains(x)));
            }
        }
    }

    /// Nearer spheres are painted later, with the camera in front of each side of the spheres in turn.
    #[test]
    fn the_nearer_sphere_is_painted_last() {
        for axis in 0..3 {
            let centres = [-1.0, 3.0, 1.0].map(|x| core::array::from_fn(|i| if i == axis { x } else { 0.0 }));
            let spheres = centres.map(|centre| Sphere { centre, radius: 0.5 });
            let camera = Camera::for_balls(centres.iter().map(|centre| (*centre, 0.5)));
            let sign = camera.back[axis].signum();
            let tree = body::of_spheres("spheres", &spheres).unwrap();
            let text = String::from_utf8(paint_spheres(&tree.view(), "spheres", Format::Svg)).unwrap();
            let painted = text.lines().filter(|line| line.starts_with("<circle"));
            let mut want = [-1.0, 1.0, 3.0].map(|x| x * sign);
            want.sort_by(f64::total_cmp);
            let place = |x: f64| {
                let [x, y] =
                    camera.project(&core::array::from_fn(|i| if i == axis { x * sign } else { 0.0 }));
                format!("cx=\"{x:.1}\" cy=\"{y:.1}\"")
            };
            for (line, x) in painted.zip(want) {
                assert!(line.contains(&place(x)), "{line} {axis} {x}");
            }
        }
    }
}
