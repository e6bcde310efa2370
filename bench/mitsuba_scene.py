"""The same pictures by Mitsuba 3 on a mesh: its own intersection, integrator and environment light, our pixel centres.

The LLVM variant is used where DRJIT_LIBLLVM_PATH or the environment (pip: karellen-llvm-core) has LLVM 17 or later.
"""

import os
import sys
from functools import cache
from pathlib import Path
from typing import Any, no_type_check

import numpy as np

from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.maths import sphere

RAYS = 1 << 21  # a wavefront

# Before anything imports drjit, which would take the system's LLVM, perhaps one too old, and abort
if found := sorted(Path(sys.prefix, "lib").glob("libLLVM.so*")):
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(found[-1]))


@cache
def mitsuba() -> Any:
    """The module with its fast variant set and the Phong lobe registered. Raises RuntimeError without LLVM."""
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        raise RuntimeError("Mitsuba's llvm_ad_rgb needs LLVM 17 or later: pip install karellen-llvm-core")
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    mi.register_bsdf("phong_mixture", _phong(mi))
    return mi


@no_type_check
def _phong(mi: Any) -> type:
    """albedo / pi + specular (s+2)/(2 pi) cos^s about the mirrored view, in Mitsuba's local frame (n = +z)."""
    import drjit as dr

    class PhongMixture(mi.BSDF):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.kd = [float(props[f"kd{c}"]) for c in range(3)]
            self.ks = [float(props[f"ks{c}"]) for c in range(3)]
            self.s = float(props["exponent"])
            self.share = sum(self.kd) / max(sum(self.kd) + sum(self.ks), 1e-12)  # of the diffuse lobe's samples
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            self.m_components = [flags]
            self.m_flags = flags

        def both(self, si, wo, active):
            """BRDF times cosine, and density."""
            active = active & (mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)
            lobe = dr.maximum(dr.dot(mi.Vector3f(-si.wi.x, -si.wi.y, si.wi.z), wo), 0) ** self.s
            cosine = mi.Frame3f.cos_theta(wo)
            glossy = lobe * ((self.s + 2) / (2 * dr.pi))
            value = (mi.Color3f(self.kd) / dr.pi + mi.Color3f(self.ks) * glossy) * cosine
            density = self.share * cosine / dr.pi + (1 - self.share) * lobe * ((self.s + 1) / (2 * dr.pi))
            return dr.select(active, value, 0), dr.select(active, density, 0)

        def eval(self, ctx, si, wo, active):
            return self.both(si, wo, active)[0]

        def pdf(self, ctx, si, wo, active):
            return self.both(si, wo, active)[1]

        def eval_pdf(self, ctx, si, wo, active):
            return self.both(si, wo, active)

        def sample(self, ctx, si, sample1, sample2, active):
            base = mi.warp.square_to_cosine_hemisphere(sample2)
            cosine = sample2.x ** (1 / (self.s + 1))
            sine, (east, north) = dr.safe_sqrt(1 - cosine * cosine), dr.sincos(2 * dr.pi * sample2.y)
            mirrored = mi.Frame3f(mi.Vector3f(-si.wi.x, -si.wi.y, si.wi.z))
            glossy = mirrored.to_world(mi.Vector3f(sine * north, sine * east, cosine))
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = dr.select(sample1 < self.share, base, glossy)
            value, bs.pdf = self.both(si, bs.wo, active)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = mi.UInt32(0)
            good = active & (bs.pdf > 0)
            return bs, dr.select(good, value / bs.pdf, 0)

        def to_string(self):
            return f"PhongMixture[{self.s}]"

    return PhongMixture


def envmap(light: Light) -> dict:
    """The same bilinear radiance: Mitsuba's rows are corner-aligned, so W x (2H+1) of them (DESIGN of the light)."""
    mi = mitsuba()
    height, width = light.pixels.shape[:2]
    polar = np.arange(2 * height + 1) * np.pi / (2 * height)
    azimuth = (0.5 - (np.arange(width) + 0.5) / width) * 2 * np.pi
    s = np.sin(polar)[:, None]
    y = np.broadcast_to(np.cos(polar)[:, None], (2 * height + 1, width))
    directions = np.stack([s * np.sin(azimuth), y, s * np.cos(azimuth)], axis=-1)
    directions[0, :, 0], directions[-1, :, 0] = 1e-9 * np.sin(azimuth), 1e-9 * np.sin(azimuth)
    directions[0, :, 2], directions[-1, :, 2] = 1e-9 * np.cos(azimuth), 1e-9 * np.cos(azimuth)
    pixels = sphere.latlong_lookup(light.pixels, directions).astype(np.float32)
    turn = np.eye(4)
    turn[:3, :3] = light.rotation
    return {"type": "envmap", "bitmap": mi.Bitmap(pixels), "to_world": mi.ScalarTransform4f(turn)}


def bsdf(material: Material) -> dict:
    """Mitsuba's own diffuse lobe, or the mixture above."""
    if isinstance(material, Diffuse):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(material.albedo)}}
    kd, glossy = (0.0, 0.0, 0.0), material.lobes[-1]
    if isinstance(material.lobes[0], Diffuse):
        kd = material.lobes[0].albedo
    assert isinstance(glossy, Phong)
    colours = {f"kd{c}": float(kd[c]) for c in range(3)} | {f"ks{c}": float(glossy.specular[c]) for c in range(3)}
    return {"type": "phong_mixture", "exponent": float(glossy.exponent), **colours}


@no_type_check
def build(
    vertices: np.ndarray,
    faces: np.ndarray,
    normals: np.ndarray,
    light: Light,
    material: Material,
    albedo: np.ndarray | None = None,
    relief: tuple[np.ndarray, np.ndarray] | None = None,
    two_sided: bool = False,
) -> Any:
    """A Mitsuba scene of one mesh with vertex normals; `albedo`, one row a vertex, takes the place of a Diffuse's.

    The back of a triangle is black, if not `two_sided`.

    `relief` is a normal map and the vertices' places in it (v upwards), in which u and v are right-handed: Mitsuba's bitangents are
    always so. Its softening of the terminator, which has no part in a normal map, is off.
    """
    mi = mitsuba()
    props = mi.Properties()
    lobes = bsdf(material)
    if relief is not None:
        texels = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(np.ascontiguousarray(relief[0]))}
        lobes = {"type": "normalmap", "normalmap": texels, "bsdf": lobes, "use_shadowing_function": False}
    painted = albedo is not None and lobes["type"] == "diffuse"
    if painted:
        lobes["reflectance"] = {"type": "mesh_attribute", "name": "vertex_color"}
    props["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": lobes} if two_sided else lobes)
    given = {"has_vertex_normals": True, "has_vertex_texcoords": relief is not None}
    mesh = mi.Mesh("mesh", len(vertices), len(faces), props=props, **given)
    table = mi.traverse(mesh)
    table["vertex_positions"] = mi.Float(np.ascontiguousarray(vertices, np.float32).ravel())
    table["vertex_normals"] = mi.Float(np.ascontiguousarray(normals, np.float32).ravel())
    if relief is not None:
        table["vertex_texcoords"] = mi.Float(np.ascontiguousarray(relief[1] * (1, -1) + (0, 1), np.float32).ravel())
    table["faces"] = mi.UInt32(np.ascontiguousarray(faces, np.uint32).ravel())
    table.update()
    if painted:
        mesh.add_attribute("vertex_color", 3, np.ascontiguousarray(albedo, np.float32).ravel())
    return mi.load_dict({"type": "scene", "light": envmap(light), "mesh": mesh})


@no_type_check
def picture(
    scene: Any, camera: Camera, size: tuple[int, int], spp: int, bounces: int = 0, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Radiance (H, W, 3), the variance of its mean (H, W, 3), and the hit mask (H, W), rays through pixel centres.

    Stratified within sets of 16 or 64 paths a pixel; the spread of the sets' means gives the variance.
    """
    import drjit as dr

    mi = mitsuba()
    origin, directions = camera.rays(size)
    flat = directions.reshape(-1, 3).astype(np.float32)
    eye = mi.Point3f(*map(float, origin))
    hit = np.asarray(scene.ray_intersect(mi.Ray3f(eye, mi.Vector3f(flat.T))).is_valid())
    path = mi.load_dict({"type": "path", "max_depth": bounces + 2, "rr_depth": 1000, "hide_emitters": True})
    count = 64 if spp >= 2048 else 16
    sets = max(2, -(-spp // count))
    mean, variance = np.zeros((len(flat), 3)), np.zeros((len(flat), 3))
    for part in np.array_split(np.flatnonzero(hit), max(1, hit.sum() * count // RAYS)):
        index = dr.arange(mi.UInt32, len(part) * count) // count
        way = dr.gather(mi.Vector3f, mi.Vector3f(flat[part].T), index)
        values = np.zeros((sets, len(part), 3))
        for k in range(sets):
            sampler = mi.load_dict({"type": "multijitter", "sample_count": count})
            sampler.set_samples_per_wavefront(count)
            sampler.seed(seed * 7919 + k, len(part) * count)
            radiance, _, _ = path.sample(scene, sampler, mi.RayDifferential3f(eye, way))
            values[k] = np.asarray(radiance).T.reshape(len(part), count, 3).mean(axis=1, dtype=np.float64)
        mean[part], variance[part] = values.mean(axis=0), values.var(axis=0) / (sets - 1)
    shape = (size[1], size[0])
    return mean.reshape(*shape, 3), variance.reshape(*shape, 3), hit.reshape(shape)


@no_type_check
def met(scene: Any, camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Points and interpolated unit normals of the mesh at pixel centres, (H, W, 3) each; on a miss they mean nothing."""
    mi = mitsuba()
    origin, directions = camera.rays(size)
    ways = mi.Vector3f(directions.reshape(-1, 3).astype(np.float32).T)
    surface = scene.ray_intersect(mi.Ray3f(mi.Point3f(*map(float, origin)), ways))
    return tuple(np.asarray(v).T.reshape(size[1], size[0], 3) for v in (surface.p, surface.sh_frame.n))
