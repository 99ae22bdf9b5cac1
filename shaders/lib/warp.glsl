// SPDX-License-Identifier: MIT OR Apache-2.0
// Where n_dot_v or a roughness lies along a side of a table. Rust twin: `Warp::position` in src/axis.rs, which has the names in
// this order.

// The position in [0, 1]. Domain: n_dot_v and roughness in [0, 1].
float position(uint warp, float n_dot_v, float roughness) {
    switch (warp) {
    case 0u: return n_dot_v;
    case 1u: return sqrt(n_dot_v);
    case 2u: return sqrt(1.0 - n_dot_v);
    case 3u: return acos(n_dot_v) * 0.63661977;
    case 4u: return roughness;
    default: return roughness * roughness;
    }
}
