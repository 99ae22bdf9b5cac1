// SPDX-License-Identifier: MIT OR Apache-2.0
/// Degrees that an arrow key turns, and stops that a key brightens.
const KEY_DEG = 5;
const KEY_EV = 0.5;

function files() {
    const list = [
        ...data.lights.map(light => [light, "environment", `${light.specular.size} × ${light.specular.size} a face, ` +
            `${light.specular.levels === 1 ? "1 level" : `${light.specular.levels} mips`}, filtered with ${light.kernel}, roughness law ${light.law}` +
            (light.specular.scale > 1 ? `; stored over ${light.specular.scale}, so that its sun fits half floats` : "")]),
        ...data.diffuses.map(diffuse => [diffuse, "irradiance", `${diffuse.map.size} × ${diffuse.map.size} a face`]),
        ...data.tables.map(table => [table, "table", `${table.size.join(" × ")}, x ${table.position[0]}, y ${table.position[1]}`]),
    ];
    const file = ([entry, kind, words]) => element("div", { class: "file" }, element("b", {}, entry.name), ` ${kind}`,
        element("div", { class: "note" }, words),
        entry.facts.length ? said("Everything that the file says of itself", entry.facts) : null);
    const megabytes = (document.documentElement.innerHTML.length / 1e6).toFixed(1);
    return section("What it is drawn from", element("div", { class: "columns" }, list.map(file)),
        element("p", { class: "note below" }, `Texels are half floats here, filtered by the GPU. This page has ${megabytes} MB and ` +
            "needs no network."));
}

function viewPage() {
    const page = document.getElementById("page");
    page.classList.add("view");
    const canvas = element("canvas", {
        id: "spheres", tabindex: "0", role: "application", "aria-describedby": "keys",
        "aria-label": "Spheres under an environment; the form beside them says what is drawn",
    });
    const title = element("header", {}, element("h1", {}, data.title));
    const brush = painter(canvas);
    const refusal = brush === null ? "This browser shows no WebGL 2." : brush.refusal();
    if (refusal !== null) {
        page.append(title, element("section", { class: "failures", id: "no-webgl" }, element("h2", {}, "No picture"),
            element("p", {}, `${refusal} Another browser may, or this one with hardware acceleration switched on in its settings. ` +
                "Without a browser the same picture is drawn by"),
            element("pre", {}, command(1280, 720))), files());
        return;
    }

    const probe = element("span", { id: "probe" });
    const warning = element("p", { class: "note unsure", id: "warning", role: "status" });
    const line = element("pre", { id: "command", tabindex: "0" });
    let waiting = false;
    const draw = () => {
        waiting = false;
        brush.draw(sceneOf());
    };
    const changed = () => {
        line.textContent = command(canvas.width, canvas.height);
        warning.textContent = warnings();
        if (!waiting) requestAnimationFrame(draw);
        waiting = true;
    };
    const { form, set } = controls(changed);
    canvas.addEventListener("redraw", changed);

    // One pixel of the picture is one of the screen, up to two along a side of a CSS pixel.
    const frame = element("div", { class: "frame" }, canvas);
    new ResizeObserver(() => {
        const ratio = Math.min(window.devicePixelRatio, 2);
        const box = frame.getBoundingClientRect();
        const [left, top] = [box.left + window.scrollX, box.top + window.scrollY].map(at => Math.ceil(at) - at);
        const [width, height] = [box.width - left, box.height - top].map(side => Math.max(Math.floor(side), 1));
        canvas.style.left = `${left}px`;
        canvas.style.top = `${top}px`;
        canvas.style.width = `${width}px`;
        canvas.style.height = `${height}px`;
        [canvas.width, canvas.height] = [width, height].map(side => Math.round(side * ratio));
        // Setting the size has cleared it.
        draw();
        changed();
    }).observe(frame);

    const within = (value, most) => Math.min(Math.max(Math.round(2 * value) / 2, -most), most);
    const around = value => ((((Math.round(2 * value) / 2 + 180) % 360) + 360) % 360) - 180;
    const turn = (rotate, tilt) => {
        state.rotate = around(rotate);
        set("tilt", within(tilt, 90));
    };

    // What is in the middle of the background stays under the pointer.
    let held = null;
    canvas.addEventListener("pointerdown", event => {
        held = { x: event.clientX, y: event.clientY, rotate: state.rotate, tilt: state.tilt };
        canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", event => {
        if (held) {
            const degrees = 1.1547 / canvas.clientHeight * 180 / Math.PI;
            turn(held.rotate - (event.clientX - held.x) * degrees, held.tilt + (event.clientY - held.y) * degrees);
        }
        const box = canvas.getBoundingClientRect();
        probe.textContent = told(event.clientX - box.left, event.clientY - box.top, box);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
    canvas.addEventListener("keydown", event => {
        const act = {
            ArrowLeft: () => turn(state.rotate + KEY_DEG, state.tilt), ArrowRight: () => turn(state.rotate - KEY_DEG, state.tilt),
            ArrowUp: () => turn(state.rotate, state.tilt + KEY_DEG), ArrowDown: () => turn(state.rotate, state.tilt - KEY_DEG),
            "+": () => set("ev", Math.min(state.ev + KEY_EV, 8)), "-": () => set("ev", Math.max(state.ev - KEY_EV, -8)),
            Home: () => turn(0, 0),
        }[event.key];
        if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        act();
    });

    /// What the sphere under a point is made of.
    function told(x, y, box) {
        const { grid: [columns, rows], span } = sceneOf();
        const tile = Math.min(box.width / columns, box.height / rows);
        const column = Math.floor((x - 0.5 * box.width) / tile + 0.5 * columns);
        const row = Math.floor((y - 0.5 * box.height) / tile + 0.5 * rows);
        const inside = column >= 0 && row >= 0 && column < columns && row < rows;
        return inside
            ? `Here: metallic ${(span[0] + span[1] * column).toFixed(2)}, roughness ${(span[2] + span[3] * row).toFixed(2)}.`
            : "";
    }
    probe.textContent = told(-1e9, 0, { width: 1, height: 1 });

    page.append(title,
        element("div", { class: "stage" },
            element("section", { class: "picture" }, frame,
                element("p", { class: "note" }, `In the grid metallic runs to the right and roughness downwards, from 0 to 1. `, probe),
                element("p", { class: "note", id: "keys" }, "Drag to look around. Keys: arrows turn, + and − expose, Home looks ahead."),
                warning),
            element("section", {}, form)),
        section("The same from the command line", line,
            element("p", { class: "note below" }, "In place of the GPU's filtering it reads single floats between texels; with --reference it " +
                "integrates the BRDF instead.")),
        files());
}

viewPage();
