// SPDX-License-Identifier: MIT OR Apache-2.0
// A sheen: the Charlie distribution (Estevez, Kulla 2017, Eq. 2) with the visibility of Neubelt and Pettineo 2013.

float D(float n_dot_h, float alpha) {
    float inverse = 1.0 / alpha;
    float sin2 = 1.0 - n_dot_h * n_dot_h;
    return (2.0 + inverse) * pow(sin2, 0.5 * inverse) / (2.0 * 3.14159265358979);
}

float V(float n_dot_v, float n_dot_l, float alpha) {
    return 1.0 / (4.0 * (n_dot_l + n_dot_v - n_dot_l * n_dot_v));
}
