//! The parts of a picture, from back to front.

/// A triangle or a sphere to paint.
pub(super) struct Part {
    /// Position along the axis to the viewer.
    pub(super) depth: f64,
    pub(super) outline: Outline,
    pub(super) colour: [u8; 3],
}

/// An outline in pixels.
pub(super) enum Outline {
    Triangle([[f64; 2]; 3]),
    Disc { centre: [f64; 2], radius: f64 },
}

/// The colour of a disc's edge.
pub(super) fn rim(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|x| x / 2)
}
