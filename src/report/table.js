// SPDX-License-Identifier: MIT OR Apache-2.0
/// A table: maps with a probe, slices, conventions.
function tablePage() {
    const [columns, rows] = picture.shown;
    const { channels, step, axes } = picture;
    const count = channels.length;
    const values = floatsOf(picture.values);
    const ulps = halvesOf(picture.ulps);
    const coordinate = name => axes.findIndex(axis => axis.coordinate === name);
    const spoken = { n_dot_v: "n·v", roughness: "roughness" };
    const named = axis => spoken[axis.coordinate] ?? axis.coordinate;
    const flat = axes.length === 1;
    const at = (array, x, y, channel) => array[(y * columns + x) * count + channel];

    let channel = 0;
    const redraws = [];
    const redraw = () => redraws.forEach(draw => draw());
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", redraw);

    // Most errors are within half a step by rounding alone; single floats get the range that they have.
    const worst = ulps.reduce((most, e) => Math.max(most, Math.abs(e)), 0);
    const reach = picture.single ? Math.max(1, Math.min(worst, 1e4)) : 1;
    // A wrong file opens with the probe on what is worst.
    const worstAt = Math.floor(ulps.findIndex(e => Math.abs(e) === worst || Number.isNaN(e)) / count);
    let probe = result.passed || worstAt < 0 ? [Math.floor(columns / 3), Math.floor(rows / 3)]
        : [worstAt % columns, Math.floor(worstAt / columns)];
    const reachText = picture.single ? reach.toPrecision(2) : "1";

    function overview() {
        const row = (c, i) => [element("b", {}, c.name), number(`report.channels.${i}.worst`),
            element("span", {}, "(", number(`report.channels.${i}.worst_texel.0`, plain), ", ",
                number(`report.channels.${i}.worst_texel.1`, plain), ")"),
            number(`report.channels.${i}.rms`), number(`report.channels.${i}.median`),
            number(`report.channels.${i}.correctly_rounded`, percent)];
        return section("Errors against the truth",
            tableOf(["channel", "largest", "at texel (x, y)", "rms", "median", "correctly rounded"],
                result.report.channels.map(row)),
            element("p", { class: "note below" }, "Absolute up to 1, relative beyond, rounding to ", element("code", {}, result.encoding),
                " included. The truth: ", number("report.truth_texels", plain),
                " texels by adaptive f64 integration over light directions, itself within ", number("report.truth_error"),
                ". The twin: ", number("report.twin_texels", plain),
                " texels by the same rule in f64, largest difference ", number("report.twin_worst"), ", median ",
                number("report.twin_median"), ". The tightest bound of a checked texel is ", number("report.bound"), "."));
    }

    function channelButtons() {
        const buttons = channels.map((c, i) => {
            const button = element("button", { type: "button", title: c.meaning }, c.name);
            button.addEventListener("click", () => { channel = i; redraw(); });
            redraws.push(() => button.setAttribute("aria-pressed", String(i === channel)));
            return button;
        });
        const meaning = element("span", { class: "note" });
        redraws.push(() => { meaning.textContent = channels[channel].meaning; });
        return element("div", { class: "choice", role: "group", "aria-label": "channel" }, buttons, meaning);
    }

    function map(title, note, colour, scale) {
        const canvas = element("canvas", { tabindex: "0", role: "img", "aria-label": `${title}; arrow keys move the probe` });
        const move = event => {
            const box = canvas.getBoundingClientRect();
            const place = (offset, size, n) => Math.min(Math.max(Math.floor((offset / size) * n), 0), n - 1);
            probe = [place(event.clientX - box.left, box.width, columns), place(event.clientY - box.top, box.height, rows)];
            redraw();
        };
        canvas.addEventListener("pointermove", move);
        canvas.addEventListener("pointerdown", move);
        canvas.addEventListener("keydown", event => {
            const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
            const [dx, dy] = steps[event.key] ?? [0, 0];
            if (dx === 0 && dy === 0) return;
            event.preventDefault();
            probe = [Math.min(Math.max(probe[0] + dx, 0), columns - 1), Math.min(Math.max(probe[1] + dy, 0), rows - 1)];
            redraw();
        });
        // The picture itself is painted once a channel, the probe's mark over it.
        const still = element("canvas");
        let painted = -1;
        redraws.push(() => {
            if (painted !== channel) paint(still, columns, rows, colour);
            painted = channel;
            const zoom = Math.max(1, Math.round(512 / columns));
            // A single row is drawn as a band.
            const tall = flat ? 72 : zoom;
            canvas.width = columns * zoom;
            canvas.height = rows * tall;
            const context = canvas.getContext("2d");
            context.imageSmoothingEnabled = false;
            context.drawImage(still, 0, 0, canvas.width, canvas.height);
            const [x, y] = [(probe[0] + 0.5) * zoom, (probe[1] + 0.5) * tall];
            for (const [width, ink] of [[3, "#000"], [1, "#fff"]]) {
                context.lineWidth = width;
                context.strokeStyle = ink;
                context.beginPath();
                context.arc(x, y, 7, 0, 7);
                for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
                    context.moveTo(x + 7 * dx, y + 7 * dy);
                    context.lineTo(x + 14 * dx, y + 14 * dy);
                }
                context.stroke();
            }
        });
        const end = (axis, last) => axis.coordinates[last ? axis.coordinates.length - 1 : 0].toFixed(3);
        const x = element("div", { class: "x" }, element("span", {}, end(axes[0], false)),
            element("span", {}, `${named(axes[0])} →`), element("span", {}, end(axes[0], true)));
        const y = flat ? element("div", { class: "y" }) : element("div", { class: "y" }, element("span", {}, end(axes[1], false)),
            element("span", { class: "name" }, `← ${named(axes[1])}`), element("span", {}, end(axes[1], true)));
        return element("figure", {}, element("h3", {}, title), element("div", { class: "map" }, y, canvas, x), scale,
            element("p", { class: "note", style: "margin: 6px 0 0 44px" }, note));
    }

    function maps() {
        let [low, high] = [0, 1];
        const bar = element("div");
        redraws.push(() => {
            [low, high] = [Infinity, -Infinity];
            for (let i = channel; i < values.length; i += count) {
                low = Math.min(low, values[i]);
                high = Math.max(high, values[i]);
            }
            bar.replaceChildren(colourScale(short(low), viridis, short(high)));
        });
        const value = map("Stored values", "Row 0 of the file is on top.",
            (x, y) => viridis((at(values, x, y, channel) - low) / (high - low || 1)), bar);
        const nearest = picture.single ? "" : " Within half a step a texel is the nearest value that can be stored.";
        const error = map("Error of every texel, in ulp", `${picture.ulp}; against the twin, the same rule in f64. Red is too large, ` +
            `blue too small, magenta beyond the scale.${nearest}`,
            (x, y) => signed(at(ulps, x, y, channel) / reach),
            colourScale(`−${reachText} ulp`, x => signed(2 * x - 1), `+${reachText} ulp`));
        const thinned = step > 1 ? element("p", { class: "note" },
            `The table has ${picture.width} × ${picture.height} texels; every ${step}th of every ${step}th row is drawn.`) : null;
        return section("Every texel", channelButtons(), thinned, element("div", { class: "columns" }, value, error), probed());
    }

    /// What lies under the pointer.
    function probed() {
        const cells = element("div", { class: "cells" });
        const cell = (name, value) => element("div", {}, element("span", {}, name), element("b", { class: "number" }, value));
        redraws.push(() => {
            const [x, y] = probe;
            const found = [cell("texel (x, y)", `(${x * step}, ${y * step})`)];
            axes.forEach((axis, i) => found.push(cell(named(axis), axis.coordinates[probe[i] * step].toFixed(5))));
            channels.forEach((c, i) => {
                const error = at(ulps, x, y, i);
                found.push(cell(c.name, short(at(values, x, y, i))));
                found.push(cell(`${c.name}, error`, `${error < 0 ? "−" : "+"}${Math.abs(error).toFixed(3)} ulp`));
            });
            const [scale, bias] = ["scale", "bias"].map(name => channels.findIndex(c => c.name === name));
            if (scale >= 0 && bias >= 0) {
                const [a, b] = [at(values, x, y, scale), at(values, x, y, bias)];
                found.push(cell("specular at F0 0.04", short(0.04 * a + b)), cell("white metal, F0 1", short(a + b)));
            }
            cells.replaceChildren(...found);
        });
        return element("div", { class: "probe" }, element("h3", {}, "Under the pointer"), cells);
    }

    /// Lines across the table with the truth on them, and what is left between the two.
    function chart(along) {
        const [width, height, rest, left, gap] = [500, 250, 110, 46, 34];
        const lines = picture.slices.filter(slice => slice.along === along);
        const [axis, other] = [axes[along], axes[1 - along]];
        const svg = drawn("svg", { viewBox: `0 0 ${width + left + 74} ${height + gap + rest + 40}`, role: "img",
            "aria-label": `slices along ${named(axis)}` });
        redraws.push(() => {
            const range = channels[channel].range;
            const of = key => lines.flatMap(line => line[key].map(p => p[channel]));
            const [low, high] = [Math.min(0, range[0]), Math.max(...of("found"), ...of("truth"), 1e-6)];
            const errors = of("ulps").filter(Number.isFinite);
            const most = Math.max(picture.single ? 1 : 0.5, ...errors.map(Math.abs)) * 1.1;
            const px = x => left + x * width;
            const py = v => 8 + height * (1 - (v - low) / (high - low));
            const pe = e => 8 + height + gap + rest * (0.5 - 0.5 * (e / most));
            const parts = [];
            for (const t of [0, 0.25, 0.5, 0.75, 1]) {
                const value = low + t * (high - low);
                parts.push(drawn("line", { class: "grid", x1: px(0), x2: px(1), y1: py(value), y2: py(value) }),
                    drawn("line", { class: "grid", x1: px(t), x2: px(t), y1: 8, y2: 8 + height }),
                    drawn("line", { class: "grid", x1: px(t), x2: px(t), y1: pe(most), y2: pe(-most) }),
                    label(left - 6, py(value) + 4, value.toPrecision(2), { "text-anchor": "end" }),
                    label(px(t), pe(-most) + 16, String(t), { "text-anchor": "middle" }));
            }
            for (const e of picture.single ? [-most / 1.1, 0, most / 1.1] : [-0.5, 0, 0.5]) {
                parts.push(drawn("line", { class: e === 0 ? "axis" : "grid", x1: px(0), x2: px(1), y1: pe(e), y2: pe(e) }),
                    label(left - 6, pe(e) + 4, e === 0 ? "0" : e.toPrecision(2).replace("-", "−"), { "text-anchor": "end" }));
            }
            parts.push(label(px(0.5), pe(-most) + 32, named(axis), { "text-anchor": "middle", class: "strong" }),
                label(px(0), pe(most) - 7, "stored − truth, in ulp"));
            let ends = [];
            lines.forEach((line, i) => {
                // The end of the ramp that the page's colour would swallow is left out.
                const [r, g, b] = viridis((dark.matches ? 0.3 : 0.05) + (0.7 * i) / Math.max(lines.length - 1, 1));
                const ink = `rgb(${r} ${g} ${b})`;
                const where = other ? other.coordinates[line.at] : 0;
                const x = j => px(axis.coordinates[line.places[j]]);
                const points = line.found.map((p, j) => [x(j), p[channel]]).filter(p => Number.isFinite(p[1]));
                parts.push(drawn("polyline", { fill: "none", stroke: ink, "stroke-width": 2,
                    points: points.map(p => `${p[0].toFixed(1)},${py(p[1]).toFixed(1)}`).join(" ") }));
                line.truth.forEach((truth, j) => {
                    parts.push(drawn("circle", { cx: x(j).toFixed(1), cy: py(truth[channel]).toFixed(1), r: 2.6, fill: "var(--card)",
                        stroke: ink, "stroke-width": 1.4 }));
                    if (Number.isFinite(line.ulps[j][channel])) {
                        parts.push(drawn("circle", { cx: x(j).toFixed(1), cy: pe(line.ulps[j][channel]).toFixed(1), r: 2, fill: ink }));
                    }
                });
                if (other) ends.push({ y: py(line.truth[axis.reversed ? 0 : line.truth.length - 1][channel]), text: where.toFixed(3), ink });
            });
            // Labels at the ends of the lines, moved apart.
            ends = ends.sort((a, b) => a.y - b.y);
            ends.forEach((end, i) => { end.y = Math.max(end.y, i > 0 ? ends[i - 1].y + 14 : 0); });
            ends.forEach(end => parts.push(drawn("circle", { cx: px(1) + 12, cy: end.y, r: 4, fill: end.ink }),
                label(px(1) + 20, end.y + 4, end.text)));
            svg.replaceChildren(...parts);
        });
        return element("figure", { class: "chart" }, element("h3", {}, `Along ${named(axis)}` + (other ? `, at five values of ${named(other)}` : "")), svg);
    }

    function slices() {
        return section("Slices against the truth",
            element("p", { class: "note" }, "Lines: what the file stores. Rings: the truth, integrated over light directions. " +
                "Dots below: what is left between the two."),
            element("div", { class: "columns" }, flat ? chart(0) : [chart(0), chart(1)]));
    }

    function conventions() {
        const [cell, left, top, n] = [44, 120, 54, 4];
        const high = flat ? 1 : n;
        const parts = [drawn("rect", { class: "row", x: left, y: top, width: n * cell, height: cell })];
        for (let i = 0; i <= n; i += 1) {
            parts.push(drawn("line", { class: "axis", x1: left + i * cell, x2: left + i * cell, y1: top, y2: top + high * cell }));
            if (i <= high) parts.push(drawn("line", { class: "axis", x1: left, x2: left + n * cell, y1: top + i * cell, y2: top + i * cell }));
        }
        const first = axis => axis.coordinates[0].toPrecision(3);
        const last = axis => axis.coordinates[axis.coordinates.length - 1].toPrecision(3);
        parts.push(...arrow(left, top - 14, left + n * cell, top - 14),
            label(left + (n * cell) / 2, top - 34, `x: ${named(axes[0])}, ${axes[0].reversed ? "descending" : "ascending"}`, { "text-anchor": "middle", class: "strong" }),
            label(left, top - 20, first(axes[0]), { "text-anchor": "middle" }), label(left + n * cell, top - 20, last(axes[0]), { "text-anchor": "middle" }),
            label(left + n * cell + 10, top + cell / 2 + 4, "row 0: first in the file, top of the picture", { class: "strong" }));
        if (!flat) {
            parts.push(...arrow(left - 14, top, left - 14, top + n * cell),
                label(left - 24, top + 8, first(axes[1]), { "text-anchor": "end" }),
                label(left - 24, top + (n * cell) / 2, `y: ${named(axes[1])}`, { "text-anchor": "end", class: "strong" }),
                label(left - 24, top + (n * cell) / 2 + 16, axes[1].reversed ? "descending" : "ascending", { "text-anchor": "end" }),
                label(left - 24, top + n * cell, last(axes[1]), { "text-anchor": "end" }),
                label(left + n * cell + 10, top + (n - 0.5) * cell + 4, `row ${picture.height - 1}: last in the file`));
        }
        const orientation = drawn("svg", { viewBox: `0 0 580 ${top + high * cell + 16}`, role: "img", "aria-label": "which axis runs where" }, parts);

        // Where in its texel a value is taken, for a line of four.
        const edges = axes[0].points === "edges";
        const [x0, y0, size] = [40, 40, 84];
        const taken = i => (edges ? (i / (n - 1)) * n : i + 0.5);
        const texels = [];
        for (let i = 0; i < n; i += 1) {
            texels.push(drawn("rect", { class: "axis", x: x0 + i * size, y: y0, width: size, height: 34 }),
                drawn("circle", { class: "point", cx: x0 + taken(i) * size, cy: y0 + 17, r: 5 }),
                label(x0 + taken(i) * size, y0 - 10, edges ? `${i}/3` : `${2 * i + 1}/8`, { "text-anchor": "middle" }),
                label(x0 + (i + 0.5) * size, y0 + 52, `texel ${i}`, { "text-anchor": "middle" }));
        }
        const points = drawn("svg", { viewBox: "0 0 500 110", role: "img", "aria-label": "where in its texel a value is taken" }, texels);
        const rule = edges ? "Edges: texel i of N holds the value at i/(N − 1). The first is the limit at 0, the last the value at 1."
            : "Centers: texel i of N holds the value at (i + ½)/N, which is what a sampler reads there.";

        const uv = axes.map((axis, i) => {
            const value = axis.reversed ? `1.0 - ${axis.position}` : axis.position;
            const size = i === 0 ? picture.width : picture.height;
            return edges ? `((${value}) * ${size - 1}.0 + 0.5) / ${size}.0` : value;
        });
        const letters = "rgba".slice(0, count);
        const lookup = `// clamp to edge, linear filter\nvec2 uv = vec2(${uv[0]}, ${uv[1] ?? "0.5"});\n` +
            `${count > 1 ? `vec${count}` : "float"} t = texture(table, uv).${letters};\n` +
            channels.map((c, i) => `// t${count > 1 ? `.${letters[i]}` : ""}: ${c.name}, ${c.meaning}`).join("\n");
        const usage = picture.meta.find(([key]) => key === "usage");
        return section("Conventions", element("div", { class: "columns" },
            element("div", {}, element("h3", {}, "Which axis runs where"), orientation),
            element("div", {}, element("h3", {}, "Where in its texel a value is taken"), points, element("p", { class: "note" }, rule),
                element("p", { class: "note" }, "roughness is what an artist sets; the width of the lobe is alpha = roughness²."))),
            element("h3", { style: "margin-top: 14px" }, "Reading it in a shader"), element("pre", {}, lookup),
            usage ? element("p", { class: "note", style: "margin-top: 8px" }, usage[1]) : null);
    }

    const what = `${result.table} · ${result.ndf} · ${result.visibility} · Fresnel ${result.fresnel} · ${result.encoding} · ` +
        `${picture.width} × ${picture.height} texels`;
    const made = [header(), element("p", { class: "what" }, what), failures(), overview(), maps(), slices(),
        element("section", {}, element("div", { class: "columns" }, laws(), certificate())), conventions(), metadata()];
    document.getElementById("page").replaceChildren(...made.filter(part => part !== null));
    redraw();
}
