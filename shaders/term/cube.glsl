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
