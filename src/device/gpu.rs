//! A device, and its errors as values.

use super::{Compiled, DeviceError};
use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::time::Duration;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A device, with the kernels that it has compiled so far.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    programs: Mutex<Vec<Arc<Compiled>>>,
}

impl Gpu {
    /// The most powerful adapter there is: a GPU before a CPU. `WGPU_BACKEND` in the environment restricts
    /// the backends.
    ///
    /// # Errors
    /// [`DeviceError::NoAdapter`], and those of [`Gpu::with_adapter`].
    pub fn new() -> Result<Self, DeviceError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|error| DeviceError::NoAdapter { reason: error.to_string() })?;
        Self::with_adapter(&adapter)
    }

    /// A device of an adapter that the caller chose, with as large buffers as it has.
    ///
    /// # Errors
    /// [`DeviceError::Limit`], [`DeviceError::NoDevice`].
    pub fn with_adapter(adapter: &wgpu::Adapter) -> Result<Self, DeviceError> {
        let available = adapter.limits();
        check_limits(&available)?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("simdop"),
            required_features: adapter.features() & wgpu::Features::SHADER_INT64,
            required_limits: wgpu::Limits {
                max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
                max_buffer_size: available.max_buffer_size,
                ..needed_limits()
            },
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| DeviceError::NoDevice { reason: error.to_string() })?;
        Self::with_device(device, queue)
    }

    /// A device that the caller has, which may have other work too. 64-bit sums are native if its features
    /// have `SHADER_INT64`; its limits must be WebGPU's defaults for compute shaders at least.
    ///
    /// # Errors
    /// [`DeviceError::Limit`].
    pub fn with_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, DeviceError> {
        check_limits(&device.limits())?;
        Ok(Self { device, queue, programs: Mutex::new(Vec::new()) })
    }

    /// Name, driver and kind of the adapter.
    #[must_use]
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.device.adapter_info()
    }

    /// Whether sums of 64 bits are native, not two words with a carry. Results are the same.
    #[must_use]
    pub fn has_int64(&self) -> bool {
        self.device.features().contains(wgpu::Features::SHADER_INT64)
    }

    /// What was compiled so far.
    pub(super) fn programs(&self) -> MutexGuard<'_, Vec<Arc<Compiled>>> {
        // A thread that panicked has pushed, or it has not.
        self.programs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `work`, and returns what the device has to object rather than to leave it to the device's
    /// handler, which panics. `bytes` are allocated by it.
    pub(crate) fn guarded<T, E: From<DeviceError>>(
        &self,
        bytes: u64,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [Internal, Validation, OutOfMemory].map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // The last is the innermost. What follows from a lack of memory is no news.
        let errors: Vec<wgpu::Error> =
            scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
        match errors.first() {
            None => result,
            Some(wgpu::Error::OutOfMemory { .. }) => Err(DeviceError::OutOfMemory { bytes }.into()),
            // A lost device says nothing itself; what is made on it is invalid.
            Some(_) if self.is_lost() => Err(DeviceError::Lost.into()),
            Some(error) => Err(DeviceError::Device { reason: error.to_string() }.into()),
        }
    }

    /// Whether the device cannot even map four bytes.
    fn is_lost(&self) -> bool {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let probe = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("simdop probe"),
            size: 4,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let lost = self.read(&probe, 4, |_| ()).is_err();
        let _ = pollster::block_on(scope.pop());
        lost
    }

    /// The bytes of `buffer`, which is mapped for that, as soon as all that was submitted is done.
    pub(crate) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        use_bytes: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, DeviceError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        let slice = buffer.slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens any more if the device was lost in between.
            let _ = sender.send(result);
        });
        self.wait()?;
        // The callback runs in whichever thread polls the device: maybe in another one that has not come to
        // it yet.
        match receiver.recv_timeout(Duration::from_secs(10)) {
            Ok(Ok(())) => {}
            _ => return Err(DeviceError::Lost),
        }
        let view = slice.get_mapped_range().map_err(|_| DeviceError::Lost)?;
        let result = use_bytes(&view);
        drop(view);
        buffer.unmap();
        Ok(result)
    }

    /// Until all that was submitted is done.
    pub(crate) fn wait(&self) -> Result<(), DeviceError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(|_| DeviceError::Lost)
    }
}

/// What the kernels need, by the limits' names: within the defaults of WebGPU, which every adapter has but
/// the oldest.
fn needed_limits() -> wgpu::Limits {
    wgpu::Limits {
        max_storage_buffers_per_shader_stage: 8,
        max_compute_workgroup_storage_size: 16 << 10,
        max_compute_invocations_per_workgroup: 256,
        max_compute_workgroup_size_x: 256,
        max_compute_workgroup_size_y: 1,
        max_compute_workgroup_size_z: 1,
        max_compute_workgroups_per_dimension: 65_535,
        ..wgpu::Limits::downlevel_webgl2_defaults()
    }
}

fn check_limits(available: &wgpu::Limits) -> Result<(), DeviceError> {
    // Only these: a device may be made for compute shaders alone. Buffers are checked when they are made.
    let needed = needed_limits();
    let check = |name, of: fn(&wgpu::Limits) -> u32| {
        let (needed, available) = (of(&needed).into(), of(available).into());
        if needed > available { Err(DeviceError::Limit { name, needed, available }) } else { Ok(()) }
    };
    check("max_storage_buffers_per_shader_stage", |l| l.max_storage_buffers_per_shader_stage)?;
    check("max_compute_workgroup_storage_size", |l| l.max_compute_workgroup_storage_size)?;
    check("max_compute_invocations_per_workgroup", |l| l.max_compute_invocations_per_workgroup)?;
    check("max_compute_workgroup_size_x", |l| l.max_compute_workgroup_size_x)?;
    check("max_compute_workgroups_per_dimension", |l| l.max_compute_workgroups_per_dimension)
}
