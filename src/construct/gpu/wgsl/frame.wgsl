// From positions in the tree to local coordinates in a node.

const BOX_WORDS = 7u;

var<workgroup> reached: array<atomic<u32>, BOX_WORDS>;

fn position(index: u32) -> vec3<u32> {
    return vec3(positions[3u * index], positions[3u * index + 1u], positions[3u * index + 2u]);
}

/// The box of the primitives of each node. `boxes` starts as zeros.
@compute @workgroup_size(WORKGROUP)
fn bounds(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.chunks {
        return;
    }
    if thread < BOX_WORDS {
        atomicStore(&reached[thread], 0u);
    }
    workgroupBarrier();
    let chunk = chunks[number];
    var below = vec3(0u);
    var high = vec3(0u);
    var heaviest = 1u;
    for (var i = thread; i < chunk.count; i += WORKGROUP) {
        let index = order[chunk.start + i];
        let p = position(index);
        below = max(below, ~p);
        high = max(high, p);
        if level.weighted != 0u {
            heaviest = max(heaviest, weights[index]);
        }
    }
    if thread < chunk.count {
        for (var axis = 0u; axis < 3u; axis++) {
            atomicMax(&reached[axis], below[axis]);
            atomicMax(&reached[3u + axis], high[axis]);
        }
        atomicMax(&reached[6], heaviest);
    }
    workgroupBarrier();
    if thread < BOX_WORDS {
        atomicMax(&boxes[BOX_WORDS * chunk.node + thread], atomicLoad(&reached[thread]));
    }
}

fn low_corner(node: u32) -> vec3<u32> {
    let first = BOX_WORDS * node;
    return ~vec3(atomicLoad(&boxes[first]), atomicLoad(&boxes[first + 1u]), atomicLoad(&boxes[first + 2u]));
}

fn high_corner(node: u32) -> vec3<u32> {
    let first = BOX_WORDS * node + 3u;
    return vec3(atomicLoad(&boxes[first]), atomicLoad(&boxes[first + 1u]), atomicLoad(&boxes[first + 2u]));
}

fn bit_length(a: u32) -> u32 {
    return 32u - countLeadingZeros(a);
}

/// a - b, or 0.
fn excess(a: u32, b: u32) -> u32 {
    return max(a, b) - b;
}

/// The finaliser of MurmurHash3.
fn scramble(number: u32) -> u32 {
    var x = number;
    x = (x ^ x >> 16u) * 0x85ebca6bu;
    x = (x ^ x >> 13u) * 0xc2b2ae35u;
    return x ^ x >> 16u;
}

/// random * (extent + 1) / 2^32, for extents below 2^15.
fn anywhere(random: u32, extent: u32) -> u32 {
    let size = extent + 1u;
    return ((random >> 16u) * size + ((random & 0xffffu) * size >> 16u)) >> 16u;
}

/// The frame of each node, and the initial positions of its prototypes. One invocation per lane.
@compute @workgroup_size(WORKGROUP)
fn start(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let i = group_number(group, groups) * WORKGROUP + thread;
    let node = i / LANES;
    let lane = i % LANES;
    if node >= level.nodes {
        return;
    }
    let size = high_corner(node) - low_corner(node);
    let longest = max(size.x, max(size.y, size.z));
    let shift = excess(bit_length(longest), LOCAL_BITS);
    if lane == 0u {
        let bits = min(WEIGHT_BITS, WEIGHT_SUM_BITS - bit_length(nodes[node].count));
        let weight_shift = excess(bit_length(atomicLoad(&boxes[BOX_WORDS * node + 6u])), bits);
        states[node] = State(shift, weight_shift, 0u, select(MOVING, SMALL, longest < MIN_EXTENT));
    }
    var at: vec3<u32>;
    for (var axis = 0u; axis < 3u; axis++) {
        let number = (nodes[node].number * LANES + lane) * 3u + axis;
        let random = scramble(scramble(number) ^ scramble(~level.seed));
        at[axis] = anywhere(random, size[axis] >> shift);
    }
    prototypes[i] = packed(at, 0u);
}

/// Local coordinates, and weights of at least 1.
@compute @workgroup_size(WORKGROUP)
fn local_coordinates(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.chunks {
        return;
    }
    let chunk = chunks[number];
    let low = low_corner(chunk.node);
    let state = states[chunk.node];
    for (var i = chunk.start + thread; i < chunk.start + chunk.count; i += WORKGROUP) {
        let index = order[i];
        var weight = 1u;
        if level.weighted != 0u {
            weight = max(weights[index] >> state.weight_shift, 1u);
        }
        places[i] = packed((position(index) - low) >> vec3(state.shift), weight);
    }
}
