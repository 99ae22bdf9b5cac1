#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Khronos' glTF Sample Renderer in Chromium on SwiftShader. Called by run.sh. Its own filter takes minutes on a processor.
set -eu
cd "$WORK"
for environment in sky lights; do
    "$BAKER" env $environment.exr --for gltf -o gltf-${environment}_specular.ktx2 --quiet
done
"$BAKER" env sky.exr -o gltf-sky.hdr --quiet --shape equirect --mips 1 --size 512
"$BAKER" bake split-sum --for gltf -o gltf-lut.png --quiet
LIMIT=1500 node "$ENGINES/browser.mjs" gltf.mjs "$WORK" "$WORK/node_modules"
"$SPHERES" lights gltf gltf-lights.f32 --background gltf-background.f32
# As the renderer turns environments unless it is told not to: the middle along +Z.
"$SPHERES" lights "gltf, turned" gltf-lights-turned.f32 --background gltf-background-turned.f32 --shows z,y,-x
# The spheres' roughnesses lie on the renderer's own five mips, between ours.
"$SPHERES" compare "$WORK" --formula gltf --bound "$BOUND" --other-mips ${PICTURES:+--png "$PICTURES/gltf.png"} \
    ours@8=gltf-ours.f32 own@5=gltf-own.f32 table@8=gltf-table.f32
