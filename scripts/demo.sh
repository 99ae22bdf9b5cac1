#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Bakes a split-sum table, an albedo table and an environment, verifies all three, and draws them and what they light.
set -eu
cd "$(dirname "$0")/.."

out=${DEMO_DIR:-demo-out}
baker=target/release/brdf-baker
mkdir -p "$out"

# Prints a command, then runs it.
show() {
    printf '\n$ %s\n' "$*"
    "$@"
}

# shellcheck disable=SC2086 # flags are words
example() {
    name=$1
    shift
    cargo run --quiet --release --locked ${CARGO_DEMO_FLAGS:-} --example "$name" -- "$@"
}

show $baker sky -o "$out/sky.exr" --elevation 25 --sun-disc --exposure -5
show $baker bake split-sum -o "$out/dfg.ktx2"
show $baker bake albedo -o "$out/albedo.exr" --size 64 --encoding r32f
show $baker env "$out/sky.exr" -o "$out/sky.ktx2"
show $baker verify "$out/dfg.ktx2"
show $baker verify "$out/albedo.exr"
show $baker verify "$out/sky.ktx2" --source "$out/sky.exr"
show $baker preview -o "$out/spheres.png" --env "$out/sky.exr" --lut "$out/dfg.ktx2" --compensate
example contact_sheet "$out/dfg.ktx2" "$out/sky.ktx2" "$out/preview.png"
printf '\nLook at %s/preview.png, the table and the environment from smooth to rough, and at %s/spheres.png.\n' "$out" "$out"
