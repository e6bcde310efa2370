"""Texture units: which sampler of the shaders reads where, in the renderer, the page and the window alike; and units of images."""

from enum import IntEnum


class Unit(IntEnum):
    """A texture unit; those of a scene's own textures are SCENE, SCENE + 1 …"""

    POINT = 0  # what the first pass saw, read by the second
    NORMAL = 1
    COLOUR = 2
    ENVIRONMENT = 3  # the light behind the scene
    WEIGHTS = 4  # of the network
    TRANSFER = 4  # textures of a mesh, or a volume, where there is no network
    PICTURE = 5  # of a mesh's finish, in its first pass
    RELIEF = 6  # its normal map
    SUN_DIFFUSE = 5  # what the discs of the light give, by rays
    SUN_GLOSSY = 6
    SUN_CORNERS = 6  # what every so many samples see of them, of the pass before
    SUN_TILES = 7  # how far something may touch the cones of a tile to the discs of the light
    GLOSS = 8  # the light with the lobe, prefiltered
    OPEN_LIGHT = 9
    SCENE = 10


class Image(IntEnum):
    """A unit of images that compute shaders write: the `binding` in their text. Each pass binds its own."""

    SEEN = 0  # surface.glsl: point, normal and colour
    CONES = 3
    MISSED = 4  # the radiance of what no sample hit: clearing all of it takes a quarter of a millisecond where few processors draw
    RADIANCE = 0  # light.glsl, background.glsl
    SUNS = 0  # sunlight.glsl: two sums, or shares at corners
    SUN_TILES = 0  # suntiles.glsl
    MEAN = 0  # mean.glsl


SAMPLERS = {
    "surfacePoint": Unit.POINT,
    "surfaceDirection": Unit.NORMAL,
    "surfaceColour": Unit.COLOUR,
    "environment": Unit.ENVIRONMENT,
    "networkWeights": Unit.WEIGHTS,
    "picture": Unit.PICTURE,
    "cover": Unit.PICTURE,  # in the depth pass, which has no colours
    "normalMap": Unit.RELIEF,
    "transferTextures": Unit.TRANSFER,
    "volumeTexture": Unit.TRANSFER,
    "sunTiles": Unit.SUN_TILES,
    "sunCorners": Unit.SUN_CORNERS,
    "sunDiffuse": Unit.SUN_DIFFUSE,
    "sunGlossy": Unit.SUN_GLOSSY,
    "glossMaps": Unit.GLOSS,
    "openLight": Unit.OPEN_LIGHT,
}  # uniform -> unit


def scene_samplers(names: list[str]) -> dict[str, int]:
    """Units of a scene's own textures, in their order."""
    return {name: Unit.SCENE + number for number, name in enumerate(names)}
