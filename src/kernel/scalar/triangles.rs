//! One triangle against four.

use crate::primitive::triangle::{Probe, Triangle};

/// [`crate::kernel::Kernel::apart_4`].
#[inline(always)]
pub(in crate::kernel) fn apart_4(probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16 {
    let bit = |i: usize| u16::from(probe.is_apart(&triangles[i])) << i;
    bit(0) | bit(1) | bit(2) | bit(3)
}
