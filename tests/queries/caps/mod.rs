//! Solids whose holes are capped. The oracle counts winding numbers of the triangles and the caps together, along rays
//! parallel to the z axis, with exact signs; the library's rays are parallel to the x axis.

mod bodies;
mod bytes;
mod holes;
mod meshes;
mod motions;
mod oracle;
mod points;
