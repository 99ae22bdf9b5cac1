// SPDX-License-Identifier: MIT OR Apache-2.0
// Oren and Nayar's rough diffuse surface (1994, Eq. 30, the qualitative model), of albedo 1; alpha stands for the standard
// deviation of the slopes' angle in radians. It has kinks where light and viewer are equally steep, and at right angles.

const float PI = 3.14159265358979;

vec3 brdf(vec3 l, vec3 v, float alpha) {
    float s2 = alpha * alpha;
    float a = 1.0 - 0.5 * s2 / (s2 + 0.33);
    float b = 0.45 * s2 / (s2 + 0.09);
    // sin(theta_l) sin(theta_v) cos(phi_l - phi_v); the larger angle has the smaller cosine.
    float across = l.x * v.x + l.y * v.y;
    return vec3((a + b * max(across, 0.0) / max(l.z, v.z)) / PI);
}
