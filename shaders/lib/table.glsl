// SPDX-License-Identifier: MIT OR Apache-2.0
// What the cone rule's kernels share: a grid of (n_dot_v, alpha), one invocation a texel.

#include "lib/slice.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer NDotV { float n_dot_v_of[]; };
layout(std430, set = 0, binding = 1) readonly buffer Alpha { float alpha_of[]; };
// Nodes of the rule that are loaded: (near, far, weight, 0).
layout(std430, set = 0, binding = 2) readonly buffer ConeOuter { vec4 cone_outer[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Result { vec4 result[]; };
