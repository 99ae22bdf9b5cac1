// SPDX-License-Identifier: MIT OR Apache-2.0
// Trowbridge-Reitz, known as GGX. Rust twin: src/ndf/ggx.rs.

// D(h) per steradian. Walter et al. 2007, Eq. 33; the integral of D n_dot_h is 1.
// Domain: cos2 + sin2 = 1, alpha in (0, 1]. Written with sin2 apart: nothing cancels at the peak.
float d(float cos2, float sin2, float alpha) {
    float a2 = alpha * alpha;
    float w = sin2 + a2 * cos2;
    return a2 / (3.14159265358979 * w * w);
}

// Length of the view vector stretched by the ellipsoid of normals. Domain: n_dot_x, alpha in [0, 1].
float stretch(float n_dot_x, float alpha) {
    return sqrt(alpha * alpha + (1.0 - alpha) * (1.0 + alpha) * n_dot_x * n_dot_x);
}

// Smith's projected area n_dot_x (1 + Lambda), finite at grazing.
float sigma(float n_dot_x, float alpha) {
    return 0.5 * (n_dot_x + stretch(n_dot_x, alpha));
}
