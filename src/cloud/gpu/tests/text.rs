//! The shader source against the assumptions of the host.

use super::*;
use wgpu::naga;

/// Parses and validates the source; needs no adapter.
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
        // No more than every device can bind.
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

/// The number of sums and differences of floats, and the number of their operands that are exposed float results:
/// neither converted from bits nor hidden from the compiler by `rounded`.
fn sums_and_exposed(source: &str) -> (usize, usize) {
    use naga::{BinaryOperator as Op, Expression as E};
    let module = naga::front::wgsl::parse_str(source).unwrap();
    let (mut sums, mut exposed) = (0, 0);
    for (_, function) in module.functions.iter() {
        if !matches!(function.name.as_deref(), Some("square" | "difference")) {
            continue;
        }
        let values = &function.expressions;
        for (_, value) in values.iter() {
            let E::Binary { op: Op::Add | Op::Subtract, left, right } = value else { continue };
            sums += 1;
            let is_hidden = |operand| matches!(values[operand], E::CallResult(_) | E::As { .. });
            exposed += [*left, *right].into_iter().filter(|operand| !is_hidden(*operand)).count();
        }
    }
    (sums, exposed)
}

/// All float arithmetic is in two functions.
#[test]
fn no_operation_can_be_fused_with_another() {
    let source = shader::source();
    assert_eq!(sums_and_exposed(&source), (3, 0));
    for (guarded, bare) in
        [("rounded(x * x)", "x * x"), ("rounded(z * z)", "z * z"), ("rounded(xx + yy)", "xx + yy")]
    {
        assert_eq!(source.matches(guarded).count(), 1);
        let (_, exposed) = sums_and_exposed(&source.replace(guarded, bare));
        assert_eq!(exposed, 1, "{guarded}");
    }
    let float = |line: &&str| line.contains("f32") && !line.trim_start().starts_with("//");
    let stray = [
        include_str!("../wgsl/refit.wgsl"),
        include_str!("../wgsl/seat.wgsl"),
        include_str!("../wgsl/search.wgsl"),
    ];
    assert!(stray.iter().all(|text| text.lines().filter(float).count() == 0));
}
