// SPDX-License-Identifier: MIT OR Apache-2.0
const { result, picture } = data;

/// The same for SVG.
function drawn(name, attributes = {}, ...children) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children.flat());
    return made;
}

const exponential = value => value.toExponential(2);
const percent = value => `${(100 * value).toFixed(2)} %`;
const plain = value => String(value);
/// Six significant digits: more than a half float holds, fewer than hide in a row of zeros.
const short = value => (value === 0 ? "0" : Math.abs(value) < 1e-4 ? value.toExponential(3) : String(Number(value.toPrecision(6))));

/// A number of the result, e.g. "report.channels.0.worst".
function number(path, format = exponential) {
    const value = path.split(".").reduce((at, key) => at[key], result);
    // JSON has no NaN: it comes as null.
    const text = value === null ? "not a number" : format(value);
    return element("span", { class: "number", "data-path": path, "data-value": JSON.stringify(value) }, text);
}

/// Single floats from base64; the page's bytes are little endian, whatever the machine's.
function floatsOf(base64) {
    const view = new DataView(bytesOf(base64).buffer);
    return Float32Array.from({ length: view.byteLength / 4 }, (_, i) => view.getFloat32(4 * i, true));
}

function halvesOf(base64) {
    const view = new DataView(bytesOf(base64).buffer);
    return Float32Array.from({ length: view.byteLength / 2 }, (_, i) => {
        const bits = view.getUint16(2 * i, true);
        const [sign, exponent, mantissa] = [bits >> 15 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
        if (exponent === 31) return mantissa ? NaN : sign * Infinity;
        return sign * (exponent ? 2 ** (exponent - 15) * (1 + mantissa / 1024) : (2 ** -14 * mantissa) / 1024);
    });
}

/// Colours at evenly spaced stops, mixed in between. `x` is clamped to [0, 1].
function ramp(stops, x) {
    const at = Math.min(Math.max(x, 0), 1) * (stops.length - 1);
    const i = Math.min(Math.floor(at), stops.length - 2);
    return [0, 1, 2].map(c => Math.round(stops[i][c] + (at - i) * (stops[i + 1][c] - stops[i][c])));
}

// Viridis at nine places: even steps look even, in grey and to the colour-blind too.
const VIRIDIS = [
    [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
    [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];
const viridis = x => ramp(VIRIDIS, x);

// Blue below, red above, grey at 0: the same grey suits a light and a dark page.
const SIGNED = [[20, 70, 190], [120, 160, 215], [205, 205, 205], [225, 145, 115], [185, 35, 25]];
const BEYOND = [255, 0, 255];
/// `x` from −1 to 1; what lies beyond or is no number is magenta.
const signed = x => (Math.abs(x) <= 1 ? ramp(SIGNED, 0.5 + 0.5 * x) : BEYOND);

/// Paints a canvas texel by texel.
function paint(canvas, width, height, colour) {
    canvas.width = width;
    canvas.height = height;
    const context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    for (let i = 0; i < width * height; i += 1) {
        const [r, g, b, a = 255] = colour(i % width, Math.floor(i / width));
        image.data.set([r, g, b, a], 4 * i);
    }
    context.putImageData(image, 0, 0);
}

/// A bar of colours between two labels.
function colourScale(low, colour, high) {
    const canvas = element("canvas", { "aria-hidden": "true" });
    paint(canvas, 256, 1, x => colour(x / 255));
    return element("div", { class: "scale" }, element("span", {}, low), canvas, element("span", {}, high));
}

function mark(good) {
    return element("span", { class: `mark ${good ? "good" : "bad"}` }, good ? "✓" : "✗");
}

function header() {
    const verdict = result.passed ? "✓ right" : "✗ wrong";
    const name = result.path.split(/[\\/]/).pop();
    return element("header", {}, element("h1", {}, name),
        element("span", { class: `badge ${result.passed ? "good" : "bad"}`, id: "verdict" }, verdict));
}

function failures() {
    if (result.failures.length === 0) return null;
    return element("section", { class: "failures" }, element("h2", {}, "What is wrong"),
        element("ul", {}, result.failures.map(failure => element("li", {}, failure))));
}

function laws() {
    const row = law => [mark(law.holds), element("span", {}, law.statement,
        law.detail ? element("div", { class: "note bad" }, law.detail) : null)];
    return element("div", {}, element("h2", {}, "Laws"),
        element("p", { class: "note" }, "What every sound file of this kind obeys, whoever made it."),
        tableOf(null, result.report.laws.map(row)));
}

function certificate() {
    const words = { confirmed: "✓ confirmed", refuted: "✗ refuted", stated: "stated", missing: "not stated" };
    const colours = { confirmed: "good", refuted: "bad", stated: "unsure", missing: "unsure" };
    const brief = text => (text.length > 60 ? `${text.slice(0, 16)}…${text.slice(-8)}` : text);
    const row = claim => {
        const text = claim.stated ?? "";
        const found = claim.found !== null && claim.found !== claim.stated
            ? element("div", { class: "note" }, "found ", element("code", {}, brief(claim.found))) : null;
        return [element("code", {}, claim.key), element("span", {}, element("code", { title: text }, brief(text)), found),
            element("span", { class: colours[claim.verdict] }, words[claim.verdict])];
    };
    return element("div", { class: "certificate" }, element("h2", {}, "Certificate"),
        element("p", { class: "note" }, "What the file claims of itself. Errors are those before rounding; where it was " +
            "baked cannot be seen in it."),
        tableOf(null, result.certificate.claims.map(row)));
}

function metadata() {
    return element("section", {}, said("Everything that the file says of itself", picture.meta));
}

/// A line with an arrow head at its end.
function arrow(x0, y0, x1, y1) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    const [dx, dy] = [(x1 - x0) / length, (y1 - y0) / length];
    const corner = side => `${x1 - 9 * dx + side * 4.5 * dy},${y1 - 9 * dy - side * 4.5 * dx}`;
    return [drawn("line", { class: "arrow", x1: x0, y1: y0, x2: x1 - 7 * dx, y2: y1 - 7 * dy }),
        drawn("polygon", { class: "head", points: `${x1},${y1} ${corner(1)} ${corner(-1)}` })];
}

function label(x, y, text, attributes = {}) {
    return drawn("text", { x, y, ...attributes }, text);
}
