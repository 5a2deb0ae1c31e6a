//! The byte view: which types may be read in place from a baked tree.
//!
//! The only `unsafe` outside the kernels and ISA detection. All other casts use `bytemuck`'s checked functions.
#![expect(unsafe_code, reason = "bytemuck cannot derive Pod for const-generic structs")]

use crate::key::Storage;
use crate::node::{Node4, Node16};

macro_rules! plain_old_data {
    ($($k:literal)*) => { $(
        const _: () = {
            assert!(size_of::<Node16<$k>>() == 32 * $k + 64, "no padding in Node16");
            assert!(size_of::<Node4<$k>>() == 8 * $k + 16, "no padding in Node4");
        };
        // SAFETY: `Node16` is `repr(C)`, `Copy` and `'static`. Its fields, arrays of `i16` and of the Pod `Child`,
        // are valid for any bits. The assertion above checks that they fill it, so there is no padding.
        unsafe impl<S: Storage> bytemuck::Pod for Node16<$k, S> {}
        // SAFETY: all fields may be zero.
        unsafe impl<S: Storage> bytemuck::Zeroable for Node16<$k, S> {}
        // SAFETY: `Node4` is `repr(C)`, `Copy` and `'static`. Its fields, arrays of `i16` and of the Pod `Child`, are
        // valid for any bits. The assertion above checks that they fill it, so there is no padding.
        unsafe impl<S: Storage> bytemuck::Pod for Node4<$k, S> {}
        // SAFETY: all fields may be zero.
        unsafe impl<S: Storage> bytemuck::Zeroable for Node4<$k, S> {}
    )* };
}

plain_old_data!(6 14 18 26 32);
