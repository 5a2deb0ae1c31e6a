//! Compute shaders: source and pipelines.

use super::{DeviceError, Gpu};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// The source of kernels that are compiled together.
pub(crate) struct Program {
    /// Shown in a device's log.
    pub(crate) label: &'static str,
    /// The variant of the source.
    pub(crate) variant: usize,
    pub(crate) source: fn(usize, &Gpu) -> String,
    /// The entry points.
    pub(crate) kernels: Vec<&'static str>,
}

/// The kernels of a program, compiled.
#[derive(Debug)]
pub(crate) struct Compiled {
    label: &'static str,
    variant: usize,
    pipelines: Vec<wgpu::ComputePipeline>,
}

impl Compiled {
    fn new(gpu: &Gpu, program: &Program) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(program.label),
            source: wgpu::ShaderSource::Wgsl((program.source)(program.variant, gpu).into()),
        });
        let pipeline = |name: &&'static str| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(*name),
                layout: None,
                module: &module,
                entry_point: Some(*name),
                // Every kernel writes its workgroup's memory before it reads it.
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: None,
            })
        };
        let pipelines = program.kernels.iter().map(pipeline).collect();
        Self { label: program.label, variant: program.variant, pipelines }
    }

    /// The pipeline of kernel `number` of the program.
    pub(crate) fn pipeline(&self, number: usize) -> &wgpu::ComputePipeline {
        &self.pipelines[number]
    }

    /// Binds buffers to a kernel, each by its binding number.
    pub(crate) fn bind<'b>(
        &self,
        gpu: &Gpu,
        number: usize,
        buffers: impl Iterator<Item = (u32, wgpu::BindingResource<'b>)>,
    ) -> wgpu::BindGroup {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.pipeline(number).get_bind_group_layout(0),
            entries: &buffers.map(entry).collect::<Vec<_>>(),
        })
    }
}

impl Gpu {
    /// The program, compiled on first use, which takes some tenths of a second.
    pub(crate) fn compiled(&self, program: &Program) -> Result<Arc<Compiled>, DeviceError> {
        let is_it = |made: &&Arc<Compiled>| (made.label, made.variant) == (program.label, program.variant);
        if let Some(made) = self.programs().iter().find(is_it) {
            return Ok(made.clone());
        }
        let made = Arc::new(self.guarded(0, || Ok::<_, DeviceError>(Compiled::new(self, program)))?);
        // If another thread compiled it meanwhile, either result will do.
        self.programs().push(made.clone());
        Ok(made)
    }
}
