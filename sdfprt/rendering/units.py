"""Texture units: which sampler of the shaders reads where, in the renderer, the page and the window alike."""

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
    CONES = 7  # how far the coarse pass was free
    SUN_TILES = 7  # how far something may touch the cones of a tile to the discs of the light, after it
    GLOSS = 8  # the light with the lobe, prefiltered
    OPEN_LIGHT = 9
    SCENE = 10


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
    "freeCones": Unit.CONES,
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
