"""The cache: a folder that sdfprt marked as its own, and nothing in it but what sdfprt wrote.

`SDFPRT_CACHE` names it; else it is `sdfprt` in `XDG_CACHE_HOME`, or in `~/.cache`. An empty variable counts as unset, and so does a
relative `XDG_CACHE_HOME`, as the XDG Base Directory Specification has it. A folder that holds other things is left alone: the cache
is then a folder `sdfprt-cache` inside it. Where no folder can be written, a temporary one serves until the process ends.
"""

import functools
import os
import re
import stat
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.files import remove_leftovers

_Read = TypeVar("_Read")
_MARK = "CACHEDIR.TAG"  # the name, and below the first line, that programs for back-ups know (bford.info/cachedir)
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55"
_OWN = "# This folder is a cache of sdfprt."
_TEXT = f"{_SIGNATURE}\n{_OWN} sdfprt removes old files that it wrote here itself; the whole folder may be deleted.\n"
_INSIDE = "sdfprt-cache"  # the cache in a folder that holds other things

# What sdfprt writes below the cache's folder, by names relative to it
WORK, ASSETS, CUBINS, LIGHTS = "work", "assets", "cuda", "lights"
_HASH = r"[0-9a-f]{16,20}"
_FILES = re.compile(
    rf"backends\.json|{ASSETS}/{_HASH}-(k\d+|{_HASH})\.safetensors|{CUBINS}/{_HASH}\.cubin"
    rf"|{LIGHTS}/map-{_HASH}\.safetensors"
    rf"|{WORK}/((surface|view)-{_HASH}\.npz|fit-{_HASH}\.(safetensors|part)|(transfer|bounce)-{_HASH}/\d{{8}}\.npz)"
    r"|(.*/)?\.(sdfprt|backends|surface|view|fit|\d{8}|[0-9a-f]{16})-[^/]*"  # hidden files of writes that were killed
)
# `warp` are kernels that Warp compiled
_FOLDERS = re.compile(rf"warp(/.*)?|{ASSETS}|{CUBINS}|{LIGHTS}|{WORK}|{WORK}/(transfer|bounce)-{_HASH}")


def cache_folder() -> Path:
    """Folder for bakes and translated scenes; it exists and is marked as ours.

    Warns once (SdfprtWarning) where a temporary folder has to do.
    """
    return _prepared(os.environ.get("SDFPRT_CACHE") or "", os.environ.get("XDG_CACHE_HOME") or "", os.getcwd())


@functools.lru_cache(maxsize=64)
def _prepared(own: str, shared: str, here: str) -> Path:
    """`here` is there since relative names change their meaning with it."""
    try:
        folder = Path(here, own) if own else (Path(shared) if os.path.isabs(shared) else Path.home() / ".cache") / "sdfprt"
        for place in (folder, folder / _INSIDE):
            if _claimed(place):
                return place
        reason = f"{folder / _INSIDE} holds files that are not the cache's"
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home folder
        reason = str(error)
    warnings.warn(
        f"no cache: {reason}; a temporary folder serves until the end. SDFPRT_CACHE may name another", SdfprtWarning, stacklevel=3
    )
    return Path(_temporary().name)


def kernel_folder(version: str) -> Path | None:
    """Where Warp keeps what it compiled: its usual place, or in our cache where that cannot be written; None by WARP_CACHE_PATH."""
    if os.environ.get("WARP_CACHE_PATH"):
        return None
    shared = os.environ.get("XDG_CACHE_HOME") or ""
    try:
        usual = (Path(shared) if os.path.isabs(shared) else Path.home() / ".cache") / "warp" / version
        usual.mkdir(parents=True, exist_ok=True)
        if os.access(usual, os.W_OK | os.X_OK):
            return usual
    except (OSError, RuntimeError):
        pass
    return cache_folder() / "warp" / version


@functools.cache
def _temporary() -> tempfile.TemporaryDirectory:
    """Vanishes with the process."""
    return tempfile.TemporaryDirectory(prefix="sdfprt-")


def _claimed(folder: Path) -> bool:
    """Whether the folder is ours, marked now where it is new, empty or plainly of an earlier sdfprt. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / _MARK
    if not _is_marked(mark):
        if not _holds_only_ours(folder):
            return False
        mark.write_text(_TEXT)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(f"{folder} cannot be written")
    return True


def _is_marked(mark: Path) -> bool:
    try:
        return stat.S_ISREG(mark.lstat().st_mode) and _OWN in mark.read_text(errors="replace")
    except OSError:
        return False


def _holds_only_ours(folder: Path) -> bool:
    return all(path.name != _MARK and _is_ours(folder, path) for path in folder.iterdir())  # a mark is another program's here


def _is_ours(root: Path, path: Path) -> bool:
    """Whether a file, or a folder with all that is in it, bears a name that the cache gives. Links never do."""
    name = path.relative_to(root).as_posix()
    if path.is_symlink():
        return False
    if path.is_dir():
        return bool(_FOLDERS.fullmatch(name)) and all(_is_ours(root, inner) for inner in path.iterdir())
    return bool(_FILES.fullmatch(name)) or name.startswith("warp/")


def _newest_first(name: str) -> list[tuple[float, int, Path]]:
    """Time, bytes and path of what lies in a folder of the cache: what bears a name that the cache gives, and no link."""
    folder = cache_folder() / name
    if folder.is_symlink() or not folder.is_dir():
        return []
    remove_leftovers(folder)
    entries = []
    for path in folder.iterdir():
        names = _FOLDERS if path.is_dir() else _FILES
        hidden = path.name.startswith(".")  # another process' temporary file
        try:
            if not hidden and not path.is_symlink() and names.fullmatch(f"{name}/{path.name}"):
                found = path.stat()
                entries.append((found.st_mtime, found.st_size, path))
        except OSError:
            continue  # another process was quicker
    return sorted(entries, reverse=True)


def trim_lights(most: int) -> None:
    """Remove the oldest maps of lights until the others take no more than `most` bytes; the newest stays."""
    total = 0
    for number, (_, size, path) in enumerate(_newest_first(LIGHTS)):
        total += size
        if number and total > most:
            try:
                path.unlink(missing_ok=True)
            except OSError:
                continue  # a folder of that name, or one that must not be written


def trim_work(keep: int) -> None:
    """Remove all but the newest `keep` working files: only those whose names the cache gives, and nothing through a link."""
    for _, _, path in _newest_first(WORK)[keep:]:
        try:
            if not path.is_dir():
                path.unlink(missing_ok=True)
                continue
            for inner in path.iterdir():
                if _FILES.fullmatch(f"{WORK}/{path.name}/{inner.name}") and not inner.is_dir():
                    inner.unlink(missing_ok=True)
            path.rmdir()
        except OSError:
            continue  # it holds something else, or another bake was quicker


def regular_file(path: Path) -> bool:
    """Whether a file is there that can be read to its end. Raises SdfprtError for a folder, pipe or device of that name."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    if not stat.S_ISREG(mode):
        raise SdfprtError(f"{path}: not a file but {'a folder' if stat.S_ISDIR(mode) else 'a pipe or device'}; remove it")
    return True


def read_whole(path: Path, load: Callable[[Path], _Read]) -> _Read | None:
    """What `load` reads of a file of the cache; None where none is there, or a damaged one, which is to be made again."""
    if not regular_file(path):
        return None
    try:
        return load(path)
    except SdfprtError:
        return None
