// SPDX-License-Identifier: MIT OR Apache-2.0
"use strict";

// What every page of this program starts with.
const data = JSON.parse(document.getElementById("data").textContent);

// An error must not hide behind an unfinished page: it is shown, and a test looks for it.
window.addEventListener("error", event => {
    const box = element("section", { class: "failures", "data-script-error": "" }, `This page failed: ${event.message}`);
    document.getElementById("page").prepend(box);
});

/// An element with attributes and children; text children become text nodes, never markup.
function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children.flat().filter(child => child !== null));
    return made;
}

function tableOf(heads, rows) {
    const cells = (name, list) => element("tr", {}, list.map(cell => element(name, {}, cell)));
    const body = rows.map(row => cells("td", row));
    return element("div", { class: "scroll" }, element("table", {}, heads ? cells("th", heads) : null, body));
}

function section(title, ...children) {
    return element("section", {}, element("h2", {}, title), ...children);
}

/// Everything that a file says of itself, folded away.
function said(summary, facts) {
    const rows = facts.flatMap(([key, value]) => [element("dt", {}, key), element("dd", {}, value)]);
    return element("details", {}, element("summary", {}, summary), element("dl", {}, rows));
}

function bytesOf(base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
    return bytes;
}
