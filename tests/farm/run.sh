#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Bakes 210 probes as a render farm does: the job that `run --emit-openjd` writes, checked and run by Open Job Description's
# own program (openjd-cli, from PyPI, installed under target/farm) in four workers, of which one is killed at work.
# Python's venv comes from apt when it is missing.
set -eu
cd "$(dirname "$0")/../.."
work=$PWD/target/farm
mkdir -p "$work"

. scripts/need.sh
. scripts/venv.sh
venv "$work/venv" "tests/farm/requirements.txt"

# With what `make` builds with, so that nothing is built twice.
# shellcheck disable=SC2046 # flags are words
cargo build --quiet --release $(sh scripts/setup.sh --cargo-flags) --bin brdf-baker
rm -rf "$work/studio"
"$work/venv/bin/python" tests/farm/check.py "$PWD/target/release/brdf-baker" "$work/venv/bin/openjd" "$work/studio"
