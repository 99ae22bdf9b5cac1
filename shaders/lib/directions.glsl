// SPDX-License-Identifier: MIT OR Apache-2.0
// What a geometry term may depend on. Rust twin: `Directions` in src/term/visibility/mod.rs.

struct Directions {
    float n_dot_l;
    float n_dot_v;
    float n_dot_h;
    float v_dot_h;
    // Smith's projected areas n_dot_x (1 + Lambda(x)) of the distribution in use.
    float sigma_l;
    float sigma_v;
    // Width of the distribution.
    float alpha;
};
