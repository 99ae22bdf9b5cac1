// SPDX-License-Identifier: MIT OR Apache-2.0
// Elementary functions in double precision, which GLSL lacks: overloads of its own names, so that a BRDF that is written
// with `float` can be evaluated with `double`. Relative errors are a few 1e-16, of powers that times |y log x|;
// tests/own_brdf.rs compares them with those of Rust. Arguments of sin, cos and tan up to about 1e9.

const double BAKER_LN2_HIGH = 0.693147180369123816490lf;
const double BAKER_LN2_LOW = 1.90821492927058770002e-10lf;
const double BAKER_PI = 3.14159265358979323846lf;
const double BAKER_HALF_PI = 1.57079632679489661923lf;

// Taylor's series after reduction by multiples of ln 2.
double exp(double x) {
    double k = floor(clamp(x, -708.0lf, 709.0lf) * 1.44269504088896340736lf + 0.5lf);
    precise double r = (clamp(x, -708.0lf, 709.0lf) - k * BAKER_LN2_HIGH) - k * BAKER_LN2_LOW;
    double p = 1.0lf / 6227020800.0lf;
    p = p * r + 1.0lf / 479001600.0lf;
    p = p * r + 1.0lf / 39916800.0lf;
    p = p * r + 1.0lf / 3628800.0lf;
    p = p * r + 1.0lf / 362880.0lf;
    p = p * r + 1.0lf / 40320.0lf;
    p = p * r + 1.0lf / 5040.0lf;
    p = p * r + 1.0lf / 720.0lf;
    p = p * r + 1.0lf / 120.0lf;
    p = p * r + 1.0lf / 24.0lf;
    p = p * r + 1.0lf / 6.0lf;
    p = p * r + 0.5lf;
    p = p * r + 1.0lf;
    p = p * r + 1.0lf;
    double power = packDouble2x32(uvec2(0u, uint(int(k) + 1023) << 20));
    // Not a number stays so; numbers too small for a double are 0.
    return isnan(x) ? x : (x < -708.0lf ? 0.0lf : p * power);
}

// The series of artanh after reduction to a mantissa in [sqrt(1/2), sqrt(2)].
double log(double x) {
    if (!(x > 0.0lf)) {
        return packDouble2x32(uvec2(0u, x == 0.0lf ? 0xfff00000u : 0x7ff80000u));
    }
    uvec2 bits = unpackDouble2x32(x);
    int k = int(bits.y >> 20) - 1023;
    double m = packDouble2x32(uvec2(bits.x, (bits.y & 0x000fffffu) | 0x3ff00000u));
    if (m > 1.41421356237309504880lf) {
        m *= 0.5lf;
        k++;
    }
    double s = (m - 1.0lf) / (m + 1.0lf);
    double z = s * s;
    double p = 1.0lf / 21.0lf;
    p = p * z + 1.0lf / 19.0lf;
    p = p * z + 1.0lf / 17.0lf;
    p = p * z + 1.0lf / 15.0lf;
    p = p * z + 1.0lf / 13.0lf;
    p = p * z + 1.0lf / 11.0lf;
    p = p * z + 1.0lf / 9.0lf;
    p = p * z + 1.0lf / 7.0lf;
    p = p * z + 1.0lf / 5.0lf;
    p = p * z + 1.0lf / 3.0lf;
    precise double tail = 2.0lf * s * z * p + double(k) * BAKER_LN2_LOW;
    precise double sum = double(k) * BAKER_LN2_HIGH + (2.0lf * s + tail);
    return sum;
}

double exp2(double x) { return exp(x * 0.693147180559945309417lf); }
double log2(double x) { return log(x) * 1.44269504088896340736lf; }
double pow(double x, double y) { return x == 0.0lf && y > 0.0lf ? 0.0lf : exp(y * log(x)); }

// (cos x, sin x): Taylor's series after reduction by multiples of pi/2.
dvec2 baker_circle(double x) {
    double k = floor(x * 0.636619772367581343076lf + 0.5lf);
    precise double r = (x - k * 1.57079632673412561417lf) - k * 6.07710050650619224932e-11lf;
    double z = r * r;
    double s = 1.0lf / 355687428096000.0lf;
    s = s * z - 1.0lf / 1307674368000.0lf;
    s = s * z + 1.0lf / 6227020800.0lf;
    s = s * z - 1.0lf / 39916800.0lf;
    s = s * z + 1.0lf / 362880.0lf;
    s = s * z - 1.0lf / 5040.0lf;
    s = s * z + 1.0lf / 120.0lf;
    s = s * z - 1.0lf / 6.0lf;
    s = r + r * z * s;
    double c = 1.0lf / 20922789888000.0lf;
    c = c * z - 1.0lf / 87178291200.0lf;
    c = c * z + 1.0lf / 479001600.0lf;
    c = c * z - 1.0lf / 3628800.0lf;
    c = c * z + 1.0lf / 40320.0lf;
    c = c * z - 1.0lf / 720.0lf;
    c = c * z + 1.0lf / 24.0lf;
    c = c * z - 0.5lf;
    c = 1.0lf + z * c;
    int quadrant = int(k) & 3;
    dvec2 turned = (quadrant & 1) == 0 ? dvec2(c, s) : dvec2(-s, c);
    return (quadrant & 2) == 0 ? turned : -turned;
}

double sin(double x) { return baker_circle(x).y; }
double cos(double x) { return baker_circle(x).x; }
double tan(double x) {
    dvec2 circle = baker_circle(x);
    return circle.y / circle.x;
}

// Gregory's series after two halvings of the angle.
double atan(double x) {
    double a = abs(x);
    bool steep = a > 1.0lf;
    a = steep ? 1.0lf / a : a;
    a = a / (1.0lf + sqrt(1.0lf + a * a));
    a = a / (1.0lf + sqrt(1.0lf + a * a));
    double z = a * a;
    double p = 1.0lf / 25.0lf;
    p = 1.0lf / 23.0lf - z * p;
    p = 1.0lf / 21.0lf - z * p;
    p = 1.0lf / 19.0lf - z * p;
    p = 1.0lf / 17.0lf - z * p;
    p = 1.0lf / 15.0lf - z * p;
    p = 1.0lf / 13.0lf - z * p;
    p = 1.0lf / 11.0lf - z * p;
    p = 1.0lf / 9.0lf - z * p;
    p = 1.0lf / 7.0lf - z * p;
    p = 1.0lf / 5.0lf - z * p;
    p = 1.0lf / 3.0lf - z * p;
    p = 4.0lf * (a - a * z * p);
    p = steep ? BAKER_HALF_PI - p : p;
    return x < 0.0lf ? -p : p;
}

double atan(double y, double x) {
    if (x == 0.0lf) {
        return y == 0.0lf ? 0.0lf : (y < 0.0lf ? -BAKER_HALF_PI : BAKER_HALF_PI);
    }
    double angle = atan(y / x);
    return x > 0.0lf ? angle : (y < 0.0lf ? angle - BAKER_PI : angle + BAKER_PI);
}

double asin(double x) { return atan(x, sqrt((1.0lf - x) * (1.0lf + x))); }
double acos(double x) { return atan(sqrt((1.0lf - x) * (1.0lf + x)), x); }
double sinh(double x) { return abs(x) < 0.1lf
    ? x * (1.0lf + x * x / 6.0lf * (1.0lf + x * x / 20.0lf * (1.0lf + x * x / 42.0lf * (1.0lf + x * x / 72.0lf))))
    : 0.5lf * (exp(x) - exp(-x)); }
double cosh(double x) { return 0.5lf * (exp(x) + exp(-x)); }
double tanh(double x) { return abs(x) > 20.0lf ? sign(x) : sinh(x) / cosh(x); }
double radians(double x) { return x * (BAKER_PI / 180.0lf); }
double degrees(double x) { return x * (180.0lf / BAKER_PI); }

#define BAKER_VECTORS(f) \
    dvec2 f(dvec2 x) { return dvec2(f(x.x), f(x.y)); } \
    dvec3 f(dvec3 x) { return dvec3(f(x.x), f(x.y), f(x.z)); } \
    dvec4 f(dvec4 x) { return dvec4(f(x.x), f(x.y), f(x.z), f(x.w)); }
BAKER_VECTORS(exp)
BAKER_VECTORS(log)
BAKER_VECTORS(exp2)
BAKER_VECTORS(log2)
BAKER_VECTORS(sin)
BAKER_VECTORS(cos)
BAKER_VECTORS(tan)
BAKER_VECTORS(asin)
BAKER_VECTORS(acos)
BAKER_VECTORS(atan)
#undef BAKER_VECTORS
dvec2 pow(dvec2 x, dvec2 y) { return dvec2(pow(x.x, y.x), pow(x.y, y.y)); }
dvec3 pow(dvec3 x, dvec3 y) { return dvec3(pow(x.x, y.x), pow(x.y, y.y), pow(x.z, y.z)); }
dvec4 pow(dvec4 x, dvec4 y) { return dvec4(pow(x.x, y.x), pow(x.y, y.y), pow(x.z, y.z), pow(x.w, y.w)); }
