// SPDX-License-Identifier: MIT OR Apache-2.0
// Cube faces: face and position -> direction. Rust twin: src/term/cube.rs, which has the table.

// The point (s, t) of a face: a vector whose largest component is +-1. Normalise it to get a direction.
vec3 direction(uint face, float s, float t) {
    switch (face) {
    case 0u: return vec3(1.0, -t, -s);
    case 1u: return vec3(-1.0, -t, s);
    case 2u: return vec3(s, 1.0, t);
    case 3u: return vec3(s, -1.0, -t);
    case 4u: return vec3(s, -t, 1.0);
    default: return vec3(-s, -t, -1.0);
    }
}

// The face that a direction (of any length) meets, and where: face, s, t. On an edge the lower axis wins.
vec3 locate(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= a.y && a.x >= a.z) {
        return d.x >= 0.0 ? vec3(0.0, -d.z / a.x, -d.y / a.x) : vec3(1.0, d.z / a.x, -d.y / a.x);
    }
    if (a.y >= a.z) {
        return d.y >= 0.0 ? vec3(2.0, d.x / a.y, d.z / a.y) : vec3(3.0, d.x / a.y, -d.z / a.y);
    }
    return d.z >= 0.0 ? vec3(4.0, d.x / a.z, -d.y / a.z) : vec3(5.0, -d.x / a.z, -d.y / a.z);
}
