// Spheres lit by a filtered environment, a split-sum table and an irradiance map: shaders/spheres/split_sum.comp in WebGL 2.
// The script puts before it: the version, the precision, PART_OF (samples of a pixel, in sixteenths), and POSITION, where
// n_dot_v and roughness lie along x and y of the table.

uniform vec2 size;                // of the picture, pixels
uniform vec2 grid;                // columns and rows
uniform float radius;             // of a sphere, in tiles
uniform vec4 span;                // metallic of the first column and step to the next, the same of roughness and rows
uniform vec3 base;
uniform vec3 edge;
uniform float f0;
uniform bool compensate;
uniform mat3 frame;               // from the viewer's directions to the maps'
uniform float background;         // radiance behind the spheres; below 0 the environment
uniform float exposure;
uniform bool film;                // the tone curve, or none

uniform samplerCube specular_map;
uniform samplerCube diffuse_map;
uniform sampler2D table_map;
uniform float specular_scale;
uniform float diffuse_scale;
uniform int mips;
uniform float roughness_of[MIPS]; // of each mip
uniform mat2 place;               // columns are x and y: texel of the table = position * scale + shift

out vec4 colour;

// The filtered environment along d at a roughness, between the two mips next to it.
vec3 filtered(vec3 d, float roughness) {
    int upper = 0;
    while (upper + 1 < mips && roughness_of[upper] < roughness) {
        upper++;
    }
    int lower = max(upper - 1, 0);
    float from = roughness_of[lower];
    float to = roughness_of[upper];
    float share = to > from ? clamp((roughness - from) / (to - from), 0.0, 1.0) : 0.0;
    return specular_scale * textureLod(specular_map, frame * d, float(lower) + share).rgb;
}

// Scale, bias and tint.
vec3 table(float n_dot_v, float roughness) {
    vec2 texels = vec2(textureSize(table_map, 0));
    vec2 position = POSITION;
    vec2 at = position * vec2(place[0].x, place[1].x) + vec2(place[0].y, place[1].y);
    return textureLod(table_map, (clamp(at, vec2(0.0), texels - 1.0) + 0.5) / texels, 0.0).rgb;
}

vec3 shade(vec3 n, float metallic, float roughness) {
    vec3 split = table(clamp(n.z, 1e-4, 1.0), roughness);
    vec3 light = filtered(2.0 * n.z * n - vec3(0.0, 0.0, 1.0), roughness);
    vec3 diffuse = diffuse_scale * textureLod(diffuse_map, frame * n, 0.0).rgb;
    float albedo = max(split.x + split.y, 1e-6);
    float gain_f0 = compensate ? compensation(f0, albedo) : 1.0;
    float reflected = (f0 * split.x + split.y) * gain_f0;
    vec3 sum;
    for (int c = 0; c < 3; c++) {
        float gain = compensate ? compensation(base[c], albedo) : 1.0;
        sum[c] = specular(split * light[c], base[c], edge[c], f0, metallic, gain, gain_f0)
            + body(base[c], metallic, reflected) * diffuse[c];
    }
    return sum;
}

// A point of the picture, in pixels from its middle, rightwards and upwards.
vec3 seen(vec2 from_middle) {
    float tile = min(size.x / grid.x, size.y / grid.y);
    vec2 tiles = from_middle / tile;
    vec2 cell = floor(vec2(tiles.x + 0.5 * grid.x, 0.5 * grid.y - tiles.y));
    vec2 centre = vec2(cell.x + 0.5 - 0.5 * grid.x, 0.5 * grid.y - 0.5 - cell.y);
    vec2 offset = (tiles - centre) / radius;
    float left = 1.0 - dot(offset, offset);
    if (left > 0.0 && all(greaterThanEqual(cell, vec2(0.0))) && all(lessThan(cell, grid))) {
        return shade(vec3(offset, sqrt(left)), span.x + span.y * cell.x, span.z + span.w * cell.y);
    }
    if (background >= 0.0) {
        return vec3(background);
    }
    return filtered(vec3(from_middle * (1.1547 / size.y), -1.0), 0.45);
}

// Tone curve and sRGB: `Tone` and `srgb` of the program.
float shown(float radiance) {
    float x = max(exposure * radiance, 0.0);
    x = clamp(film ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : x, 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PARTS; i++) {
        sum += seen(gl_FragCoord.xy - 0.5 * size + vec2(PART_OF[i].x, -PART_OF[i].y) / 16.0);
    }
    sum /= float(PARTS);
    colour = vec4(shown(sum.r), shown(sum.g), shown(sum.b), 1.0);
}
