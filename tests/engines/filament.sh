#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Filament's WebAssembly in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
"$BAKER" env lights.exr --for filament -o filament_ibl.ktx --quiet
node "$ENGINES/browser.mjs" filament.mjs "$WORK" "$WORK/node_modules"
# As cmgen places a panorama: its middle along +Z.
"$SPHERES" lights filament filament-lights.f32 --shows z,y,-x --background filament-background.f32 \
    ${PICTURES:+--png "$PICTURES/filament.png"}
