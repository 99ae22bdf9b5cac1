#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# MaterialX' shaders (from PyPI's package) in Chromium on SwiftShader. Called by run.sh.
set -eu
cd "$WORK"
. "$ENGINES/venv.sh"
venv materialx python3 materialx==1.39.5 openexr==3.5.3 numpy
for environment in sky lights; do
    "$BAKER" env $environment.exr --for materialx -o materialx-${environment}_specular.exr --quiet
done
"$BAKER" bake split-sum --for materialx -o materialx-table.exr --quiet
materialx/bin/python "$ENGINES/materialx.py" . sky materialx-table materialx-sky_specular materialx-sky_irradiance \
    materialx-lights_specular materialx-lights_irradiance
node "$ENGINES/browser.mjs" materialx.mjs "$WORK" "$WORK/node_modules"
# Where MaterialX itself shows the same panorama: its middle along +Z.
"$SPHERES" lights materialx materialx-lights.f32 --shows z,y,-x
"$SPHERES" compare "$WORK" --formula materialx --bound "$BOUND" ${PICTURES:+--png "$PICTURES/materialx.png"} \
    ours@8=materialx-ours.f32 own@9=materialx-own.f32 table@8=materialx-ours-but-table.f32
