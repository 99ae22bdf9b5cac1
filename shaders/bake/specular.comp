// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// The walk over nodes that are small enough as they are.
#define CUT 0
#define SHARED 0
#include "bake/specular_walk.glsl"
