// Seats: the nearest bucket of a query that is not a point of the cloud.

fn lower_of(node: u32, lane: u32) -> vec3<u32> {
    return vec3(nodes[node].lower[0][lane], nodes[node].lower[1][lane], nodes[node].lower[2][lane]);
}

fn upper_of(node: u32, lane: u32) -> vec3<u32> {
    return vec3(nodes[node].upper[0][lane], nodes[node].upper[1][lane], nodes[node].upper[2][lane]);
}

/// Whether a lane links to points that were not all removed.
fn holds(child: u32, lower: vec3<u32>) -> bool {
    return child != UNUSED && !is_nan(vec4(lower, 0u)).x;
}

/// Descends to the lane whose box is nearest, the first of equals. Squares so small that the device may have flushed
/// parts of them to 0 cannot be compared here: if they matter, the seat is UNSURE, and the host finds it.
@compute @workgroup_size(WORKGROUP)
fn seat(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups) * WORKGROUP + thread;
    if number >= search.count {
        return;
    }
    let point = asks[number].xyz;
    let place = order(vec4(point, 0u)).xyz;
    var node = 0u;
    // No tree is deeper.
    for (var depth = 0u; depth < MAX_DEPTH; depth++) {
        // The least square, with the lane in its low bits.
        var nearest = UNUSED;
        var is_inside = false;
        // Number of lanes with uncertain squares before the first lane that contains the point. Later lanes are no
        // nearer.
        var unsure = 0u;
        for (var lane = 0u; lane < 16u; lane++) {
            let child = nodes[node].child[lane];
            let lower = lower_of(node, lane);
            let upper = upper_of(node, lane);
            if is_inside || !holds(child, lower) {
                continue;
            }
            // Do not test the square: it may be 0 for points outside.
            if all(order(vec4(lower, 0u)).xyz <= place) && all(order(vec4(upper, 0u)).xyz >= place) {
                is_inside = true;
                nearest = lane;
                continue;
            }
            let distance = box_square(lower, upper, point, point);
            unsure += select(0u, 1u, distance < SURE_SQUARE);
            nearest = min(nearest, (distance & ~15u) | lane);
        }
        // A single uncertain lane is nearer than all with certain squares.
        if unsure > select(1u, 0u, is_inside) {
            seats[number] = UNSURE;
            return;
        }
        let child = nodes[node].child[nearest & 15u];
        if nearest == UNUSED || child == UNUSED {
            break;
        }
        if !is_inner(child) {
            seats[number] = bucket_of(child);
            return;
        }
        node = node_of(child);
    }
    seats[number] = 0u;
}
