// The buffers of the kernels. The program puts the constants UNUSED, FOUND, ... before this text (see shader.rs).
//
// Coordinates are stored as the bits of f32, and become f32 only for arithmetic: WGSL may flush small numbers to 0
// and may assume that there is no NaN, but unused elements are NaN.

/// Sixteen children.
struct Node {
    lower: array<array<u32, 16>, 3>,
    upper: array<array<u32, 16>, 3>,
    built: array<u32, 16>,
    child: array<u32, 16>,
}

/// Up to sixteen points, in groups of four.
struct Bucket {
    coordinates: array<array<vec4<u32>, 4>, 3>,
    indices: array<vec4<u32>, 4>,
}

/// The nodes of a level of the tree.
struct Level {
    first: u32,
    count: u32,
}

/// Parameters of the dispatches of a search.
struct Search {
    /// 0, unknown to the compiler.
    zero: u32,
    /// Number of elements: queries to seat, or packets to search.
    count: u32,
    /// The first bucket whose points are the queries; NO_BUCKET for other queries.
    own: u32,
    /// Nonzero if `squares` has one element for each query, 0 if one for all.
    each: u32,
    /// The packets of this dispatch: the first, and their number.
    first_packet: u32,
    packets: u32,
    /// Start of the first packet's lists.
    start: u32,
}

@group(0) @binding(0) var<uniform> search: Search;
@group(0) @binding(1) var<uniform> level: Level;
@group(0) @binding(2) var<storage, read> nodes: array<Node>;
@group(0) @binding(3) var<storage, read> buckets: array<Bucket>;
/// The same buffers, writable.
@group(0) @binding(4) var<storage, read_write> refitted: array<Node>;
@group(0) @binding(5) var<storage, read_write> moved: array<Bucket>;
/// x, y, z of each index.
@group(0) @binding(6) var<storage, read> positions: array<u32>;
/// x, y, z and index of queries that are not points of the cloud. Those of a packet are contiguous.
@group(0) @binding(7) var<storage, read> asks: array<vec4<u32>>;
/// The first query of each packet in `asks`, and their number.
@group(0) @binding(8) var<storage, read> packets: array<vec2<u32>>;
/// Squared radii.
@group(0) @binding(9) var<storage, read> squares: array<u32>;
/// The seat of each query.
@group(0) @binding(10) var<storage, read_write> seats: array<u32>;
/// Number of neighbours of each query, sixteen queries per packet.
@group(0) @binding(11) var<storage, read_write> counts: array<u32>;
/// Start of the list of each query.
@group(0) @binding(12) var<storage, read_write> starts: array<u32>;
/// Neighbours of each group of WORKGROUP packets; then the sums of all groups before.
@group(0) @binding(13) var<storage, read_write> totals: array<u32>;
/// Start and count of each query.
@group(0) @binding(14) var<storage, read_write> lists: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> indices: array<u32>;
/// Squared distances.
@group(0) @binding(16) var<storage, read_write> results: array<u32>;

/// The index of a workgroup in a two-dimensional dispatch.
fn group_number(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

fn is_nan(bits: vec4<u32>) -> vec4<bool> {
    return (bits & vec4(0x7fffffffu)) > vec4(0x7f800000u);
}

/// Maps f32 bits to an integer with the same order. Both zeros map to the same integer.
fn order(bits: vec4<u32>) -> vec4<u32> {
    let key = select(bits | vec4(0x80000000u), ~bits, bits > vec4(0x7fffffffu));
    return select(key, vec4(0x80000000u), bits == vec4(0x80000000u));
}

/// The f32 bits with this order; for zeros, the positive one.
fn bits_of(order: u32) -> u32 {
    return select(~order, order & 0x7fffffffu, order > 0x7fffffffu);
}

fn is_inner(child: u32) -> bool {
    return child < LEAF_BIT;
}

/// The node that a link refers to.
fn node_of(child: u32) -> u32 {
    return child & NODE_BITS;
}

/// The bucket that a link refers to.
fn bucket_of(child: u32) -> u32 {
    return child & BUCKET_BITS;
}
