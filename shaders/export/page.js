"use strict";
const at = (id) => document.getElementById(id);
const scene = JSON.parse(at("data").textContent);
const canvas = at("canvas");
[canvas.width, canvas.height] = scene.size;
const state = { ...scene.start, light: 0, eye: scene.camera.eye };

function say(text) {
    at("message").textContent = text;
    at("message").style.display = "block";
    canvas.style.display = at("controls").style.display = "none";
    document.body.dataset.state = "failed";
}

const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });

// Vectors

const minus = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const scaled = (a, s) => a.map((x) => x * s);
const unit = (a) => scaled(a, 1 / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// Light: rows of coefficients turned about +y, as the vectors and matrices that the shader reads (sdfprt/material/shading.py)

function turnedLight(rows, degrees) {
    // tilt takes +z to +y: turn = tilt * (turn about z) * tilt transposed
    const angle = degrees * Math.PI / 180, A = scene.tilt, count = scene.bands ** 2;
    const columns = rows[0].map((_, c) => c);
    const lying = rows.map((_, k) => columns.map((c) => A.reduce((sum, row, i) => sum + row[k] * rows[i][c], 0)));
    const turned = lying.map((row) => row.slice());
    for (let l = 1; l < scene.bands; l++)
        for (let m = 1; m <= l; m++) {
            const p = l * (l + 1) + m, q = l * (l + 1) - m, c = Math.cos(m * angle), s = Math.sin(m * angle);
            for (const k of columns) {
                turned[p][k] = c * lying[p][k] - s * lying[q][k];
                turned[q][k] = s * lying[p][k] + c * lying[q][k];
            }
        }
    return A.map((row) => columns.map((c) => {
        let sum = 0;
        for (let i = 0; i < count; i++) sum += row[i] * turned[i][c];
        return sum;
    }));
}

const quads = Math.ceil(scene.bands ** 2 / 4);

function diffuseLight(L) {
    const out = new Float32Array(3 * 4 * quads);
    L.forEach((row, i) => row.forEach((x, c) => { out[c * 4 * quads + i] = x / Math.PI; }));
    return out;
}

function glossyLight(L) {
    const out = new Float32Array(3 * quads * quads * 16), [K, I, J, value] = scene.tau;
    for (let t = 0; t < K.length; t++)
        for (let c = 0; c < 3; c++) {
            const block = (c * quads + (K[t] >> 2)) * quads + (I[t] >> 2);
            out[block * 16 + (I[t] & 3) * 4 + (K[t] & 3)] += value[t] * L[J[t]][c];
        }
    return out;
}

// What light bounces off, as bounced.glsl reads it: the twin of sdfprt/material/colours.py

function bounced(light) {
    const known = scene.bounces;
    if (!known) return {};
    const before = scene.owns.albedo ? known.colours : [], diffuse = (state.lobes & 1) !== 0;
    const now = scene.owns.albedo ? known.colours : known.colours.map(() => state.albedo);
    const weights = now.map((colour) => [...colour]);
    if (known.deeper) {
        const mean = (colours, c) => colours.reduce((sum, colour, q) => sum + known.sent[q] * colour[c], 0);
        const scale = [0, 1, 2].map((c) => mean(known.colours, c) > 0 ? (mean(now, c) / mean(known.colours, c)) ** 2 : 1);
        if (known.deeper === 1) weights.push(scale);
        else for (let c = 0; c < 3; c++) weights.push([0, 1, 2].map((k) => k === c ? scale[c] : 0));
    }
    const padded = [...before, ...Array(8 - before.length).fill([0, 0, 0])];
    return {
        bounceColours: weights.map((colour) => diffuse ? colour : [0, 0, 0]), partCount: before.length,
        partsBefore: padded, partsNow: padded, wholeLight: diffuseLight(turnedLight(light.whole, state.yaw)),
    };
}

// Light and lobe exact: the twin of sdfprt/light/prefiltered.py

function basis(d) {
    const n = scene.bands, y = new Float64Array(n * n);
    let re = 1, im = 0, diagonal = 1, first = 1;
    for (let m = 0; m < n; m++) {
        let before = 0, here = diagonal, ratio = first;
        for (let l = m; l < n; l++) {
            const value = Math.sqrt((2 * l + 1) / (4 * Math.PI) * ratio) * here, at = l * (l + 1);
            if (m === 0) y[at] = value;
            else {
                y[at + m] = Math.SQRT2 * value * re;
                y[at - m] = Math.SQRT2 * value * im;
            }
            [before, here] = [here, ((2 * l + 1) * d[2] * here - (l + m) * before) / (l - m + 1)];
            ratio *= (l - m + 1) / (l + m + 1);
        }
        [re, im] = [re * d[0] - im * d[1], re * d[1] + im * d[0]];
        diagonal *= -(2 * m + 1);
        first /= (2 * m + 1) * (2 * m + 2);
    }
    return y;
}

// Of each row of light times basis function, the Fourier coefficients about the vertical
function spectrum(light) {
    if (light.spectrum) return light.spectrum;
    const [W, H] = light.rest.size, F = W / 2 + 1, C = 3 * scene.bands ** 2;
    const re = new Float32Array(F * H * C), im = new Float32Array(F * H * C), row = new Float32Array(W * C);
    for (let r = 0; r < H; r++) {
        const polar = (r + 0.5) * Math.PI / H;
        const texel = (Math.cos(r * Math.PI / H) - Math.cos((r + 1) * Math.PI / H)) * 2 * Math.PI / W;
        for (let c = 0; c < W; c++) {
            const turn = (0.5 - (c + 0.5) / W) * 2 * Math.PI, s = Math.sin(polar);
            basis([s * Math.sin(turn), Math.cos(polar), s * Math.cos(turn)]).forEach((y, k) => {
                for (let j = 0; j < 3; j++) row[c * C + 3 * k + j] = y * texel * light.pixels[(r * W + c) * 3 + j];
            });
        }
        for (let f = 0; f < F; f++)
            for (let c = 0; c < W; c++) {
                const u = Math.cos(2 * Math.PI * f * c / W), v = -Math.sin(2 * Math.PI * f * c / W), to = (f * H + r) * C;
                for (let i = 0; i < C; i++) {
                    re[to + i] += u * row[c * C + i];
                    im[to + i] += v * row[c * C + i];
                }
            }
    }
    return light.spectrum = { re, im };
}

// F_j for one exponent, as layers of a texture: channel, coefficients in fours
function prefiltered(light, exponent) {
    const [W, H] = light.rest.size, F = W / 2 + 1, C = 3 * scene.bands ** 2, { re, im } = spectrum(light);
    const lobes = new Float32Array(F * H * H), values = new Float64Array(F);
    const cosines = Float64Array.from({ length: W }, (_, k) => Math.cos(2 * Math.PI * k / W));
    for (let a = 0; a < H; a++)
        for (let b = 0; b <= a; b++) {
            const p = (a + 0.5) * Math.PI / H, q = (b + 0.5) * Math.PI / H;
            for (let k = 0; k < F; k++) {
                const cosine = Math.cos(p) * Math.cos(q) + Math.sin(p) * Math.sin(q) * cosines[k];
                values[k] = (exponent + 2) / (2 * Math.PI) * Math.max(cosine, 0) ** exponent * (k === 0 || k === W / 2 ? 1 : 2);
            }
            for (let f = 0; f < F; f++) {
                let sum = 0;
                for (let k = 0; k < F; k++) sum += values[k] * cosines[f * k % W];
                lobes[(f * H + a) * H + b] = lobes[(f * H + b) * H + a] = sum;
            }
        }
    const out = new Float32Array(3 * quads * W * H * 4), sums = new Float32Array(2 * F * C), value = new Float32Array(C);
    for (let a = 0; a < H; a++) {
        sums.fill(0);
        for (let f = 0; f < F; f++)
            for (let b = 0; b < H; b++) {
                const lobe = lobes[(f * H + a) * H + b] * (f === 0 || f === W / 2 ? 1 : 2) / W, from = (f * H + b) * C;
                for (let i = 0; i < C; i++) {
                    sums[2 * f * C + i] += lobe * re[from + i];
                    sums[(2 * f + 1) * C + i] += lobe * im[from + i];
                }
            }
        for (let c = 0; c < W; c++) {
            value.fill(0);
            for (let f = 0; f < F; f++) {
                const u = cosines[f * c % W], v = Math.sin(2 * Math.PI * f * c / W);
                for (let i = 0; i < C; i++) value[i] += u * sums[2 * f * C + i] - v * sums[(2 * f + 1) * C + i];
            }
            for (let i = 0; i < C; i++) {
                const k = Math.floor(i / 3), layer = i % 3 * quads + (k >> 2);
                out[((layer * H + a) * W + c) * 4 + (k & 3)] = Math.min(Math.max(value[i], -65504), 65504);
            }
        }
    }
    return out;
}

const glossTextures = new Map();

// The maps of a light in their unit: of the exponent that is chosen, or of 1, 2, 4 ... where the scene gives its own
function useGloss(number, exponent) {
    const levels = scene.levels, key = `${number} ${levels > 1 ? "" : exponent}`, light = scene.lights[number];
    gl.activeTexture(gl.TEXTURE0 + scene.units.gloss);
    if (glossTextures.has(key)) return gl.bindTexture(gl.TEXTURE_2D_ARRAY, glossTextures.get(key));
    const [W, H] = light.rest.size, made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, made);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGBA16F, W, H, levels * 3 * quads);
    for (let level = 0; level < levels; level++) {
        const data = prefiltered(light, levels > 1 ? 2 ** level : exponent);
        gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, level * 3 * quads, W, H, 3 * quads, gl.RGBA, gl.FLOAT, data);
    }
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl["TEXTURE_" + name], gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    if (glossTextures.size >= 16) {
        const oldest = glossTextures.keys().next().value;
        gl.deleteTexture(glossTextures.get(oldest));
        glossTextures.delete(oldest);
    }
    glossTextures.set(key, made);
}

// The turn of coefficients into the light's frame: the transpose, in 4x4 blocks column by column
function turnTransfer(light, degrees) {
    const M = turnedLight(light.turn, degrees), out = new Float32Array(16 * quads * quads);
    M.forEach((row, i) => row.forEach((x, j) => {
        out[(((j >> 2) * quads + (i >> 2)) * 4 + (i & 3)) * 4 + (j & 3)] = x;
    }));
    return out;
}

// WebGL

async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

function texture(unit, inner, outer, kind, size, data, filter) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, inner, size[0], size[1], 0, outer, kind, data);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}

const programs = {};

function program(lobes) {
    if (programs[lobes]) return programs[lobes];
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, scene.vertex], [gl.FRAGMENT_SHADER, scene.fragment[lobes]]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(made, shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
            throw new Error("The browser does not take the shader:\n" + gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost())
        throw new Error("The browser does not take the shader:\n" + gl.getProgramInfoLog(made));
    gl.useProgram(made);
    const block = gl.getUniformBlockIndex(made, "GlossyLight");
    if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(made, block, 0);
    const textures = Object.fromEntries(Object.keys(scene.textures).map((name, k) => [name, scene.units.scene + k]));
    give(made, { ...scene.uniforms, ...textures, networkWeights: scene.units.weights, environment: scene.units.environment,
        glossMaps: scene.units.gloss, openLight: scene.units.open, glossLevels: scene.levels });
    return programs[lobes] = made;
}

function give(program, values) {
    const setters = {
        [gl.FLOAT]: "uniform1fv", [gl.FLOAT_VEC2]: "uniform2fv", [gl.FLOAT_VEC3]: "uniform3fv", [gl.FLOAT_VEC4]: "uniform4fv",
        [gl.INT]: "uniform1iv", [gl.BOOL]: "uniform1iv", [gl.SAMPLER_2D]: "uniform1iv",
        [gl.SAMPLER_3D]: "uniform1iv", [gl.SAMPLER_2D_ARRAY]: "uniform1iv",
    };
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
        const { name, type } = gl.getActiveUniform(program, i), key = name.replace("[0]", "");
        if (!(key in values)) continue;
        const place = gl.getUniformLocation(program, name), value = [values[key]].flat(2);
        const flat = value.length === 1 && ArrayBuffer.isView(value[0]) ? value[0] : value.map(Number);
        if (type === gl.FLOAT_MAT3) gl.uniformMatrix3fv(place, false, flat);
        else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(place, false, flat);
        else gl[setters[type]](place, flat);
    }
}

function draw() {
    const light = scene.lights[state.light], L = turnedLight(light.sh, state.yaw);
    const angle = state.yaw * Math.PI / 180, c = Math.cos(angle), s = Math.sin(angle), R = light.rotation;
    const forward = unit(minus(scene.camera.target, state.eye)), right = unit(cross(forward, scene.camera.up));
    const half = Math.tan(scene.camera.fov * Math.PI / 360);
    const now = program(state.lobes);
    gl.useProgram(now);
    gl.bindBuffer(gl.UNIFORM_BUFFER, glossy);
    gl.bufferData(gl.UNIFORM_BUFFER, glossyLight(L), gl.DYNAMIC_DRAW);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, glossy);
    gl.activeTexture(gl.TEXTURE0 + scene.units.environment);
    gl.bindTexture(gl.TEXTURE_2D, maps[state.light]);
    // Rows of the rotation as columns: world to map
    const toMap = [R[0].map((x, k) => c * x + s * R[2][k]), R[1], R[2].map((x, k) => c * x - s * R[0][k])];
    const discs = light.suns.sunDirection.map(([...way]) =>
        [0, 1, 2].map((i) => toMap[i][0] * way[0] + toMap[i][1] * way[1] + toMap[i][2] * way[2]).concat(way[3]));
    if (scene.exact) {
        if (state.lobes & 2) useGloss(state.light, state.exponent);
        gl.activeTexture(gl.TEXTURE0 + scene.units.open);
        gl.bindTexture(gl.TEXTURE_2D, opens[state.light]);
        give(now, { toLight: toMap, turnTransfer: turnTransfer(light, state.yaw) });
    }
    give(now, bounced(light));
    give(now, {
        sunCount: light.suns.sunCount, sunDirection: discs, sunEnergy: light.suns.sunEnergy, sunRough: light.suns.sunRough,
        eye: state.eye,
        // GL's first row is the lowest: the camera's image plane upside down
        axes: [...scaled(right, half * canvas.width / canvas.height), ...scaled(cross(forward, right), half), ...forward],
        canvas: scene.size,
        toMap,
        diffuseLight: diffuseLight(L),
        baseColour: state.albedo, baseExponent: state.exponent, specular: state.specular,
        exposure: state.exposure, background: state.background ? 1 : 0,
    });
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
}

let waiting = false;
function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
        waiting = false;
        try {
            draw();
            document.body.dataset.state = "drawn";
        } catch (error) {
            say(error.message);
        }
    });
}

// Camera: the mouse turns it about its target, the wheel moves it

function orbit(around, rise) {
    const offset = minus(state.eye, scene.camera.target), radius = Math.hypot(...offset);
    const turn = Math.atan2(offset[0], offset[2]) + around;
    const up = Math.min(1.5, Math.max(-1.5, Math.asin(offset[1] / radius) + rise));
    const way = [Math.sin(turn) * Math.cos(up), Math.sin(up), Math.cos(turn) * Math.cos(up)];
    state.eye = way.map((x, k) => scene.camera.target[k] + radius * x);
    redraw();
}

function zoom(factor) {
    state.eye = state.eye.map((x, k) => scene.camera.target[k] + (x - scene.camera.target[k]) * factor);
    redraw();
}

const fingers = new Map();
canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, e); });
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => fingers.delete(e.pointerId));
canvas.addEventListener("pointermove", (e) => {
    const before = fingers.get(e.pointerId);
    if (!before) return;
    if (fingers.size === 1) orbit((before.clientX - e.clientX) * 0.01, (e.clientY - before.clientY) * 0.01);
    else if (fingers.size === 2) {
        const other = [...fingers.values()].find((f) => f.pointerId !== e.pointerId);
        const apart = (f) => Math.max(1, Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY));
        zoom(apart(before) / apart(e));
    }
    fingers.set(e.pointerId, e);
});
canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(Math.sign(e.deltaY) * 0.1)); }, { passive: false });

// Controls: they start where the state is, and write to it

const decoded = (x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
const encoded = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
const toHex = (colour) => "#" + colour.map((x) => Math.round(255 * encoded(Math.min(1, x))).toString(16).padStart(2, "0")).join("");
const fromHex = (text) => [1, 3, 5].map((k) => decoded(parseInt(text.slice(k, k + 2), 16) / 255));

function labels() {
    at("yawText").textContent = state.yaw + "°";
    at("exponentText").textContent = state.exponent.toPrecision(3);
    at("exposureText").textContent = state.exposure.toPrecision(3);
    at("albedoLabel").style.display = !(state.lobes & 1) || scene.owns.albedo ? "none" : "";
    at("specularLabel").style.display = state.lobes === 1 ? "none" : "";
    at("exponentLabel").style.display = !(state.lobes & 2) || scene.owns.exponent ? "none" : "";
}

function bind(id, show, read) {
    show(at(id));
    at(id).addEventListener("input", () => { read(at(id)); labels(); redraw(); });
}

let glossy, maps;
const opens = [];
async function start() {
    if (!gl) return say("This page needs WebGL 2, which this browser or this machine does not offer.\n" +
        "Use a current Firefox, Chrome, Edge or Safari, and see that hardware acceleration is not switched off.");
    if (typeof DecompressionStream === "undefined") return say("This browser is too old for this page (no DecompressionStream).");
    texture(scene.units.weights, gl.RGBA32F, gl.RGBA, gl.FLOAT, scene.weights.size, new Float32Array(await unpacked(scene.weights.data)), gl.NEAREST);
    for (const [k, { size, data }] of Object.values(scene.textures).entries()) {
        const target = size.length === 2 ? gl.TEXTURE_2D : gl.TEXTURE_3D;
        gl.activeTexture(gl.TEXTURE0 + scene.units.scene + k);
        gl.bindTexture(target, gl.createTexture());
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        const halves = new Uint16Array(await unpacked(data));
        if (size.length === 2) gl.texImage2D(target, 0, gl.RGBA16F, ...size, 0, gl.RGBA, gl.HALF_FLOAT, halves);
        else gl.texImage3D(target, 0, gl.R16F, ...size, 0, gl.RED, gl.HALF_FLOAT, halves);
        const wrap = size.length === 2 ? gl.REPEAT : gl.CLAMP_TO_EDGE;
        for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(target, gl["TEXTURE_" + name], gl.LINEAR);
        for (const name of ["S", "T", "R"]) gl.texParameteri(target, gl["TEXTURE_WRAP_" + name], wrap);
    }
    maps = [];
    for (const light of scene.lights) {
        const pixels = new Uint32Array(await unpacked(light.map));
        texture(scene.units.environment, gl.RGB9_E5, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, light.size, pixels, gl.LINEAR);
        maps.push(gl.getParameter(gl.TEXTURE_BINDING_2D));
        if (scene.exact) {
            light.pixels = new Float32Array(await unpacked(light.rest.data));
            gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
            const open = new Uint16Array(await unpacked(light.open.data));
            texture(scene.units.open, gl.RGB16F, gl.RGB, gl.HALF_FLOAT, light.open.size, open, gl.LINEAR);
            opens.push(gl.getParameter(gl.TEXTURE_BINDING_2D));
        }
        at("light").append(new Option(light.name));
    }
    glossy = gl.createBuffer();
    gl.bindVertexArray(gl.createVertexArray());
    bind("light", (e) => { e.selectedIndex = 0; }, (e) => { state.light = e.selectedIndex; });
    bind("yaw", (e) => { e.value = state.yaw; }, (e) => { state.yaw = Number(e.value); });
    bind("lobes", (e) => { e.value = state.lobes; }, (e) => { state.lobes = Number(e.value); });
    bind("albedo", (e) => { e.value = toHex(state.albedo); }, (e) => { state.albedo = fromHex(e.value); });
    bind("specular", (e) => { e.value = toHex(state.specular); }, (e) => { state.specular = fromHex(e.value); });
    bind("exponent", (e) => { e.value = Math.log2(Math.max(1, state.exponent)); }, (e) => { state.exponent = 2 ** Number(e.value); });
    bind("exposure", (e) => { e.value = Math.log2(state.exposure); }, (e) => { state.exposure = 2 ** Number(e.value); });
    bind("background", (e) => { e.checked = state.background; }, (e) => { state.background = e.checked; });
    canvas.addEventListener("webglcontextlost", (e) => {
        e.preventDefault();
        say("The graphics driver took the drawing surface away. Load the page again.");
    });
    labels();
    redraw();
}
start().catch((error) => say(error.message));
