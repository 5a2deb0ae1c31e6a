//! Clouds from the images of depth cameras.

use super::error::CloudError;
use super::owned::PointCloud;
use crate::pose::Pose;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// A pinhole camera that looks along z, with x to the right and y down. All numbers are in pixels; the first pixel of
/// the image has its centre at (0, 0).
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Pinhole {
    /// Focal lengths along x and y.
    pub focal: [f64; 2],
    /// The principal point.
    pub centre: [f64; 2],
}

/// An image of depths, row by row: the z of what each pixel shows, in the camera's frame.
#[derive(Copy, Clone, Debug)]
pub struct DepthImage<'a> {
    depths: &'a [f32],
    width: usize,
    camera: Pinhole,
    range: [f32; 2],
}

/// Why an image of depths is invalid.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum DepthImageError {
    /// The number of depths is not a multiple of the width.
    Size {
        /// Number of depths.
        depths: usize,
        /// The width given.
        width: usize,
    },
    /// A focal length is not positive and finite, or the principal point is not finite.
    Camera,
    /// The range is not an interval of positive depths.
    Range,
}

impl fmt::Display for DepthImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { depths, width } => write!(f, "{depths} depths do not fill rows of {width} pixels"),
            Self::Camera => f.write_str("a focal length must be positive, and the principal point finite"),
            Self::Range => f.write_str("a range of depths must be positive, and its end not below its start"),
        }
    }
}

impl core::error::Error for DepthImageError {}

impl<'a> DepthImage<'a> {
    /// An image with `width` pixels per row. All positive finite depths count.
    ///
    /// # Errors
    /// [`DepthImageError`].
    pub fn new(depths: &'a [f32], width: usize, camera: Pinhole) -> Result<Self, DepthImageError> {
        if width == 0 || !depths.len().is_multiple_of(width) {
            return Err(DepthImageError::Size { depths: depths.len(), width });
        }
        let is_length = |x: f64| x > 0.0 && x.is_finite();
        if !camera.focal.into_iter().all(is_length) || !camera.centre.into_iter().all(f64::is_finite) {
            return Err(DepthImageError::Camera);
        }
        Ok(Self { depths, width, camera, range: [f32::MIN_POSITIVE, f32::MAX] })
    }

    /// Ignores depths outside `near..=far`.
    ///
    /// # Errors
    /// [`DepthImageError::Range`].
    pub fn within(self, near: f32, far: f32) -> Result<Self, DepthImageError> {
        if near > 0.0 && near <= far {
            Ok(Self { range: [near, far], ..self })
        } else {
            Err(DepthImageError::Range)
        }
    }

    /// The points that the pixels show, for a camera at a pose in the world, rounded to `f32`. Pixels whose depth is
    /// out of range are skipped; cameras mark missing depths by 0 or NaN.
    pub fn points(&self, camera: &Pose) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let (Self { depths, width, camera: Pinhole { focal, centre }, range: [near, far] }, at) =
            (*self, *camera);
        depths.iter().enumerate().filter(move |(_, depth)| (near..=far).contains(depth)).map(
            move |(pixel, &depth)| {
                let z = f64::from(depth);
                let (u, v) = ((pixel % width) as f64, (pixel / width) as f64);
                let point = [(u - centre[0]) / focal[0] * z, (v - centre[1]) / focal[1] * z, z];
                at.apply(point).map(|x| x as f32)
            },
        )
    }

    /// A cloud of these points. If `cell` is above 0, each cube of a grid with this edge length keeps only its first
    /// point: each dropped point is less than `sqrt(3) * cell` from one that was kept.
    ///
    /// # Errors
    /// [`CloudError`]: too many points, or one beyond the range of `f32`.
    pub fn cloud(&self, camera: &Pose, cell: f32) -> Result<PointCloud, CloudError> {
        let mut grid = CubeGrid::new(cell);
        let points: Vec<[f32; 3]> = self.points(camera).filter(|point| grid.is_first(point)).collect();
        PointCloud::new(&points)
    }
}

/// The cubes of a grid that hold a point: a hash table with linear probing.
struct CubeGrid {
    /// Cubes per unit of length; 0 without a grid.
    scale: f32,
    cubes: Vec<Option<[i32; 3]>>,
    used: usize,
    /// The cube of the last point: adjacent pixels often share one.
    last: Option<[i32; 3]>,
}

impl CubeGrid {
    fn new(cell: f32) -> Self {
        let scale = if cell > 0.0 { 1.0 / cell } else { 0.0 };
        Self { scale, cubes: vec![None; 1 << 12], used: 0, last: None }
    }

    /// Whether a point is the first of its cube.
    fn is_first(&mut self, point: &[f32; 3]) -> bool {
        /// Cubes farther out are not numbered: all their points are kept.
        const MOST: f32 = 1e9;
        let scaled = point.map(|x| libm::floorf(x * self.scale));
        if self.scale <= 0.0 || !scaled.iter().all(|x| x.abs() < MOST) {
            return true;
        }
        let cube = scaled.map(|x| x as i32);
        if self.last == Some(cube) {
            return false;
        }
        self.last = Some(cube);
        if 2 * self.used >= self.cubes.len() {
            let longer = vec![None; 4 * self.cubes.len()];
            for cube in core::mem::replace(&mut self.cubes, longer).into_iter().flatten() {
                let place = self.place(&cube);
                self.cubes[place] = Some(cube);
            }
        }
        let place = self.place(&cube);
        let is_first = self.cubes[place].is_none();
        self.cubes[place] = Some(cube);
        self.used += usize::from(is_first);
        is_first
    }

    /// The slot of a cube, or the free slot where it belongs.
    fn place(&self, cube: &[i32; 3]) -> usize {
        let mask = self.cubes.len() - 1;
        let mixed = cube.iter().fold(0_u64, |hash, x| {
            (hash.rotate_left(5) ^ u64::from(*x as u32)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        });
        let mut place = (mixed >> 32) as usize & mask;
        while self.cubes[place].is_some_and(|other| other != *cube) {
            place = (place + 1) & mask;
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use alloc::collections::BTreeMap;

    const CAMERA: Pinhole = Pinhole { focal: [500.0, 400.0], centre: [3.5, 2.0] };

    /// Projected, each point is at its pixel, and at its depth.
    #[test]
    fn points_are_where_their_pixels_look() {
        let mut rng = Rng::new(1);
        let depths: Vec<f32> = (0..48).map(|_| rng.range(0.5, 4.0) as f32).collect();
        let image = DepthImage::new(&depths, 8, CAMERA).unwrap();
        let turn = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, -2.0], [0.0, 0.0, 1.0, 0.5]];
        let at = Pose::from_rows(turn).unwrap();
        let points: Vec<_> = image.points(&at).collect();
        assert_eq!(points.len(), 48);
        for (i, point) in points.iter().enumerate() {
            let [x, y, z] = point.map(f64::from);
            // The inverse of a quarter turn about z.
            let [x, y, z] = [y + 2.0, -(x - 1.0), z - 0.5];
            assert!((z - f64::from(depths[i])).abs() < 1e-6);
            assert!((x / z * 500.0 + 3.5 - (i % 8) as f64).abs() < 1e-3, "{i}");
            assert!((y / z * 400.0 + 2.0 - (i / 8) as f64).abs() < 1e-3, "{i}");
        }
    }

    #[test]
    fn pixels_without_a_depth_show_nothing() {
        let depths = [0.0, f32::NAN, -1.0, f32::INFINITY, 1.0, 2.0, 3.0, 4.0];
        let image = DepthImage::new(&depths, 4, CAMERA).unwrap();
        let count = |image: &DepthImage<'_>| image.points(&Pose::IDENTITY).count();
        assert_eq!(count(&image), 4);
        assert_eq!(count(&image.within(2.0, 3.0).unwrap()), 2);
        for (near, far) in [(0.0, 1.0), (-1.0, 1.0), (2.0, 1.0), (f32::NAN, 1.0), (1.0, f32::NAN)] {
            assert_eq!(image.within(near, far).unwrap_err(), DepthImageError::Range);
        }
        let size = |width| DepthImage::new(&depths, width, CAMERA).unwrap_err();
        assert_eq!(size(3), DepthImageError::Size { depths: 8, width: 3 });
        assert_eq!(size(0), DepthImageError::Size { depths: 8, width: 0 });
        for focal in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
            let camera = Pinhole { focal, ..CAMERA };
            assert_eq!(DepthImage::new(&depths, 4, camera).unwrap_err(), DepthImageError::Camera);
        }
        assert!(
            DepthImage::new(&[], 4, CAMERA).unwrap().cloud(&Pose::IDENTITY, 0.1).unwrap().view().is_empty()
        );
    }

    /// A grid keeps the first point of each cube, as a map of cubes says, through all its growth.
    #[test]
    fn a_grid_keeps_the_first_of_each_cube() {
        let mut rng = Rng::new(2);
        for cell in [0.01_f32, 0.05, 1.0] {
            let mut grid = CubeGrid::new(cell);
            let mut known = BTreeMap::new();
            for _ in 0..60_000 {
                let point: [f32; 3] = core::array::from_fn(|_| rng.range(-0.4, 0.4) as f32);
                let cube = point.map(|x| (x * (1.0 / cell)).floor() as i64);
                let kept = *known.entry(cube).or_insert(point);
                let is_first = grid.is_first(&point);
                assert_eq!(is_first, kept == point);
                let distance = (0..3).map(|i| (kept[i] - point[i]).powi(2)).sum::<f32>().sqrt();
                assert!(distance < 3.0_f32.sqrt() * cell * (1.0 + 1e-5));
            }
        }
        let mut far = CubeGrid::new(1e-30);
        assert!(far.is_first(&[1.0; 3]) && far.is_first(&[1.0; 3]), "cubes without a number keep all");
        let mut none = CubeGrid::new(0.0);
        assert!(none.is_first(&[1.0; 3]) && none.is_first(&[1.0; 3]));
    }
}
