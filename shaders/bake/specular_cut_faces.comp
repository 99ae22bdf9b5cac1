// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// The walk for lobes narrower than the leaves of a cube: it cuts them.
#define CUT 2
#define SHARED 0
#include "bake/specular_walk.glsl"
