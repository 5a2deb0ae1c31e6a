//! Numbers over the whole range in one shape, with all digits of `f64`.
