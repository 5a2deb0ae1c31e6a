// Starts of the lists: prefix sums of the counts, packet by packet. Sums saturate at the largest number; the host
// computes the total from the counts.

/// Inclusive prefix sums over the threads.
var<workgroup> scanned: array<u32, WORKGROUP>;

fn plus(a: u32, b: u32) -> u32 {
    let sum = a + b;
    return select(sum, 0xffffffffu, sum < a);
}

/// The sum of `own` over all threads before this one. `scanned` of the last thread is the total.
fn sum_before(own: u32, thread: u32) -> u32 {
    scanned[thread] = own;
    workgroupBarrier();
    for (var step = 1u; step < WORKGROUP; step *= 2u) {
        let before = select(0u, scanned[max(thread, step) - step], thread >= step);
        workgroupBarrier();
        scanned[thread] = plus(scanned[thread], before);
        workgroupBarrier();
    }
    return select(0u, scanned[max(thread, 1u) - 1u], thread > 0u);
}

/// Prefix sums within groups of WORKGROUP packets.
@compute @workgroup_size(WORKGROUP)
fn scan(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups);
    if number * WORKGROUP >= search.count {
        return;
    }
    let packet = number * WORKGROUP + thread;
    let is_packet = packet < search.count;
    var sum = 0u;
    for (var slot = 0u; slot < 16u && is_packet; slot++) {
        sum = plus(sum, counts[packet * 16u + slot]);
    }
    var start = sum_before(sum, thread);
    for (var slot = 0u; slot < 16u && is_packet; slot++) {
        starts[packet * 16u + slot] = start;
        start = plus(start, counts[packet * 16u + slot]);
    }
    if thread == WORKGROUP - 1u {
        totals[number] = scanned[thread];
    }
}

/// Prefix sums over the groups, in one workgroup.
@compute @workgroup_size(WORKGROUP)
fn scan_totals(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if group_number(group, groups) != 0u {
        return;
    }
    let count = (search.count + WORKGROUP - 1u) / WORKGROUP;
    var carry = 0u;
    for (var first = 0u; first < count; first += WORKGROUP) {
        let here = first + thread < count;
        let own = select(0u, totals[min(first + thread, count - 1u)], here);
        let before = sum_before(own, thread);
        if here {
            totals[first + thread] = plus(carry, before);
        }
        carry = plus(carry, scanned[WORKGROUP - 1u]);
        workgroupBarrier();
    }
}

/// The list of each query. One thread per slot of a packet.
@compute @workgroup_size(WORKGROUP)
fn write_lists(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = group_number(group, groups) * WORKGROUP + thread;
    let packet = number / 16u;
    if packet >= search.count {
        return;
    }
    let start = plus(totals[packet / WORKGROUP], starts[number]);
    starts[number] = start;
    let query = ask_of(packet, number % 16u).query;
    if query < arrayLength(&lists) {
        lists[query] = vec2(start, counts[number]);
    }
}
