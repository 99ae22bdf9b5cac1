#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# three.js in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
for environment in sky lights; do
    "$BAKER" env $environment.exr --for three -o three-$environment.ktx2 --quiet
done
# Larger than the engine's own, and where a loader finds it.
"$BAKER" bake split-sum --for three -o three-dfg.ktx2 --size 128 --quiet
node "$ENGINES/browser.mjs" three.mjs "$WORK" "$WORK/node_modules"
"$SPHERES" lights three three-lights.f32 --background three-background.f32
"$SPHERES" compare "$WORK" --formula three --bound "$BOUND" ${PICTURES:+--png "$PICTURES/three.png"} \
    ours@6=three-ours.f32 own@6=three-own.f32 table@6=three-table.f32
