#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Babylon.js in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
"$BAKER" env lights.exr --for babylon -o lights.env --quiet
"$BAKER" env lights.exr -o lights.hdr --quiet --shape equirect --mips 1 --size 256
"$BAKER" bake split-sum --for babylon -o babylon_brdf.png --quiet
node "$ENGINES/browser.mjs" babylon.mjs "$WORK" "$WORK/node_modules"
# Where Babylon itself shows the same panorama: its middle straight ahead, in either of its worlds.
for hand in left right; do
    for maps in ours own; do
        "$SPHERES" lights "babylon, $hand-handed, $maps" babylon-$hand-$maps.f32 --shows=-z,y,x \
            --background babylon-$hand-$maps-background.f32 ${PICTURES:+--png "$PICTURES/babylon.png"}
    done
done
# Babylon's own table is off by up to 2 % at grazing angles.
"$SPHERES" alike "babylon, our table and its own" babylon-table-ours.f32 babylon-table-own.f32 --bound 0.01
