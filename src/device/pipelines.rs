//! Compute shaders: source and pipelines.

use alloc::string::String;
use alloc::vec::Vec;

/// The source of kernels that are compiled together.
pub(crate) struct Program {
    /// Shown in a device's log.
    pub(crate) label: &'static str,
    /// The variant of the source.
    pub(crate) variant: usize,
    /// Called with the variant and whether 64-bit integers are native.
    pub(crate) source: fn(usize, bool) -> String,
    /// The entry points.
    pub(crate) kernels: Vec<&'static str>,
}

/// The kernels of a program, compiled.
#[derive(Debug)]
pub(crate) struct Compiled {
    pub(super) label: &'static str,
    pub(super) variant: usize,
    pipelines: Vec<wgpu::ComputePipeline>,
}

impl Compiled {
    pub(super) fn new(device: &wgpu::Device, has_int64: bool, program: &Program) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(program.label),
            source: wgpu::ShaderSource::Wgsl((program.source)(program.variant, has_int64).into()),
        });
        let pipeline = |name: &&'static str| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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
        device: &wgpu::Device,
        number: usize,
        buffers: impl Iterator<Item = (u32, wgpu::BindingResource<'b>)>,
    ) -> wgpu::BindGroup {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.pipeline(number).get_bind_group_layout(0),
            entries: &buffers.map(entry).collect::<Vec<_>>(),
        })
    }
}
