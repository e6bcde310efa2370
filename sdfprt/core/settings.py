"""Every default of sdfprt, once: function signatures and the command line point here.

Lengths that say "of the scene" are fractions of the diagonal of its bounds.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Compile:
    seconds: int = 30  # that the GLSL compiler may take for one text
    memory: int = 1 << 30  # bytes that the GLSL compiler may hold
    output: int = 16 << 20  # bytes that the GLSL compiler may write
    text: int = 2_000_000  # letters that a scene and all its included files may have together
    files: int = 1000  # that a scene may include
    depth: int = 100  # files that may include each other in a row
    module: int = 4 << 20  # bytes of SPIR-V that a scene may become
    instructions: int = 150_000  # that the distance and all its callees may have together
    numbers: int = 50_000  # that all variables may hold together: 16 lanes of them still fit a thread's stack
    cases: int = 2000  # that one switch may have
    nesting: int = 1000  # conditions and loops that may lie in each other
    brackets: int = 2000  # that may lie in each other in the text
    kernel: int = 1_500_000  # letters of C++ that a scene may become


@dataclass(frozen=True)
class Surface:
    resolution: int = 256  # marching-cubes cells along the longest side of the bounds
    tolerance: float = 1e-4  # largest |distance| of a sample from the surface, of the scene
    points: int = 260_000  # samples a bake draws


@dataclass(frozen=True)
class Trace:
    hit: float = 1e-5  # distance below which a camera's ray has hit the surface, of the scene
    epsilon: float = 5e-5  # distance below which a shadow's ray has hit the surface, of the scene
    lift: float = 2e-4  # how far off the surface a shadow's ray begins, of the scene
    steps: int = 256  # that a ray may take
    relaxation: float = 1.3  # factor on a ray's step, which is taken back where two spheres do not overlap (Keinert et al. 2014)


@dataclass(frozen=True)
class Transfer:
    bands: int = 4  # n*n coefficients
    rays: int = 128  # a point; more do not help the fit, which averages them
    sampling: str = "sequence"  # how their directions are chosen; or stratified, random


@dataclass(frozen=True)
class Bounce:
    rays: int = 32  # a point that look for what light bounces off; the fit averages them
    held_out_rays: int = 256  # the same of a point of validation


@dataclass(frozen=True)
class Lattice:
    cells: int = 48  # coarse ones along the longest side of the bounds
    near: float = 5e-5  # largest error of a plane at the surface, of the scene
    far: float = 0.12  # by which a plane may say more than the distance elsewhere, as a fraction of the distance
    short: float = 0.5  # by which a plane may say less than the distance elsewhere, as a fraction of the distance
    few: int = 8_000_000  # rays of a bake up to which building the lattice takes longer than it spares
    cheap: int = 9_000  # characters of a field's C++ up to which rays are quicker by the field itself


@dataclass(frozen=True)
class Network:
    width: int = 64  # neurons a layer
    layers: int = 4  # linear layers
    position_frequencies: int = 7  # octaves of the positional encoding of p
    normal_frequencies: int = 2  # the same for n


@dataclass(frozen=True)
class Fit:
    steps: int = 16_000  # of the optimizer
    batch: int = 1024  # samples a step
    rate: float = 0.05  # learning rate of the matrices (Muon) at the peak of the one cycle
    decay: float = 0.1  # of the matrices a step, as a fraction of the rate: steps of one size turn small matrices farther
    bias_share: float = 0.25  # learning rate of the biases (Adam), as a fraction of that of the matrices
    outlier: float = 0.1  # error of T over its largest value from which on it counts linearly: edges that no network holds
    hidden: float = 0.2  # importance of samples that no far camera sees, beside a mean of 1 of what they see
    own_view: float = 0.95  # mean importance, at least, of samples that the scene's own camera sees
    from_above: float = 1.0  # by which a camera straight above counts more than one at the horizon, one below less
    by_degree: tuple[float, ...] = (1.0, 0.35, 0.25, 0.2)  # weight of T's squared error by SH degree: light has less of higher ones
    seconds: float = 5.0  # between two checkpoints
    held_out: int = 4096  # samples of a bake that are kept for validation
    held_out_rays: int = 1024  # rays a sample of validation
    doubtful: float = 0.05  # RMSE of T at those samples that a bake warns of; the library's 46 networks have 0.0035 to 0.019


@dataclass(frozen=True)
class Cells:
    band: float = 0.04  # half of the width of the blend of two networks about a cut, of a cell's side
    overlap: float = 0.1  # how far the samples of a cell reach into its neighbours, of a cell's side
    points: float = 0.25  # samples that each cell adds, of those of one network
    steps: float = 0.5  # steps of a cell's fit, of those of one network
    least: int = 2000  # samples of a network; with fewer it joins a neighbour
    held_out: int = 32  # vertices in a cell that test its network; where there are fewer some of the samples do
    auto: int = 16  # cells at most where nobody says how many
    triangles: int = 50_000  # of a mesh for each cell then, at least
    pilot: int = 8192  # samples that tell how many cells a mesh needs
    pilot_rays: int = 256  # of such a sample
    unresolved: float = 0.02  # variance of transfer that those samples leave unresolved for each cell, of the whole


@dataclass(frozen=True)
class Render:
    width: int = 512
    height: int = 512
    samples: int = 1  # n x n in each pixel
    suns: str = "auto"  # how many discs of a light go by rays: as many as it needs, off, or so many at most
    gloss: str = "exact"  # light and lobe exact, or sh: the triple product of the papers
    product: str = "tpfl"  # light fixed in one matrix a frame, or tp: the whole triple product in each fragment
    exposure: float = 1.0  # PNG only, multiplies radiance before the tone curve
    tonemap: str = "shoulder"  # PNG only, the tone curve, of imaging.tone.CURVES
    bloom: float = 0.0  # PNG only, share of the light above white that goes into a halo
    constant_after: int = 2_000_000  # samples lit by a network until, on a CPU, its weights become constants: seconds to compile
    constant_most: int = 50_000  # weights that do


@dataclass(frozen=True)
class Picture:
    texels: int = 1 << 27  # of a picture that is read, at most: 16384 x 8192
    unpacked: int = 2 << 30  # bytes of all channels and layers of a picture that is read, at most


@dataclass(frozen=True)
class Probe:
    side: int = 512  # rows of a light's picture that is written


@dataclass(frozen=True)
class Suns:
    auto: int = 16  # of a light at most
    most: int = 16  # that may be asked for, and that shaders hold
    contrast: float = 8.0  # a sun is so much brighter than the mean of the rest
    least: float = 0.01  # energy of a sun, as a share of the light's: one that holds less stays in the rest
    left: float = 0.02  # energy that may stay in the rest for want of suns, as a share of all that could be suns
    narrow: float = 0.03  # radius of a disc that is never split, radians
    fine: float = 0.06  # share of the light's energy that a disc gives an open surface, from which its penumbra is a fine one
    faint: float = 0.02  # the same, below which it is a faint one
    tolerance: float = 0.035  # root of a cluster's share of energy times its mean squared angle, radians, from which it is split


@dataclass(frozen=True)
class Gloss:
    source_rows: int = 512  # of a light's map, at most, where suns and prefiltered maps are made of it
    least_rows: int = 32  # of a prefiltered map of a light
    most_rows: int = 128
    levels: int = 11  # exponents 1, 2, 4 … where the exponent varies over the surface
    level_rows: int = 64  # of their maps
    open_bands: int = 9  # of an open sky's diffuse light; beyond them the clamped cosine has less than 1e-3 of it
    cached: int = 256 << 20  # bytes of maps in the cache, of 2 to 40 MB a light and lobe


@dataclass(frozen=True)
class Reference:
    spp: int = 256  # samples a pixel
    bounces: int = 0  # interreflections; 0 is direct light, what PRT models


@dataclass(frozen=True)
class Exact:
    rays: int = 4096  # a pixel
    points: int = 100_000  # of the surface that send bounced light


@dataclass(frozen=True)
class Material:
    albedo: tuple[float, float, float] = (0.5, 0.5, 0.5)
    specular: tuple[float, float, float] = (1.0, 1.0, 1.0)
    exponent: float = 32.0


@dataclass(frozen=True)
class Camera:
    fov: float = 40.0  # vertical, degrees


@dataclass(frozen=True)
class Mesh:
    bytes: int = 2**31 - 1  # of a file that is read, at most
    triangles: int = 20_000_000  # with all instances, at most
    texels: int = 4096  # along a side of a texture; larger ones are made smaller
    picture: int = 2**28  # pixels of a texture's file, at most
    crease: float = 30.0  # degrees between triangles from which on an edge is sharp where the file has no normals
    far: float = 500.0  # sizes from the origin beyond which a mesh is moved there: float32 keeps 24 bits
    lift: float = 4e-6  # how far off the surface a ray begins, of the scene


@dataclass(frozen=True)
class Vertex:
    rays: int = 1024  # a vertex, fewer where there are many
    budget: int = 200_000_000  # rays of all vertices together that are aimed at
    least: int = 192  # rays a vertex
    bounce_rays: int = 512  # a vertex and bounce, at most


@dataclass(frozen=True)
class Texture:
    resolution: int = 1024  # texels along a side of a sheet
    sets: str = "auto"  # one sheet, or one an object
    bands: int = 5
    rays: int = 1024  # a texel, fewer where there are many
    budget: int = 600_000_000  # rays of all texels together that are aimed at
    least: int = 512  # rays a texel: with half of them noise is 1.5 % of a picture's peak at the 99.9th percentile
    bounce_rays: int = 256  # a texel and bounce, at most
    padding: int = 128  # charts lie a sheet's side divided by this apart
    pieces: int = 4096  # stretches of shared normals up to which a chart ends at each hard edge
    objects: int = 16  # that have a sheet each by `auto`
    overlap: float = 0.01  # share of texels in several triangles up to which a file's own coordinates are taken
    crowded: float = 0.001  # share of texels too near to another chart up to which they are
    least_used: float = 0.05  # share of texels that they use at least
    layers: int = 2048  # of a texture array, as OpenGL 4.3 promises


@dataclass(frozen=True)
class Volume:
    resolution: int = 32  # grid points along the longest side of the bounds
    rays: int = 512  # a grid point


@dataclass(frozen=True)
class NeuralFit:
    width: int = 32  # neurons a layer
    layers: int = 2  # of them, before the output
    steps: int = 6000  # of the optimizer
    batch: int = 4096  # samples a step
    samples: int = 400_000
    rate: float = 0.02  # peak of the one cycle (Adam)
    frequency: float = 6.0  # reach of the first layer's weights, for a point in [-1, 1]


@dataclass(frozen=True)
class GridFit:
    resolution: int = 128  # samples along the longest side of the bounds


@dataclass(frozen=True)
class FromTorch:
    neurons: int = 4096  # of all layers together that are followed
    weights: int = 16_000  # that GLSL gets; more become a grid
    samples: int = 20_000  # points at which the GLSL or the grid is held against the module
    tolerance: float = 1e-4  # |difference| that counts as the same, of the largest |distance| where that is above 1
