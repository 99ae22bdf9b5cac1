#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Draws spheres in real engines with what brdf-baker bakes, and compares them with an f64 reference.
#
#   tests/engines/run.sh [ENGINE...]     default: all but bevy, whose first build takes long, blender, which is large, and
#                                        gltf, whose own filter takes minutes on a processor
#
# Engines come from their package registries into target/engines; Chromium, node and npm from apt when they are missing
# (CHROMIUM names another).
# An engine is a script here: it bakes, draws, and compares. Pictures stay in target/engines; with PICTURES=FOLDER small ones
# are put there too. SKY=FILE.exr is a panorama of your own (twice as wide as high) instead of the test's sky, BOUND the
# largest error that is right (0.02): what engines lose between two mips grows with the contrast.
set -eu
cd "$(dirname "$0")/../.."
export ENGINES="$PWD/tests/engines" WORK="$PWD/target/engines" BAKER="$PWD/target/release/brdf-baker"
export SPHERES="$PWD/target/release/examples/spheres"
mkdir -p "$WORK"

. scripts/need.sh
need nodejs node --version
need npm npm --version
need chromium "${CHROMIUM:-chromium}" --version

if ! cmp -s "$ENGINES/package.json" "$WORK/package.json" || [ ! -d "$WORK/node_modules" ]; then
    cp "$ENGINES/package.json" "$WORK/"
    # Only what pages load: no scripts of packages, and not what they want beside them.
    (cd "$WORK" && npm install --silent --no-audit --no-fund --ignore-scripts --legacy-peer-deps)
fi
# With what `make` builds with, so that nothing is built twice.
# shellcheck disable=SC2046 # flags are words
cargo build --quiet --release $(sh scripts/setup.sh --cargo-flags) --bin brdf-baker --example spheres
"$SPHERES" prepare "$WORK"
[ -z "${SKY:-}" ] || cp "$SKY" "$WORK/sky.exr"
export BOUND="${BOUND:-0.02}"

[ $# -gt 0 ] || set -- three babylon filament godot materialx playcanvas
failed=
for engine; do
    start=$(date +%s)
    if sh "$ENGINES/$engine.sh"; then verdict=right; else verdict=WRONG && failed="$failed $engine"; fi
    echo "engines: $engine: $verdict, $(($(date +%s) - start)) s"
done
[ -z "$failed" ] || { echo "engines: wrong:$failed" >&2; exit 1; }
