// SPDX-License-Identifier: MIT OR Apache-2.0
// What the h-split rule's kernels share: a grid of texels, one invocation a texel, whose outer nodes and rows are laid out
// by src/rule/h_split.rs.

#include "lib/slice.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer NDotV { float n_dot_v_of[]; };
// A row's distribution: (alpha, three numbers of the map), (power, linear, 0, 0), then the coefficients of Smith's function.
layout(std430, set = 0, binding = 1) readonly buffer Rows { vec4 row_of[]; };
// Outer nodes of all texels, (tan theta_h, weight) each.
layout(std430, set = 0, binding = 2) readonly buffer Nodes { vec2 nodes[]; };
// Texel i owns the nodes from first_node[i] to first_node[i + 1].
layout(std430, set = 0, binding = 3) readonly buffer FirstNode { uint first_node[]; };
layout(std430, set = 0, binding = 4) writeonly buffer Result { vec4 result[]; };
