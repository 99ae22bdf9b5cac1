#!/bin/sh
# three.js in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
for environment in sky lights; do
    "$BAKER" env $environment.exr -o three-$environment.ktx2 --quiet \
        --size 256 --mips 6 --roughness-law quadratic --mirror
done
"$BAKER" bake split-sum -o three-dfg.ktx2 --quiet --size 128 --axes roughness,n_dot_v
node "$ENGINES/browser.mjs" three.mjs "$WORK" "$WORK/node_modules"
"$SPHERES" lights three three-lights.f32 --background three-background.f32
"$SPHERES" compare "$WORK" --formula three ${PICTURES:+--png "$PICTURES/three.png"} \
    ours@6=three-ours.f32 own@6=three-own.f32 table@6=three-table.f32
