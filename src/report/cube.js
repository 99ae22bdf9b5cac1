// SPDX-License-Identifier: MIT OR Apache-2.0
/// A filtered environment: its mips beside the brute-force integral, conventions.
function environmentPage() {
    const cube = picture.projection === "cube";
    const FACES = ["+X", "−X", "+Y", "−Y", "+Z", "−Z"];
    // Column and row of each face in a cross; what touches here touches on the cube, the right way round.
    const CROSS = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
    const levels = picture.levels.map(level => ({ ...level, texels: floatsOf(level.texels) }));
    const compared = picture.compared.map(mip => ({ ...mip, found: floatsOf(mip.found), expected: floatsOf(mip.expected) }));

    // The mean of the first level at a middle grey.
    const mean = levels[0].texels.reduce((sum, v) => sum + v, 0) / levels[0].texels.length;
    let exposure = mean > 0 ? Math.round(2 * Math.log2(0.25 / mean)) / 2 : 0;
    const redraws = [];
    const redraw = () => redraws.forEach(draw => draw());

    const srgb = v => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
    /// Linear radiance to what a screen shows: exposed, and rolled off above one half so that lights keep a shape.
    const shown = radiance => radiance.map(v => {
        const x = Math.max(v, 0) * 2 ** exposure;
        return Number.isFinite(x) ? Math.round(srgb(x < 0.5 ? x : 1 - 0.25 / x)) : BEYOND[0];
    });

    /// Where the texels of one or six faces of columns × rows lie in a picture; null where it has none.
    function layout(columns, rows) {
        if (!cube) return { width: columns, height: rows, index: (x, y) => y * columns + x };
        const index = (x, y) => {
            const [column, row] = [Math.floor(x / columns), Math.floor(y / rows)];
            const face = CROSS.findIndex(([c, r]) => c === column && r === row);
            return face < 0 ? null : (face * rows + (y % rows)) * columns + (x % columns);
        };
        return { width: 4 * columns, height: 3 * rows, index };
    }

    const probe = element("p", { class: "note", id: "probe", "aria-live": "polite" }, "Point at a picture to read its texels.");

    /// A picture of texels, `colour` from an index, `told` what the probe says.
    function face(caption, [columns, rows], colour, told) {
        const { width, height, index } = layout(columns, rows);
        const canvas = element("canvas", { role: "img", "aria-label": caption });
        redraws.push(() => paint(canvas, width, height, (x, y) => {
            const i = index(x, y);
            return i === null ? [0, 0, 0, 0] : colour(i);
        }));
        canvas.addEventListener("pointermove", event => {
            const box = canvas.getBoundingClientRect();
            const i = index(Math.floor(((event.clientX - box.left) / box.width) * width),
                Math.floor(((event.clientY - box.top) / box.height) * height));
            if (i === null || i === undefined) return;
            const side = cube ? `face ${FACES[Math.floor(i / (columns * rows))]}, ` : "";
            probe.textContent = `${side}${told(i)}`;
        });
        return element("figure", {}, canvas, element("figcaption", {}, caption));
    }

    const rgb = (texels, i) => Array.from(texels.subarray(3 * i, 3 * i + 3));
    const triple = list => list.map(short).join(" ");
    const difference = (mip, i) => {
        const [found, expected] = [rgb(mip.found, i), rgb(mip.expected, i)];
        // The channel that is furthest off, with its sign.
        return found.map((v, c) => (v - expected[c]) / Math.max(Math.abs(expected[c]), 1e-6))
            .reduce((most, d) => (Math.abs(d) > Math.abs(most) || Number.isNaN(d) ? d : most), 0);
    };
    // The scale of a mip's differences: a few texels may be further off than the root mean square.
    const REACH = 2;
    const boundOf = mip => result.report.mips.find(m => m.mip === mip.mip).bound;

    function mips() {
        const slider = element("input", { type: "range", min: String(exposure - 10), max: String(exposure + 10), step: "0.5", value: String(exposure), id: "exposure" });
        const stops = element("span", { class: "number" });
        slider.addEventListener("input", () => { exposure = Number(slider.value); redraw(); });
        redraws.push(() => { stops.textContent = `${exposure > 0 ? "+" : ""}${exposure} EV`; });
        const rows = levels.map(level => {
            const i = result.report.mips.findIndex(mip => mip.mip === level.mip);
            const lines = [element("h3", {}, `mip ${level.mip}`),
                element("div", { class: "note" }, `${level.size[0]} × ${level.size[1]} texels${cube ? " a face" : ""}`)];
            lines.push(element("div", { class: "note" }, level.filtered ? `alpha ${level.alpha.toFixed(5)}` : "the source, not filtered"));
            if (i >= 0) {
                const path = `report.mips.${i}`;
                const line = (name, value) => element("div", { class: "note" }, `${name} `, value);
                lines.push(line("rms", number(`${path}.rms`)), line("largest", number(`${path}.worst`)), line("bound, rms", number(`${path}.bound`)),
                    line("texels", number(`${path}.texels`, plain)));
                if (result.report.mips[i].bias !== null) lines.push(line("energy", number(`${path}.bias`)));
            } else if (result.report.skipped.includes(level.mip)) {
                lines.push(element("div", { class: "note unsure" }, "not compared: give the environment with --source"));
            }
            const told = of => index => `mip ${level.mip}: ${of(index)}`;
            const shapes = [face("the file", level.shown, n => shown(rgb(level.texels, n)), told(n => triple(rgb(level.texels, n))))];
            const mip = compared.find(m => m.mip === level.mip);
            if (mip) {
                const both = told(n => `stored ${triple(rgb(mip.found, n))}, brute force ${triple(rgb(mip.expected, n))}, ` +
                    `off by ${exponential(difference(mip, n))}`);
                shapes.push(face("some of its texels", mip.grid, n => shown(rgb(mip.found, n)), both),
                    face("the same by brute force", mip.grid, n => shown(rgb(mip.expected, n)), both),
                    face("relative difference", mip.grid, n => signed(difference(mip, n) / (REACH * boundOf(mip))), both));
            }
            return element("div", { class: "mip" }, element("div", {}, lines), shapes);
        });
        return section("Mips beside brute force",
            element("p", { class: "note" }, `Brute force is ${result.against}: a sum over its texels in f64, which shares no node and no ` +
                "approximation with the bake. The figures at the left are of the check itself, the pictures of an even grid of texels."),
            element("div", { class: "choice" }, element("label", { for: "exposure" }, "exposure"), slider, stops),
            element("div", { class: "mips" }, rows),
            compared.length ? colourScale(`too dark by ${REACH} × the mip's bound`, x => signed(2 * x - 1), `too bright by ${REACH} × the bound; magenta: beyond`) : null,
            element("div", { class: "probe" }, probe));
    }

    function overview() {
        const row = (level, i) => [element("b", {}, `mip ${level.mip}`),
            element("span", {}, [0, 1, 2].map(c => [number(`report.levels.${i}.mean.${c}`, short), " "]).flat()),
            number(`report.levels.${i}.peak`, short), number(`report.levels.${i}.variance`),
            level.seams ? number(`report.levels.${i}.seams.across`) : "", level.seams ? number(`report.levels.${i}.seams.within`) : ""];
        return section("Light in every mip", tableOf(["", "mean radiance (r g b)", "brightest", "relative variance", "roughness of seams", "of the inside"],
            result.report.levels.map(row)),
            element("p", { class: "note below" }, "The mean over the sphere stays nearly the same from mip to mip (a few texels are a coarse sample of it), peak and variance fall. Where faces meet, " +
                "steps between texels should be as regular as inside of them."));
    }

    function conventions() {
        const parts = [];
        let height = 300;
        if (cube) {
            // Direction in which s and t run on each face, as the Vulkan and KTX2 specifications have it.
            const AXES = [["−Z", "−Y"], ["+Z", "−Y"], ["+X", "+Z"], ["+X", "−Z"], ["+X", "−Y"], ["−X", "−Y"]];
            const size = 96;
            CROSS.forEach(([column, row], i) => {
                const [x, y] = [column * size + 4, row * size + 4];
                parts.push(drawn("rect", { class: "axis", x, y, width: size, height: size }),
                    drawn("rect", { class: "row", x, y, width: size, height: 10 }),
                    label(x + 58, y + 62, FACES[i], { "text-anchor": "middle", class: "strong", style: "font-size: 18px" }),
                    label(x + size - 8, y + size - 8, `face ${i}`, { "text-anchor": "end" }),
                    ...arrow(x + 16, y + 22, x + 46, y + 22), label(x + 50, y + 26, AXES[i][0]),
                    ...arrow(x + 16, y + 22, x + 16, y + 52), label(x + 6, y + 68, AXES[i][1]));
            });
            height = 3 * size + 8;
        } else {
            const width = picture.projection === "equirect" ? 380 : 280;
            const high = picture.projection === "equirect" ? 190 : 280;
            const named = picture.projection === "equirect"
                ? [[0.5, 0.5, "+X"], [0.75, 0.5, "+Z"], [0.25, 0.5, "−Z"], [0.03, 0.5, "−X"], [0.97, 0.5, "−X"], [0.5, 0.06, "+Y along the top"], [0.5, 0.95, "−Y along the bottom"]]
                : [[0.5, 0.5, "+Y"], [0.94, 0.5, "+X"], [0.06, 0.5, "−X"], [0.5, 0.95, "+Z"], [0.5, 0.06, "−Z"], [0.07, 0.06, "−Y"], [0.93, 0.06, "−Y"], [0.07, 0.95, "−Y"], [0.93, 0.95, "−Y"]];
            parts.push(drawn("rect", { class: "axis", x: 30, y: 24, width, height: high }),
                drawn("rect", { class: "row", x: 30, y: 24, width, height: 10 }),
                ...arrow(30, 14, 30 + width, 14), ...arrow(20, 24, 20, 24 + high), label(34 + width, 18, "u"), label(16, 40 + high, "v"),
                ...named.map(([u, v, text]) => label(30 + u * width, 28 + v * high, text, { "text-anchor": "middle", class: "strong" })));
            height = high + 50;
        }
        const svg = drawn("svg", { viewBox: `0 0 430 ${height}`, role: "img", "aria-label": "how the sphere is laid out" }, parts);
        const lod = picture.roughness_law === "linear" ? "roughness * float(mips - 1)"
            : "(1.0 - (1.0 - roughness) * (1.0 - roughness)) * float(mips - 1)";
        const lookup = levels.length > 1 ? `const int mips = ${levels.length};\nfloat lod = ${lod};\n` +
            `vec3 radiance = textureLod(environment, ${cube ? "reflection" : "uv"}, lod).rgb;` : `vec3 light = texture(environment, ${cube ? "normal" : "uv"}).rgb;`;
        const law = levels.map(level => [String(level.mip), level.filtered ? level.alpha.toFixed(5) : "0",
            level.filtered ? Math.sqrt(level.alpha).toFixed(5) : "0"]);
        const alone = picture.meta.filter(([key]) => ["layout", "orientation", "mip.0"].includes(key));
        return section("Conventions", element("div", { class: "columns" },
            element("div", {}, element("h3", {}, "How the sphere is laid out"), svg,
                element("p", { class: "note", style: "margin-top: 8px" }, cube ? "Seen from inside. Arrows: where a face's texels run, first to the right, then down. " +
                    "Blue: row 0, first in the file." : "Blue: row 0, first in the file.")),
            element("div", {}, element("h3", {}, "Which mip holds which roughness"), tableOf(["mip", "alpha", "roughness = √alpha"], law))),
            element("h3", { style: "margin-top: 14px" }, "Reading it in a shader"), element("pre", {}, lookup),
            element("dl", {}, alone.flatMap(([key, value]) => [element("dt", {}, key), element("dd", {}, value)])));
    }

    const what = `${picture.projection} · ${picture.kernel} · ${result.encoding} · ${picture.levels[0].size.join(" × ")} texels` +
        `${cube ? " a face" : ""}, ${levels.length} ${levels.length === 1 ? "level" : "mips"} · compared with ${result.against}`;
    const made = [header(), element("p", { class: "what" }, what), failures(), mips(), result.report.levels.length ? overview() : null,
        element("section", {}, element("div", { class: "columns" }, laws(), certificate())), conventions(), metadata()];
    document.getElementById("page").replaceChildren(...made.filter(part => part !== null));
    redraw();
}
