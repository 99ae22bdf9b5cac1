#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Reads files of every format with what is not ours: OpenImageIO, OpenEXR, Pillow, NumPy, imagecodecs (Python), ktx-parse
# (node), and the compilers of the languages that tables are written in.
# The other way round, environments that the Python ones wrote are read here.
# Installs them under target/readers; Python's venv, node and npm come from apt when they are missing. Fails loudly.
set -eu
cd "$(dirname "$0")/../.."
readers=$PWD/tests/readers
work=$PWD/target/readers
samples=$work/samples
mkdir -p "$work"

. scripts/need.sh
. scripts/venv.sh
need nodejs node --version
need npm npm --version

venv "$work/venv" "$readers/requirements.txt"
if ! cmp -s "$readers/package.json" "$work/package.json" || [ ! -d "$work/node_modules/typescript" ]; then
    cp "$readers/package.json" "$work/"
    (cd "$work" && npm install --silent --no-audit --no-fund)
fi
cp "$readers/read.mjs" "$readers/levels.mjs" "$work/" # node looks for modules beside the script

# What `make` builds with, so that nothing is built twice.
flags=$(sh scripts/setup.sh --cargo-flags)

rm -rf "$samples"
# shellcheck disable=SC2086 # flags are words
cargo run --quiet --release $flags --example write_samples -- "$samples"
"$work/venv/bin/python" "$readers/read.py" "$samples"
node "$work/read.mjs" "$samples"

rm -rf "$work/inputs"
"$work/venv/bin/python" "$readers/write.py" "$work/inputs"
# shellcheck disable=SC2086
cargo run --quiet --release $flags --example read_inputs -- "$work/inputs"

rm -rf "$work/targets"
# shellcheck disable=SC2086
cargo build --quiet --release $flags --bin brdf-baker
"$work/venv/bin/python" "$readers/targets.py" "$PWD/target/release/brdf-baker" "$work/targets" "$work"
