//! Detection on x86-64 without the standard library: CPUID and XCR0.

use core::arch::x86_64::{__cpuid, __cpuid_count, __get_cpuid_max, _xgetbv};

/// Where CPUID reports a feature, and which registers the operating system must save for it.
#[derive(Copy, Clone, Debug)]
pub(super) struct Feature {
    leaf: u32,
    register: CpuidRegister,
    bit: u32,
    /// Required bits of XCR0.
    state: u64,
}

#[derive(Copy, Clone, Debug)]
enum CpuidRegister {
    Ebx,
    Ecx,
}

/// No registers beyond those that every x86-64 system saves.
const NONE: u64 = 0;
/// SSE and AVX state.
const YMM: u64 = 0b110;
/// YMM, and mask registers, upper halves of the lower zmm registers, upper zmm registers.
const ZMM: u64 = 0b1110_0110;

impl Feature {
    /// The entry of a feature, from Intel's Software Developer's Manual, volume 2A, CPUID, and AMD's volume 3,
    /// appendix E.
    pub(super) const fn named(name: &str) -> Self {
        let (leaf, register, bit, state) = match name.as_bytes() {
            b"popcnt" => (1, CpuidRegister::Ecx, 23, NONE),
            b"f16c" => (1, CpuidRegister::Ecx, 29, YMM),
            b"bmi1" => (7, CpuidRegister::Ebx, 3, NONE),
            b"avx2" => (7, CpuidRegister::Ebx, 5, YMM),
            b"bmi2" => (7, CpuidRegister::Ebx, 8, NONE),
            b"avx512f" => (7, CpuidRegister::Ebx, 16, ZMM),
            b"avx512bw" => (7, CpuidRegister::Ebx, 30, ZMM),
            b"avx512vl" => (7, CpuidRegister::Ebx, 31, ZMM),
            b"lzcnt" => (0x8000_0001, CpuidRegister::Ecx, 5, NONE),
            _ => panic!("a feature without a row"),
        };
        Self { leaf, register, bit, state }
    }

    /// Whether the processor has it and the operating system saves its registers.
    pub(super) fn detected(self) -> bool {
        let (highest, _) = __get_cpuid_max(self.leaf & 0x8000_0000);
        if highest < self.leaf {
            return false;
        }
        let answer = __cpuid_count(self.leaf, 0);
        let register = match self.register {
            CpuidRegister::Ebx => answer.ebx,
            CpuidRegister::Ecx => answer.ecx,
        };
        register >> self.bit & 1 != 0 && saved_state() & self.state == self.state
    }
}

/// XCR0, or zero if the operating system has not enabled XSAVE.
fn saved_state() -> u64 {
    const OSXSAVE: u32 = 27;
    if __cpuid(1).ecx >> OSXSAVE & 1 == 0 {
        return 0;
    }
    // SAFETY: XGETBV exists and is enabled where CPUID reports OSXSAVE, and register 0 always exists.
    unsafe { _xgetbv(0) }
}

#[cfg(all(test, feature = "std", not(miri)))] // Miri has no CPUID
mod tests {
    use super::Feature;

    /// The standard library's detection is the reference.
    #[test]
    fn cpuid_agrees_with_std() {
        macro_rules! check {
            ($($name:tt)*) => { $(
                let want = std::arch::is_x86_feature_detected!($name);
                assert_eq!(Feature::named($name).detected(), want, $name);
            )* };
        }
        check!("popcnt" "f16c" "bmi1" "avx2" "bmi2" "avx512f" "avx512bw" "avx512vl" "lzcnt");
    }
}
