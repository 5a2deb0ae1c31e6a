//! Clouds of points against a loop over all points: the same neighbours, to the last bit.

mod body;
mod bytes;
mod changes;
#[path = "../support/data.rs"]
mod data;
mod memory;
mod neighbours;
#[path = "../support/rng.rs"]
mod rng;
mod scenes;
mod single;
