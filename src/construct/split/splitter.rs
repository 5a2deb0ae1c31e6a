//! The choice of a splitter.

/// How primitives are assigned to the lanes of a node (SIMDop paper, section IV-A).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Splitter {
    /// Sort along the longest axis and divide into equal parts.
    LongestAxis,
    /// Halve along the longest axis, then each half along its own longest axis, until there is a part for each lane.
    ExtendedLongestAxis,
    /// Cut where the sum of box area x primitives per lane is least: the surface area heuristic, without an
    /// intermediate binary tree.
    SurfaceArea,
    /// Cut where the sum of the cube of the box's mean width x primitives per lane is least, then exchange primitives
    /// between lanes while that sum falls. Queries visit the outermost lanes first. The fewest visits.
    #[default]
    MeanWidth,
    /// Cluster with Batch Neural Gas, one prototype per lane (BNG paper, section 3). The slowest build.
    BatchNeuralGas {
        /// The weight of a primitive.
        magnification: Magnification,
        /// Seed of the initial prototypes.
        seed: u32,
    },
}

/// The weight of a primitive in clustering: magnification control (BNG paper, section 3.1.1).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Magnification {
    /// All weights are equal, as in the SIMDop paper.
    #[default]
    None,
    /// The weight of a triangle is its area, that of a sphere its volume. Large primitives are then no outliers, and
    /// end up high in the tree.
    Area,
}
