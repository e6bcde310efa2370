"""Files that are written whole or not at all, what a killed write left behind, and which files were read.

A write goes to a hidden file beside its target, which takes the target's place when all is there. The hidden file's name says
which process of which system writes it, so a later write into the folder can tell those that nobody will finish and remove them.
"""

import functools
import hashlib
import os
import re
import secrets
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from safetensors import SafetensorError

from sdfprt.core.errors import SdfprtError

_PREFIX = ".sdfprt-"
_HIDDEN = re.compile(rf"{re.escape(_PREFIX)}(?P<system>[0-9a-f]{{8}})-(?P<process>\d+)-[0-9a-f]{{8}}(\..*)?")
_DAY = 86_400  # seconds until a hidden file of another system counts as left behind
_PROBE = 1 << 20  # bytes that are appended to learn why a library could not write
_records: list[set[Path]] = []  # of the blocks of `files_read` that are under way


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """A temporary path in the same folder that takes the place of `path` when the block ends well, and vanishes if not.

    The file gets the mode of the one that it replaces, or what the umask leaves. Raises SdfprtError that names `path` where it
    cannot be written: no such folder, no permission, a full disk, something there that is no file.
    """
    path = Path(path)
    mode = _mode(path)
    temporary = path.parent / f"{_PREFIX}{_system()}-{os.getpid()}-{secrets.token_hex(4)}{path.suffix}"
    remove_leftovers(path.parent)
    try:
        # The system applies the umask; to ask for it would set it for a moment, for all threads
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        if mode is None:
            mode = stat.S_IMODE(temporary.stat().st_mode)
    except OSError as error:
        raise SdfprtError(f"{path}: cannot be written: {error.strerror}") from error
    try:
        yield temporary
        os.chmod(temporary, mode)
        os.replace(temporary, path)
    except (OSError, RuntimeError, SafetensorError) as error:
        raise SdfprtError(f"{path}: cannot be written: {_reason(temporary, error)}") from error
    finally:
        temporary.unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> None:
    """Remove the hidden files of writes into this folder that were killed; it is looked through once a process."""
    _remove_leftovers(os.path.realpath(folder), os.getpid())


@functools.lru_cache(maxsize=1024)
def _remove_leftovers(folder: str, process: int) -> None:
    """`process` is there for forked children: each looks for itself."""
    try:
        hidden = [entry for entry in os.scandir(folder) if entry.name.startswith(_PREFIX)]
    except OSError:
        return  # the write itself says what is wrong with the folder
    for entry in hidden:
        match = _HIDDEN.fullmatch(entry.name)
        if match is None:
            continue
        try:
            old = time.time() - entry.stat(follow_symlinks=False).st_mtime > _DAY
            if old or (match["system"] == _system() and not _alive(int(match["process"]))):
                os.unlink(entry.path)
        except OSError:
            continue  # another process was quicker, or the file is not ours to remove


def _mode(path: Path) -> int | None:
    """Permissions of the file that is there, None where there is none. Raises SdfprtError for what no file can replace."""
    try:
        found = path.stat()
    except OSError:
        return None
    if not stat.S_ISREG(found.st_mode):
        what = "a folder" if stat.S_ISDIR(found.st_mode) else "not a file"
        raise SdfprtError(f"{path}: cannot be written: there is {what} of that name")
    return stat.S_IMODE(found.st_mode)


def _reason(temporary: Path, error: Exception) -> str:
    """Why a write failed. Libraries hide the system's own word, so it is asked for by writing a little more."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    try:
        with temporary.open("ab") as file:
            file.write(bytes(_PROBE))
    except OSError as found:
        return found.strerror or str(found)
    return " ".join(str(error).split()) or type(error).__name__


@functools.cache
def _system() -> str:
    """The system whose process numbers we see: a machine since its start, and a container on it."""
    parts = [os.uname().nodename]
    try:
        parts += [Path("/proc/sys/kernel/random/boot_id").read_text(), os.readlink("/proc/self/ns/pid")]
    except OSError:
        pass  # not Linux: the machine's name has to do
    return hashlib.sha256("|".join(parts).encode()).hexdigest()[:8]


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """The files of scenes and meshes that are read while the block runs, in whatever thread."""
    found: set[Path] = set()
    _records.append(found)
    try:
        yield found
    finally:
        _records[:] = [each for each in _records if each is not found]


def note_read(path: Path) -> Path:
    """The path itself; whoever reads a scene's or a mesh's own file asks for it by this."""
    for each in _records:
        each.add(path)
    return path


def belonging(path: Path, root: Path) -> Path:
    """`path`, which is a file in `root` or below, wherever links lead.

    Raises SdfprtError for a link that leads out of it or to nothing, and for what is no plain file (a pipe would never end).
    """
    try:
        real = path.resolve()
        if not real.is_relative_to(root.resolve()):
            raise SdfprtError(f"{path}: it is a link that leads out of its folder; a scene reads nothing there")
        if not real.is_file():
            what = "a link to nothing" if path.is_symlink() else "no such file" if not path.exists() else "no plain file"
            raise SdfprtError(f"{path}: {what}")
    except (OSError, RuntimeError, ValueError) as error:
        raise SdfprtError(f"{path}: cannot be read: {error}") from None
    return path
