// Moving points, and refitting boxes.

/// The lesser of each pair: the first if the second is NaN, and the second if both are equal. The scalar code merges
/// boxes in the same way.
fn lesser(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    return select(b, a, (order(a) < order(b) & !is_nan(a)) | is_nan(b));
}

fn greater(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    return select(b, a, (order(a) > order(b) & !is_nan(a)) | is_nan(b));
}

fn least(x: array<vec4<u32>, 4>) -> u32 {
    let four = lesser(lesser(x[0], x[2]), lesser(x[1], x[3]));
    let two = lesser(four, four.zwxy);
    return lesser(two, two.yxwz).x;
}

fn greatest(x: array<vec4<u32>, 4>) -> u32 {
    let four = greater(greater(x[0], x[2]), greater(x[1], x[3]));
    let two = greater(four, four.zwxy);
    return greater(two, two.yxwz).x;
}

/// Sixteen elements in groups of four.
fn by_fours(x: array<u32, 16>) -> array<vec4<u32>, 4> {
    return array(
        vec4(x[0], x[1], x[2], x[3]),
        vec4(x[4], x[5], x[6], x[7]),
        vec4(x[8], x[9], x[10], x[11]),
        vec4(x[12], x[13], x[14], x[15]),
    );
}

/// Moves each point. One thread for four slots of a bucket.
@compute @workgroup_size(WORKGROUP)
fn move_points(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups) * WORKGROUP + thread;
    let bucket = number / 4u;
    let quarter = number % 4u;
    if bucket >= arrayLength(&moved) {
        return;
    }
    let index = moved[bucket].indices[quarter];
    let is_point = index < vec4(arrayLength(&positions) / 3u);
    let first = 3u * select(vec4(0u), index, is_point);
    for (var axis = 0u; axis < 3u; axis++) {
        let at = vec4(
            positions[first.x + axis],
            positions[first.y + axis],
            positions[first.z + axis],
            positions[first.w + axis],
        );
        let old = moved[bucket].coordinates[axis][quarter];
        moved[bucket].coordinates[axis][quarter] = select(old, at, is_point);
    }
}

/// Refits the boxes of a level. One thread per lane.
@compute @workgroup_size(WORKGROUP)
fn refit(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups) * WORKGROUP + thread;
    if number / 16u >= level.count {
        return;
    }
    let node = level.first + number / 16u;
    let lane = number % 16u;
    let child = refitted[node].child[lane];
    if child == UNUSED {
        return;
    }
    for (var axis = 0u; axis < 3u; axis++) {
        var lower: u32;
        var upper: u32;
        if is_inner(child) {
            lower = least(by_fours(refitted[node_of(child)].lower[axis]));
            upper = greatest(by_fours(refitted[node_of(child)].upper[axis]));
        } else {
            let points = buckets[bucket_of(child)].coordinates[axis];
            lower = least(points);
            upper = greatest(points);
        }
        refitted[node].lower[axis][lane] = lower;
        refitted[node].upper[axis][lane] = upper;
    }
}
