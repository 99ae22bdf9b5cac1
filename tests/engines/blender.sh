#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Blender as a Python module (PyPI's bpy, 370 MB, for Python 3.11). Called by run.sh.
set -eu
cd "$WORK"
. "$ENGINES/venv.sh"
python=$(command -v python3.11) || { echo "blender: needs Python 3.11" >&2; exit 1; }
venv venv "$python" bpy==5.0.1
"$BAKER" env lights.exr --for blender -o blender.exr --quiet
venv/bin/python "$ENGINES/blender.py" . >blender.log 2>&1 || { cat blender.log >&2; exit 1; }
"$SPHERES" lights blender blender-lights.f32 --background blender-background.f32 \
    ${PICTURES:+--png "$PICTURES/blender.png"}
