//! Each kernel against its scalar reference, and the shader source against the types here.
//!
//! References: for `arithmetic` the predicate itself; for `move_points` and `refit` [`PointCloud::refit`]; for `seat`
//! [`RangeSearch::seat`]; for `count` and `fill` [`RangeSearch::count`] and [`RangeSearch::fill`]; for the scans a
//! loop of additions.

mod kernels;
mod mutants;
mod text;

use super::super::packet::Asking;
use super::super::{List, PointCloud, Queries, Radii, RangeSearch, Seat};
use super::memory::{CloudBinding, SearchData, TreeLevel};
use super::shader::{self, CloudShader, NO_BUCKET, WORKGROUP};
use super::*;
use crate::isa::{Isa, Scalar};
use crate::rng::Rng;
use std::{eprintln, format, println};

/// The device shared by all tests, if there is an adapter.
fn device() -> Option<&'static Gpu> {
    static DEVICE: std::sync::OnceLock<Option<Gpu>> = std::sync::OnceLock::new();
    let make = || {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions::default();
        let Ok(adapter) = pollster::block_on(instance.request_adapter(&options)) else {
            let required = std::env::var_os("SIMDOP_REQUIRE_GPU").is_some();
            assert!(!required, "SIMDOP_REQUIRE_GPU is set, and there is no adapter");
            eprintln!("\n*** SKIPPED: no adapter ***\n");
            return None;
        };
        let gpu = Gpu::with_adapter(&adapter).unwrap();
        println!("{} {}", gpu.info().name, gpu.info().driver_info);
        Some(gpu)
    };
    DEVICE.get_or_init(make).as_ref()
}

fn scalar() -> RangeSearch {
    RangeSearch::new(Isa::Scalar(Scalar::new()))
}

/// A point in the unit cube.
fn any_point(rng: &mut Rng) -> [f32; 3] {
    [(); 3].map(|()| rng.unit() as f32)
}

/// Points in a cube, some in a plane, and some duplicates.
fn points(rng: &mut Rng, count: usize) -> Vec<[f32; 3]> {
    let mut points: Vec<[f32; 3]> = Vec::new();
    for i in 0..count {
        let point = any_point(rng);
        points.push(match i % 10 {
            7 => [point[0], -0.0, point[2]],
            8 => [point[0], 0.0, point[2]],
            9 => points[i / 2],
            _ => point,
        });
    }
    points
}
