// The square of a distance, with every operation rounded, and none fused or reordered.
//
// WGSL allows a compiler to fuse a product with a sum, and to reorder sums. It cannot know the bits of a result
// before computing it, so each result goes through a bit operation with a number that the compiler does not know.

fn rounded(x: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) ^ vec4(search.zero));
}

/// The bits of (x * x + y * y) + z * z, which are ordered as the squares are.
fn square(x: vec4<f32>, y: vec4<f32>, z: vec4<f32>) -> vec4<u32> {
    let xx = rounded(x * x);
    let yy = rounded(y * y);
    let zz = rounded(z * z);
    let sum = rounded(xx + yy);
    return bitcast<vec4<u32>>(sum + zz);
}

fn difference(a: vec4<u32>, b: vec4<u32>) -> vec4<f32> {
    return rounded(bitcast<vec4<f32>>(a) - bitcast<vec4<f32>>(b));
}

/// The gap between boxes along an axis: the maximum of 0 and both differences, compared as integers.
fn gap(lower: vec4<u32>, upper: vec4<u32>, query_lower: vec4<u32>, query_upper: vec4<u32>) -> vec4<f32> {
    let below = bitcast<vec4<i32>>(difference(lower, query_upper));
    let above = bitcast<vec4<i32>>(difference(query_lower, upper));
    return bitcast<vec4<f32>>(max(max(below, above), vec4(0i)));
}

/// The squared distance between a lane's box, which must not be NaN, and a query's box.
fn box_square(lower: vec3<u32>, upper: vec3<u32>, query_lower: vec3<u32>, query_upper: vec3<u32>) -> u32 {
    // One axis per component.
    let gaps = gap(vec4(lower, 0u), vec4(upper, 0u), vec4(query_lower, 0u), vec4(query_upper, 0u));
    return square(vec4(gaps.x), vec4(gaps.y), vec4(gaps.z)).x;
}

/// Squares computed on this device, for comparison with the CPU's.
@compute @workgroup_size(WORKGROUP)
fn arithmetic(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= search.count {
        return;
    }
    // Each vector is the difference of two points.
    let from_point = asks[2u * id.x];
    let to_point = asks[2u * id.x + 1u];
    let apart = difference(from_point, to_point);
    results[id.x] = square(vec4(apart.x), vec4(apart.y), vec4(apart.z)).x;
}
