// SPDX-License-Identifier: MIT OR Apache-2.0
// The reflectance integral of a BRDF of one's own over cells of half vectors, by a Gauss-Kronrod rule with its error
// estimate. The change of variables is explained in src/bake/own/cells.rs, which also splits the cells. The text of `REAL`,
// `REAL3` and `brdf` comes before and after, see src/bake/own/program.rs.

layout(local_size_x = 64) in;
layout(push_constant) uniform BakerPush { uint first; uint count; uint colored; } baker_push;
// Eight numbers a place: n_dot_v, sin theta_v, alpha, the scale of the map, and the ends of its panels.
layout(std430, set = 0, binding = 0) readonly buffer BakerPlaces { REAL baker_places[]; };
// Six words a cell: place, panel, and as floats its start and width in u and x.
layout(std430, set = 0, binding = 1) readonly buffer BakerCells { uint baker_cells[]; };
// Three numbers a node of the rule on [0, 1]: abscissa, Kronrod's weight, Gauss's weight (0 where it has none).
layout(std430, set = 0, binding = 2) readonly buffer BakerNodes { REAL baker_nodes[]; };
// Eight numbers a cell: three integrals, the error along u and along x, the least value of the BRDF, the number of nodes
// that were evaluated, and 1 + the first node that was not finite.
layout(std430, set = 0, binding = 3) writeonly buffer BakerSums { REAL baker_sums[]; };

const uint BAKER_NODES = 15u;

float baker_float(uint at) { return uintBitsToFloat(baker_cells[at]); }

REAL baker_largest(REAL3 x) { return max(max(abs(x.x), abs(x.y)), abs(x.z)); }

void main() {
    if (gl_GlobalInvocationID.x >= baker_push.count) {
        return;
    }
    uint cell = baker_push.first + gl_GlobalInvocationID.x;
    uint at = 6u * cell;
    uint place = 8u * baker_cells[at];
    uint panel = place + 4u + baker_cells[at + 1u];
    REAL n_dot_v = baker_places[place];
    REAL sine = baker_places[place + 1u];
    REAL alpha = baker_places[place + 2u];
    REAL scale = baker_places[place + 3u];
    REAL start = baker_places[panel];
    REAL width = baker_places[panel + 1u] - start;
    REAL3 v = REAL3(sine, 0.0, n_dot_v);

    REAL3 kronrod = REAL3(0.0);
    // What the sum lost to rounding, added at the end.
    REAL3 lost = REAL3(0.0);
    REAL3 gauss_u = REAL3(0.0);
    REAL3 gauss_x = REAL3(0.0);
    REAL least = REAL(1.0);
    uint evaluated = 0u;
    uint bad = 0u;
    for (uint i = 0u; i < BAKER_NODES; i++) {
        // The polar angle of the half vector, and the share of its circle that mirrors v upwards.
        REAL u = REAL(baker_float(at + 2u)) + REAL(baker_float(at + 3u)) * baker_nodes[3u * i];
        REAL y = start + width * u * u * (3.0 - 2.0 * u);
        REAL t = scale * sinh(y);
        REAL c = 1.0 / sqrt(1.0 + t * t);
        REAL rise = n_dot_v * (t - 1.0) * (t + 1.0);
        REAL reach = 2.0 * t * sine;
        REAL end = rise <= -reach ? BAKER_PI : (rise >= reach ? REAL(0.0) : BAKER_ACOS(rise / reach));
        REAL share = REAL(baker_float(at + 5u));
        // d(theta_h) sin(theta_h) d(psi) over du dx, the factor 4 (v.h) of dl/dh left for later, and both halves of the circle.
        REAL ring = width * 6.0 * u * (1.0 - u) * REAL(baker_float(at + 3u)) * sqrt(scale * scale + t * t)
            * t * c * c * c * end * share * 8.0;
        REAL3 row = REAL3(0.0);
        REAL3 row_gauss = REAL3(0.0);
        for (uint j = 0u; j < BAKER_NODES; j++) {
            REAL x = REAL(baker_float(at + 4u)) + share * baker_nodes[3u * j];
            REAL2 circle = baker_circle(end * x);
            REAL v_dot_h = max(c * (t * sine * circle.x + n_dot_v), BAKER_TINY);
            REAL3 l = 2.0 * v_dot_h * c * REAL3(t * circle.x, t * circle.y, 1.0) - v;
            l.z = max(l.z, BAKER_TINY);
            REAL3 f = brdf(l, v, alpha);
            least = min(least, min(f.x, min(f.y, f.z)));
            REAL m = max(1.0 - v_dot_h, 0.0);
            REAL m5 = m * m * m * m * m;
            REAL3 weighed = v_dot_h * l.z * (baker_push.colored != 0u ? f : f.x * REAL3(1.0, m5, v_dot_h * m5 * m));
            if (bad == 0u && (any(isnan(f)) || any(isinf(f)))) {
                bad = 1u + i * BAKER_NODES + j;
            }
            evaluated++;
            row += baker_nodes[3u * j + 1u] * weighed;
            row_gauss += baker_nodes[3u * j + 2u] * weighed;
        }
        REAL3 term = ring * baker_nodes[3u * i + 1u] * row;
        precise REAL3 sum = kronrod + term;
        precise REAL3 added = sum - kronrod;
        precise REAL3 rest = (kronrod - (sum - added)) + (term - added);
        lost += rest;
        kronrod = sum;
        gauss_u += ring * baker_nodes[3u * i + 2u] * row;
        gauss_x += ring * baker_nodes[3u * i + 1u] * row_gauss;
    }
    kronrod += lost;
    uint to = 8u * cell;
    baker_sums[to] = kronrod.x;
    baker_sums[to + 1u] = kronrod.y;
    baker_sums[to + 2u] = kronrod.z;
    baker_sums[to + 3u] = baker_largest(kronrod - gauss_u);
    baker_sums[to + 4u] = baker_largest(kronrod - gauss_x);
    baker_sums[to + 5u] = least;
    baker_sums[to + 6u] = REAL(evaluated);
    baker_sums[to + 7u] = REAL(bad);
}
