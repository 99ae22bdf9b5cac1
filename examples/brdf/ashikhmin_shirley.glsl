// SPDX-License-Identifier: MIT OR Apache-2.0
// The specular lobe of Ashikhmin and Shirley 2000 (Eq. 4) with equal exponents and F = 1. The exponent 2 / alpha^2 - 2 makes
// alpha a width like GGX's.

const float PI = 3.14159265358979;

vec3 brdf(vec3 l, vec3 v, float alpha) {
    vec3 h = normalize(l + v);
    float n = 2.0 / (alpha * alpha) - 2.0;
    return vec3((n + 1.0) / (8.0 * PI) * pow(h.z, n) / (dot(v, h) * max(l.z, v.z)));
}
