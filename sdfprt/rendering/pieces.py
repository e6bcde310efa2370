"""Shader text: pieces of shaders/*.glsl, the network's weights as constants, the user's scene last.

The user's text comes after ours, so its macros cannot touch us; names of ours that it declares again are renamed there.
"""

import functools
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float16
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder
from sdfprt.glsl.parts import KINDS
from sdfprt.glsl.rounding import rounded_singly
from sdfprt.glsl.scanner import Block, declarations, macros, without_comments
from sdfprt.glsl.text import blocks, fours, number, vector
from sdfprt.light.suns import Suns
from sdfprt.material.lobes import Diffuse, Material, Phong, Reflection, parts
from sdfprt.material.shading import ExactLight
from sdfprt.maths import sh
from sdfprt.network.cells import AnyNet, CellNets, networks
from sdfprt.network.mlp import SLOPE, TransferNet, encode
from sdfprt.sdf.scene import NORMAL_STEP, Scene
from sdfprt.tables.volume import LIFT, VolumeTable, cosine_product

VERSION = "#version 430"
SURFACE = ("grid", "hits", "camera", "trace", "normal", "surface")
LIGHT = ("network", "open_sky", "sh", "latlong", "reflection", "shade", "bounced", "light")
VOLUME_LIGHT = ("volume", *LIGHT[2:])
SUNLIGHT = ("trace", "suns", "sunlight")
SUN_TILES = ("grid", "trace", "suntiles")
LIST = ("grid", "hits", "list")
MESH_VERTEX = ("pinhole", "mesh_vertex")
GOURAUD_VERTEX = ("pinhole", "sh", "latlong", "reflection", "shade", "gouraud_vertex")
GOURAUD = ("sh", "latlong", "reflection", "shade", "gouraud")
TEXTURED = ("relief", "sh", "latlong", "reflection", "shade", "textured")
MESH_DEPTH = ("mesh_depth",)
MESH_SURFACE = ("relief", "mesh_surface")
BACKGROUND = ("grid", "camera", "latlong", "background")
MEAN = ("grid", "mean")
GRAIN = 4  # samples along a side that a cone of the coarse pass holds
HALVES = "GL_NV_gpu_shader5"  # the extension that has f16vec2
_TEXELS = 1024  # in a row of the texture of weights
_NETS = 8  # networks, and how they are drawn, whose sizes are not worked out anew in each frame
_PROBES, _ROOM = 512, 16  # points that are tried, and how much more the others may reach, before hidden values are half floats
_NEURONS, _WARP = 16, 32  # of blocks.glsl: neurons that so many invocations take
_LAYERS = 11  # at most: a compute shader has 12 blocks of uniforms with every driver (OpenGL 4.3, table 23.64), one the light's
_SHARED = 32_768  # bytes of shared memory that a work group has with every driver (OpenGL 4.3, table 23.60)


@dataclass(frozen=True)
class Variant:
    """What makes another lighting program: lobes, bands, fixed light (TPFL) or the whole triple product (TP)."""

    lobes: int  # 1 diffuse, 2 Phong, 4 reflection mapping, and sums of them
    light_bands: int = 4
    result_bands: int = 4
    fixed_light: bool = True
    points: int = 1  # samples an invocation takes through the network together
    constant: str = ""  # digest of the network whose weights are in the text
    exact: bool = False  # light and lobe exact: bands of light and result do not count
    group: int = 8  # invocations side by side: llvmpipe runs 8 together, a GPU two warps of 32
    block: int = 0  # points that a group takes through the network together; 0: each invocation its own
    halves: bool = False  # their sums are half floats

    @property
    def samples(self) -> int:
        """Of a group."""
        return self.block or self.group * self.points


def lobes_of(material: Material) -> int:
    return sum({Diffuse: 1, Phong: 2, Reflection: 4}[type(lobe)] for lobe in material.lobes)


@functools.cache
def piece(name: str) -> str:
    """Text of shaders/<stage>/<name>.glsl; names are unique over the stages."""
    (path,) = folder("shaders").glob(f"*/{name}.glsl")
    return path.read_text()


def _quads(count: int) -> int:
    return -(-count // 4)


def join(pieces: tuple[str, ...]) -> str:
    """The pieces, each under a #line whose ten-thousands say which piece it is; what several of them declare, once."""
    seen: set[str] = set()

    def keep(match: re.Match) -> str:
        return match[0] if match[1] not in seen and not seen.add(match[1]) else ""

    text = "\n".join(f"#line {10000 * at + 1}\n{piece(name)}" for at, name in enumerate(pieces, 1))
    return re.sub(r"^(?:uniform )?\w+ (\w+)(?:\[[^\]]*\])?;[^\n]*$", keep, text, flags=re.M)


def place(message: str, pieces: tuple[str, ...]) -> str:
    """A driver's message with its numbers turned back into `piece.glsl:line`."""

    def name(match: re.Match) -> str:
        at, line = divmod(int(match[1]), 10000)
        return f"{pieces[at - 1]}.glsl:{line}" if 1 <= at <= len(pieces) else match[0]

    return re.sub(r"\b0:(\d+)\b", name, message)


def flags(scene: Scene) -> list[str]:
    """What the pieces ask of a scene's text."""
    return [f"#define HAS_{name.upper()}" for name in KINDS if getattr(scene, f"has_{name}")]


def scene_uniforms(scene: Scene) -> dict[str, Any]:
    """Uniforms of trace.glsl and normal.glsl."""
    low, high = scene.bounds
    return {
        "boundsLow": low,
        "boundsHigh": high,
        "hitDistance": settings.Trace.hit * scene.diagonal,
        "stepFactor": scene.step,
        "marchSteps": settings.Trace.steps,
        "normalStep": NORMAL_STEP * scene.diagonal,
    }


def shadow_uniforms(scene: Scene) -> dict[str, Any]:
    """Uniforms of suns.glsl for what belongs to the scene."""
    return {
        "shadowDistance": settings.Trace.epsilon * scene.diagonal,
        "shadowLift": settings.Trace.lift * scene.diagonal,
    }


@functools.lru_cache(maxsize=_NETS)
def network_uniforms(net: AnyNet) -> dict[str, Any]:
    """Uniforms of network.glsl, or of cells.glsl, without the weights."""
    above = {"networkOpen": float(networks(net)[0].residual)}
    if isinstance(net, CellNets):
        cells = net.cells
        counts = tuple(map(int, cells.owner.shape))
        return {"cellsLow": cells.low, "cellsSide": cells.side, "cellsCount": counts, "cellsBand": float(cells.band), **above}
    box = {"networkCenter": tuple(map(float, net.center)), "networkExtent": float(net.extent)}
    return {**box, "networkScale": fours(padded_outputs(net.scale, net)), **above}


def picture_uniforms(material: Material) -> dict[str, Any]:
    """Uniforms of picture.glsl for what the material has; `albedo` and `exponent` are the scene's functions there."""
    names = {"albedo": "baseColour", "exponent": "baseExponent", "specular": "specular"}
    return {names[part]: value for part, value in parts(material).items()}


def scene_compute(scene: Scene, pieces: tuple[str, ...], shape: tuple[int, int]) -> str:
    """A pass with the scene's text: SURFACE, SUN_TILES or SUNLIGHT, in groups of `shape` samples."""
    sizes = [f"#define MOST_SUNS {settings.Suns.most}", *grid_sizes(shape)]
    ours = "\n".join([VERSION, *flags(scene), *sizes, join(pieces)])
    users = rounded_singly(scene.shader_source)
    return "\n".join([ours, renamed(ours, users), "#line 1", users])


def fixed_compute(pieces: tuple[str, ...], shape: tuple[int, int]) -> str:
    """A pass without anything of the scene's or the network's: LIST, BACKGROUND or MEAN."""
    return "\n".join([VERSION, *grid_sizes(shape), join(pieces)])


def grid_sizes(shape: tuple[int, int]) -> list[str]:
    """What grid.glsl asks for, of groups that are so wide and high."""
    return [f"#define GROUP {shape[0] * shape[1]}", f"#define GROUP_WIDTH {shape[0]}"]


def fixed_stage(pieces: tuple[str, ...], *options: str) -> str:
    """A stage without anything of the scene's or the network's, such as MESH_VERTEX, with these options of its pieces."""
    return "\n".join([VERSION, *(f"#define {name}" for name in options), join(pieces)])


def light_compute(net: AnyNet, variant: Variant) -> str:
    """The second pass, a compute shader without text of the user's; without weights too, the same for all, if not `constant`."""
    tau = [] if variant.fixed_light or variant.exact else [tau_text(net.bands, variant.light_bands, variant.result_bands)]
    weights = [constant_network(net)] if variant.constant and isinstance(net, TransferNet) else []
    halves = [f"#extension {HALVES} : require"] if variant.halves else []
    return "\n".join([VERSION, *halves, defines(net, variant), *tau, *weights, join(light_pieces(net, variant))])


def volume_compute(table: VolumeTable, variant: Variant) -> str:
    """The second pass where a volume holds transfer; the same for all volumes of its bands."""
    tau = [] if variant.fixed_light or variant.exact else [tau_text(table.bands, variant.light_bands, variant.result_bands)]
    return "\n".join([VERSION, volume_defines(table, variant), *tau, join(VOLUME_LIGHT)])


def volume_defines(table: VolumeTable, variant: Variant) -> str:
    """What the pieces of that pass ask for: sizes, and the products of visibility with the cosine."""
    exact = ["#define EXACT_LIGHT"] if variant.exact else []
    sizes = {**_shading_sizes(table.bands, variant), "POINTS": 1, "GROUP": variant.group, "SAMPLES": variant.group}
    sizes["MOST_SUNS"] = settings.Suns.most
    return "\n".join(
        [*exact, *(f"#define {k} {v}" for k, v in sizes.items()), products_text("cosine", cosine_product(table.bands))]
    )


def volume_uniforms(table: VolumeTable) -> dict[str, Any]:
    """Uniforms of volume.glsl, without the texture."""
    return {
        "volumeLow": table.low,
        "volumeCell": table.cell,
        "volumeCounts": tuple(map(float, table.counts)),
        "volumeLift": LIFT,
    }


def volume_slabs(table: VolumeTable) -> np.ndarray:
    """Coefficients in fours as (fours * depth, height, width, 4), a slab of the whole grid for each four."""
    values = np.pad(table.visibility, ((0, 0), (0, 0), (0, 0), (0, -(table.bands**2) % 4)))
    quads = values.reshape(*values.shape[:3], -1, 4)
    return np.ascontiguousarray(np.moveaxis(quads, 3, 0).reshape(-1, *values.shape[1:3], 4))


def lit_stage(pieces: tuple[str, ...], bands: int, variant: Variant) -> str:
    """A stage of a table's program that joins light with transfer: GOURAUD_VERTEX, GOURAUD or TEXTURED."""
    exact = ["#define EXACT_LIGHT"] if variant.exact else []
    tau = [] if variant.fixed_light or variant.exact else [tau_text(bands, variant.light_bands, variant.result_bands)]
    sizes = [f"#define {name} {value}" for name, value in _shading_sizes(bands, variant).items()]
    return "\n".join([VERSION, *exact, *sizes, *tau, join(pieces)])


def _shading_sizes(bands: int, variant: Variant, transfers: int = 1) -> dict[str, int]:
    """What sh.glsl, shade.glsl and bounced.glsl ask for, in fours where it counts vectors; `transfers` with those of bounces."""
    return {
        "OUTPUTS": _quads(bands**2),
        "TRANSFERS": transfers,
        "NETWORK_OUTPUTS": transfers * _quads(bands**2),
        "RESULT_BANDS": variant.result_bands,
        "RESULTS": _quads(variant.result_bands**2),
        "LIGHT_COUNT": variant.light_bands**2,
        "LOBES": variant.lobes,
    }


def light_pieces(net: AnyNet, variant: Variant) -> tuple[str, ...]:
    """The pieces of the second pass."""
    if len(networks(net)) > 1:
        return (LIGHT[0], "cells", *LIGHT[1:])
    if variant.block:
        return ("blocks", *LIGHT[1:])
    return LIGHT[2:] if variant.constant else LIGHT


def constant_network(net: TransferNet) -> str:
    """What network.glsl computes, for one point, as statements with the weights in them.

    Generated code is the exception here: Mesa's CPU driver fetches what it reads from textures and buffers lane by lane, and
    multiplies by constants seven times as fast.
    """
    lines = ["void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]) {"]

    # Features, each octave by the formulas of the double angle
    lines.append(f"vec3 e0 = (p[0] - {vector(net.center)}) / {number(net.extent)}, e1 = n[0];")
    at = 2
    for source, octaves in (("e0", net.position_frequencies), ("e1", net.normal_frequencies)):
        for octave in range(octaves):
            sine, cosine = f"e{at - 2}", f"e{at - 1}"
            first, twice = (f"{f}({number(np.pi)} * {source})" for f in ("sin", "cos")), f"2.0 * {sine}"
            values = first if octave == 0 else (f"{twice} * {cosine}", f"1.0 - {twice} * {sine}")
            lines += [f"vec3 e{at + k} = {value};" for k, value in enumerate(values)]
            at += 2
    layer = [f"e{i}.{axis}" for i in range(at) for axis in "xyz"]

    # Layers, a column of a block of four rows a statement: so they compile in half the time of mat4
    for depth, (weight, bias) in enumerate(shader_layers(net)):
        rows = np.pad(weight, ((0, -len(weight) % 4), (0, 0))).reshape(-1, 4, weight.shape[1])
        for i, (block, start) in enumerate(zip(rows, fours(bias), strict=True)):
            lines.append(f"vec4 s{depth}_{i} = {vector(start)};")
            lines += [f"s{depth}_{i} += {vector(column)} * {value};" for column, value in zip(block.T, layer, strict=True)]
        lines += [f"vec4 h{depth}_{i} = max(s{depth}_{i}, {SLOPE} * s{depth}_{i});" for i in range(len(rows))]
        layer = [f"h{depth}_{k // 4}.{'xyzw'[k % 4]}" for k in range(len(bias))]
    last = len(net.weights) - 1
    scales = fours(padded_outputs(net.scale, net))
    above = open_sky(net, "n[0]")
    lines += [f"transfer[{i}] = {vector(scale)} * tanh(s{last}_{i}){above[i]};" for i, scale in enumerate(scales)]
    return "\n".join([*lines, "}"])


def fits_halves(net: TransferNet) -> bool:
    """Whether the hidden layers' values at random points of the network's box stay far below what a half float holds.

    The library's networks reach 1,340, a 50th of it; what norms of their matrices promise lies 200 times higher.
    """
    rng = np.random.default_rng(0)
    points, normals = rng.uniform(-1.1, 1.1, (_PROBES, 3)), rng.normal(size=(_PROBES, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    values = encode(points.astype(np.float32), normals.astype(np.float32), net.position_frequencies, net.normal_frequencies)
    for weight, bias in net.weights[:-1]:
        values = values @ weight.T + bias
        if not np.abs(values).max() < float(np.finfo(np.float16).max) / _ROOM:
            return False
        values = np.maximum(values, SLOPE * values)
    return True


def padded_outputs(values: np.ndarray, net: TransferNet) -> np.ndarray:
    """Rows of the network's outputs with zeros after each transfer, where its coefficients are no multiple of four."""
    each = net.bands**2
    split = values.reshape(-1, each, *values.shape[1:])
    return np.pad(split, ((0, 0), (0, -each % 4), *[(0, 0)] * (values.ndim - 1))).reshape(-1, *values.shape[1:])


def shader_layers(net: TransferNet) -> list[tuple[np.ndarray, np.ndarray]]:
    """The layers with the outputs as shaders have them."""
    weight, bias = net.weights[-1]
    return [*net.weights[:-1], (padded_outputs(weight, net), padded_outputs(bias, net))]


def open_sky(net: TransferNet, n: str) -> list[str]:
    """What is added to each four outputs of a network whose weights are in the text: `openSky` of network.glsl, or nothing."""
    low = [0.886226925, *(f"1.02332671 * {v}" for v in (f"-{n}.y", f"{n}.z", f"-{n}.x"))]
    low += [f"{0.858085531 * sign} * {n}.{a} * {n}.{b}" for sign, a, b in ((1, "x", "y"), (-1, "y", "z"))]
    low += [f"0.247707956 * (3.0 * {n}.z * {n}.z - 1.0)", f"-0.858085531 * {n}.x * {n}.z"]
    low += [f"0.429042765 * ({n}.x * {n}.x - {n}.y * {n}.y)", *["0.0"] * 3]
    rows = [f" + vec4({', '.join(map(str, low[i : i + 4]))})" for i in range(0, 12, 4)]
    return [rows[i] if net.residual and i < 3 else "" for i in range(len(padded_outputs(net.scale, net)) // 4)]


def shader_columns(net: TransferNet) -> np.ndarray:
    """The first layer's weights with columns of zeros after x and n and at the end, as network.glsl has its features."""
    weight = np.insert(net.weights[0][0], [6, 6], 0.0, axis=1)
    return np.pad(weight, ((0, 0), (0, 4 * _inputs(net) - weight.shape[1])))


def _inputs(net: TransferNet) -> int:
    """Quads of features in network.glsl: two for x and n, three for every two octaves."""
    return 2 + 3 * -(-(net.position_frequencies + net.normal_frequencies) // 2)


def block_count(net: TransferNet) -> int:
    """4x4 blocks of all layers in the texture of weights."""
    columns = [_inputs(net), *(_quads(w.shape[1]) for w, _ in net.weights[1:])]
    return sum(_quads(len(b)) * count for (_, b), count in zip(shader_layers(net), columns, strict=True))


def weights_texture(net: AnyNet) -> np.ndarray:
    """All weights as (rows, 1024, 4): 4x4 blocks row of blocks after row, then the biases in fours.

    Of cells, network after network, each with its box and its scale at the end, then the number of the network of each cell.
    """
    flat = _weights(net) if isinstance(net, TransferNet) else _weights_of_cells(net)
    return np.pad(flat, ((0, -len(flat) % _TEXELS), (0, 0))).reshape(-1, _TEXELS, 4)


def _weights(net: TransferNet) -> np.ndarray:
    layers = shader_layers(net)
    matrices = [shader_columns(net), *(w for w, _ in layers[1:])]
    quads = [np.concatenate([blocks(w) for w in matrices]).reshape(-1, 4)]
    quads += [fours(b) for _, b in layers]
    return np.concatenate(quads).astype(np.float32)


def _weights_of_cells(net: CellNets) -> np.ndarray:
    each = [np.concatenate([_weights(one), [(*one.center, one.extent)], fours(padded_outputs(one.scale, one))]) for one in net.nets]
    owners = np.zeros((net.cells.owner.size, 4))
    owners[:, 0] = net.cells.owner.ravel(order="F")  # x fastest
    return np.concatenate([*each, owners]).astype(np.float32)


@functools.lru_cache(maxsize=_NETS)
def block_sizes(net: TransferNet) -> dict[str, int]:
    """What blocks.glsl asks for: points of a group, as many as share the memory that every driver has, and sizes of layers.

    Empty where the network is too wide for a point an invocation.
    """
    features, outputs = net.weights[0][0].shape[1], len(padded_outputs(net.scale, net))
    warps = -(-max((len(b) for _, b in net.weights[:-1]), default=1) // _NEURONS)
    while warps < 4 and 4 % warps:
        warps += 1  # so that an invocation has a whole number of points
    neurons = _NEURONS * warps
    points = next((each for each in (4, 2, 1) if 2 * max(features, neurons) * _WARP * each <= _SHARED), 0)
    if not points or warps > _WARP or len(net.weights) > _LAYERS:
        return {}
    # Words of four neurons of pairs of inputs, and of biases before them; layers begin at multiples of 256 bytes
    inputs = [features, *[neurons] * (len(net.weights) - 1)]
    words = [*[neurons // 4] * (len(net.weights) - 1), -(-outputs // 16) * 4]
    return {
        "BLOCK": _WARP * points,
        "LANE_POINTS": points,
        "WARPS": warps,
        "PAIR_ROWS": max(features, neurons) // 2,
        "LAYER_SIZE": -(-max((1 + each // 2) * wide for each, wide in zip(inputs, words, strict=True)) // 16) * 16,
    }


def in_blocks(net: TransferNet) -> tuple[int, int, int] | None:
    """Points of an invocation, invocations of a group and points of a group for blocks.glsl.

    None where the network is too wide, or half floats do not hold its weights.
    """
    most = max(float(np.abs(values).max()) for layer in net.weights for values in layer)
    if not (sizes := block_sizes(net)) or not most < float(np.finfo(np.float16).max):
        return None
    group = _WARP * sizes["WARPS"]
    return max(sizes["BLOCK"] // group, 1), group, sizes["BLOCK"]


def uniform_weights(net: TransferNet) -> bool:
    """Whether each layer fits a block of uniforms of the size that NVIDIA's driver has; else they are in a storage buffer."""
    return 16 * block_sizes(net)["LAYER_SIZE"] <= 65_536


def block_weights(net: TransferNet) -> Float16[ndarray, "l n 4 2"]:
    """Weights as blocks.glsl reads them: of each layer (bias, 0) of each neuron, then its weights of each pair of inputs."""
    sizes = block_sizes(net)
    neurons, layers = _NEURONS * sizes["WARPS"], shader_layers(net)
    made = np.zeros((len(layers), sizes["LAYER_SIZE"], 4, 2), np.float16)
    for depth, (weight, bias) in enumerate(layers):
        last = depth == len(layers) - 1
        wide, inputs = -(-len(bias) // 16) * 16 if last else neurons, weight.shape[1] if depth == 0 else neurons
        rows = np.zeros((1 + inputs // 2, wide, 2), np.float16)
        rows[0, : len(bias), 0] = bias
        padded = np.pad(weight, ((0, wide - len(bias)), (0, inputs - weight.shape[1])))
        rows[1:] = padded.reshape(wide, -1, 2).transpose(1, 0, 2)
        made[depth, : rows.size // 8] = rows.reshape(-1, 4, 2)
    return made


def gloss_layers(exact: ExactLight) -> np.ndarray:
    """F_j as (layers, rows, columns, 4), in shade.glsl's order: level, channel, coefficients in fours."""
    if exact.gloss is None:
        raise SdfprtError("the light was prepared for a material without gloss")
    levels, rows, columns, count, _ = exact.gloss.shape
    padded = np.pad(exact.gloss, ((0, 0), (0, 0), (0, 0), (0, -count % 4), (0, 0)))
    quads = padded.reshape(levels, rows, columns, _quads(count), 4, 3)
    return np.ascontiguousarray(quads.transpose(0, 5, 3, 1, 2, 4).reshape(-1, rows, columns, 4), np.float32)


def turn_blocks(exact: ExactLight) -> np.ndarray:
    """The turn of coefficients into the light's frame as shade.glsl has it: (blocks, 4 columns, 4 rows)."""
    count = len(exact.turn)
    padded = np.pad(exact.turn.T, ((0, -count % 4), (0, -count % 4)))
    quads = _quads(count)
    return padded.reshape(quads, 4, quads, 4).transpose(0, 2, 3, 1).reshape(-1, 4, 4)


def sun_uniforms(suns: Suns) -> dict[str, Any]:
    """Uniforms of suns.glsl for what belongs to the light; discs in world directions."""
    directions, energy = np.zeros((settings.Suns.most, 4), np.float32), np.zeros((settings.Suns.most, 3), np.float32)
    directions[: len(suns), :3], directions[: len(suns), 3], energy[: len(suns)] = suns.directions, suns.radii, suns.energy
    return {"sunCount": len(suns), "sunDirection": directions, "sunEnergy": energy, "sunRough": suns.levels}


@functools.lru_cache(maxsize=_NETS)
def defines(net: AnyNet, variant: Variant) -> str:
    """The sizes that the pieces ask for, in fours where they count vectors."""
    count, net = len(networks(net)), networks(net)[0]
    transfers = 1 + (net.bounces.transfers if net.bounces else 0)
    outputs = transfers * _quads(net.bands**2)
    values = {
        "CELLS": count,
        "STRIDE": 4 * block_count(net) + sum(_quads(len(b)) for _, b in shader_layers(net)) + 1 + outputs,
        "POSITION_OCTAVES": net.position_frequencies,
        "NORMAL_OCTAVES": net.normal_frequencies,
        "INPUTS": _inputs(net),
        "WIDTH": _quads(net.weights[0][0].shape[0]),
        "LAYERS": len(net.weights),
        "BLOCKS": block_count(net),
        **_shading_sizes(net.bands, variant, transfers),
        "POINTS": variant.points,
        "GROUP": variant.group,
        "SAMPLES": variant.samples,
        "MOST_SUNS": settings.Suns.most,
        **(block_sizes(net) if variant.block else {}),
    }
    exact = ["#define EXACT_LIGHT"] if variant.exact else []
    exact += ["#define HALVES"] if variant.halves else []
    exact += ["#define WEIGHTS_UNIFORM"] if variant.block and uniform_weights(net) else []
    return "\n".join([*exact, *(f"#define {name} {value}" for name, value in values.items())])


def tau_text(transfer_bands: int, light_bands: int, result_bands: int) -> str:
    """The non-zero triple products as constant arrays."""
    return products_text("tau", sh.triple_product(transfer_bands, light_bands, result_bands))


def products_text(name: str, values: np.ndarray) -> str:
    """The values (i, j, k) that are not zero as `name`Value, and i + 256 j + 65536 k of each as `name`Index."""
    i, j, k = np.nonzero(values)
    index = ",".join(str(int(v)) for v in i + (j << 8) + (k << 16))
    floats = ",".join(number(v, 7) for v in values[i, j, k])
    return (
        f"#define {name.upper()}_COUNT {len(i)}\nconst int {name}Index[{len(i)}] = int[]({index});\n"
        f"const float {name}Value[{len(i)}] = float[]({floats});"
    )


def global_names(text: str) -> set[str]:
    """Functions, constants, uniforms and structs that the text declares at its outermost level."""
    return {each.name for each in declarations(text).every if not isinstance(each, Block)}


def renamed(ours: str, users: str) -> str:
    """#defines that give the user's versions of our global names other names; our macros end before the user's text."""
    bare = without_comments(users)
    ended = [f"#undef {name}" for name in sorted(set(re.findall(r"^#define (\w+)", ours, flags=re.M)))]
    names = (
        (global_names(ours) & set(re.findall(r"\b\w+\b", bare))) - macros(users) - {"sdfprt_distance", "albedo", "exponent", "main"}
    )
    return "\n".join([*ended, *(f"#define {name} sdfprt_user_{name}" for name in sorted(names))])
