//! Clouds of points against a loop over all points: the same neighbours, to the last bit.

mod body;
mod bytes;
mod changes;
mod memory;
mod neighbours;
mod scenes;
mod single;
