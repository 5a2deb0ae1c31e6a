# Parts of the stages of .ci/run, and of .ci/mutations: both source this file.
# shellcheck shell=bash

NEON=aarch64-unknown-linux-gnu
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
# For Miri, whose detection answers what the crate is compiled for: the features of the tokens in src/isa.
# shellcheck disable=SC2034 # used by who sources this
X86_FEATURES=+avx2,+bmi1,+bmi2,+f16c,+lzcnt,+popcnt,+avx512f,+avx512bw,+avx512vl

# The features that benches and tests of wgpu are built with: the same, so that nothing is built twice.
BENCHED=gpu,rayon,urdf

# The features of the README's command.
# shellcheck disable=SC2034 # used by who sources this
TESTED=simdop/rayon,simdop/mint,simdop/nalgebra,simdop/urdf,simdop-cli/report,simdop-cli/selftest

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

# neon CPU ARGUMENTS...: cargo test for aarch64 on an emulated CPU.
neon() {
  local cpu=$1
  shift
  CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu -cpu $cpu" \
    cargo test --locked --target "$NEON" "$@"
}

# miri_kernels TARGET: the kernels' law in Miri. The scalar kernels have a part in each test, and no unsafe code to be looked at.
miri_kernels() {
  MIRIFLAGS=-Zmiri-disable-isolation cargo +nightly miri test --locked --target "$1" --test kernel_law -- --skip scalar::
}

# short_bench NAME: a benchmark in its short form.
short_bench() {
  step "$1, short"
  timeout 60 cargo bench --quiet --locked --features "$BENCHED" --bench "$1" -- --test
  evidence "bench $1, short"
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
    count=$(grep -cE "^test (.*[^a-z0-9])?$isa([^a-z0-9].*)? \.\.\. ok$" "$log") || die "no test named after $isa ran on $place"
    line+=" $isa $count"
  done
  evidence "$line"
}
