#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Runs under Miri, which finds undefined behaviour, what neither talks to Vulkan nor takes hours when it is interpreted: the
# readers and writers of texels, the arithmetic of terms, the axes.
#
# Needs a nightly toolchain with the components miri and rust-src.
set -eu
cd "$(dirname "$0")/.."

# Isolation keeps files away; threads that end with the process are no leak here.
export MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-ignore-leaks"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/miri"
cargo +nightly miri test --locked --lib -- \
    format::encoding::rgbe format::encoding::packed format::encoding::range format::fingerprint env::import::packed axis error texture
