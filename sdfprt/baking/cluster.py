"""Work spread over the processes of a Dask cluster: tasks of bounded size, repeated where a worker dies, results as they come.

A task is a function of values and gives a value, so it does not matter who runs it, or how often. Nothing but the
scheduler's address is shared: workers need sdfprt of the same version, but neither the files nor the cache of the caller.
"""

import functools
import itertools
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.sdf import lattice
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.compute import compute_transfer

POINTS = 8192  # surface points that one task holds at most: 200 KB are sent, 512 KB come back at 4 bands
RETRIES = 3  # times that a failed task is run again
AHEAD = 2  # tasks under way for each thread of a worker; this bounds the memory of the scheduler
SECONDS = 20  # that a caller waits for a scheduler, and then for its first worker


@contextmanager
def connect(address: str) -> Iterator[Any]:
    """A client of the scheduler at `address`, such as tcp://10.0.0.5:8786, with one worker or more of our version.

    Raises SdfprtError without `distributed`, where no scheduler answers, and where it has no workers or theirs is another sdfprt.
    """
    try:
        from distributed import Client
    except ImportError:
        raise SdfprtError("a cluster needs Dask: pip install 'sdfprt[cluster]'") from None
    if not re.fullmatch(r"(\w+://)?(\[[^\]]+\]|[^/:\s]+):\d+/?", address):
        raise SdfprtError(f"--cluster {address}: expected a scheduler's address, such as tcp://127.0.0.1:8786")
    try:
        try:
            client = Client(address, timeout=SECONDS, set_as_default=False)
        except AssertionError:  # distributed gives its own thread ten seconds to start, which a busy machine may need
            client = Client(address, timeout=SECONDS, set_as_default=False)
    except (
        AssertionError,
        OSError,
        ValueError,
        TypeError,
        RuntimeError,
    ) as error:  # the last three: TLS asked for by one side only
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SdfprtError(
            f"--cluster {address}: no Dask scheduler answers there ({reason}). Start one with `dask scheduler`, "
            "workers with `dask worker ADDRESS`; docs/cluster.md says how certificates are named"
        ) from None
    try:
        try:
            client.wait_for_workers(1, timeout=SECONDS)
        except TimeoutError:
            raise SdfprtError(
                f"--cluster {address}: the scheduler has no workers; start some with `dask worker {address}`"
            ) from None
        _same_version(client, address)
        yield client
    finally:
        client.close()


def each(client: Any, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[int, Any]]:
    """(number, function(*task)) of each task, in the order in which they end; `tasks` is read as workers come free.

    A task whose worker died runs again elsewhere. Raises what the function raised RETRIES + 1 times, and SdfprtError for a
    task on which worker after worker died.
    """
    from distributed import KilledWorker, as_completed

    waiting = enumerate(tasks)
    numbers: dict[str, int] = {}
    running = as_completed(loop=client.loop)

    def refill() -> None:
        room = max(2, AHEAD * sum(client.nthreads().values())) - len(numbers)
        for number, task in itertools.islice(waiting, max(room, 0)):
            future = client.submit(_in_lane, function, *task, pure=False, retries=RETRIES)
            numbers[future.key] = number
            running.add(future)

    refill()
    try:
        for future in running:
            try:
                result = future.result()
            except KilledWorker as error:
                raise SdfprtError(
                    f"workers of the cluster died over one task again and again; is their memory enough? {error}"
                ) from None
            yield numbers.pop(future.key), result
            refill()
    finally:
        running.clear()


def shared(client: Any, value: Any) -> Any:
    """What stands for a value in many tasks: sent to a worker once, and again where that one dies."""
    return client.submit(_itself, value, pure=False)


def _itself(value: Any) -> Any:
    return value


def transfer(
    scene: AnyScene,
    points: ndarray,
    normals: ndarray,
    bands: int,
    rays: int,
    seed: int,
    start: int,
    rounded: bool,
    sampling: str = settings.Transfer.sampling,
) -> ndarray:
    """The task of the bake: transfer of points whose numbers begin at `start`, by the lattice if `rounded`; joins the others'."""
    by = lattice.worthwhile(scene) if rounded and isinstance(scene, Scene) else None
    return compute_transfer(scene, points, normals, bands, rays, seed=seed, start=start, lattice=by, sampling=sampling)


@functools.cache
def _lane() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1)


def _in_lane(function: Callable, *arguments: Any) -> Any:
    """On one thread, the same for all tasks of a process: an OpenGL context belongs to its thread, and Warp loads modules."""
    return _lane().submit(function, *arguments).result()


def _version() -> str:
    return version("sdfprt")


def _same_version(client: Any, address: str) -> None:
    try:
        found = set(client.run(_version).values())
    except ImportError as error:
        raise SdfprtError(f"--cluster {address}: sdfprt is not installed where the workers run ({error})") from None
    if found != {_version()}:
        raise SdfprtError(f"--cluster {address}: workers have sdfprt {', '.join(sorted(found))}, this is {_version()}")
