// SPDX-License-Identifier: MIT OR Apache-2.0
// What the kernels of a BRDF of one's own need in single precision, where GLSL has the rest. acos of some drivers is good to
// 1e-4 only: `half_acos` is ours.

const float BAKER_PI = 3.14159265358979;

vec2 baker_circle(float x) { return vec2(cos(x), sin(x)); }
