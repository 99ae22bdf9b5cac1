#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Opens a page of `brdf-baker view` in headless Chromium on SwiftShader, uses every control, and compares screenshots with the
# pictures of `brdf-baker preview`; then a browser without WebGL 2. Chromium and node come from apt when they are missing.
# Screenshots stay in target/view.
set -eu
cd "$(dirname "$0")/../.."

NEED_FLAGS=--no-install-recommends
. scripts/need.sh
need nodejs node --version
need chromium "${CHROMIUM:-chromium}" --version

# With what `make` builds with, so that nothing is built twice.
# shellcheck disable=SC2046 # flags are words
cargo build --quiet --release $(sh scripts/setup.sh --cargo-flags)
rm -rf target/view
mkdir -p target/view
target/release/brdf-baker sky -o target/view/sky.exr --size 256 --elevation 25 --sun-disc --exposure -5
target/release/brdf-baker sky -o target/view/evening.exr --size 128 --elevation 4 --azimuth 200 --turbidity 5 --exposure -5
node tests/view/check.mjs target/release/brdf-baker target/view
