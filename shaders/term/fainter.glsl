// SPDX-License-Identifier: MIT OR Apache-2.0
// How much more room a filter kernel leaves where it is exp(-fall) of its peak. Rust twin: src/term/fainter.rs.
float fainter(float fall) {
    return exp(fma(0.1, clamp(fall, 0.0, 200.0), clamp(fall - 9.21, 0.0, 60.0) / 3.0));
}
