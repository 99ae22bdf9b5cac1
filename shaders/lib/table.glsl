// What every table kernel shares: a grid of (n_dot_v, alpha), one invocation a texel.

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer NDotV { float n_dot_v_of[]; };
layout(std430, set = 0, binding = 1) readonly buffer Alpha { float alpha_of[]; };
// Nodes of the rule that are loaded: (near, far, weight, 0).
layout(std430, set = 0, binding = 2) readonly buffer ConeOuter { vec4 cone_outer[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Result { float result[]; };

// A slice of the grid: texels [first, first + count), rows of `columns` texels with n_dot_v along them.
layout(push_constant) uniform Slice { uint columns; uint first; uint count; } slice;
