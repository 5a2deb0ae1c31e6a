//! The splitters to choose from.

/// How primitives are assigned to the lanes of a node (SIMDop paper, section IV-A).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Splitter {
    /// Sort along the longest axis and cut into equal parts.
    LongestAxis,
    /// Halve along the longest axis, then each half along its own, until there is a part for each lane.
    ExtendedLongestAxis,
    /// Cut where the sum of box area x primitives per lane is least: the surface area heuristic, without the
    /// detour over a binary tree.
    SurfaceArea,
    /// Cut where the sum of the cube of the box's mean width x primitives per lane is least, then exchange
    /// primitives between lanes as long as that sum falls, and look at the outermost lanes first. The
    /// fewest visits.
    #[default]
    MeanWidth,
    /// Cluster with Batch Neural Gas, one prototype for each lane (BNG paper, section 3): the slowest to
    /// build.
    BatchNeuralGas {
        /// What draws prototypes besides the number of primitives.
        magnification: Magnification,
        /// Decides where prototypes start, and nothing else.
        seed: u32,
    },
}

/// What a primitive weighs in a cluster: magnification control (BNG paper, section 3.1.1).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Magnification {
    /// Each primitive counts once, as in the SIMDop paper.
    #[default]
    None,
    /// A primitive weighs as much as it is large, a triangle its area, a sphere its volume, so that large ones are
    /// not outliers and come high up in the tree.
    Area,
}
