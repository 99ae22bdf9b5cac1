// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// The same spheres by an integral over the BRDF's half vectors: src/spheres/nodes.rs places them, src/spheres/shade.rs is the
// f64 twin.

#define ALONE 1
#include "spheres/scene.glsl"
#include <visibility>
#include "term/fresnel/schlick.glsl"

// Half vectors about the normal: x, y, weight, level of detail.
layout(std430, set = 0, binding = 8) readonly buffer Nodes { vec4 node_of[]; };
// Smith's function, a row a roughness.
layout(std430, set = 0, binding = 9) readonly buffer Rows { vec4 row_of[]; };
// Where a texture varies the roughness, lobes for evenly spaced ones from 0 to 1: first node and 2^24 times the row, number of
// nodes.
layout(std430, set = 0, binding = 10) readonly buffer Lobes { uvec2 lobe_of[]; };

#include "lib/smith_row.glsl"

const uint ROW = 8u;

// The environment along d, averaged over about a node's share of the sphere.
vec3 source(vec3 d, float lod) {
    float level = clamp(floor(lod + 0.5), 0.0, float(scene.source_levels - 1u));
    return lookup(scene.source_level + uint(level), d);
}

vec3 integral(Surface s, uvec2 lobe) {
    float n_dot_v = max(s.n.z, 1e-4);
    // Any two directions that complete the normal.
    vec3 other = abs(s.n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 t = normalize(cross(other, s.n));
    vec3 b = cross(s.n, t);

    vec3 scale_light = vec3(0.0);
    vec3 bias_light = vec3(0.0);
    vec3 f82_light = vec3(0.0);
    if (lobe.y == 0u) {
        float g = n_dot_v * g_over_n_dot_v(Directions(n_dot_v, n_dot_v, 1.0, n_dot_v, n_dot_v, n_dot_v, 0.0));
        float schlick = schlick_weight(1.0 - n_dot_v);
        vec3 light = g * lookup(scene.source_level, 2.0 * s.n.z * s.n - vec3(0.0, 0.0, 1.0));
        scale_light = (1.0 - schlick) * light;
        bias_light = schlick * light;
        f82_light = n_dot_v * (1.0 - n_dot_v) * schlick * light;
    } else {
        load_row(ROW * (lobe.x >> 24u));
        uint first = lobe.x & 0xffffffu;
        float alpha = row_map.x;
        float sigma_v = projected_area(n_dot_v);
        for (uint i = first; i < first + lobe.y; i++) {
            vec4 node = node_of[i];
            float n_dot_h = sqrt(max(1.0 - node.x * node.x - node.y * node.y, 0.0));
            vec3 h = node.x * t + node.y * b + n_dot_h * s.n;
            float v_dot_h = h.z;
            vec3 l = 2.0 * v_dot_h * h - vec3(0.0, 0.0, 1.0);
            float n_dot_l = dot(s.n, l);
            if (v_dot_h > 0.0 && n_dot_l > 0.0) {
                float f = node.z * v_dot_h / n_dot_h * g_over_n_dot_v(Directions(
                    n_dot_l, n_dot_v, n_dot_h, v_dot_h, projected_area(n_dot_l), sigma_v, alpha));
                float schlick = schlick_weight(1.0 - v_dot_h);
                vec3 light = f * source(l, node.w + 0.5 * log2(v_dot_h));
                scale_light += (1.0 - schlick) * light;
                bias_light += schlick * light;
                f82_light += v_dot_h * (1.0 - v_dot_h) * schlick * light;
            }
        }
    }
    return leaving(s, scale_light, bias_light, f82_light, lookup(scene.diffuse_level, s.n));
}

vec3 shade(Surface s) {
    if (scene.lobes == 0u) {
        return integral(s, uvec2(s.first_node, s.node_count));
    }
    float at = s.roughness * float(scene.lobes - 1u);
    uint lower = min(uint(at), scene.lobes - 2u);
    return mix(integral(s, lobe_of[lower]), integral(s, lobe_of[lower + 1u]), at - float(lower));
}
