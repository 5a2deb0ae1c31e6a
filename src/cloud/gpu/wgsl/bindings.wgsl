// What the kernels work on. The constants UNUSED, FOUND, ... are written before this text by the program (see shader.rs).
//
// Coordinates are the bits of f32, and become f32 only where they are computed with: the language may take numbers for zero that are
// too small, and may take it that none is NaN, which the bits of what is unused are.

/// Sixteen children.
struct Node {
    lower: array<array<u32, 16>, 3>,
    upper: array<array<u32, 16>, 3>,
    built: array<u32, 16>,
    child: array<u32, 16>,
}

/// Up to sixteen points, four at a time.
struct Bucket {
    coordinates: array<array<vec4<u32>, 4>, 3>,
    indices: array<vec4<u32>, 4>,
}

/// Nodes of a level of the tree.
struct Level {
    first: u32,
    count: u32,
}

/// Of all dispatches of a search.
struct Search {
    /// 0, which the compiler does not know.
    zero: u32,
    /// Elements of what is asked: queries that look for seats, packets that search.
    count: u32,
    /// The first bucket whose points ask; NO_BUCKET if others do.
    own: u32,
    /// Whether `squares` has one for each query, and not one for all.
    each: u32,
    /// Of this dispatch of `fill`: its first packet, and how many.
    first_packet: u32,
    packets: u32,
    /// Where the lists of the first packet begin.
    start: u32,
}

@group(0) @binding(0) var<uniform> search: Search;
@group(0) @binding(1) var<uniform> level: Level;
@group(0) @binding(2) var<storage, read> nodes: array<Node>;
@group(0) @binding(3) var<storage, read> buckets: array<Bucket>;
/// The same, where they change.
@group(0) @binding(4) var<storage, read_write> refitted: array<Node>;
@group(0) @binding(5) var<storage, read_write> moved: array<Bucket>;
/// x, y, z of each index.
@group(0) @binding(6) var<storage, read> positions: array<u32>;
/// x, y, z and index of queries that are no points of the cloud; of packets, those of a packet one after another.
@group(0) @binding(7) var<storage, read> asks: array<vec4<u32>>;
/// The first ask of each packet, and how many there are.
@group(0) @binding(8) var<storage, read> packets: array<vec2<u32>>;
/// Of radii.
@group(0) @binding(9) var<storage, read> squares: array<u32>;
/// The bucket beside each query.
@group(0) @binding(10) var<storage, read_write> seats: array<u32>;
/// Neighbours of each query, sixteen to a packet.
@group(0) @binding(11) var<storage, read_write> counts: array<u32>;
/// Where they go.
@group(0) @binding(12) var<storage, read_write> starts: array<u32>;
/// Neighbours of SCANNED packets; then those of all before.
@group(0) @binding(13) var<storage, read_write> totals: array<u32>;
/// Start and count of each query.
@group(0) @binding(14) var<storage, read_write> lists: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> indices: array<u32>;
/// Squares of distances.
@group(0) @binding(16) var<storage, read_write> results: array<u32>;

/// The number of a workgroup of a dispatch in two dimensions.
fn group_number(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

fn is_nan(bits: vec4<u32>) -> vec4<bool> {
    return (bits & vec4(0x7fffffffu)) > vec4(0x7f800000u);
}

/// A number that is ordered as these bits are as an f32. Both zeros are the same.
fn order(bits: vec4<u32>) -> vec4<u32> {
    let key = select(bits | vec4(0x80000000u), ~bits, bits > vec4(0x7fffffffu));
    return select(key, vec4(0x80000000u), bits == vec4(0x80000000u));
}

/// Bits that have this order; of the zeros, the positive one.
fn bits_of(order: u32) -> u32 {
    return select(~order, order & 0x7fffffffu, order > 0x7fffffffu);
}

fn is_inner(child: u32) -> bool {
    return child < LEAF_BIT;
}

/// The index of the node that a link leads to.
fn node_of(child: u32) -> u32 {
    return child & NODE_BITS;
}

/// The bucket that a link leads to.
fn bucket_of(child: u32) -> u32 {
    return child & BUCKET_BITS;
}
