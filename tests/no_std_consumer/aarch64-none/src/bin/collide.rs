//! The smallest program that asks a query: its size is what `Query::collide` adds to a firmware.
#![no_std]
#![no_main]

use aarch64_none::exit;
use core::hint::black_box;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let (Ok(ring), Ok(pose)) = (check::RING.view(), Pose::from_rows(black_box(check::poses::POSES[1].1)))
    else {
        exit(false)
    };
    exit(Query::new(Isa::detect()).collide(&ring, &ring, &pose).hit().is_some())
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
