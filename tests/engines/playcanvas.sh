#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# PlayCanvas in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
"$BAKER" env lights.exr --for playcanvas -o lights_atlas.png --quiet
"$BAKER" env lights.exr -o lights.hdr --quiet --shape equirect --mips 1 --size 256
node "$ENGINES/browser.mjs" playcanvas.mjs "$WORK" "$WORK/node_modules"
# Where the engine itself shows the same panorama: its middle towards the viewer of the usual camera.
for maps in own ours; do
    "$SPHERES" lights "playcanvas, $maps" playcanvas-$maps.f32 --shows z,y,-x --background playcanvas-$maps-background.f32 \
        ${PICTURES:+--png "$PICTURES/playcanvas.png"}
done
