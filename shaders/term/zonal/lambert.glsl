// SPDX-License-Identifier: MIT OR Apache-2.0
// Lambert: max(n.w, 0), irradiance over pi (Ramamoorthi, Hanrahan 2001, Eq. 1). Rust twin: src/term/zonal/lambert.rs.
#define SHARP_HORIZON 1
#define BEYOND 0.0625

// Mean over a node and slope: (x, y). Neither h, v nor alpha matters.
// Domain: mu >= 0, f in [0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    return vec2(mu, f);
}

// The room of a node: the whole sphere, unless the horizon of an axis may run through it.
float room(float away2, float reach, float extent, float alpha) {
    return abs(1.0 - 0.5 * away2) > reach + 2.0 * extent ? 1e3 : 0.22;
}
