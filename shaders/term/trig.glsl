// SPDX-License-Identifier: MIT OR Apache-2.0
// Trigonometry that does not depend on the driver. Rust twin: src/term/trig.rs.

// sin x by a minimax polynomial, absolute error 2e-8 before rounding. Domain: x in [0, pi/2].
float sin_quarter(float x) {
    float u = x * x;
    float p = -2.408048379e-8;
    p = p * u + 2.753647811e-6;
    p = p * u - 1.984108679e-4;
    p = p * u + 8.333332770e-3;
    p = p * u - 0.1666666666;
    return x + x * u * p;
}

// atan x by a minimax polynomial, absolute error 3e-9 before rounding. Domain: x in [0, 1].
float atan_unit(float x) {
    float u = x * x;
    float p = -0.001743701148;
    p = p * u + 0.01068071946;
    p = p * u - 0.03071750893;
    p = p * u + 0.05746355787;
    p = p * u - 0.08372063949;
    p = p * u + 0.1094019897;
    p = p * u - 0.1426157368;
    p = p * u + 0.1999823064;
    p = p * u - 0.3333328230;
    p = p * u + 0.9999999975;
    return x * p;
}

// acos(x) / 2. Domain: any x; beyond [-1, 1] the end's value.
float half_acos(float x) {
    // tan of the result is sqrt((1 - x) / (1 + x)); the smaller of the two over the larger is in [0, 1].
    float s = sqrt(max(1.0 - x, 0.0));
    float c = sqrt(max(1.0 + x, 0.0));
    float angle = atan_unit(min(s, c) / max(s, c));
    return s <= c ? angle : 1.57079632679490 - angle;
}
