#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Builds the program as a Python wheel into target/wheels, with maturin from PyPI, which lies in target/wheel/venv.
# Python's venv comes from apt when it is missing.
set -eu
cd "$(dirname "$0")/.."
venv=$PWD/target/wheel/venv

. scripts/need.sh
. scripts/venv.sh
venv "$venv" "tests/wheel/requirements.txt"

# A folder that other versions' wheels do not lie in.
rm -rf target/wheels
# What `make` builds with, and what pack-spirv turns on there: nothing but the program itself is compiled for the wheel.
# shellcheck disable=SC2046 # flags are words
"$venv/bin/maturin" build --quiet --release --out target/wheels --features compile-shaders $(sh scripts/setup.sh --cargo-flags)
