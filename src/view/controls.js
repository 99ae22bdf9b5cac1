// SPDX-License-Identifier: MIT OR Apache-2.0
const START = {
    light: "0", diffuse: "", table: "0", rotate: 0, tilt: 0, layout: "grid", metallic: 1, roughness: 0.3,
    material: "", colour: "#e7cca0", compensate: false, ev: 0, tone: "aces", background: "env",
};
/// What an environment brings with it.
const lit = light => ({
    diffuse: light.baked_diffuse === null ? "" : String(light.baked_diffuse),
    tone: light.white ? "clip" : "aces",
});
Object.assign(START, lit(data.lights[0]));
/// What the user has chosen.
const state = { ...START };
/// Spheres along a side of the grid.
const GRID = 5;

const linear = encoded => (encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4);
const signed = (value, decimals) => `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(decimals)}`;
/// A number as a command takes it.
const typed = value => String(Number(value.toPrecision(8)));

/// Everything that a picture depends on, from the state.
function sceneOf() {
    const light = data.lights[Number(state.light)];
    const grid = state.layout === "grid";
    const metal = data.metals.find(m => m.name === state.material);
    const dielectric = data.dielectrics.find(d => d.name === state.material);
    const colour = [1, 3, 5].map(i => linear(parseInt(state.colour.slice(i, i + 2), 16) / 255));
    const exposure = light.exposure_ev + state.ev;
    const [sinR, cosR] = [Math.sin(state.rotate * Math.PI / 180), Math.cos(state.rotate * Math.PI / 180)];
    const [sinT, cosT] = [Math.sin(state.tilt * Math.PI / 180), Math.cos(state.tilt * Math.PI / 180)];
    return {
        light,
        diffuse: { "": light.diffuse, harmonics: light.harmonics }[state.diffuse] ?? data.diffuses[Number(state.diffuse)].map,
        table: data.tables[Number(state.table)],
        grid: grid ? [GRID, GRID] : [1, 1],
        span: grid ? [0, 1 / (GRID - 1), 0, 1 / (GRID - 1)] : [state.metallic, 0, state.roughness, 0],
        base: metal ? metal.f0 : dielectric ? [0.5, 0.5, 0.5] : colour,
        edge: metal ? metal.edge : [0, 0, 0],
        f0: dielectric ? dielectric.f0 : 0.04,
        compensate: state.compensate,
        // The environment turned about the vertical, seen by a viewer who looks upwards.
        frame: [[cosR, -sinR * sinT, -sinR * cosT], [0, cosT, -sinT], [sinR, cosR * sinT, cosR * cosT]],
        // A grey is a grey whatever the exposure.
        background: { env: -1, black: 0, grey: 0.18 * 2 ** -exposure }[state.background],
        exposure,
        film: state.tone === "aces",
    };
}

/// The command that draws the same picture.
function command(width, height) {
    const scene = sceneOf();
    const quoted = word => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
    const words = ["brdf-baker", "preview", "-o", "spheres.png", ...data.words, ...scene.light.words, ...scene.table.words];
    if (/^\d/.test(state.diffuse)) words.push(...data.diffuses[Number(state.diffuse)].words);
    words.push("--size", `${width}x${height}`);
    if (state.layout === "one") {
        words.push("--spheres", "1x1", "--metallic", typed(state.metallic), "--roughness", typed(state.roughness));
    }
    if (state.material) words.push("--material", state.material);
    else words.push("--base-color", scene.base.map(typed).join(","));
    if (state.compensate) words.push("--compensate");
    if (state.rotate !== 0) words.push("--rotate", typed(state.rotate));
    if (state.tilt !== 0) words.push("--tilt", typed(state.tilt));
    if (scene.background >= 0) words.push("--background", typed(scene.background));
    words.push("--exposure", typed(scene.exposure), "--tone", scene.film ? "aces" : "clip");
    return words.map(quoted).join(" ");
}

/// What the picture lacks, and what the command cannot say; empty where there is nothing.
function warnings() {
    const { table, edge } = sceneOf();
    const untinted = !table.tinted && edge.some(v => v !== 0);
    return [
        untinted ? `${table.name} has no f82, so the edge of ${state.material} follows Schlick's curve; preview refuses the pair.` : "",
        state.diffuse === "harmonics" ? "Diffuse light by nine harmonics: preview integrates it instead." : "",
    ].join(" ").trim();
}

/// The form that changes the state. `changed` is called after every change; `show` puts the state into the form.
function controls(changed) {
    const shows = [];
    const show = () => shows.forEach(of => of());
    const set = (key, value) => {
        state[key] = value;
        show();
        changed();
    };
    const row = (key, text, control, value = null) =>
        element("div", { class: "row" }, element("label", { for: key }, text), value, control);

    function slider(key, text, [min, max, step], words) {
        const input = element("input", { type: "range", id: key, min: String(min), max: String(max), step: String(step) });
        const value = element("output", { for: key, class: "number" });
        input.addEventListener("input", () => set(key, Number(input.value)));
        shows.push(() => {
            input.value = String(state[key]);
            value.textContent = words(state[key]);
            input.setAttribute("aria-valuetext", words(state[key]));
        });
        return row(key, text, input, value);
    }

    function choice(key, text, groups, chosen = () => {}) {
        const options = list => list.map(([value, name]) => element("option", { value }, name));
        const select = element("select", { id: key }, groups.map(([name, list]) =>
            (name === null ? options(list) : [element("optgroup", { label: name }, options(list))])).flat());
        select.addEventListener("change", () => {
            chosen(select.value);
            set(key, select.value);
        });
        shows.push(() => { select.value = state[key]; });
        return row(key, text, select);
    }

    const names = list => list.map((entry, i) => [String(i), entry.name]);
    const colour = element("input", { type: "color", id: "colour" });
    colour.addEventListener("input", () => set("colour", colour.value));
    shows.push(() => {
        colour.value = state.colour;
        colour.disabled = state.material !== "";
    });
    const compensate = element("input", { type: "checkbox", id: "compensate" });
    compensate.addEventListener("change", () => set("compensate", compensate.checked));
    shows.push(() => { compensate.checked = state.compensate; });
    const reset = element("button", { type: "button", id: "reset" }, "Reset");
    reset.addEventListener("click", () => {
        Object.assign(state, START);
        show();
        changed();
    });

    const degrees = value => `${signed(value, 1)}°`;
    const share = value => value.toFixed(2);
    const group = (legend, ...rows) => element("fieldset", {}, element("legend", {}, legend), ...rows);
    const one = [slider("metallic", "Metallic", [0, 1, 0.01], share), slider("roughness", "Roughness", [0, 1, 0.01], share)];
    shows.push(() => {
        const stated = data.lights[Number(state.light)].harmonics !== null;
        form.querySelector("#diffuse [value=harmonics]").disabled = !stated;
    });
    shows.push(() => one.forEach(part => { part.querySelector("input").disabled = state.layout !== "one"; }));
    const form = element("form", { class: "controls", "aria-label": "What is drawn" },
        group("Light",
            choice("light", "Environment", [[null, names(data.lights)]], value => Object.assign(state, lit(data.lights[Number(value)]))),
            choice("diffuse", "Diffuse",
                [[null, [["", "integrated over it"], ["harmonics", "its nine harmonics"], ...names(data.diffuses)]]]),
            slider("rotate", "Turned", [-180, 180, 0.5], degrees), slider("tilt", "Looking up", [-90, 90, 0.5], degrees)),
        group("Spheres",
            choice("layout", "Show", [[null, [["grid", `${GRID} × ${GRID}`], ["one", "one sphere"]]]]), ...one,
            choice("material", "Material", [[null, [["", "base colour"]]], ["metals", data.metals.map(m => [m.name, m.name])],
                ["dielectrics", data.dielectrics.map(d => [d.name, d.name])]]),
            row("colour", "Base colour", colour)),
        group("Table",
            choice("table", "Split sum", [[null, names(data.tables)]]),
            row("compensate", "Give back multiple scattering", compensate)),
        group("Picture",
            slider("ev", "Exposure", [-8, 8, 0.25], value => `${signed(value, 2)} EV`),
            choice("tone", "Tone curve", [[null, [["aces", "ACES"], ["clip", "none"]]]]),
            choice("background", "Background", [[null, [["env", "environment"], ["grey", "grey"], ["black", "black"]]]]),
            element("p", {}, reset)));
    form.addEventListener("submit", event => event.preventDefault());
    show();
    return { form, set };
}
