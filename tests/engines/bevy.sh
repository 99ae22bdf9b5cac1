#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Bevy without a window, on whatever Vulkan device there is. Called by run.sh. Builds Bevy at the first run.
set -eu
cd "$WORK"
CARGO_TARGET_DIR=${BEVY_TARGET_DIR:-$WORK/bevy} cargo build --quiet --release --locked --manifest-path "$ENGINES/bevy/Cargo.toml"
for environment in sky lights; do
    "$BAKER" env $environment.exr --for bevy -o bevy-${environment}_specular.ktx2 --quiet
done
"$BAKER" bake split-sum --for bevy -o bevy-dfg.ktx2 --quiet
for job in ours own table lights; do
    # Only what it complains about; that the device is a processor is no complaint here.
    RUST_LOG=warn NO_COLOR=1 "${BEVY_TARGET_DIR:-$WORK/bevy}/release/bevy-spheres" "$WORK" $job >bevy.log 2>&1 ||
        { cat bevy.log >&2; exit 1; }
    if grep -E 'ERROR|WARN' bevy.log | grep -vE 'software rendering|readback result'; then exit 1; fi
done
"$SPHERES" lights bevy bevy-lights.f32 --background bevy-background.f32
"$SPHERES" compare "$WORK" --formula bevy --bound "$BOUND" ${PICTURES:+--png "$PICTURES/bevy.png"} \
    ours@8=bevy-ours.f32 own@10=bevy-own.f32 table@8=bevy-table.f32
