// From prototypes to the order of the next level.

/// Primitives of each lane in this workgroup's chunk.
var<workgroup> members: array<atomic<u32>, LANES>;
/// For each lane, the threads whose primitives of a batch are in it, one bit each.
var<workgroup> masks: array<atomic<u32>, LANES * MASK_WORDS>;
/// The destination of the next primitive of each lane.
var<workgroup> next: array<u32, LANES>;

const MASK_WORDS = WORKGROUP / 32u;

/// The lane of each primitive, and the number of primitives of each chunk in each lane.
@compute @workgroup_size(WORKGROUP)
fn nearest(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.chunks {
        return;
    }
    let chunk = chunks[number];
    if thread < LANES {
        atomicStore(&members[thread], 0u);
    }
    load_prototypes(chunk.node, thread);
    for (var i = chunk.start + thread; i < chunk.start + chunk.count; i += WORKGROUP) {
        let lane = nearest_lane(unpacked(places[i]));
        lanes[i] = lane;
        atomicAdd(&members[lane], 1u);
    }
    workgroupBarrier();
    if thread < LANES {
        counts[number * LANES + thread] = atomicLoad(&members[thread]);
    }
}

/// The ends of the lanes of each node, and in `counts` the destination of each chunk's first primitive of each lane. A
/// node with only one used lane must be cut by axes.
@compute @workgroup_size(WORKGROUP)
fn lane_ends(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.nodes {
        return;
    }
    var outcome = state_of(number, thread).outcome;
    let node = nodes[number];
    let last_chunk = node.first_chunk + node.chunks;
    if thread < LANES {
        var size = 0u;
        for (var chunk = node.first_chunk; chunk < last_chunk; chunk++) {
            size += counts[chunk * LANES + thread];
        }
        next[thread] = size;
    }
    workgroupBarrier();
    if thread >= LANES {
        return;
    }
    var start = 0u;
    for (var lane = 0u; lane < LANES; lane++) {
        if next[lane] == node.count && outcome < SMALL {
            outcome = ONE_LANE;
        }
        start += select(0u, next[lane], lane < thread);
    }
    if outcome >= SMALL {
        states[number].outcome = outcome;
        ends[number * LANES + thread] = outcome;
        return;
    }
    ends[number * LANES + thread] = start + next[thread];
    var place = node.start + start;
    for (var chunk = node.first_chunk; chunk < last_chunk; chunk++) {
        let size = counts[chunk * LANES + thread];
        counts[chunk * LANES + thread] = place;
        place += size;
    }
}

/// Moves the primitives of each lane together, in their previous order.
@compute @workgroup_size(WORKGROUP)
fn sort_by_lane(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.chunks {
        return;
    }
    let chunk = chunks[number];
    if state_of(chunk.node, thread).outcome >= SMALL {
        return;
    }
    if thread < LANES {
        next[thread] = counts[number * LANES + thread];
    }
    workgroupBarrier();
    for (var first = 0u; first < chunk.count; first += WORKGROUP) {
        for (var i = thread; i < LANES * MASK_WORDS; i += WORKGROUP) {
            atomicStore(&masks[i], 0u);
        }
        workgroupBarrier();
        let i = chunk.start + first + thread;
        let here = first + thread < chunk.count;
        var lane = 0u;
        if here {
            lane = lanes[i];
            atomicOr(&masks[lane * MASK_WORDS + thread / 32u], 1u << (thread % 32u));
        }
        workgroupBarrier();
        if here {
            sorted[next[lane] + earlier(lane, thread)] = order[i];
        }
        workgroupBarrier();
        if thread < LANES {
            next[thread] += earlier(thread, WORKGROUP);
        }
        workgroupBarrier();
    }
}

/// Members of a lane in the batch with threads below `thread`.
fn earlier(lane: u32, thread: u32) -> u32 {
    var count = 0u;
    for (var word = 0u; word < thread / 32u; word++) {
        count += countOneBits(atomicLoad(&masks[lane * MASK_WORDS + word]));
    }
    if thread % 32u != 0u {
        let below = (1u << (thread % 32u)) - 1u;
        count += countOneBits(atomicLoad(&masks[lane * MASK_WORDS + thread / 32u]) & below);
    }
    return count;
}

/// Copies `sorted` to `order`.
@compute @workgroup_size(WORKGROUP)
fn replace(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.chunks {
        return;
    }
    let chunk = chunks[number];
    if states[chunk.node].outcome >= SMALL {
        return;
    }
    for (var i = chunk.start + thread; i < chunk.start + chunk.count; i += WORKGROUP) {
        order[i] = sorted[i];
    }
}
