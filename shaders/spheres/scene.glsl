// SPDX-License-Identifier: MIT OR Apache-2.0
// Spheres on a grid under an environment: what both kernels of the preview share. src/spheres/scene.rs says where things are,
// src/spheres/shade.rs is the f64 twin. The including shader defines `vec3 shade(Surface surface)`, and ALONE as 1 where one
// look at the middle of a pixel will do because rough spheres change little within it.

#include "term/cube.glsl"
#include "term/surface.glsl"
#include "lib/warp.glsl"

layout(local_size_x = 32) in;

// `Block` in src/spheres/gpu.rs.
layout(std430, set = 0, binding = 0) readonly buffer Scene {
    uint width;
    uint height;
    uint columns;
    uint rows;
    float tile_px;
    float radius;        // of a sphere, in tiles
    uint mips;           // of the filtered environment: levels 0 to mips - 1
    uint diffuse_level;
    uint source_level;   // the first level of the environment itself
    uint source_levels;
    uint table_width;
    uint table_height;
    vec2 table_place_x;  // texel = position * scale + shift
    vec2 table_place_y;
    uint table_warp_x;   // which position
    uint table_warp_y;
    uint compensate;
    float background;    // radiance behind the spheres; below 0 the environment
    uint map_width;      // of the pictures on the spheres; 0 for none
    uint map_height;
    uint lobes;          // of the reference, where a texture varies the roughness; else 0
    vec4 frame[3];       // rows of the matrix from the viewer's directions to the maps'
} scene;
// Three a sphere, floats by their bits: base colour and metallic | roughness, F0 as a dielectric, first node and 2^24 times
// the row, number of nodes | what the tint takes from a metal's edge.
layout(std430, set = 0, binding = 1) readonly buffer Spheres { uvec4 sphere_of[]; };
// Faces of all levels, each with a border of one texel that repeats its neighbours.
layout(std430, set = 0, binding = 2) readonly buffer Texels { vec4 texels[]; };
// First texel, texels along a side without the border, bits of the roughness.
layout(std430, set = 0, binding = 3) readonly buffer Levels { uvec4 level_of[]; };
// Scale and bias of F0, and the tint of F82.
layout(std430, set = 0, binding = 4) readonly buffer Table { vec4 table_of[]; };
// Pictures on the spheres, two values a texel: base colour and metallic | normal and roughness. src/spheres/pictures.rs.
layout(std430, set = 0, binding = 5) readonly buffer Maps { vec4 maps[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Result { vec4 result[]; };
// Pixels, those of like cost together.
layout(std430, set = 0, binding = 7) readonly buffer Order { uint order[]; };

layout(push_constant) uniform Slice { uint first; uint count; } slice;

// Samples a pixel, in sixteenths from its middle: each row and column of eight has one.
const uint PARTS = 8u;
const vec2 PART_OF[8] = vec2[](
    vec2(1, -3), vec2(-1, 3), vec2(5, 1), vec2(-3, -5), vec2(-5, 5), vec2(-7, -1), vec2(3, 7), vec2(7, -7));

struct Surface {
    vec3 base;
    float metallic;
    float roughness;
    float f0;
    uint first_node;
    uint node_count;
    vec3 edge;
    vec3 n;
    // Scale, bias and tint.
    vec3 split;
};

// Radiance of a level along d, bilinear and without seams.
vec3 lookup(uint level, vec3 d) {
    vec3 at = locate(vec3(dot(scene.frame[0].xyz, d), dot(scene.frame[1].xyz, d), dot(scene.frame[2].xyz, d)));
    uvec4 l = level_of[level];
    float size = float(l.y);
    uint row = l.y + 2u;
    vec2 place = (0.5 * at.yz + 0.5) * size + 0.5;
    vec2 whole = min(floor(place), vec2(size));
    vec2 share = place - whole;
    uint index = l.x + (uint(at.x) * row + uint(whole.y)) * row + uint(whole.x);
    vec3 above = mix(texels[index].rgb, texels[index + 1u].rgb, share.x);
    vec3 below = mix(texels[index + row].rgb, texels[index + row + 1u].rgb, share.x);
    return mix(above, below, share.y);
}

// The filtered environment along d at a roughness, between the two mips next to it.
vec3 filtered(vec3 d, float roughness) {
    uint upper = 0u;
    while (upper + 1u < scene.mips && uintBitsToFloat(level_of[upper].z) < roughness) {
        upper++;
    }
    uint lower = upper > 0u ? upper - 1u : 0u;
    float from = uintBitsToFloat(level_of[lower].z);
    float to = uintBitsToFloat(level_of[upper].z);
    float share = to > from ? clamp((roughness - from) / (to - from), 0.0, 1.0) : 0.0;
    return mix(lookup(lower, d), lookup(upper, d), share);
}

// Scale, bias and tint at n_dot_v and roughness.
vec3 table(float n_dot_v, float roughness) {
    vec2 last = vec2(scene.table_width - 1u, scene.table_height - 1u);
    float x = position(scene.table_warp_x, n_dot_v, roughness) * scene.table_place_x.x + scene.table_place_x.y;
    float y = position(scene.table_warp_y, n_dot_v, roughness) * scene.table_place_y.x + scene.table_place_y.y;
    vec2 place = clamp(vec2(x, y), vec2(0.0), last);
    vec2 whole = min(floor(place), max(last - 1.0, 0.0));
    vec2 share = place - whole;
    uint right = scene.table_width > 1u ? 1u : 0u;
    uint down = scene.table_height > 1u ? scene.table_width : 0u;
    uint index = uint(whole.y) * scene.table_width + uint(whole.x);
    return mix(
        mix(table_of[index].xyz, table_of[index + right].xyz, share.x),
        mix(table_of[index + down].xyz, table_of[index + down + right].xyz, share.x), share.y);
}

// What leaves a surface: light through scale, light through bias, light through the tint, and irradiance over pi.
vec3 leaving(Surface s, vec3 scale_light, vec3 bias_light, vec3 f82_light, vec3 diffuse_light) {
    float albedo = max(s.split.x + s.split.y, 1e-6);
    float gain_f0 = scene.compensate == 1u ? compensation(s.f0, albedo) : 1.0;
    float reflected = (s.f0 * s.split.x + s.split.y) * gain_f0;
    vec3 sum;
    for (int c = 0; c < 3; c++) {
        float gain = scene.compensate == 1u ? compensation(s.base[c], albedo) : 1.0;
        vec3 split = vec3(scale_light[c], bias_light[c], f82_light[c]);
        sum[c] = specular(split, s.base[c], s.edge[c], s.f0, s.metallic, gain, gain_f0)
            + body(s.base[c], s.metallic, reflected) * diffuse_light[c];
    }
    return sum;
}

vec3 shade(Surface surface);

// Two values of the pictures at their texel (x, y), which repeats along x.
mat2x4 map_at(uint x, uint y) {
    uint index = 2u * (min(y, scene.map_height - 1u) * scene.map_width + x % scene.map_width);
    return mat2x4(maps[index], maps[index + 1u]);
}

// Multiplies a surface by the pictures, and turns its normal: u runs eastwards from the back of the sphere, v from its top
// to its bottom; the tangent points east, the bitangent north.
void paint(inout Surface s) {
    vec3 n = s.n;
    float u = 0.5 + 0.159154943 * atan(n.x, n.z);
    float v = 0.318309886 * acos(clamp(n.y, -1.0, 1.0));
    vec2 place = vec2(u * float(scene.map_width) - 0.5, max(v * float(scene.map_height) - 0.5, 0.0));
    place.x = place.x < 0.0 ? place.x + float(scene.map_width) : place.x;
    vec2 share = fract(place);
    uint x = uint(place.x);
    uint y = uint(place.y);
    mat2x4 value = (1.0 - share.y) * ((1.0 - share.x) * map_at(x, y) + share.x * map_at(x + 1u, y))
        + share.y * ((1.0 - share.x) * map_at(x, y + 1u) + share.x * map_at(x + 1u, y + 1u));
    s.base *= value[0].rgb;
    s.metallic *= value[0].w;
    s.roughness *= value[1].w;
    vec3 east = vec3(n.z, 0.0, -n.x) * inversesqrt(max(n.x * n.x + n.z * n.z, 1e-12));
    s.n = normalize(value[1].x * east + value[1].y * cross(n, east) + value[1].z * n);
}

// The surface of a sphere where its normal is n.
Surface surface_at(uint sphere, vec3 n) {
    vec4 a = uintBitsToFloat(sphere_of[3u * sphere]);
    uvec4 b = sphere_of[3u * sphere + 1u];
    vec3 edge = uintBitsToFloat(sphere_of[3u * sphere + 2u].xyz);
    Surface s = Surface(a.rgb, a.w, uintBitsToFloat(b.x), uintBitsToFloat(b.y), b.z, b.w, edge, n, vec3(0.0));
    if (scene.map_width > 0u) {
        paint(s);
    }
    s.split = table(clamp(s.n.z, 1e-4, 1.0), s.roughness);
    return s;
}

// What lies under a point of the picture.
struct Seen {
    uint sphere;
    // From the sphere's middle, in radii.
    vec2 offset;
    // Squared third component of the normal; not above 0 beside the sphere.
    float left;
};

vec2 from_middle(vec2 at) {
    return vec2(at.x - 0.5 * float(scene.width), 0.5 * float(scene.height) - at.y);
}

Seen seen_at(vec2 at) {
    vec2 tiles = from_middle(at) / scene.tile_px;
    vec2 grid = vec2(scene.columns, scene.rows);
    vec2 cell = floor(vec2(tiles.x + 0.5 * grid.x, 0.5 * grid.y - tiles.y));
    vec2 centre = vec2(cell.x + 0.5 - 0.5 * grid.x, 0.5 * grid.y - 0.5 - cell.y);
    vec2 offset = (tiles - centre) / scene.radius;
    bool inside = all(greaterThanEqual(cell, vec2(0.0))) && all(lessThan(cell, grid));
    uint sphere = inside ? uint(cell.y) * scene.columns + uint(cell.x) : 0u;
    return Seen(sphere, offset, inside ? 1.0 - dot(offset, offset) : 0.0);
}

// Does a rough sphere fill the pixel?
bool is_alone(vec2 at) {
    Seen seen = seen_at(at);
    float most = 1.0 - 0.75 / (scene.radius * scene.tile_px);
    return seen.left > 1.0 - most * most && sphere_of[3u * seen.sphere + 1u].w > 0u;
}

// The environment behind the spheres, out of focus: as a camera with a field of view of 60 degrees sees it.
vec3 behind(vec2 at) {
    if (scene.background >= 0.0) {
        return vec3(scene.background);
    }
    return filtered(vec3(from_middle(at) * (1.1547 / float(scene.height)), -1.0), 0.45);
}

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint index = order[slice.first + gl_GlobalInvocationID.x];
    vec2 pixel = vec2(index % scene.width, index / scene.width);
    vec3 sum = vec3(0.0);
    float covered = 0.0;
    uint parts = ALONE == 1 && is_alone(pixel + 0.5) ? 1u : PARTS;
    for (uint part = 0u; part < parts; part++) {
        vec2 at = pixel + 0.5 + (parts == 1u ? vec2(0.0) : 0.0625 * PART_OF[part]);
        Seen seen = seen_at(at);
        if (seen.left > 0.0) {
            sum += shade(surface_at(seen.sphere, vec3(seen.offset, sqrt(seen.left))));
            covered += 1.0;
        } else {
            sum += behind(at);
        }
    }
    result[index] = vec4(sum, covered) / float(parts);
}
