//! Every instruction set of this machine, for what is generic over the kernels.

/// Evaluates an expression with the kernel of an instruction set.
#[macro_export]
macro_rules! on_isa {
    ($isa:expr, $kernel:ident => $body:expr) => {
        match $isa {
            simdop::isa::Isa::Scalar($kernel) => $body,
            #[cfg(target_arch = "x86_64")]
            simdop::isa::Isa::Avx2($kernel) => $body,
            #[cfg(target_arch = "x86_64")]
            simdop::isa::Isa::Avx512($kernel) => $body,
            #[cfg(target_arch = "aarch64")]
            simdop::isa::Isa::Neon($kernel) => $body,
            other => panic!("nothing here runs {other}"),
        }
    };
}
