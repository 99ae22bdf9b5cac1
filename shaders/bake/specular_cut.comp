// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// The walk for lobes narrower than the leaves: it cuts them.
#define CUT 1
#define SHARED 0
#include "bake/specular_walk.glsl"
