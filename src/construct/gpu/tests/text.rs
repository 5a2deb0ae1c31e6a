//! The source of the shaders, compared with the assumptions of the host.

use super::*;

/// Parsed and validated, without an adapter.
fn modules() -> Vec<wgpu::naga::Module> {
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
    let mut modules = Vec::new();
    for lanes in [4, 16] {
        for (int64, capabilities) in
            [(Int64::Native, Capabilities::SHADER_INT64), (Int64::Pairs, Capabilities::empty())]
        {
            let source = shader::source(lanes, int64);
            let module = wgpu::naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
            let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
            assert!(checked.is_ok(), "{lanes} lanes, {int64:?}: {checked:?}");
            modules.push(module);
        }
    }
    modules
}

#[test]
fn the_kernels_are_valid_and_named_as_here() {
    for module in modules() {
        let names: Vec<&str> = module.entry_points.iter().map(|entry| &*entry.name).collect();
        assert_eq!(names.len(), Shader::ALL.len());
        for kernel in Shader::ALL {
            assert!(names.contains(&kernel.interface().0), "{kernel:?}");
        }
        for (_, variable) in module.global_variables.iter() {
            if let (Some(name), Some(binding)) = (&variable.name, &variable.binding) {
                let own = std::format!("{:?}", Binding::ALL[binding.binding as usize]);
                assert_eq!(name.replace('_', ""), own.to_lowercase());
            }
        }
    }
}

/// Names and places of a type's fields, and its size.
macro_rules! layout {
    ($type:ty: $($field:ident)*) => {
        (
            vec![$((stringify!($field), core::mem::offset_of!($type, $field) as u32)),*],
            size_of::<$type>() as u32,
        )
    };
}

#[test]
fn structures_are_laid_out_as_in_the_kernels() {
    let own = [
        ("Level", layout!(memory::LevelData: nodes large_nodes chunks large_chunks seed leaf_size weighted)),
        ("Node", layout!(NodeData: start count number first_chunk chunks)),
        ("Chunk", layout!(Chunk: node start count)),
        ("State", layout!(State: shift weight_shift step outcome)),
    ];
    for module in modules() {
        for (name, want) in &own {
            let named = |(_, kind): &(_, &wgpu::naga::Type)| kind.name.as_deref() == Some(*name);
            let (_, kind) = module.types.iter().find(named).unwrap();
            let wgpu::naga::TypeInner::Struct { members, span } = &kind.inner else { panic!("{name}") };
            let got = members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset)).collect();
            assert_eq!((got, *span), *want, "{name}");
        }
    }
}

/// The sizes that the documentation of the module states.
#[test]
fn memory_is_a_number_of_bytes_for_each_primitive() {
    for (lanes, most) in [(4, 69), (16, 61)] {
        for primitives in [1 << 20, 1 << 27] {
            let sizes = Sizes { primitives, lanes, weighted: true, schedule: LIMITS.steps * lanes };
            let bytes = sizes.total() as usize;
            assert!(
                bytes < most * primitives && bytes > (most - 1) * primitives,
                "{} a primitive",
                bytes as f64 / primitives as f64
            );
        }
    }
}
