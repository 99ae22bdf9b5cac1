#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Blender as a Python module (PyPI's bpy, 370 MB, for Python 3.11). Called by run.sh.
set -eu
cd "$WORK"
BPY=bpy==5.0.1
if [ ! -f venv/installed ] || [ "$(cat venv/installed)" != "$BPY" ]; then
    rm -rf venv
    python=$(command -v python3.11) || { echo "blender: needs Python 3.11" >&2; exit 1; }
    "$python" -m venv venv
    venv/bin/pip install -q --disable-pip-version-check "$BPY"
    echo "$BPY" >venv/installed
fi
"$BAKER" env lights.exr --for blender -o blender.exr --quiet
venv/bin/python "$ENGINES/blender.py" . >blender.log 2>&1 || { cat blender.log >&2; exit 1; }
"$SPHERES" lights blender blender-lights.f32 --background blender-background.f32 \
    ${PICTURES:+--png "$PICTURES/blender.png"}
