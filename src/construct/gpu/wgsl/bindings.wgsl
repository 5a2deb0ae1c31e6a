// The buffers of the kernels. The program puts the constants LANES, STEPS, ... before this text (see shader.rs).

/// Parameters of all dispatches of a level.
struct Level {
    nodes: u32,
    /// Number of nodes with more than BALANCED_SIZE primitives. They come first; the others have one chunk each.
    large_nodes: u32,
    chunks: u32,
    /// Number of chunks of the large nodes. They come first.
    large_chunks: u32,
    seed: u32,
    leaf_size: u32,
    /// 0 if all primitives have the same weight.
    weighted: u32,
}

/// A node of the level that is clustered.
struct Node {
    /// Its first primitive, in `order`.
    start: u32,
    count: u32,
    /// Its index among all nodes of the tree, breadth first.
    number: u32,
    first_chunk: u32,
    chunks: u32,
}

/// The primitives of one workgroup.
struct Chunk {
    node: u32,
    /// The first primitive, in `order`.
    start: u32,
    count: u32,
}

/// The state of a node during clustering.
struct State {
    /// The shift from positions to local coordinates.
    shift: u32,
    weight_shift: u32,
    /// Number of completed steps.
    step: u32,
    /// MOVING, SETTLED, or why the node must be cut by axes.
    outcome: u32,
}

const MOVING = 0u;
const SETTLED = 1u;

@group(0) @binding(0) var<uniform> level: Level;
@group(0) @binding(1) var<storage, read> nodes: array<Node>;
@group(0) @binding(2) var<storage, read> chunks: array<Chunk>;
/// x, y, z of each primitive.
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> weights: array<u32>;
/// h of each rank, step by step.
@group(0) @binding(5) var<storage, read> schedule: array<u32>;
/// Primitives in the order of the nodes.
@group(0) @binding(6) var<storage, read_write> order: array<u32>;
/// The primitives of this level, in the order of the next.
@group(0) @binding(7) var<storage, read_write> sorted: array<u32>;
/// Local coordinates and weight of each primitive, in the order of `order`: x | y << 16, z | weight << 16.
@group(0) @binding(8) var<storage, read_write> places: array<vec2<u32>>;
/// Lane of each primitive, in the order of `order`.
@group(0) @binding(9) var<storage, read_write> lanes: array<u32>;
/// For each node the complements of its low corner, its high corner, and its greatest weight. All only grow, from 0.
@group(0) @binding(10) var<storage, read_write> boxes: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> states: array<State>;
/// LANES per node: x | y << 16, z.
@group(0) @binding(12) var<storage, read_write> prototypes: array<vec2<u32>>;
/// For each chunk of a large node LANES sums of weights, then LANES sums of moments for each axis.
@group(0) @binding(13) var<storage, read_write> partial_sums: array<U64>;
/// Number of primitives of each lane of each chunk; then the destination of the first one.
@group(0) @binding(14) var<storage, read_write> counts: array<u32>;
/// LANES per node: the ends of its lanes, relative to its first primitive; or a single outcome, SMALL or above.
@group(0) @binding(15) var<storage, read_write> ends: array<u32>;

/// The index of a workgroup in a two-dimensional dispatch.
fn group_number(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

fn unpacked(place: vec2<u32>) -> vec3<u32> {
    return vec3(place.x & 0xffffu, place.x >> 16u, place.y & 0xffffu);
}

fn packed(at: vec3<u32>, weight: u32) -> vec2<u32> {
    return vec2(at.x | at.y << 16u, at.z | weight << 16u);
}
