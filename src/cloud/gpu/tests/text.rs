//! What the text of the shaders says, beside what the host takes for granted.

use super::*;
use wgpu::naga;

/// Parsed and validated, without an adapter.
fn module() -> naga::Module {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let source = shader::source();
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    assert!(checked.is_ok(), "{checked:?}");
    module
}

#[test]
fn the_kernels_are_valid_and_named_as_here() {
    let module = module();
    let names: Vec<&str> = module.entry_points.iter().map(|entry| &*entry.name).collect();
    assert_eq!(names.len(), CloudShader::ALL.len());
    for kernel in CloudShader::ALL {
        let (name, bindings) = kernel.interface();
        assert!(names.contains(&name), "{kernel:?}");
        // As many as every device binds.
        let storage =
            |binding: &&CloudBinding| !matches!(binding, CloudBinding::Search | CloudBinding::Level);
        assert!(bindings.iter().filter(storage).count() <= 8, "{kernel:?}");
    }
    for (_, variable) in module.global_variables.iter() {
        if let (Some(name), Some(binding)) = (&variable.name, &variable.binding) {
            let own = format!("{:?}", CloudBinding::ALL[binding.binding as usize]);
            assert_eq!(name.replace('_', ""), own.to_lowercase());
        }
    }
}

#[test]
fn structures_are_laid_out_as_in_the_kernels() {
    let module = module();
    let own = [
        ("Node", vec![0, 192, 384, 448], size_of::<Aabb16>()),
        ("Bucket", vec![0, 192], size_of::<Bucket>()),
        ("Search", (0..7).map(|i| 4 * i).collect(), size_of::<SearchData>()),
        ("Level", vec![0, 4], 8),
    ];
    for (name, offsets, size) in own {
        let named = |(_, kind): &(_, &naga::Type)| kind.name.as_deref() == Some(name);
        let (_, kind) = module.types.iter().find(named).unwrap();
        let naga::TypeInner::Struct { members, span } = &kind.inner else { panic!("{name}") };
        let got: Vec<u32> = members.iter().map(|member| member.offset).collect();
        assert_eq!((got, *span as usize), (offsets, size), "{name}");
    }
    use core::mem::offset_of;
    assert_eq!(
        [offset_of!(Aabb16, upper), offset_of!(Aabb16, built), offset_of!(Aabb16, child)],
        [192, 384, 448]
    );
    assert_eq!(offset_of!(Bucket, indices), 192);
    assert_eq!(
        [offset_of!(SearchData, own), offset_of!(SearchData, each), offset_of!(SearchData, start)],
        [8, 12, 24]
    );
    assert_eq!(size_of::<TreeLevel>(), 256);
}

/// No sum and no difference of floats takes another result of floats as it is: each comes from bits, or from the function that hides
/// them from the compiler.
#[test]
fn no_operation_can_be_fused_with_another() {
    use naga::{BinaryOperator as Op, Expression as E};
    let module = module();
    let mut sums = 0;
    for (_, function) in module.functions.iter() {
        let values = &function.expressions;
        for (handle, value) in values.iter() {
            let E::Binary { op: Op::Add | Op::Subtract, left, right } = value else { continue };
            if matches!(function.name.as_deref(), Some("square" | "difference")) {
                sums += 1;
                for operand in [*left, *right] {
                    assert!(
                        matches!(values[operand], E::CallResult(_) | E::As { .. }),
                        "{handle:?} of {:?}: {:?}",
                        function.name,
                        values[operand]
                    );
                }
            }
        }
    }
    assert_eq!(sums, 3);
}
