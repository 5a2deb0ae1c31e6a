// Distances, ranks, sums, and the motion of the prototypes.

/// Threads that share a lane's sum.
const SLICES = WORKGROUP / LANES;
const QUADS = LANES / 4u;
/// Number of sums of a node: of weights, then of the moments of each axis.
const SUMS = 4u * LANES;

/// Ranks of a batch of primitives, 4 bits each, and their places.
var<workgroup> batch: array<vec4<u32>, WORKGROUP>;
/// h of each rank.
var<workgroup> h: array<u32, LANES>;
/// Prototypes.
var<workgroup> at: array<vec3<u32>, LANES>;
/// Each thread's part of each sum.
var<workgroup> shares: array<U64, max(4u * WORKGROUP, UPDATE_WORKGROUP)>;
var<workgroup> sums: array<U64, SUMS>;
var<workgroup> moved: atomic<u32>;
var<workgroup> has_moved: u32;
var<workgroup> state: State;

/// Squared distance from a prototype.
fn distance_to(lane: u32, p: vec3<u32>) -> u32 {
    // Differences have a sign; their squares do not depend on it, modulo 2^32.
    let d = at[lane] - p;
    return d.x * d.x + d.y * d.y + d.z * d.z;
}

/// The nearest prototype; of two equally near ones, the one with the lower index.
fn nearest_lane(p: vec3<u32>) -> u32 {
    var lane = 0u;
    var least = distance_to(0u, p);
    for (var other = 1u; other < LANES; other++) {
        let distance = distance_to(other, p);
        lane = select(lane, other, distance < least);
        least = min(least, distance);
    }
    return lane;
}

/// For each prototype, the number of prototypes nearer to p; 4 bits per lane.
fn ranks(p: vec3<u32>) -> vec2<u32> {
    if h[1] == 0u {
        // Only the nearest prototype is pulled: any rank will do for the others.
        let lane = nearest_lane(p);
        let one = 1u << (4u * (lane & 7u));
        return vec2(0x11111111u) - select(vec2(one, 0u), vec2(0u, one), lane >= 8u);
    }
    var distances: array<vec4<u32>, QUADS>;
    for (var q = 0u; q < QUADS; q++) {
        let lane = 4u * q;
        distances[q] = vec4(
            distance_to(lane, p), distance_to(lane + 1u, p), distance_to(lane + 2u, p), distance_to(lane + 3u, p)
        );
    }
    // Groups of four, in loops of constant length: compilers unroll them, and keep the distances in registers.
    var packed = vec2(0u);
    for (var q = 0u; q < QUADS; q++) {
        var rank = vec4(0u);
        for (var r = 0u; r < QUADS; r++) {
            // Of equal distances, the one with the lower index counts as less.
            let own = distances[q] + u32(r < q);
            let same = u32(r == q);
            let other = distances[r];
            rank += vec4<u32>(vec4(other.x) < own + same * vec4(0u, 1u, 1u, 1u));
            rank += vec4<u32>(vec4(other.y) < own + same * vec4(0u, 0u, 1u, 1u));
            rank += vec4<u32>(vec4(other.z) < own + same * vec4(0u, 0u, 0u, 1u));
            rank += vec4<u32>(vec4(other.w) < own);
        }
        let four = rank << (vec4(0u, 4u, 8u, 12u) + 16u * (q & 1u));
        let bits = four.x | four.y | four.z | four.w;
        packed |= select(vec2(bits, 0u), vec2(0u, bits), q >= 2u);
    }
    return packed;
}

/// The sums over a range of `places`, for the prototypes `at` and the pulls `h`.
fn add_up(start: u32, count: u32, thread: u32) {
    let lane = thread % LANES;
    let slice = thread / LANES;
    var own = array(widened(0u), widened(0u), widened(0u), widened(0u));
    for (var first = 0u; first < count; first += WORKGROUP) {
        if first + thread < count {
            let place = places[start + first + thread];
            batch[thread] = vec4(ranks(unpacked(place)), place);
        }
        workgroupBarrier();
        for (var i = slice; i < min(WORKGROUP, count - first); i += SLICES) {
            let primitive = batch[i];
            let rank = select(primitive.x, primitive.y, lane >= 8u) >> (4u * (lane & 7u)) & 15u;
            let pull = h[rank] * (primitive.w >> 16u);
            let p = unpacked(primitive.zw);
            own[0] = sum(own[0], widened(pull));
            own[1] = sum(own[1], product(pull, p.x));
            own[2] = sum(own[2], product(pull, p.y));
            own[3] = sum(own[3], product(pull, p.z));
        }
        workgroupBarrier();
    }
    for (var i = 0u; i < 4u; i++) {
        shares[i * WORKGROUP + thread] = own[i];
    }
    workgroupBarrier();
    for (var i = thread; i < SUMS; i += WORKGROUP) {
        var total = widened(0u);
        for (var j = i % LANES; j < WORKGROUP; j += LANES) {
            total = sum(total, shares[i / LANES * WORKGROUP + j]);
        }
        sums[i] = total;
    }
    workgroupBarrier();
}

/// moment / weight, rounded half up: below 2^15.
fn mean(moment: U64, weight: U64) -> u32 {
    var rest = sum(moment, half(weight));
    var quotient = 0u;
    for (var bit = LOCAL_BITS - 1u; bit > 0u; bit--) {
        let part = shifted(weight, bit);
        if !is_less(rest, part) {
            rest = difference(rest, part);
            quotient |= 1u << bit;
        }
    }
    return quotient | u32(!is_less(rest, weight));
}

/// Moves each prototype `at` to its mean; one that nothing pulls stays. Returns to the whole workgroup whether any
/// moved.
fn move_prototypes(thread: u32) -> bool {
    if thread == 0u {
        atomicStore(&moved, 0u);
    }
    workgroupBarrier();
    if thread < LANES && !is_zero(sums[thread]) {
        let weight = sums[thread];
        let to = vec3(
            mean(sums[LANES + thread], weight),
            mean(sums[2u * LANES + thread], weight),
            mean(sums[3u * LANES + thread], weight),
        );
        if any(to != at[thread]) {
            at[thread] = to;
            atomicStore(&moved, 1u);
        }
    }
    workgroupBarrier();
    if thread == 0u {
        has_moved = atomicLoad(&moved);
    }
    return workgroupUniformLoad(&has_moved) != 0u;
}

/// The state of a node, the same for the whole workgroup.
fn state_of(node: u32, thread: u32) -> State {
    if thread == 0u {
        state = states[node];
    }
    return workgroupUniformLoad(&state);
}

fn load_prototypes(node: u32, thread: u32) {
    if thread < LANES {
        at[thread] = unpacked(prototypes[node * LANES + thread]);
    }
    workgroupBarrier();
}

fn store_prototypes(node: u32, thread: u32) {
    if thread < LANES {
        prototypes[node * LANES + thread] = packed(at[thread], 0u);
    }
}

fn load_h(step: u32, thread: u32) {
    if thread < LANES {
        h[thread] = schedule[step * LANES + thread];
    }
    workgroupBarrier();
}

/// One step of each chunk of the large nodes.
@compute @workgroup_size(WORKGROUP)
fn accumulate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.large_chunks {
        return;
    }
    let chunk = chunks[number];
    let state = state_of(chunk.node, thread);
    if state.outcome != MOVING {
        return;
    }
    load_h(state.step, thread);
    load_prototypes(chunk.node, thread);
    add_up(chunk.start, chunk.count, thread);
    for (var i = thread; i < SUMS; i += WORKGROUP) {
        partial_sums[number * SUMS + i] = sums[i];
    }
}

/// Adds the sums of each large node, and moves its prototypes.
@compute @workgroup_size(UPDATE_WORKGROUP)
fn update(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number >= level.large_nodes {
        return;
    }
    let state = state_of(number, thread);
    if state.outcome != MOVING {
        return;
    }
    let node = nodes[number];
    var own = widened(0u);
    for (var i = thread / SUMS; i < node.chunks; i += UPDATE_WORKGROUP / SUMS) {
        own = sum(own, partial_sums[(node.first_chunk + i) * SUMS + thread % SUMS]);
    }
    shares[thread] = own;
    workgroupBarrier();
    if thread < SUMS {
        for (var i = thread + SUMS; i < UPDATE_WORKGROUP; i += SUMS) {
            own = sum(own, shares[i]);
        }
        sums[thread] = own;
    }
    load_prototypes(number, thread);
    let moved = move_prototypes(thread);
    store_prototypes(number, thread);
    if thread == 0u {
        states[number].step = state.step + 1u;
        states[number].outcome = select(SETTLED, MOVING, moved);
    }
}

/// The next STEPS_AT_ONCE steps of each small node.
@compute @workgroup_size(WORKGROUP)
fn cluster(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = level.large_nodes + group_number(group, groups);
    if number >= level.nodes {
        return;
    }
    let state = state_of(number, thread);
    if state.outcome != MOVING {
        return;
    }
    let node = nodes[number];
    let end = min(state.step + STEPS_AT_ONCE, STEPS);
    var step = state.step;
    var moving = true;
    load_prototypes(number, thread);
    while moving && step < end {
        load_h(step, thread);
        add_up(node.start, node.count, thread);
        moving = move_prototypes(thread);
        step++;
    }
    store_prototypes(number, thread);
    if thread == 0u {
        states[number].step = step;
        states[number].outcome = select(SETTLED, MOVING, moving);
    }
}
