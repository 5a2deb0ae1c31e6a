// Full nodes: a minimum-cost flow from overfull lanes to lanes with room.

const PAIRS = LANES * LANES;
/// No lane.
const NONE = 0xffffffffu;
const UNREACHED = 0x7fffffff;

/// The number of primitives of each lane.
var<workgroup> sizes: array<u32, LANES>;
var<workgroup> rooms: array<u32, LANES>;
/// The least cost of a move from one lane to another, and the first primitive with this cost.
var<workgroup> move_cost: array<atomic<i32>, PAIRS>;
var<workgroup> move_primitive: array<atomic<u32>, PAIRS>;
/// Lanes whose moves must be recomputed, one bit each.
var<workgroup> stale: u32;
/// The cheapest path to each lane from any overfull lane, and the lane before it.
var<workgroup> path_cost: array<i32, LANES>;
var<workgroup> giver_of: array<u32, LANES>;
var<workgroup> shorter: atomic<u32>;
/// A decision that one thread shares with all.
var<workgroup> verdict: u32;

fn cost(lane: u32, p: vec3<u32>) -> i32 {
    return i32(distance_to(lane, p) >> COST_SHIFT);
}

/// Computes the capacity of each lane. For one thread.
fn make_rooms(count: u32) {
    for (var lane = 0u; lane < LANES; lane++) {
        rooms[lane] = level.leaf_size;
    }
    let leaves = (count + level.leaf_size - 1u) / level.leaf_size;
    let more = (excess(leaves, LANES) + LANES - 2u) / (LANES - 1u);
    for (var i = 0u; i < more; i++) {
        var needy = 0u;
        for (var lane = 1u; lane < LANES; lane++) {
            if i32(rooms[lane] - sizes[lane]) < i32(rooms[needy] - sizes[needy]) {
                needy = lane;
            }
        }
        rooms[needy] += level.leaf_size * (LANES - 1u);
    }
}

/// Whether a lane exceeds its capacity.
fn is_crowded(thread: u32) -> bool {
    if thread == 0u {
        verdict = 0u;
        for (var lane = 0u; lane < LANES; lane++) {
            verdict |= u32(sizes[lane] > rooms[lane]);
        }
    }
    return workgroupUniformLoad(&verdict) != 0u;
}

/// Recomputes the cheapest moves out of the stale lanes.
fn renew(start: u32, count: u32, thread: u32) {
    let renewed = workgroupUniformLoad(&stale);
    for (var i = thread; i < PAIRS; i += WORKGROUP) {
        if (renewed >> (i / LANES) & 1u) != 0u {
            atomicStore(&move_cost[i], NEVER);
            atomicStore(&move_primitive[i], NONE);
        }
    }
    workgroupBarrier();
    for (var i = thread; i < count; i += WORKGROUP) {
        let lane = lanes[start + i];
        if (renewed >> lane & 1u) != 0u {
            let p = unpacked(places[start + i]);
            let own = cost(lane, p);
            for (var to = 0u; to < LANES; to++) {
                let pair = lane * LANES + to;
                let step = cost(to, p) - own;
                // Few threads get here, and fewer contend.
                if to != lane && step < atomicLoad(&move_cost[pair]) {
                    atomicMin(&move_cost[pair], step);
                }
            }
        }
    }
    workgroupBarrier();
    for (var i = thread; i < count; i += WORKGROUP) {
        let lane = lanes[start + i];
        if (renewed >> lane & 1u) != 0u {
            let p = unpacked(places[start + i]);
            let own = cost(lane, p);
            for (var to = 0u; to < LANES; to++) {
                let pair = lane * LANES + to;
                if to != lane && atomicLoad(&move_cost[pair]) == cost(to, p) - own {
                    atomicMin(&move_primitive[pair], i);
                }
            }
        }
    }
    workgroupBarrier();
}

/// Bellman-Ford, with one thread per receiving lane.
fn shortest_paths(thread: u32) {
    if thread < LANES {
        path_cost[thread] = select(UNREACHED, 0, sizes[thread] > rooms[thread]);
        giver_of[thread] = NONE;
    }
    for (var round = 1u; round < LANES; round++) {
        if thread == 0u {
            atomicStore(&shorter, 0u);
        }
        for (var giver = 0u; giver < LANES; giver++) {
            workgroupBarrier();
            if thread < LANES && thread != giver && path_cost[giver] != UNREACHED {
                let step = atomicLoad(&move_cost[giver * LANES + thread]);
                if step < NEVER && path_cost[giver] + step < path_cost[thread] {
                    path_cost[thread] = path_cost[giver] + step;
                    giver_of[thread] = giver;
                    atomicStore(&shorter, 1u);
                }
            }
        }
        workgroupBarrier();
        if thread == 0u {
            verdict = atomicLoad(&shorter);
        }
        if workgroupUniformLoad(&verdict) == 0u {
            break;
        }
    }
}

/// Moves a primitive along the cheapest path, and marks the lanes on it as stale. For one thread.
fn shift_along(start: u32) {
    var end = NONE;
    for (var lane = 0u; lane < LANES; lane++) {
        let open = sizes[lane] < rooms[lane];
        if open && (end == NONE || path_cost[lane] < path_cost[end]) {
            end = lane;
        }
    }
    var lane = end;
    stale = 1u << end;
    // A path has no cycle: the bound is only for safety.
    for (var i = 0u; i < LANES && giver_of[lane] != NONE; i++) {
        let giver = giver_of[lane];
        lanes[start + atomicLoad(&move_primitive[giver * LANES + lane])] = lane;
        stale |= 1u << giver;
        lane = giver;
    }
    sizes[end] += 1u;
    sizes[lane] -= 1u;
}

/// Moves primitives of each small node until no lane exceeds its capacity, at most MOVES_AT_ONCE times. The nodes'
/// `ends` store the capacities from the first dispatch on.
@compute @workgroup_size(WORKGROUP)
fn balance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = level.large_nodes + group_number(group, groups);
    if number >= level.nodes || state_of(number, thread).outcome >= SMALL {
        return;
    }
    let node = nodes[number];
    let first = node.first_chunk * LANES;
    if thread < LANES {
        sizes[thread] = counts[first + thread];
        rooms[thread] = ends[number * LANES + thread];
    }
    workgroupBarrier();
    if thread == 0u {
        stale = NONE;
        if rooms[0] == 0u {
            make_rooms(node.count);
        }
    }
    load_prototypes(number, thread);
    // Each iteration takes a primitive out of an overfull lane.
    for (var i = 0u; i < MOVES_AT_ONCE; i++) {
        if !is_crowded(thread) {
            break;
        }
        renew(node.start, node.count, thread);
        shortest_paths(thread);
        if thread == 0u {
            shift_along(node.start);
        }
        storageBarrier();
        workgroupBarrier();
    }
    if thread < LANES {
        counts[first + thread] = sizes[thread];
        ends[number * LANES + thread] = rooms[thread];
    }
}
