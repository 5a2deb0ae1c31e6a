//! Kernels: their text, and the pipelines made of it.

use super::{DeviceError, Gpu};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// The text of some kernels that are compiled together.
pub(crate) struct Program {
    /// For those who look at a device's log.
    pub(crate) label: &'static str,
    /// Which of the texts of this label.
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

    /// Kernel `number` of the program's.
    pub(crate) fn pipeline(&self, number: usize) -> &wgpu::ComputePipeline {
        &self.pipelines[number]
    }

    /// A kernel's view of buffers, each with its number in the text.
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
    /// Compiled when first needed: some tenths of a second.
    pub(crate) fn compiled(&self, program: &Program) -> Result<Arc<Compiled>, DeviceError> {
        let is_it = |made: &&Arc<Compiled>| (made.label, made.variant) == (program.label, program.variant);
        if let Some(made) = self.programs().iter().find(is_it) {
            return Ok(made.clone());
        }
        let made = Arc::new(self.guarded(0, || Ok::<_, DeviceError>(Compiled::new(self, program)))?);
        // Should another thread have been faster, either will do.
        self.programs().push(made.clone());
        Ok(made)
    }
}
