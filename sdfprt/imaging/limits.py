"""How large a picture may be: a header costs nothing to write, so it is asked before anything is unpacked."""

from pathlib import Path

from sdfprt.core.errors import SdfprtError
from sdfprt.core.settings import Picture


def check_size(path: Path, width: int, height: int) -> None:
    """Raise SdfprtError for a picture without texels, or with more than `Picture.texels`."""
    if width < 1 or height < 1:
        raise SdfprtError(f"{path}: a picture of {width} x {height} texels has nothing in it")
    if width * height > Picture.texels:
        raise SdfprtError(f"{path}: {width} x {height} texels are more than the {Picture.texels / 1e6:.0f} million that are read")


def check_bytes(path: Path, count: int) -> None:
    """Raise SdfprtError for a file whose channels and layers unpack to more than `Picture.unpacked`."""
    if count > Picture.unpacked:
        most = Picture.unpacked / 2**30
        raise SdfprtError(f"{path}: it unpacks to {count / 2**30:.1f} GiB, more than the {most:.0f} that are read")
