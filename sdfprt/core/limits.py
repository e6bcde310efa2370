"""What no memory holds is refused before it is begun, with the estimate and the limit."""

import resource
from pathlib import Path

from sdfprt.core.errors import SdfprtError

_GROUP = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))
_GIB = 2**30


def check_memory(what: str, estimate: float) -> None:
    """Raise SdfprtError where `what`, which needs about `estimate` bytes, does not fit into the memory that is free."""
    free = free_memory()
    if estimate > free:
        raise SdfprtError(f"{what} would take about {_shown(estimate)} of memory, and {_shown(free)} are free; ask for less")


def free_memory() -> float:
    """Bytes that this process may still take: of the machine, of its container, and by `ulimit -v`."""
    limits = []
    try:
        fields = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        limits.append(1024.0 * int(fields["MemAvailable"].split()[0]))
    except (OSError, KeyError, ValueError):
        limits.append(8.0 * _GIB)  # not Linux: a usual machine
    for path in _GROUP:
        try:
            limits.append(float(int(path.read_text())))
        except (OSError, ValueError):
            continue  # not there, or `max`
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    if soft != resource.RLIM_INFINITY:
        limits.append(float(soft))
    return min(limits)


def _shown(size: float) -> str:
    return f"{size / _GIB:.1f} GiB" if size < 1000 * _GIB else f"{size / _GIB / 1024:,.0f} TiB"
