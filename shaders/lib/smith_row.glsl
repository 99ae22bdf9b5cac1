// SPDX-License-Identifier: MIT OR Apache-2.0
// Smith's function of one distribution at one roughness, as a Chebyshev series: `Row` in src/rule/h_split.rs. The including
// shader declares a buffer `row_of` of such rows.

// The row in use, loaded once: a load costs many times a multiply-add in software Vulkan.
vec4 row_map;
vec4 row_form;
vec4 row_0;
vec4 row_1;
vec4 row_2;
vec4 row_3;
vec4 row_4;
vec4 row_5;

// Loads the row that starts at `at`.
void load_row(uint at) {
    row_map = row_of[at];
    row_form = row_of[at + 1u];
    row_0 = row_of[at + 2u];
    row_1 = row_of[at + 3u];
    row_2 = row_of[at + 4u];
    row_3 = row_of[at + 5u];
    row_4 = row_of[at + 6u];
    row_5 = row_of[at + 7u];
}

// Clenshaw's recurrence by one coefficient; one multiply-add long, because each step waits for the one before.
#define STEP(c) { float next = fma(x2, b1, (c) - b2); b2 = b1; b1 = next; }

// Smith's projected area n_dot_x (1 + Lambda) of the loaded row's distribution.
float projected_area(float n_dot_x) {
    float power = row_form.x;
    float linear = row_form.y;
    float u = linear == 1.0 ? n_dot_x : sqrt(max((1.0 - n_dot_x) * (1.0 + n_dot_x), 0.0));
    float root = inversesqrt(1.0 + u * row_map.y);
    float fourth = sqrt(root);
    float v = power == 1.0 ? root * root : (power == 0.5 ? root : (power == 0.25 ? fourth : sqrt(fourth)));
    float x = v * row_map.z + row_map.w;
    float x2 = 2.0 * x;
    float b1 = 0.0;
    float b2 = 0.0;
    STEP(row_5.w)
    STEP(row_5.z)
    STEP(row_5.y)
    STEP(row_5.x)
    STEP(row_4.w)
    STEP(row_4.z)
    STEP(row_4.y)
    STEP(row_4.x)
    STEP(row_3.w)
    STEP(row_3.z)
    STEP(row_3.y)
    STEP(row_3.x)
    STEP(row_2.w)
    STEP(row_2.z)
    STEP(row_2.y)
    STEP(row_2.x)
    STEP(row_1.w)
    STEP(row_1.z)
    STEP(row_1.y)
    STEP(row_1.x)
    STEP(row_0.w)
    STEP(row_0.z)
    STEP(row_0.y)
    return linear * n_dot_x + row_0.x + x * b1 - b2;
}
