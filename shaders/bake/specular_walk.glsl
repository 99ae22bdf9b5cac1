// SPDX-License-Identifier: MIT OR Apache-2.0
// A filtered environment: the walk of src/bake/specular_walk.rs, which explains it. One invocation is a block of 4 x 4 texels.
//
// Written for the cost of software Vulkan too, where both sides of every branch are executed and only loops are left
// early: the search for the next node is a small loop of its own. Such drivers may also stop, without a word, after
// 65,535 iterations of all loops together, so both count against one limit.
//
// CUT is 1 where leaves of an equirectangular picture may have to be cut into parts of their texels, 2 where those of a
// cube may, else 0. SHARED is 1 where blocks may leave what is far to groups of them, so that each walks only ranges of the
// tree: src/bake/groups.rs.

#include <zonal>
#if CUT == 2
#include "term/cube.glsl"
#endif

layout(local_size_x = 32) in;

// The source without its base, rgb.
layout(std430, set = 0, binding = 0) readonly buffer Texels { float texels[]; };
// Cosine and sine of theta at the middle of every row, then of phi at the middle of every column.
layout(std430, set = 0, binding = 1) readonly buffer Lines { vec2 lines[]; };
// Where every texel of every mip looks, in the order of the result.
layout(std430, set = 0, binding = 2) readonly buffer Axes { float axes[]; };
layout(std430, set = 0, binding = 3) buffer Result { float result[]; };
layout(std430, set = 0, binding = 4) buffer Status { uint overrun; };
// c and extent | e and skip | d and rows | q and columns: Node in src/env/tree/mod.rs. A texel buffer, because software
// Vulkan reads a storage buffer lane by lane in a loop, which took half of the walk.
layout(set = 0, binding = 5) uniform usamplerBuffer nodes;
#if SHARED
// Lists, one a group: first range and end of those for its blocks, then of those for itself. Ranges: first node and end.
layout(set = 0, binding = 6) uniform usamplerBuffer ranges;
#endif

layout(push_constant) uniform Job {
    uint width;         // texels along the sides of a face
    uint height;
    uint block;         // texels along a side of a block
    uint first;         // this slice's blocks
    uint end;
    uint offset;        // of this mip in the result, in texels
    uint node_begin;    // this pass's nodes
    uint node_count;    // where they end
    uint adds;          // 1 where an earlier pass has left its sums
    uint limit;         // iterations
    uint rows;          // of the source, or of one of its faces
    float d_theta;      // sides of a source texel
    float d_phi;
    float alpha;
    float eps;          // node size / room
    float inverse_norm;
    float blue_red;     // D of blue is blue_red * D of red + blue_green * D of green
    float blue_green;
    float base_red;
    float base_green;
    float base_blue;
    uint lists;         // this mip's first list of ranges
    uint groups_across; // in a row of a face; 0 where all blocks have one list
    uint of_groups;     // 1 where the blocks are the points of groups
} job;

uvec4 node(uint index, int quarter) {
    return texelFetch(nodes, int(4u * index) + quarter);
}

const uint TEXELS = 16u;
// A bright leaf is cut only if it has no more texels than this: near the poles there are many in one.
const uint MAX_CUT = 16u;
// Leaves are given in units of a texel / FINE.
const uint FINE = 4u;
#define EACH_TEXEL(DO) \
    DO(0u) DO(1u) DO(2u) DO(3u) DO(4u) DO(5u) DO(6u) DO(7u) DO(8u) DO(9u) DO(10u) DO(11u) DO(12u) DO(13u) DO(14u) DO(15u)

// Column and row of a block, and its face. Blocks are taken in groups of 4 x 2, so that neighbouring invocations walk the
// same nodes.
uvec3 place(uint block) {
    uvec2 sides = (uvec2(job.width, job.height) + job.block - 1u) / job.block;
    uint face = block / (sides.x * sides.y);
    uint at = block - face * sides.x * sides.y;
    if (sides.x % 4u != 0u || sides.y % 2u != 0u) return uvec3(at % sides.x, at / sides.x, face);
    uint across = sides.x / 4u;
    uint group = at / 8u;
    uint within = at % 8u;
    return uvec3((group % across) * 4u + within % 4u, (group / across) * 2u + within / 4u, face);
}

// Where texel i of a block is among all; beyond the end of a face or of a smaller block the last texels stand in.
uint index_of(uvec3 block, uint i) {
    uvec2 inside = min(uvec2(i % 4u, i / 4u), uvec2(job.block - 1u));
    uvec2 texel = min(block.xy * job.block + inside, uvec2(job.width, job.height) - 1u);
    return 3u * (job.offset + (block.z * job.height + texel.y) * job.width + texel.x);
}

vec3 axis(uvec3 block, uint i) {
    uint at = index_of(block, i);
    return vec3(axes[at], axes[at + 1u], axes[at + 2u]);
}

// Sine and cosine of (a + d) from (cos a, sin a), for small d: (cos, sin).
vec2 turned(vec2 a, float d) {
    float d2 = d * d;
    float s = d * (1.0 - d2 * (1.0 / 6.0 - d2 / 120.0));
    float c = 1.0 - d2 * (0.5 - d2 / 24.0);
    return vec2(a.x * c - a.y * s, a.y * c + a.x * s);
}

void main() {
    uint index = job.first + gl_GlobalInvocationID.x;
    if (index >= job.end) return;
    uvec3 block = place(index);

    // The block's texels, its middle, and how far its texels are from it.
    vec3 n[TEXELS];
    vec3 sum[TEXELS];
    vec3 middle = vec3(0.0);
#define START(I) n[I] = axis(block, I); sum[I] = vec3(0.0); middle += n[I];
    EACH_TEXEL(START)
    middle = normalize(middle);
    float reach = 0.0;
#define REACH(I) reach = max(reach, distance(middle, n[I]));
    EACH_TEXEL(REACH)

    // Software Vulkan reads a push constant as slowly as memory, and in a loop each time anew.
    uint node_count = job.node_count, limit = job.limit;
    float alpha = job.alpha, eps = job.eps;
    float blue_red = job.blue_red, blue_green = job.blue_green;
#if CUT
    uint all_rows = job.rows;
#if CUT == 1
    float d_theta = job.d_theta, d_phi = job.d_phi;
#endif
#if CUT == 2
    uint face = 0u;
#endif
    // A leaf that is being cut: where it starts, sides of its texels, parts of a texel, of all, and the part at hand.
    bool cutting = false;
    uvec2 corner = uvec2(0u), unit = uvec2(1u), parts = uvec2(1u), count = uvec2(0u), part = uvec2(0u);
#endif
#if SHARED
    // This block's ranges; each is looked up again before a node is searched for, which is once for 16 texels.
    uint list = job.lists;
    if (job.groups_across != 0u) {
        uint blocks = 4u;
        list += job.of_groups == 1u ? block.x
            : (block.z * (job.height / 16u) + block.y / blocks) * job.groups_across + block.x / blocks;
    }
    uvec4 of_list = texelFetch(ranges, int(list));
    uint range = job.of_groups == 1u ? of_list.z : of_list.x;
    uint last_range = job.of_groups == 1u ? of_list.w : of_list.y;
    uint all_count = node_count;
#endif
    uint i = job.node_begin;
    uint step = 0u;
    uint finished = 0u;
#if SHARED
    finished = range < last_range ? 0u : 1u;
#endif
#if CUT
    while ((i < node_count || cutting) && step < limit) {
#elif SHARED
    while (range < last_range && step < limit) {
        uvec2 from_to = texelFetch(ranges, int(range)).xy;
        i = max(i, from_to.x);
        node_count = min(from_to.y, all_count);
#else
    while (i < node_count && step < limit) {
#endif
        // Find the next node to add.
        uint at = node_count;
        vec3 c = vec3(0.0);
        float key = 0.0, threshold = 0.0;
#if CUT
        bool search = !cutting;
#else
        bool search = i < node_count;
#endif
        while (search) {
            uvec4 w = node(i, 0);
            uint skip = w.w & 0x3fffffu;
            key = uintBitsToFloat(0x30000000u | ((w.w >> 22) << 18));
            c = uintBitsToFloat(w.xyz);
            vec3 away = middle - c;
            float away2 = dot(away, away);
            threshold = eps * room(away2, reach, key, alpha);
            bool pass = w.w < 0x400000u || fma(-0.5, away2, 1.0 + reach + 2.0 * key) < 0.0;
            bool enter = !pass && key > threshold && skip > 1u;
            at = pass || enter ? at : i;
            i += enter ? 1u : skip;
            step++;
            search = (pass || enter) && i < node_count && step < limit;
        }

        // Its moments.
        vec3 e = vec3(0.0), d_red = vec3(0.0), d_green = vec3(0.0);
        vec3 q_same = vec3(0.0), q_mixed = vec3(0.0);
        if (at < node_count) {
            uvec4 w1 = node(at, 1), w2 = node(at, 2), w3 = node(at, 3);
            float extent = uintBitsToFloat(w1.w);
            float scale = 2.0 * extent;
            e = uintBitsToFloat(w1.xyz);
            vec2 d01 = unpackSnorm2x16(w2.x), d23 = unpackSnorm2x16(w2.y), d45 = unpackSnorm2x16(w2.z);
            d_red = vec3(d01, d23.x) * (scale * e.x);
            d_green = vec3(d23.y, d45) * (scale * e.y);
            vec2 q01 = unpackSnorm2x16(w3.x), q23 = unpackSnorm2x16(w3.y), q45 = unpackSnorm2x16(w3.z);
            q_same = vec3(q01, q23.x) * (scale * scale);
            q_mixed = vec3(q23.y, q45) * (scale * scale);
#if CUT
            // Is it a leaf that is too large?
            uvec2 units = uvec2(w3.w >> 16, w2.w >> 16);
            uint whole = units.x * units.y;
#if SHARP_HORIZON
            const uint least = 1u;
            // The parts of a bright texel are small for their brightness too.
            float side = sqrt(2.0) * threshold / (whole <= FINE * FINE ? max(key / extent, 1.0) : 1.0);
#else
            const uint least = FINE * FINE + 1u;
            float side = sqrt(2.0) * threshold;
#endif
            if (key > threshold && (extent > threshold || (whole >= least && whole <= MAX_CUT * FINE * FINE))) {
                cutting = true;
                // A texel of the leaf, or the leaf where it is a part of one, and how it is cut.
                unit = min(units, uvec2(FINE));
#if CUT == 2
                // The face's number shares words with the first row and column: src/env/tree/faces.rs.
                corner = uvec2(w3.w & 0x3fffu, w2.w & 0x3fffu);
                face = (w2.w & 0xffffu) >> 14 | ((w3.w & 0xffffu) >> 14) << 2;
                vec2 st = (vec2(corner) + 0.5 * vec2(units)) * (2.0 / float(FINE * all_rows)) - 1.0;
                vec2 st2 = st * st;
                vec2 sides = vec2(unit) * (2.0 / float(FINE * all_rows)) * sqrt(1.0 + st2.yx) / (1.0 + st2.x + st2.y);
#else
                corner = uvec2(w3.w & 0xffffu, w2.w & 0xffffu);
                float sin_theta = lines[corner.y / FINE + units.y / FINE / 2u].y;
                vec2 sides = vec2(unit) * vec2(d_phi * sin_theta, d_theta) / float(FINE);
#endif
                parts = uvec2(max(ceil(sides / side), 1.0));
                count = units / unit * parts;
                part = uvec2(0u);
            }
#endif
        }
#if CUT
        if (cutting) {
            // One part of a texel: a rectangle in (theta, phi) with the texel's radiance; its moments are closed.
            vec2 inside = (vec2(part) + 0.5) / vec2(parts);
            vec2 cell = floor(inside);
            uvec2 from = corner + uvec2(cell) * unit;
            uvec2 texel = from / FINE;
#if CUT == 2
            // A rectangle in (s, t) instead, to the second order of its sides.
            float scale = 2.0 / float(FINE * all_rows);
            vec2 st = (vec2(corner) + inside * vec2(unit)) * scale - 1.0;
            vec2 half_side = 0.5 * scale * vec2(unit) / vec2(parts);
            vec2 sixth = half_side * half_side / 6.0;
            vec3 middle_st = direction(face, 0.0, 0.0);
            vec3 s_axis = direction(face, 1.0, 0.0) - middle_st, t_axis = direction(face, 0.0, 1.0) - middle_st;
            vec3 p = direction(face, st.x, st.y);
            float inverse2 = 1.0 / (1.0 + dot(st, st));
            float inverse = sqrt(inverse2);
            float near_spread = (sixth.x + sixth.y) * inverse2;
            float slant = dot(sixth, st * st) * inverse2 * inverse2;
            float solid_angle = 4.0 * half_side.x * half_side.y * inverse2 * inverse * (1.0 - 3.0 * near_spread + 15.0 * slant);
            c = inverse * (1.0 - near_spread + 9.0 * slant) * p
                - 8.0 * inverse * inverse2 * (sixth.x * st.x * s_axis + sixth.y * st.y * t_axis);
            uint first = 3u * ((face * all_rows + texel.y) * all_rows + texel.x);
            // How the direction moves with s and t.
            vec3 along = inverse * (s_axis - p * (st.x * inverse2)), down = inverse * (t_axis - p * (st.y * inverse2));
            float q_along = 2.0 * sixth.x, q_down = 2.0 * sixth.y;
#else
            vec2 off = (vec2(from - texel * FINE) + (inside - cell) * vec2(unit)) / float(FINE) - 0.5;
            vec2 half_side = (0.5 / float(FINE)) * vec2(d_phi, d_theta) * vec2(unit) / vec2(parts);
            vec2 theta = turned(lines[texel.y], off.y * d_theta);
            vec2 phi = turned(lines[all_rows + texel.x], off.x * d_phi);
            float a2 = half_side.y * half_side.y, b2 = half_side.x * half_side.x;
            float across = (1.0 - b2 / 6.0) * (theta.y * (1.0 - 0.5 * a2) + a2 / (3.0 * theta.y));
            c = vec3(across * phi.x, theta.x * (1.0 - 0.5 * a2), across * phi.y);
            uint first = 3u * (texel.y * 2u * all_rows + texel.x);
            float solid_angle = 4.0 * half_side.x * half_side.y * theta.y * (1.0 - a2 / 6.0);
            vec3 down = vec3(theta.x * phi.x, -theta.y, theta.x * phi.y);
            vec3 along = vec3(-phi.y, 0.0, phi.x);
            float q_down = a2 / 3.0, q_along = b2 / 3.0 * theta.y * theta.y;
#endif
            e = solid_angle * vec3(texels[first], texels[first + 1u], texels[first + 2u]);
            q_same = q_down * down * down + q_along * along * along;
            q_mixed = q_down * down.xxy * down.yzz + q_along * along.xxy * along.yzz;
            d_red = vec3(0.0);
            d_green = vec3(0.0);
            bool last = part.x + 1u == count.x;
            part = last ? uvec2(0u, part.y + 1u) : uvec2(part.x + 1u, part.y);
            cutting = part.y < count.y;
        }
#endif
#if CUT
        finished = i < node_count || cutting ? 0u : 1u;
#elif SHARED
        range += i < node_count ? 0u : 1u;
        finished = range < last_range ? 0u : 1u;
#else
        finished = i < node_count ? 0u : 1u;
#endif
        // One for this loop, one for the test that ended the search.
        step += 2u;

        // Add it to every texel; a lane that found none adds nothing, as its e and d are 0.
        float spread = q_same.x + q_same.y + q_same.z;
        float w = sqrt(1.5 * spread) + 1e-7;
        float slope = 0.5 / w;
#if SHARP_HORIZON
        // Half the node's reach along the texel's axis, instead of the mean over all directions.
#define HORIZON w = sqrt(max(24.0 * (v - v0), 0.0)) + 1e-7; slope = 0.5 / w;
#else
#define HORIZON
#endif
        float v0 = BEYOND * spread * spread;
        float h0 = 0.25 * spread;
        q_same *= 0.125;
        q_mixed *= 0.25;
#define ADD(I) { \
        vec3 d = n[I] - c; \
        vec3 dd = d * d; \
        vec3 dm = d.xxy * d.yzz; \
        float h = fma(0.25, dd.x + dd.y + dd.z, h0); \
        float v = fma(q_same.x, dd.x, fma(q_same.y, dd.y, fma(q_same.z, dd.z, \
                  fma(q_mixed.x, dm.x, fma(q_mixed.y, dm.y, fma(q_mixed.z, dm.z, v0)))))); \
        float mu0 = fma(-2.0, h, 1.0); \
        HORIZON \
        float f = clamp(fma(mu0, slope, 0.5), 0.0, 1.0); \
        float mu = max(mu0, w * f * f); \
        vec2 k = over_node(h, mu, f, v, alpha); \
        float red = fma(n[I].x, d_red.x, fma(n[I].y, d_red.y, n[I].z * d_red.z)); \
        float green = fma(n[I].x, d_green.x, fma(n[I].y, d_green.y, n[I].z * d_green.z)); \
        float blue = fma(blue_red, red, blue_green * green); \
        sum[I].x = fma(k.x, e.x, fma(k.y, red, sum[I].x)); \
        sum[I].y = fma(k.x, e.y, fma(k.y, green, sum[I].y)); \
        sum[I].z = fma(k.x, e.z, fma(k.y, blue, sum[I].z)); }
        EACH_TEXEL(ADD)
    }
    // Not at the end: by our limit, or because the driver stopped the loops. It counts those of all lanes that it runs side
    // by side, so that it may stop long before one of them has counted this far; and what a loop hands on where it ends is then
    // as old as its beginning, so that only a variable that starts as "no" tells.
    if (finished == 0u) atomicMax(overrun, 1u);

    // Texels that stand in for others hold the same sums, so what they read must not be what they wrote.
    vec3 before[TEXELS];
    uint at;
#define BEFORE(I) at = index_of(block, I); \
    before[I] = job.adds == 0u ? vec3(job.base_red, job.base_green, job.base_blue) \
                           : vec3(result[at], result[at + 1u], result[at + 2u]);
    EACH_TEXEL(BEFORE)
#define STORE(I) at = index_of(block, I); \
    result[at] = fma(sum[I].x, job.inverse_norm, before[I].x); \
    result[at + 1u] = fma(sum[I].y, job.inverse_norm, before[I].y); \
    result[at + 2u] = fma(sum[I].z, job.inverse_norm, before[I].z);
    EACH_TEXEL(STORE)
}
