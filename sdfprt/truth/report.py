"""Where the error of a picture comes from: network, truncation of the SH, and the rest, on one page.

    render - reference = (network - exact) + (exact - reference) + (render - network)

"network" is the asset's transfer at the exact hit points, "exact" the transfer by ray casting there, both with the same
shading; the last part is what OpenGL adds. A part's share is its projection on the whole error, so shares add up to 1.
"""

import base64
import io
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from sdfprt.baking.sdf import bake
from sdfprt.core import pages, settings
from sdfprt.core.files import atomic_write
from sdfprt.imaging import metrics, tone
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Lighting
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong, name
from sdfprt.rendering.backends import frame
from sdfprt.sdf.kinds import AnyScene
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference_image

BANDS = ((4, 4, 4), (5, 5, 5), (6, 6, 6), (8, 8, 8), (4, 8, 8), (8, 4, 8), (8, 8, 4))  # transfer, light, result


@dataclass(frozen=True)
class Split:
    """PSNR (dB) of each part alone, and its share of the whole squared error; over hit pixels."""

    material: str
    width: int
    total: float
    network: float
    truncation: float
    rest: float
    network_share: float
    truncation_share: float
    rest_share: float


@dataclass(frozen=True)
class BandRow:
    """Exact transfer with so many bands against the reference, and what the shading took."""

    material: str
    transfer: int
    light: int
    result: int
    psnr: float
    flip: float
    milliseconds: float


@dataclass(frozen=True)
class WayRow:
    """Exact transfer against the reference, by the papers' way of light and lobe or by ours; and what OpenGL draws by default.

    `relative_error`: mean over pixels of |difference| over the reference, where PSNR hides highlights and shadows.
    """

    material: str
    way: str
    psnr: float
    flip: float
    relative_error: float


WAYS = {
    "as in the papers": Lighting(suns="off", gloss="sh"),
    "with suns": Lighting(gloss="sh"),
    "with exact lobe": Lighting(suns="off", gloss="exact"),
    "with both": Lighting(),
}


def ways(
    view: exact.View, light: Light, material: Material, truth: ndarray, mask: ndarray, others: dict[str, ndarray] | None = None
) -> list[WayRow]:
    """A row a way, then one for each of `others`, pictures by name."""
    pictures = {way: view.shade(light, material, lighting=lighting) for way, lighting in WAYS.items()}
    rows = []
    for way, picture in (pictures | (others or {})).items():
        found = measure(picture, truth, mask)
        error = np.abs(picture - truth)[mask] / np.maximum(truth[mask], 1e-3 * metrics.robust_peak(truth, mask))
        rows.append(WayRow(name(material), way, found["psnr"], found["flip"], float(error.mean())))
    return rows


def measure(a: ndarray, b: ndarray, mask: ndarray) -> dict[str, float]:
    """`metrics.compare` over the mask with the reference's (b's) robust peak."""
    return metrics.compare(a, b, mask=mask, peak=metrics.robust_peak(b, mask))


def split(material: Material, width: int, drawn: ndarray, network: ndarray, fine: ndarray, truth: ndarray, mask: ndarray) -> Split:
    """The three parts of drawn - truth; pictures (H, W, 3)."""
    peak = metrics.robust_peak(truth, mask)
    whole = (drawn - truth)[mask].astype(float)
    parts = [(x - y)[mask].astype(float) for x, y in ((network, fine), (fine, truth), (drawn, network))]
    squares = max(float((whole**2).sum()), 1e-30)
    psnr = [10 * np.log10(peak**2 / max(float(np.mean(e**2)), 1e-12 * peak**2)) for e in (whole, *parts)]
    return Split(name(material), width, *map(float, psnr), *(float((e * whole).sum()) / squares for e in parts))


def report(
    scene: AnyScene,
    output: Path,
    light: Light | None = None,
    materials: Sequence[Material] = (Diffuse(), Phong()),
    camera: Camera | None = None,
    size: tuple[int, int] = (256, 256),
    spp: int = settings.Reference.spp,
    rays: int = settings.Exact.rays,
    widths: Sequence[int] = (64, 128),
    bands: Iterable[tuple[int, int, int]] = BANDS,
    bounces: int = 0,
) -> tuple[list[Split], list[BandRow]]:
    """Measure, and write one HTML page with the pictures inside; bakes what is not there. Truth has as many `bounces`.

    Raises SdfprtError without OpenGL, and where the camera sees nothing of the scene.
    """
    light, camera = light or Light.load("sky_afternoon"), camera or scene.camera
    bands = list(bands)
    view = exact.view(scene, camera, size, max(row[0] for row in bands), rays, bounces=bounces)
    assets = {width: bake(scene, width=width, bounces=bounces) for width in widths}
    splits, rows, sections, by_way = [], [], [], []
    for material in materials:
        truth = reference_image(scene, light, material, camera, size, spp, bounces)
        mask = view.mask & (truth.alpha > 0)
        pictures, exacts = {"reference": truth.rgb}, {}

        # One network a width
        for width, asset in assets.items():
            n = asset.net.bands
            fine = view.cut(n).shade(light, material)
            drawn = frame(scene, asset, light, material, camera, size, suns="off", gloss="sh")
            seen = mask & (drawn.alpha > 0)
            predicted = view.predicted(asset.net).shade(light, material)
            splits.append(split(material, width, drawn.rgb, predicted, fine, truth.rgb, seen))
            exacts[n] = fine
            pictures[f"network, k={width}, {n} bands"] = drawn.rgb
        best = frame(scene, assets[widths[0]], light, material, camera, size)
        by_way += ways(
            view.cut(assets[widths[0]].net.bands),
            light,
            material,
            truth.rgb,
            mask & (best.alpha > 0),
            {"with both, network by OpenGL": best.rgb},
        )
        pictures[f"with suns and exact lobe, network, k={widths[0]}"] = best.rgb

        # What more bands buy and cost
        for transfer, of_light, result in bands:
            if isinstance(material, Diffuse) and not transfer == of_light == result:
                continue
            cut = view.cut(transfer)
            start = time.perf_counter()
            fine = cut.shade(light, material, of_light, result)
            spent = time.perf_counter() - start
            found = measure(fine, truth.rgb, mask)
            rows.append(BandRow(name(material), transfer, of_light, result, found["psnr"], found["flip"], 1e3 * spent))
            if transfer == of_light == result:
                exacts[transfer] = fine
        pictures |= {f"exact transfer, {n} bands": picture for n, picture in sorted(exacts.items())}
        noise = float(np.sqrt(np.mean(truth.standard_error[mask] ** 2)) / metrics.robust_peak(truth.rgb, mask))
        sections.append(_gallery(f"{name(material)}; noise of the reference {-20 * np.log10(noise):.1f} dB", pictures, mask))
    settings_line = f"{size[0]}x{size[1]}, light {light.name}, {spp} paths a pixel, {rays} rays a pixel"
    settings_line += f", {bounces} bounces" if bounces else ""
    page = _page(scene.name, settings_line, splits, rows, by_way, sections)
    with atomic_write(output) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return splits, rows


def _gallery(title: str, pictures: dict[str, ndarray], mask: ndarray) -> dict[str, Any]:
    """Tone-mapped pictures and their FLIP heatmaps against the first; numbers over the mask."""
    from matplotlib import colormaps

    truth = next(iter(pictures.values()))
    figures = []
    for caption, picture in pictures.items():
        shown = tone.srgb_encode(tone.tone_map(picture))
        error = metrics.flip_map(tone.tone_map(picture), tone.tone_map(truth))
        heat = colormaps["magma"](np.clip(error, 0, 1))[..., :3]
        numbers = f"{measure(picture, truth, mask)['psnr']:.1f} dB, FLIP {error[mask].mean():.3f}" if picture is not truth else ""
        figures.append({"pictures": (_png(shown), _png(heat)), "caption": caption, "numbers": numbers})
    return {"title": title, "figures": figures}


def _png(picture: ndarray) -> str:
    import imageio.v3 as iio

    memory = io.BytesIO()
    iio.imwrite(memory, (np.clip(picture, 0, 1) * 255 + 0.5).astype(np.uint8), extension=".png")
    return f"data:image/png;base64,{base64.b64encode(memory.getvalue()).decode()}"


PARTS = (
    "total: the network's picture by OpenGL against the reference; network: its transfer against exact transfer, same shading; "
    "truncation: exact transfer against the reference; rest: what OpenGL adds. Each in dB as if it were alone; the shares are "
    "those of the squared error and add up to 1, a negative one cancels part of another."
)
BANDS_TEXT = "Against the reference, on linear radiance; milliseconds are the shading's, in numpy."
WAYS_TEXT = (
    "Exact transfer of the network's bands, lit in spherical harmonics alone, with the light's suns by rays, with light and lobe "
    "exact, and with both, which is how pictures are drawn by default; against the reference."
)
PICTURES = "Above as PNGs are shown, below FLIP of the two as shown, black 0 to white 1."


def _cell(key: str, value: object) -> str:
    if not isinstance(value, float):
        return str(value)
    if "share" in key:
        return f"{round(value, 3) + 0.0:.3f}"  # no minus before a zero
    return f"{value:.3f}" if key in ("flip", "relative_error") else f"{value:.1f}"


def table(rows: Sequence[Split | BandRow | WayRow]) -> list[list[str]]:
    """Rows of one dataclass as texts, the names of the columns first; empty where there are none."""
    if not rows:
        return []
    head = [key.replace("_", " ") for key in asdict(rows[0])]
    return [head, *([_cell(key, value) for key, value in asdict(row).items()] for row in rows)]


STYLE = (
    "body{font:15px sans-serif;margin:2em;max-width:90em}td,th{padding:.2em .8em;text-align:right}"
    "p{max-width:60em}td:first-child,th:first-child{text-align:left}td{border-top:1px solid #ddd}"
    "table{border-collapse:collapse}"
    "figure{display:inline-block;vertical-align:top;margin:.4em}img{display:block;image-rendering:pixelated}"
)
BODY = """{% macro table(rows) %}{% if rows %}<table>
<tr>{% for cell in rows[0] %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in rows[1:] %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>{% endif %}{% endmacro %}
<h1>{{ name }}: where the error comes from</h1>
<p>{{ line }}. PSNR in dB and FLIP over hit pixels, peak: 99.9th percentile of the reference.</p>
<h2>Past the truncation</h2><p>{{ about_ways }}</p>{{ table(ways) }}
<h2>Network, truncation, rest, in the papers' way</h2><p>{{ about_parts }}</p>{{ table(splits) }}
<h2>Bands of transfer, light and result, exact transfer</h2><p>{{ about_bands }}</p>{{ table(rows) }}
<h2>Pictures</h2><p>{{ about_pictures }}</p>
{% for section in sections %}<h3>{{ section.title }}</h3><div>{% for figure in section.figures %}
<figure>{% for picture in figure.pictures %}<img alt="" src="{{ picture }}">{% endfor %}
<figcaption>{{ figure.caption }}<br>{{ figure.numbers }}</figcaption></figure>{% endfor %}</div>
{% endfor %}"""


def _page(
    name: str, line: str, splits: list[Split], rows: list[BandRow], by_way: list[WayRow], sections: list[dict[str, Any]]
) -> str:
    values = {
        "ways": table(by_way),
        "about_ways": WAYS_TEXT,
        "name": name,
        "line": line,
        "splits": table(splits),
        "rows": table(rows),
        "sections": sections,
        "about_parts": PARTS,
        "about_bands": BANDS_TEXT,
        "about_pictures": PICTURES,
    }
    return pages.page(f"sdfprt: {name}", BODY, values, STYLE)
