// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each language calls an array, and how it looks a value up.

use super::Facts;

/// A language that tables are written in.
#[derive(Debug)]
pub struct Language {
    /// Its name.
    pub(super) name: &'static str,
    /// The extension of its files.
    pub(super) extension: &'static str,
    /// What begins a comment that ends with the line.
    pub(super) comment: &'static str,
    /// What ends a single float.
    pub(super) float_suffix: &'static str,
    /// The code before and after the numbers.
    pub(super) code: fn(&Facts) -> (String, String),
}

/// A module with constants, an array and a function.
pub static RUST: Language = Language { name: "Rust", extension: "rs", comment: "//", float_suffix: "", code: rust };
/// A translation unit.
pub static C: Language =
    Language { name: "C", extension: "c", comment: "//", float_suffix: "f", code: |facts| c(facts, false) };
/// A header of which every unit that includes it gets its own copy.
pub static C_HEADER: Language =
    Language { name: "C header", extension: "h", comment: "//", float_suffix: "f", code: |facts| c(facts, true) };
/// An ECMAScript module.
pub static JAVASCRIPT: Language = Language {
    name: "JavaScript",
    extension: "js",
    comment: "//",
    float_suffix: "",
    code: |facts| script(facts, false),
};
/// The same with types.
pub static TYPESCRIPT: Language = Language {
    name: "TypeScript",
    extension: "ts",
    comment: "//",
    float_suffix: "",
    code: |facts| script(facts, true),
};
/// A module that needs nothing but the standard library.
pub static PYTHON: Language =
    Language { name: "Python", extension: "py", comment: "#", float_suffix: "", code: python };

/// What the array is, for a comment.
fn about(facts: &Facts) -> String {
    let Facts { width, height, channels, words, .. } = facts;
    let kind = words.map_or(String::new(), |words| format!(", each {words}"));
    let (several, slices) = match facts.slices {
        Some((n, stack)) => (format!(" x {n}"), format!("{} in order, ", stack.word)),
        None => (String::new(), String::new()),
    };
    let texels = match facts.planes {
        true => format!("{channels} planes of {width} x {height}{several} values{kind}, one after the other"),
        false => format!("{width} x {height}{several} texels of {channels} values{kind}"),
    };
    format!("{texels}; {slices}rows from the top, texels from the left.")
}

/// The number of slices or layers where there are some: `before`, the name of the constant, `between`, the number, `after`.
fn slices(facts: &Facts, before: &str, between: &str, after: &str) -> String {
    let Some((n, stack)) = facts.slices else { return String::new() };
    format!("{before}{}_{}{between}{n}{after}", facts.name, stack.constant)
}

/// What the function does, for a comment.
fn usage(facts: &Facts) -> String {
    format!("Values at u and v in [0, 1], from the left and from the top, between texels. Axes: {}.", facts.axes)
}

fn rust(facts: &Facts) -> (String, String) {
    let Facts { name, small_name, width, height, channels, words, edges, .. } = facts;
    let element = if words.is_some() { "u16" } else { "f32" };
    let slices = slices(facts, "/// Tables that follow each other.\npub const ", ": usize = ", ";\n");
    let before = format!(
        "
/// Texels from left to right.
pub const {name}_WIDTH: usize = {width};
/// Rows.
pub const {name}_HEIGHT: usize = {height};
{slices}/// Values of a texel.
pub const {name}_CHANNELS: usize = {channels};

/// {}
#[rustfmt::skip]
pub static {name}: [{element}; {}] = [
",
        about(facts),
        facts.len()
    );
    if !facts.samples() {
        return (before, "];\n".into());
    }
    let place = if *edges { "t * (n - 1) as f32" } else { "t * n as f32 - 0.5" };
    let after = format!(
        "];

/// {}
pub fn {small_name}_sample(u: f32, v: f32) -> [f32; {name}_CHANNELS] {{
    let at = |t: f32, n: usize| {{
        let place = ({place}).clamp(0.0, (n - 1) as f32);
        (place as usize, (place as usize + 1).min(n - 1), place.fract())
    }};
    let ((x0, x1, s), (y0, y1, t)) = (at(u, {name}_WIDTH), at(v, {name}_HEIGHT));
    let value = |x: usize, y: usize, c: usize| {name}[(y * {name}_WIDTH + x) * {name}_CHANNELS + c];
    let row = |y: usize, c: usize| value(x0, y, c) * (1.0 - s) + value(x1, y, c) * s;
    core::array::from_fn(|c| row(y0, c) * (1.0 - t) + row(y1, c) * t)
}}
",
        usage(facts)
    );
    (before, after)
}

fn c(facts: &Facts, is_header: bool) -> (String, String) {
    let Facts { name, small_name, width, height, channels, words, edges, .. } = facts;
    let (element, include) = if words.is_some() { ("uint16_t", "#include <stdint.h>\n\n") } else { ("float", "") };
    let slices = slices(facts, ", ", " = ", "");
    let (guard, end, own, inline) = match is_header {
        true => (format!("#ifndef {name}_H\n#define {name}_H\n\n"), "\n#endif\n", "static ", "static inline "),
        false => (String::new(), "", "", ""),
    };
    let before = format!(
        "
{guard}{include}enum {{ {name}_WIDTH = {width}, {name}_HEIGHT = {height}{slices}, {name}_CHANNELS = {channels} }};

// {}
{own}const {element} {name}[{}] = {{
",
        about(facts),
        facts.len()
    );
    if !facts.samples() {
        return (before, format!("}};\n{end}"));
    }
    let place = if *edges { "uv[i] * (float)(sizes[i] - 1)" } else { "uv[i] * (float)sizes[i] - 0.5f" };
    let after = format!(
        "}};

// {}
{inline}void {small_name}_sample(float u, float v, float out[{channels}])
{{
    const float uv[2] = {{ u, v }};
    const int sizes[2] = {{ {name}_WIDTH, {name}_HEIGHT }};
    int low[2], high[2];
    float share[2];
    for (int i = 0; i < 2; i++) {{
        float place = {place};
        place = place > 0.0f ? place : 0.0f;
        place = place < (float)(sizes[i] - 1) ? place : (float)(sizes[i] - 1);
        low[i] = (int)place;
        high[i] = low[i] + 1 < sizes[i] ? low[i] + 1 : low[i];
        share[i] = place - (float)low[i];
    }}
    for (int c = 0; c < {name}_CHANNELS; c++) {{
        const float *top = {name} + low[1] * {name}_WIDTH * {name}_CHANNELS + c;
        const float *bottom = {name} + high[1] * {name}_WIDTH * {name}_CHANNELS + c;
        int left = low[0] * {name}_CHANNELS, right = high[0] * {name}_CHANNELS;
        float above = top[left] * (1.0f - share[0]) + top[right] * share[0];
        float below = bottom[left] * (1.0f - share[0]) + bottom[right] * share[0];
        out[c] = above * (1.0f - share[1]) + below * share[1];
    }}
}}
{end}",
        usage(facts)
    );
    (before, after)
}

fn script(facts: &Facts, typed: bool) -> (String, String) {
    let Facts { name, small_name, width, height, channels, words, edges, .. } = facts;
    let slices = slices(facts, "export const ", " = ", ";\n");
    let array = if words.is_some() { "Uint16Array" } else { "Float32Array" };
    let before = format!(
        "
export const {name}_WIDTH = {width};
export const {name}_HEIGHT = {height};
{slices}export const {name}_CHANNELS = {channels};

/** {} */
export const {name} = new {array}([
",
        about(facts)
    );
    if !facts.samples() {
        return (before, "]);\n".into());
    }
    let (number, numbers) = if typed { (": number", ": number[]") } else { ("", "") };
    let place = if *edges { "t * (n - 1)" } else { "t * n - 0.5" };
    let after = format!(
        "]);

/** {} */
export function {small_name}Sample(u{number}, v{number}){numbers} {{
    const at = (t{number}, n{number}) => {{
        const place = Math.min(Math.max({place}, 0), n - 1);
        const low = Math.floor(place);
        return {{ low, high: Math.min(low + 1, n - 1), share: place - low }};
    }};
    const x = at(u, {name}_WIDTH);
    const y = at(v, {name}_HEIGHT);
    const value = (column{number}, row{number}, c{number}) => {name}[(row * {name}_WIDTH + column) * {name}_CHANNELS + c];
    const between = (row{number}, c{number}) => value(x.low, row, c) * (1 - x.share) + value(x.high, row, c) * x.share;
    return Array.from({{ length: {name}_CHANNELS }}, (_, c) => between(y.low, c) * (1 - y.share) + between(y.high, c) * y.share);
}}
",
        usage(facts)
    );
    (before, after)
}

fn python(facts: &Facts) -> (String, String) {
    let Facts { name, small_name, width, height, channels, words, edges, .. } = facts;
    let kind = if words.is_some() { "H" } else { "f" };
    let slices = slices(facts, "", " = ", "\n");
    let before = format!(
        "
import array

{name}_WIDTH = {width}
{name}_HEIGHT = {height}
{slices}{name}_CHANNELS = {channels}

# {}
{name} = array.array(\"{kind}\", [
",
        about(facts)
    );
    if !facts.samples() {
        return (before, "])\n".into());
    }
    let place = if *edges { "t * (n - 1)" } else { "t * n - 0.5" };
    let after = format!(
        "])


def {small_name}_sample(u, v):
    \"\"\"{}\"\"\"

    def at(t, n):
        place = min(max({place}, 0.0), n - 1)
        low = int(place)
        return low, min(low + 1, n - 1), place - low

    (x0, x1, s), (y0, y1, t) = at(u, {name}_WIDTH), at(v, {name}_HEIGHT)

    def row(y, c):
        left, right = ({name}[(y * {name}_WIDTH + x) * {name}_CHANNELS + c] for x in (x0, x1))
        return left * (1 - s) + right * s

    return [row(y0, c) * (1 - t) + row(y1, c) * t for c in range({name}_CHANNELS)]
",
        usage(facts)
    );
    (before, after)
}
