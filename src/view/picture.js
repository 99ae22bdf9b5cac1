// SPDX-License-Identifier: MIT OR Apache-2.0
const VERTICES = `#version 300 es
void main() {
    // One triangle over the whole picture.
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

/// Draws scenes into a canvas; null where the browser has no WebGL 2.
function painter(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false });
    if (gl === null) return null;
    // What a GPU holds of the page's maps; all of it is lost when the GPU is taken away.
    let maps = new Map();
    let programs = new Map();
    const mostMips = Math.max(...data.lights.map(light => light.specular.levels));

    function compiled(type, text) {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
            throw new Error(`the shader does not compile: ${gl.getShaderInfoLog(shader)}`);
        }
        return shader;
    }

    /// The program for tables with these positions, and the places of its uniforms.
    function programFor([x, y]) {
        const key = `vec2(${x}, ${y})`;
        if (!programs.has(key)) {
            const parts = data.parts.map(([dx, dy]) => `vec2(${dx.toFixed(1)}, ${dy.toFixed(1)})`);
            const head = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp samplerCube;
#define MIPS ${mostMips}
#define PARTS ${parts.length}
#define POSITION ${key}
const vec2 PART_OF[PARTS] = vec2[](${parts.join(", ")});
`;
            const program = gl.createProgram();
            gl.attachShader(program, compiled(gl.VERTEX_SHADER, VERTICES));
            gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, head + data.shader));
            gl.linkProgram(program);
            if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
                throw new Error(`the shader does not link: ${gl.getProgramInfoLog(program)}`);
            }
            programs.set(key, program);
        }
        return programs.get(key);
    }

    function uploaded(key, target, upload) {
        if (!maps.has(key)) {
            const texture = gl.createTexture();
            gl.bindTexture(target, texture);
            // Rows of a single texel have six bytes.
            gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
            upload();
            gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
            gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
            gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
            maps.set(key, texture);
        }
        return maps.get(key);
    }

    /// Half floats of the page.
    const halves = base64 => new Uint16Array(bytesOf(base64).buffer);

    function cubeMap(key, map) {
        return uploaded(key, gl.TEXTURE_CUBE_MAP, () => {
            const texels = halves(map.texels);
            let at = 0;
            for (let level = 0; level < map.levels; level += 1) {
                const size = Math.max(map.size >> level, 1);
                for (let face = 0; face < 6; face += 1) {
                    gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + face, level, gl.RGB16F, size, size, 0, gl.RGB, gl.HALF_FLOAT,
                        texels.subarray(at, at + 3 * size * size));
                    at += 3 * size * size;
                }
            }
            gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAX_LEVEL, map.levels - 1);
            gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
        });
    }

    function tableMap(key, table) {
        return uploaded(key, gl.TEXTURE_2D, () => {
            const [width, height] = table.size;
            gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, width, height, 0, gl.RGB, gl.HALF_FLOAT, halves(table.texels));
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        });
    }

    /// Draws a scene as `sceneOf` describes it.
    function draw(scene) {
        if (gl.isContextLost()) return;
        const { light, table } = scene;
        const program = programFor(table.position);
        gl.useProgram(program);
        gl.viewport(0, 0, canvas.width, canvas.height);
        const at = name => gl.getUniformLocation(program, name);
        const bind = (unit, target, name, texture) => {
            gl.activeTexture(gl.TEXTURE0 + unit);
            gl.bindTexture(target, texture);
            gl.uniform1i(at(name), unit);
        };
        // Uploads bind, too: first all of them.
        const specular = cubeMap(light.specular, light.specular);
        const diffuse = cubeMap(scene.diffuse, scene.diffuse);
        const split = tableMap(table, table);
        bind(0, gl.TEXTURE_CUBE_MAP, "specular_map", specular);
        bind(1, gl.TEXTURE_CUBE_MAP, "diffuse_map", diffuse);
        bind(2, gl.TEXTURE_2D, "table_map", split);
        gl.uniform2f(at("size"), canvas.width, canvas.height);
        gl.uniform2fv(at("grid"), scene.grid);
        gl.uniform1f(at("radius"), data.radius);
        gl.uniform4fv(at("span"), scene.span);
        gl.uniform3fv(at("base"), scene.base);
        gl.uniform3fv(at("edge"), scene.edge);
        gl.uniform1f(at("f0"), scene.f0);
        gl.uniform1i(at("compensate"), scene.compensate ? 1 : 0);
        gl.uniformMatrix3fv(at("frame"), true, scene.frame.flat());
        gl.uniform1f(at("background"), scene.background);
        gl.uniform1f(at("exposure"), 2 ** scene.exposure);
        gl.uniform1i(at("film"), scene.film ? 1 : 0);
        gl.uniform1f(at("specular_scale"), light.specular.scale);
        gl.uniform1f(at("diffuse_scale"), scene.diffuse.scale);
        gl.uniform1i(at("mips"), light.specular.levels);
        gl.uniform1fv(at("roughness_of"), [...light.roughness, ...Array(mostMips).fill(1)].slice(0, mostMips));
        gl.uniformMatrix2fv(at("place"), false, table.place.flat());
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const error = gl.getError();
        if (error !== gl.NO_ERROR && error !== gl.CONTEXT_LOST_WEBGL) throw new Error(`WebGL error ${error}`);
    }

    canvas.addEventListener("webglcontextlost", event => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
        maps = new Map();
        programs = new Map();
        canvas.dispatchEvent(new Event("redraw"));
    });

    /// The first map that this browser cannot hold, in words; null where it holds all.
    function refusal() {
        const most = gl.getParameter(gl.MAX_CUBE_MAP_TEXTURE_SIZE);
        const light = data.lights.find(l => l.specular.size > most);
        if (light) return `${light.name} has faces of ${light.specular.size} texels; this browser holds ${most}.`;
        const side = gl.getParameter(gl.MAX_TEXTURE_SIZE);
        const table = data.tables.find(t => Math.max(...t.size) > side);
        return table ? `${table.name} has ${table.size.join(" × ")} texels; this browser holds ${side}.` : null;
    }

    return { draw, refusal };
}
