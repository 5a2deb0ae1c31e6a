//! Spheres inside meshes and around them.

use crate::body::mesh;
use crate::boundary::{answered, given, guarded, places};
use crate::error::{Failure, simdop_error};
use simdop::packing::{Filling, Packer};
use simdop::primitive::Sphere;
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// Called as a packing grows: `placed` of `asked` spheres fill `share` of the volume. Returns 0 to go on; anything else
/// ends the packing with SIMDOP_ERROR_PACK_STOPPED. It must return, without an exception or a longjmp().
pub type simdop_on_filling =
    Option<unsafe extern "C" fn(user: *mut c_void, placed: usize, asked: usize, share: f64) -> c_int>;

/// Disjoint spheres inside a mesh.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_packing {
    /// Number of spheres written.
    pub count: usize,
    /// The volume that the mesh encloses, in its unit cubed.
    pub volume: f64,
    /// The fraction of it that the spheres fill.
    pub share: f64,
}

fn write(spheres: &[Sphere], places: &mut [MaybeUninit<[f64; 4]>]) {
    for (place, sphere) in places.iter_mut().zip(spheres) {
        let [x, y, z] = sphere.centre;
        place.write([x, y, z, sphere.radius]);
    }
}

/// Fills a closed mesh with at most `room` disjoint spheres, roughly the largest first. `spheres` has room for x, y, z
/// and the radius of each, as simdop_body_build_spheres() takes them. The mesh is given as in
/// simdop_body_build_surface(). Writes fewer spheres if no other fits. `on_filling` may be NULL. The call allocates,
/// and takes seconds for thousands of spheres.
///
/// # Safety
/// The arrays have these lengths. `user`, which may be NULL, is what `on_filling` expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_pack(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    spheres: *mut f64,
    room: usize,
    on_filling: simdop_on_filling,
    user: *mut c_void,
    packing: Option<&mut MaybeUninit<simdop_packing>>,
) -> simdop_error {
    answered(packing, || {
        // SAFETY: the caller guarantees the lengths.
        let mesh = unsafe { mesh(vertices, vertex_count, triangles, triangle_count) }?;
        // SAFETY: the caller guarantees the room; four numbers in a row are aligned as one.
        let spheres = unsafe { places(spheres.cast(), room, "spheres") }?;
        let mut observer = |Filling { placed, asked, share }| {
            // SAFETY: the caller guarantees that `user` is what the function expects.
            match on_filling.map_or(0, |on_filling| unsafe { on_filling(user, placed, asked, share) }) {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let packing = Packer::new().spheres(room).pack_with(&mesh, &mut observer)?;
        write(&packing.spheres, spheres);
        let share = packing.shares().last().unwrap_or(0.0);
        Ok(simdop_packing { count: packing.spheres.len(), volume: packing.volume, share })
    })
}

/// Covers a mesh with spheres: they contain every point of it, and no point farther than `error` from it. If `is_solid`
/// is not zero, they cover the inside, too, and the mesh must be closed. If a body of these spheres does not meet
/// another body, neither does the mesh. The mesh is given as in simdop_body_build_surface().
///
/// Writes the number of spheres to `count`, even if it exceeds `room`, which is SIMDOP_ERROR_BUFFER. `spheres` has room
/// for x, y, z and the radius of `room` spheres. The call allocates.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cover(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    error: f64,
    is_solid: c_int,
    spheres: *mut f64,
    room: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    guarded(|| {
        let count = given(count, "count")?;
        // SAFETY: the caller guarantees the lengths.
        let mesh = unsafe { mesh(vertices, vertex_count, triangles, triangle_count) }?;
        // SAFETY: the caller guarantees the room; four numbers in a row are aligned as one.
        let places = unsafe { places(spheres.cast(), room, "spheres") }?;
        let cover = if is_solid == 0 { mesh.cover(error) } else { mesh.cover_solid(error) }?;
        count.write(cover.len());
        if cover.len() > room {
            let message = format!("{} spheres, and room for {room}", cover.len());
            return Err(Failure::new(simdop_error::Buffer, message));
        }
        write(&cover, places);
        Ok(())
    })
}
