// The queries of a packet traverse the tree together, and each selects its neighbours from the buckets found. One
// workgroup per packet: four threads for each of its sixteen queries.

/// A query.
struct Ask {
    point: vec3<u32>,
    /// The squared radius.
    square: u32,
    /// Index of the query; UNUSED for none.
    query: u32,
}

/// The bounding box of the packet's points, as integers from `order`.
var<workgroup> lowest: array<atomic<u32>, 3>;
var<workgroup> highest: array<atomic<u32>, 3>;
/// The largest squared radius.
var<workgroup> widest: atomic<u32>;

/// Mask of the near lanes of the node opened last.
var<workgroup> near: atomic<u32>;
/// The stack: the links of each open node, and the mask of lanes left.
var<workgroup> links: array<u32, MAX_DEPTH * 16>;
var<workgroup> left: array<u32, MAX_DEPTH>;
var<workgroup> depth: u32;
/// The node to open, or one of the codes below.
var<workgroup> next: u32;
var<workgroup> steps: u32;

/// Pending buckets near the packet.
var<workgroup> found: array<u32, FOUND>;
var<workgroup> found_count: u32;
/// For each of them, the mask of points near each query.
var<workgroup> hits: array<u32, FOUND * 16>;
/// Counts of each thread.
var<workgroup> sums: array<u32, WORKGROUP>;

/// The traversal is complete.
const DONE = 0xffffffffu;
// ENDLESS is a third code: the packet exceeded MOST_STEPS.
/// `found` is full.
const FULL = 0xfffffffeu;

fn ask_of(packet: u32, slot: u32) -> Ask {
    var ask = Ask(vec3(0u), 0u, UNUSED);
    if search.own != NO_BUCKET {
        let bucket = search.own + packet;
        ask.query = buckets[bucket].indices[slot / 4u][slot % 4u];
        for (var axis = 0u; axis < 3u; axis++) {
            ask.point[axis] = buckets[bucket].coordinates[axis][slot / 4u][slot % 4u];
        }
    } else if slot < packets[packet].y {
        let own = asks[packets[packet].x + slot];
        ask.query = own.w;
        ask.point = own.xyz;
    }
    if ask.query != UNUSED {
        ask.square = squares[select(0u, ask.query, search.each != 0u)];
    }
    return ask;
}

/// Computes the packet's box and square, and sets the root as the first node to open.
fn begin(ask: Ask, thread: u32) {
    if thread < 3u {
        atomicStore(&lowest[thread], UNUSED);
        atomicStore(&highest[thread], 0u);
    }
    if thread == 0u {
        atomicStore(&widest, 0u);
        atomicStore(&near, 0u);
        depth = 0u;
        next = DONE;
        steps = 0u;
        found_count = 0u;
    }
    workgroupBarrier();
    if thread < 16u && ask.query != UNUSED {
        let place = order(vec4(ask.point, 0u));
        for (var axis = 0u; axis < 3u; axis++) {
            atomicMin(&lowest[axis], place[axis]);
            atomicMax(&highest[axis], place[axis]);
        }
        atomicMax(&widest, ask.square);
    }
    workgroupBarrier();
    // No finite coordinate maps to UNUSED.
    if thread == 0u && atomicLoad(&lowest[0]) != UNUSED {
        next = 0u;
    }
}

fn lower_corner() -> vec3<u32> {
    return vec3(
        bits_of(atomicLoad(&lowest[0])),
        bits_of(atomicLoad(&lowest[1])),
        bits_of(atomicLoad(&lowest[2])),
    );
}

fn upper_corner() -> vec3<u32> {
    return vec3(
        bits_of(atomicLoad(&highest[0])),
        bits_of(atomicLoad(&highest[1])),
        bits_of(atomicLoad(&highest[2])),
    );
}

/// Tests the lanes of a node, one thread each.
fn open(node: u32, lane: u32) {
    let child = nodes[node].child[lane];
    let lower = lower_of(node, lane);
    links[depth * 16u + lane] = child;
    if holds(child, lower) {
        let distance = box_square(lower, upper_of(node, lane), lower_corner(), upper_corner());
        if distance <= atomicLoad(&widest) {
            atomicOr(&near, 1u << lane);
        }
    }
}

/// Steps from lane to lane, in order, until there is a node to open or another code in `next`. For one thread.
fn advance() {
    loop {
        steps++;
        if steps > MOST_STEPS {
            next = ENDLESS;
            return;
        }
        let lanes = left[depth];
        if lanes == 0u {
            if depth == 0u {
                next = DONE;
                return;
            }
            depth--;
            continue;
        }
        let child = links[depth * 16u + firstTrailingBit(lanes)];
        if is_inner(child) {
            left[depth] = lanes & (lanes - 1u);
            depth = min(depth + 1u, MAX_DEPTH - 1u);
            next = node_of(child);
            return;
        }
        if found_count == FOUND {
            next = FULL;
            return;
        }
        left[depth] = lanes & (lanes - 1u);
        found[found_count] = bucket_of(child);
        found_count++;
    }
}

/// Mask of the points, of four, that are near a query.
fn near_four(bucket: u32, quarter: u32, ask: Ask) -> u32 {
    let used = buckets[bucket].indices[quarter] != vec4(UNUSED);
    let x = difference(select(vec4(0u), buckets[bucket].coordinates[0][quarter], used), vec4(ask.point.x));
    let y = difference(select(vec4(0u), buckets[bucket].coordinates[1][quarter], used), vec4(ask.point.y));
    let z = difference(select(vec4(0u), buckets[bucket].coordinates[2][quarter], used), vec4(ask.point.z));
    let is_near = (square(x, y, z) <= vec4(ask.square)) & used;
    let bits = select(vec4(0u), vec4(1u, 2u, 4u, 8u), is_near);
    return (bits.x | bits.y) | (bits.z | bits.w);
}

/// Mask of the points of a bucket that are near a query.
fn near_points(bucket: u32, ask: Ask) -> u32 {
    if ask.query == UNUSED {
        return 0u;
    }
    return (near_four(bucket, 0u, ask) | near_four(bucket, 1u, ask) << 4u)
        | (near_four(bucket, 2u, ask) << 8u | near_four(bucket, 3u, ask) << 12u);
}

/// Number of neighbours of a query in this thread's part of `found`.
fn count_found(ask: Ask, part: u32) -> u32 {
    var count = 0u;
    for (var i = part; i < found_count; i += PARTS) {
        count += countOneBits(near_points(found[i], ask));
    }
    return count;
}

/// Writes the indices in the mask, of four, to the buffer. Returns the next position.
fn put_four(place: u32, four: vec4<u32>, mask: u32) -> u32 {
    var to = place;
    if (mask & 1u) != 0u {
        put(to, four.x);
        to++;
    }
    if (mask & 2u) != 0u {
        put(to, four.y);
        to++;
    }
    if (mask & 4u) != 0u {
        put(to, four.z);
        to++;
    }
    if (mask & 8u) != 0u {
        put(to, four.w);
        to++;
    }
    return to;
}

fn put(place: u32, index: u32) {
    if place < arrayLength(&indices) {
        indices[place] = index;
    }
}

/// Writes the neighbours of a query, in the order of `found`. Each thread writes a part, after those of the parts
/// before. Returns the number of neighbours.
fn fill_found(ask: Ask, place: u32, thread: u32) -> u32 {
    let slot = thread % 16u;
    let part = thread / 16u;
    let size = (found_count + PARTS - 1u) / PARTS;
    let first = part * size;
    let end = min(first + size, found_count);
    var count = 0u;
    for (var i = first; i < end; i++) {
        let mask = near_points(found[i], ask);
        hits[i * 16u + slot] = mask;
        count += countOneBits(mask);
    }
    sums[thread] = count;
    workgroupBarrier();
    var to = place;
    var all = 0u;
    for (var other = 0u; other < PARTS; other++) {
        let sum = sums[other * 16u + slot];
        to += select(0u, sum, other < part);
        all += sum;
    }
    for (var i = first; i < end; i++) {
        let mask = hits[i * 16u + slot];
        if mask != 0u {
            let bucket = found[i];
            to = put_four(to, buckets[bucket].indices[0], mask);
            to = put_four(to, buckets[bucket].indices[1], mask >> 4u);
            to = put_four(to, buckets[bucket].indices[2], mask >> 8u);
            to = put_four(to, buckets[bucket].indices[3], mask >> 12u);
        }
    }
    return all;
}

/// Counts the neighbours of each query of a packet.
@compute @workgroup_size(WORKGROUP)
fn count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let packet = search.first_packet + group_number(group, groups);
    if packet >= search.first_packet + search.packets {
        return;
    }
    let ask = ask_of(packet, thread % 16u);
    begin(ask, thread);
    var sum = 0u;
    var ended: u32;
    loop {
        ended = workgroupUniformLoad(&next);
        if ended < ENDLESS {
            if thread < 16u {
                open(ended, thread);
            }
            workgroupBarrier();
            if thread == 0u {
                left[depth] = atomicExchange(&near, 0u);
            }
        } else {
            sum += count_found(ask, thread / 16u);
            workgroupBarrier();
            if ended != FULL {
                break;
            }
            if thread == 0u {
                found_count = 0u;
            }
        }
        if thread == 0u {
            advance();
        }
    }
    sums[thread] = sum;
    workgroupBarrier();
    if thread < 16u {
        for (var part = 1u; part < PARTS; part++) {
            sum += sums[part * 16u + thread];
        }
        counts[packet * 16u + thread] = select(sum, ENDLESS, ended == ENDLESS);
    }
}

/// Writes the neighbours of each query of a packet.
@compute @workgroup_size(WORKGROUP)
fn fill(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let packet = search.first_packet + group_number(group, groups);
    if packet >= search.first_packet + search.packets {
        return;
    }
    let ask = ask_of(packet, thread % 16u);
    begin(ask, thread);
    var place = starts[packet * 16u + thread % 16u] - search.start;
    loop {
        let ended = workgroupUniformLoad(&next);
        if ended < ENDLESS {
            if thread < 16u {
                open(ended, thread);
            }
            workgroupBarrier();
            if thread == 0u {
                left[depth] = atomicExchange(&near, 0u);
            }
        } else {
            place += fill_found(ask, place, thread);
            workgroupBarrier();
            if ended != FULL {
                break;
            }
            if thread == 0u {
                found_count = 0u;
            }
        }
        if thread == 0u {
            advance();
        }
    }
}
