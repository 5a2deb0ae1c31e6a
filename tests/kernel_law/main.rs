//! The law of the kernels (`simdop::low_level::kernel`): for every input, every instruction set gives the
//! scalar kernel's bits.
//!
//! One macro generates the same tests for each name in `Isa::NAMES`. An instruction set that this machine does
//! not have is reported as `NOT RUN`, and is a failure if `SIMDOP_REQUIRE_ISA` (names, separated by commas)
//! contains it. `SIMDOP_PAIRS` sets the number of pairs of nodes per k. At `digest::RECORDED_PAIRS` the tests
//! compare with the scalar kernel's recorded digest, which saves an emulator the scalar kernel.

mod balls;
mod digest;
mod inputs;
mod overlaps;
mod points;
mod primitive_slabs;
mod realign;
mod solids;
#[path = "../support/mod.rs"]
mod support;
mod trees;
mod triangles;
#[path = "../support/turned.rs"]
#[expect(unreachable_pub, reason = "public for the fuzz targets, where it is part of a library")]
mod turned;

use balls::balls_equal_the_scalar_kernel;
use overlaps::{
    all_key_pairs, any_one_lane_overlaps, any_one_plane_separates, lanes_permuted,
    overlaps_equal_the_scalar_kernel, roles_swapped_and_bodies_mirrored,
};
use primitive_slabs::primitive_slabs_equal_the_scalar_kernel;
use realign::{any_alignment, realignments_equal_the_scalar_kernel};
use simdop::isa::{Isa, IsaError, on_isa};
use support::data::{by_suite, notice};

/// The instruction set, if this machine has it. If not, prints a notice.
fn available(name: &str) -> Option<Isa> {
    match name.parse() {
        Ok(isa) => Some(isa),
        Err(IsaError::Unknown) => panic!("{name} is no instruction set"),
        Err(IsaError::NotAvailable) => {
            let required = std::env::var("SIMDOP_REQUIRE_ISA").unwrap_or_default();
            assert!(!required.split(',').any(|r| r == name), "SIMDOP_REQUIRE_ISA: there is no {name} here");
            notice(&format!("NOT RUN: there is no {name} here"));
            None
        }
    }
}

/// The tests of each instruction set; each test runs `law::<K>(kernel, name)` for every k, or in Miri for the least and
/// the greatest.
macro_rules! laws {
    ($($isa:ident)*) => {
        #[test]
        fn no_instruction_set_is_left_out() {
            assert_eq!([$(stringify!($isa)),*], Isa::NAMES);
        }
        $( mod $isa {
            use super::*;
            laws!(@each $isa:
                overlaps_equal_the_scalar_kernel
                realignments_equal_the_scalar_kernel
                primitive_slabs_equal_the_scalar_kernel
                any_one_plane_separates
                any_one_lane_overlaps
                roles_swapped_and_bodies_mirrored
                lanes_permuted
                any_alignment
            );

            #[test]
            fn balls_equal_the_scalar_kernel() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => super::balls_equal_the_scalar_kernel(kernel, stringify!($isa)));
                }
            }

            #[test]
            fn solids_equal_the_scalar_kernel() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => solids::solids_equal_the_scalar_kernel(kernel, stringify!($isa)));
                }
            }

            #[test]
            fn points_equal_the_scalar_kernel() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => points::points_equal_the_scalar_kernel(kernel, stringify!($isa)));
                }
            }

            #[test]
            fn picks_are_the_slots_of_the_mask() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => points::picks_are_the_slots_of_the_mask(kernel, stringify!($isa)));
                }
            }

            /// All 2^32 compares of one plane: takes minutes in an emulator.
            #[test]
            #[ignore = "exhaustive: cargo test --release --test kernel_law -- --ignored"]
            fn all_key_pairs() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => super::all_key_pairs(kernel));
                }
            }
        } )*
    };
    (@each $isa:ident: $($law:ident)*) => { $(
        #[test]
        fn $law() {
            if let Some(isa) = available(stringify!($isa)) {
                on_isa!(isa, kernel => {
                    super::$law::<6>(kernel, stringify!($isa));
                    // Miri is slow, and the code is the same but for the number of rows.
                    if !cfg!(miri) {
                        super::$law::<14>(kernel, stringify!($isa));
                        super::$law::<18>(kernel, stringify!($isa));
                        super::$law::<26>(kernel, stringify!($isa));
                    }
                    super::$law::<32>(kernel, stringify!($isa));
                });
            }
        }
    )* };
}

laws!(scalar neon avx2 avx512);

/// Pairs of nodes per k: `SIMDOP_PAIRS`, or a number that is quickly tested.
fn pairs() -> u64 {
    match std::env::var("SIMDOP_PAIRS") {
        Ok(pairs) => pairs.parse().expect("SIMDOP_PAIRS is a number"),
        Err(_) if cfg!(miri) => 3,
        Err(_) => by_suite(100_000, 4_000),
    }
}
