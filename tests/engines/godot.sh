#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Godot's web build in Chromium on SwiftShader: the compatibility renderer. Called by run.sh.
set -eu
cd "$WORK"
# A web build without threads cannot read EXR at run time.
"$BAKER" env lights.exr --for godot -o godot-lights.hdr --quiet
node "$ENGINES/browser.mjs" godot.mjs "$WORK" "$WORK/node_modules"
# Where the engine shows a panorama: its middle along +Z.
for sky in material shader; do
    "$SPHERES" lights "godot, $sky" godot-$sky-lights.f32 --shows z,y,-x --background godot-$sky-background.f32 \
        ${PICTURES:+--png "$PICTURES/godot.png"}
done
