# Parts of .ci/run, .ci/sweep, .ci/mutations and .ci/bochs, which source this file in the project's folder.
# shellcheck shell=bash
# shellcheck disable=SC2034 # used by who sources this

# Without line tables, which nobody reads here, all builds are shorter.
export CI=true CARGO_TERM_COLOR=never CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_INCREMENTAL=0 CARGO_NET_RETRY=5
# No times are measured here, and optimising across codegen units takes a fifth of the time to compile.
export CARGO_PROFILE_RELEASE_LTO=off
export DEBIAN_FRONTEND=noninteractive
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
SIMDOP_DATA=$(realpath -m "${SIMDOP_DATA:-../shared/data}")
export SIMDOP_DATA

NEON=aarch64-unknown-linux-gnu
# The smallest core that robots use: NEON and none of the later extensions, whose instructions end a test there.
NEON_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu -cpu cortex-a53"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
# For Miri, whose detection answers what the crate is compiled for: the features of the tokens in src/isa.
X86_FEATURES=+avx2,+bmi1,+bmi2,+f16c,+lzcnt,+popcnt,+avx512f,+avx512bw,+avx512vl

# Target, package in tests/no_std_consumer, and the instruction set that its queries must report. x86_64-unknown-none
# has a soft-float ABI and no vector kernels: those run without std in a Linux process.
BARE=(
  "thumbv7em-none-eabihf cortex-m-consumer scalar"
  "aarch64-unknown-none aarch64-none neon"
  "x86_64-unknown-none x86_64-none scalar"
  "x86_64-unknown-linux-gnu x86_64-none avx(2|512)"
)
CONSUMERS=tests/no_std_consumer

# Profile, packages and features of the README's test command, once `host_selection` has read it. All that is built in
# that profile for this machine is built with them, so that nothing is built twice.
HOST=()
# The same with the feature that tests and benches of devices need.
WITH_GPU=()

# A caller's flags would change what is tested.
clear_flags() {
  unset SIMDOP_REQUIRE_ISA SIMDOP_PAIRS SIMDOP_SUITE
  unset RUSTFLAGS RUSTDOCFLAGS CARGO_BUILD_TARGET CARGO_ENCODED_RUSTFLAGS
}

die() {
  echo "error: $*" >&2
  exit 1
}

# What ran where, for the summary.
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

# PACKAGE:PROOF, the proof being a command or a file that the package brings.
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

host_selection() {
  local -a words
  read -ra words <<<"$(readme_test_command)"
  [ "${words[*]:0:4}" = "cargo test --profile suite" ] ||
    die "the README's test command does not begin with cargo test --profile suite"
  HOST=("${words[@]:2}")
  # wgpu takes longer to build than all else, and most users have no use for it.
  WITH_GPU=("${HOST[@]}" --features simdop/gpu)
}

# The instruction sets of this CPU that tests must run on, with commas.
host_isas() { if has_avx512; then echo avx2,avx512; else echo avx2; fi; }

# neon ARGUMENTS...: cargo test for aarch64 on an emulated CPU.
neon() {
  SIMDOP_REQUIRE_ISA=neon CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$NEON_RUNNER \
    cargo test --locked --profile suite --target "$NEON" "$@"
}

# miri_kernels TARGET: the kernels' law in Miri. The scalar kernels have a part in each test, and no unsafe code to be
# looked at.
miri_kernels() {
  MIRIFLAGS=-Zmiri-disable-isolation \
    cargo +nightly miri test --locked --target "$1" --test kernel_law -- --skip scalar::
}

# short_bench NAME: a benchmark in its short form.
short_bench() {
  step "$1, short"
  timeout 120 cargo bench --quiet --locked "${WITH_GPU[@]}" --bench "$1" -- --test
  evidence "bench $1, short"
}

# fuzz_all RUNS SEED OPTIONS...: each target has an oracle; seed and count make a run repeatable. Built with the address
# sanitizer and checks of overflow. What the fuzzer finds new goes to a folder that is thrown away.
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

# conclude WHERE LOG ISA...: fails unless tests passed, and for each instruction set some that are named after it
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
