#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Opens pages of `verify --report` in headless Chromium, light and dark: no message on the console, every number equal to
# that of `verify --json`. Chromium and node come from apt when they are missing (CHROMIUM names another). Screenshots stay
# in target/report.
set -eu
cd "$(dirname "$0")/../.."

NEED_FLAGS=--no-install-recommends
. scripts/need.sh
need nodejs node --version
need chromium "${CHROMIUM:-chromium}" --version

# With what `make` builds with, so that nothing is built twice.
# shellcheck disable=SC2046 # flags are words
cargo build --quiet --release $(sh scripts/setup.sh --cargo-flags)
rm -rf target/report
mkdir -p target/report
target/release/brdf-baker sky -o target/report/sky.exr --size 256 --elevation 25 --sun-disc --exposure -5
node tests/report/check.mjs target/release/brdf-baker target/report
