//! Mutation test: kernels with one deliberate error each must fail the comparisons.

use super::*;
use crate::device::Program;
use alloc::string::String;

/// A string that occurs once in the source, and its replacement.
const MUTANTS: [[&str; 2]; 14] = [
    ["let two = lesser(four, four.zwxy);", "let two = four;"],
    ["vec4(0x80000000u), bits == vec4(0x80000000u)", "vec4(0x80000000u), bits == vec4(0x80000001u)"],
    ["select(old, at, is_point)", "at"],
    [
        "greatest(by_fours(refitted[node_of(child)].upper[axis]))",
        "greatest(by_fours(refitted[node_of(child)].lower[axis]))",
    ],
    ["(distance & ~15u) | lane", "(distance & ~0xffffffu) | lane"],
    ["if distance <= atomicLoad(&widest)", "if distance < atomicLoad(&widest)"],
    ["(square(x, y, z) <= vec4(ask.square))", "(square(x, y, z) < vec4(ask.square))"],
    ["select(0u, ask.query, search.each != 0u)", "0u"],
    ["atomicMax(&highest[axis], place[axis])", "atomicStore(&highest[axis], place[axis])"],
    ["for (var part = 1u; part < PARTS; part++)", "for (var part = 1u; part < PARTS - 1u; part++)"],
    ["select(0u, sum, other < part)", "select(0u, sum, other <= part)"],
    [
        "to = put_four(to, buckets[bucket].indices[2], mask >> 8u);",
        "to = put_four(to, buckets[bucket].indices[2], mask >> 9u);",
    ],
    ["plus(totals[packet / WORKGROUP], starts[number])", "starts[number]"],
    ["let sum = rounded(xx + yy);", "let sum = rounded(xx + zz);"],
];

fn mutated(number: usize) -> String {
    let source = shader::source();
    let Some([before, after]) = MUTANTS.get(number) else { return source };
    assert_eq!(source.matches(before).count(), 1, "{before}");
    source.replace(before, after)
}

/// Whether refit, seats, lists or neighbours differ from the CPU's.
fn differs(gpu: &Gpu, number: usize) -> bool {
    // A grid, for ties; zeros of both signs, and removed points.
    let side = |i: usize| {
        [i % 16, i / 16 % 16, i / 256].map(|c| if c == 0 && i.is_multiple_of(2) { -0.0 } else { c as f32 })
    };
    let mut points: Vec<[f32; 3]> = (0..4096).map(side).collect();
    let mut cloud = PointCloud::with_room(&points, 13, points.len()).unwrap();
    for index in (0..points.len() as u32).step_by(7) {
        cloud.remove(index).unwrap();
    }
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let kernels = shader::program().kernels;
    let program = Program { label: "mutants", variant: number, source: |number, _| mutated(number), kernels };
    on_device.compiled = gpu.compiled(&program).unwrap();
    let mut is_other = on_device.check_arithmetic().is_err();

    points.rotate_left(1);
    cloud.refit(&points).unwrap();
    on_device.refit(&points).unwrap();
    let nodes = on_device.nodes().unwrap();
    is_other |=
        bytemuck::cast_slice::<_, u32>(&nodes) != bytemuck::cast_slice::<_, u32>(cloud.view().nodes());

    let others: Vec<[f32; 3]> = points.iter().step_by(5).map(|p| p.map(|x| 1.1 * x - 0.3)).collect();
    let (mut seats, mut want) = (vec![Seat::default(); others.len()], vec![Seat::default(); others.len()]);
    scalar().seat(&cloud.view(), &others, &mut want).unwrap();
    on_device.seat(&others, &mut seats).unwrap();
    is_other |= seats != want;

    let each: Vec<f32> = (0..points.len()).map(|i| [1.0, 2.0, 1.5][i % 3]).collect();
    let (mut lists, mut want_lists) =
        (vec![List::default(); points.len()], vec![List::default(); points.len()]);
    let (mut indices, mut want) = (vec![0; 300_000], vec![0; 300_000]);
    let view = cloud.view();
    let work = scalar().fill(&view, &Queries::own(), Radii::Each(&each), &mut want_lists, &mut want).unwrap();
    let filled = on_device.fill(&Queries::own(), Radii::Each(&each), &mut lists, &mut indices);
    let total = work.neighbours as usize;
    is_other | filled.is_err() || lists != want_lists || indices[..total] != want[..total]
}

#[test]
fn a_wrong_kernel_is_noticed() {
    let Some(gpu) = device() else { return };
    assert!(!differs(gpu, MUTANTS.len()), "without any mutation");
    let survivors: Vec<_> =
        (0..MUTANTS.len()).filter(|&number| !differs(gpu, number)).map(|number| MUTANTS[number]).collect();
    assert!(survivors.is_empty(), "{survivors:#?}");
}
