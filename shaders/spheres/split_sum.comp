// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Spheres lit by a filtered environment, a split-sum table and an irradiance map. Rust twin: src/spheres/shade.rs.

#define ALONE 0
#include "spheres/scene.glsl"

vec3 shade(Surface s) {
    vec3 mirrored = 2.0 * s.n.z * s.n - vec3(0.0, 0.0, 1.0);
    vec3 light = filtered(mirrored, s.roughness);
    return leaving(s, s.split.x * light, s.split.y * light, s.split.z * light, lookup(scene.diffuse_level, s.n));
}
