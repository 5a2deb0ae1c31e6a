# Parts of .ci/run, .ci/sweep, .ci/mutations and .ci/bochs, which source this file in the project's folder.
# shellcheck shell=bash
# shellcheck disable=SC2034 # used by the scripts that source this

# Omits line tables, which nobody reads here, to shorten builds.
export CI=true CARGO_TERM_COLOR=never CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_INCREMENTAL=0 CARGO_NET_RETRY=5
# Omits optimisation across codegen units, a fifth of the compile time, and the highest level, a seventh, since no times
# are measured here.
export CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_OPT_LEVEL=2
export DEBIAN_FRONTEND=noninteractive
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
SIMDOP_DATA=$(realpath -m "${SIMDOP_DATA:-../shared/data}")
export SIMDOP_DATA

NEON=aarch64-unknown-linux-gnu
# The smallest core that robots use. It has NEON but no later extensions, whose instructions would abort a test.
NEON_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu -cpu cortex-a53"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
# For Miri, where detection reports the features that the crate is compiled for: those of the tokens in src/isa.
X86_FEATURES=+avx2,+bmi1,+bmi2,+f16c,+lzcnt,+popcnt,+avx512f,+avx512bw,+avx512vl

# Target, package in tests/no_std_consumer, and the instruction set that its queries must report. x86_64-unknown-none
# has a soft-float ABI and no vector kernels: these run without std in a Linux process.
BARE=(
  "thumbv7em-none-eabihf cortex-m-consumer scalar"
  "aarch64-unknown-none aarch64-none neon"
  "x86_64-unknown-none x86_64-none scalar"
  "x86_64-unknown-linux-gnu x86_64-none avx(2|512)"
)
CONSUMERS=tests/no_std_consumer

# Profile, packages and features of `host_command`, after `host_selection` has read it. All builds in that profile for
# this machine use them, so that nothing is built twice.
HOST=()

# A caller's flags would change what is tested.
clear_flags() {
  unset SIMDOP_REQUIRE_ISA SIMDOP_PAIRS SIMDOP_SUITE
  unset RUSTFLAGS RUSTDOCFLAGS CARGO_BUILD_TARGET CARGO_ENCODED_RUSTFLAGS
}

die() {
  echo "error: $*" >&2
  exit 1
}

# Records what ran where, for the summary.
evidence() { echo "  $*" >>"$LOGS/evidence"; }

have() { command -v "$1" >/dev/null 2>&1; }

has_flag() { grep -m1 '^flags' /proc/cpuinfo | grep -qw "$1"; }

has_avx512() { has_flag avx512f && has_flag avx512bw && has_flag avx512vl; }

step() { echo "-- $*"; }

install_rust_parts() {
  local target part installed
  installed=$(rustup target list --installed)
  for target in "$NEON" "${BARE[@]%% *}"; do
    grep -qx "$target" <<<"$installed" || rustup target add "$target"
  done
  { cargo clippy --version && cargo fmt --version; } || rustup component add clippy rustfmt
  installed=$(rustup +nightly component list --installed)
  for part in miri rust-src; do
    grep -q "^$part" <<<"$installed" || rustup +nightly component add "$part"
  done
}

# install_packages PACKAGE:PROOF...: the proof is a command or a file that the package installs.
install_packages() {
  local pair missing=()
  for pair; do
    have "${pair#*:}" || [ -e "${pair#*:}" ] || missing+=("${pair%%:*}")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  apt-get -qq -o Acquire::Retries=3 update
  apt-get -qq -o Acquire::Retries=3 install -y --no-install-recommends "${missing[@]}" >"$LOGS/apt" 2>&1 ||
    { cat "$LOGS/apt"; die "apt-get could not install ${missing[*]}"; }
}

# The code block that follows the marker in README.md.
readme_test_command() {
  local command
  command=$(awk '/<!-- test-command -->/ {marked = 1; next}
    marked && /^```/ {if (inside) exit; inside = 1; next}
    inside' README.md)
  [ -n "$command" ] || die "README.md has no code block after the line <!-- test-command -->"
  echo "$command"
}

# The README's test command, with the tests that need a device.
host_command() { echo "$(readme_test_command) --features simdop/gpu"; }

host_selection() {
  local -a words
  read -ra words <<<"$(host_command)"
  [ "${words[*]:0:4}" = "cargo test --profile suite" ] ||
    die "the README's test command does not begin with cargo test --profile suite"
  HOST=("${words[@]:2}")
}

# The instruction sets of this CPU that tests must run on, separated by commas.
host_isas() { if has_avx512; then echo avx2,avx512; else echo avx2; fi; }

# neon ARGUMENTS...: cargo test for aarch64 on an emulated CPU.
neon() {
  SIMDOP_REQUIRE_ISA=neon CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$NEON_RUNNER \
    cargo test --locked --profile suite --target "$NEON" "$@"
}

# miri_kernels TARGET: the kernels' law in Miri. Skips the tests of the scalar kernels, which take part in every test
# and have no unsafe code.
miri_kernels() {
  MIRIFLAGS=-Zmiri-disable-isolation \
    cargo +nightly miri test --locked --target "$1" --test kernel_law -- --skip scalar::
}

# fuzz_all RUNS SEED OPTIONS...: each target has an oracle; seed and count make a run repeatable. Built with the address
# sanitizer and overflow checks. New inputs that the fuzzer finds go to a temporary folder.
fuzz_all() {
  local targets target runs count=$1 seed=$2
  shift 2
  targets=$(cargo +nightly fuzz list)
  [ -n "$targets" ] || die "fuzz/ has no target"
  for target in $targets; do
    step "$target"
    [ -d "fuzz/seeds/$target" ] || die "fuzz/seeds has nothing for $target"
    mkdir -p "$LOGS/corpus/$target"
    cargo +nightly fuzz run --no-trace-compares "$@" "$target" "$LOGS/corpus/$target" "fuzz/seeds/$target" -- \
      -runs="$count" -seed="$seed" -max_len=4096 -timeout=60 -verbosity=0 -print_final_stats=1 2>&1 | tee "$LOGS/fuzz"
    runs=$(awk '/number_of_executed_units/ {print $2}' "$LOGS/fuzz")
    [ "${runs:-0}" -ge "$count" ] || die "$target ran ${runs:-no} times of $count"
    evidence "fuzz target $target: $runs runs"
  done
}

# conclude WHERE LOG ISA...: fails unless tests passed, including some named after each instruction set
# (`overlap_1v16_obeys_the_law_avx2`).
conclude() {
  local place=$1 log=$2 passed ignored isa count line
  shift 2
  passed=$(awk '/^test result:/ {n += $4} END {print n + 0}' "$log")
  ignored=$(awk '/^test result:/ {n += $8} END {print n + 0}' "$log")
  [ "$passed" -gt 0 ] || die "no test ran on $place"
  line="$place: $passed tests, $ignored ignored; named after"
  for isa; do
    count=$(grep -cE "^test (.*[^a-z0-9])?$isa([^a-z0-9].*)? \.\.\. ok$" "$log") ||
      die "no test named after $isa ran on $place"
    line+=" $isa $count"
  done
  evidence "$line"
}
