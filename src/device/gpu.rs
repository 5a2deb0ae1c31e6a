//! A device, and its errors as values.

use super::{Compiled, DeviceError, Program};
use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::time::Duration;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A device, with the kernels compiled so far.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    programs: Mutex<Vec<Arc<Compiled>>>,
}

impl Gpu {
    /// Opens the most powerful adapter, preferring a GPU to a CPU. The environment variable `WGPU_BACKEND` restricts
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

    /// Opens a device of the given adapter, with the largest buffers that it supports.
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

    /// Uses an existing device, which may run other work too. 64-bit sums are native if its features include
    /// `SHADER_INT64`. Its limits must be at least WebGPU's defaults for compute shaders.
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

    /// Whether 64-bit sums are native, instead of two words with a carry. Results are the same.
    #[must_use]
    pub fn has_int64(&self) -> bool {
        self.device.features().contains(wgpu::Features::SHADER_INT64)
    }

    /// The program, compiled on first use, which takes some tenths of a second.
    pub(crate) fn compiled(&self, program: &Program) -> Result<Arc<Compiled>, DeviceError> {
        let is_it = |made: &&Arc<Compiled>| (made.label, made.variant) == (program.label, program.variant);
        if let Some(made) = self.programs().iter().find(is_it) {
            return Ok(made.clone());
        }
        let made =
            Arc::new(self.guarded(0, || {
                Ok::<_, DeviceError>(Compiled::new(&self.device, self.has_int64(), program))
            })?);
        // If another thread compiled it meanwhile, either result will do.
        self.programs().push(made.clone());
        Ok(made)
    }

    /// The programs compiled so far.
    fn programs(&self) -> MutexGuard<'_, Vec<Arc<Compiled>>> {
        // Safe after a panic: a push has either happened or not.
        self.programs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `work` and returns the device's errors as values; otherwise the device's default handler would panic.
    /// `bytes` is the size that `work` allocates, for the error message.
    pub(crate) fn guarded<T, E: From<DeviceError>>(
        &self,
        bytes: u64,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [Internal, Validation, OutOfMemory].map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // The last scope is the innermost. A lack of memory comes first, since other errors follow from it.
        let errors: Vec<wgpu::Error> =
            scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
        match errors.first() {
            None => result,
            Some(wgpu::Error::OutOfMemory { .. }) => Err(DeviceError::OutOfMemory { bytes }.into()),
            // A lost device does not report it directly, but everything created on it is invalid.
            Some(_) if self.is_lost() => Err(DeviceError::Lost.into()),
            Some(error) => Err(DeviceError::Device { reason: error.to_string() }.into()),
        }
    }

    /// Whether the device fails to map even four bytes.
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

    /// Waits for all submitted work, maps `buffer`, and calls `use_bytes` with its bytes.
    pub(crate) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        use_bytes: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, DeviceError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        let slice = buffer.slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone if the device was lost in between.
            let _ = sender.send(result);
        });
        self.wait()?;
        // The callback runs in the thread that polls the device, which may be another one that has not reached it
        // yet.
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

    /// Waits for all submitted work.
    pub(crate) fn wait(&self) -> Result<(), DeviceError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(|_| DeviceError::Lost)
    }
}

/// The limits that the kernels need. They are within WebGPU's defaults, which all but the oldest adapters support.
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
    // Check only these: a device may be for compute shaders only. Buffer sizes are checked on creation.
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
