// SPDX-License-Identifier: MIT OR Apache-2.0
// A coloured diffuse base and a clear coat of GGX over it. A quarter of the light stays in the coat; the base gets the
// rest.

const float PI = 3.14159265358979;
const vec3 BASE = vec3(0.75, 0.3, 0.15);

float ggx(float n_dot_h, float a2) {
    float f = (n_dot_h * a2 - n_dot_h) * n_dot_h + 1.0;
    return a2 / (PI * f * f);
}

vec3 brdf(vec3 l, vec3 v, float alpha) {
    float a2 = alpha * alpha;
    vec3 h = normalize(l + v);
    float lambda_v = l.z * sqrt(v.z * v.z * (1.0 - a2) + a2);
    float lambda_l = v.z * sqrt(l.z * l.z * (1.0 - a2) + a2);
    float coat = 0.25 * ggx(h.z, a2) * 0.5 / (lambda_v + lambda_l);
    return 0.75 * BASE / PI + coat;
}
