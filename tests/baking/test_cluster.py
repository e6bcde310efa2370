"""A real scheduler and two worker processes give what this process gives, to the bit, even when one is killed."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import nets
import numpy as np
import pytest
import soups

import sdfprt
from sdfprt import Scene, SdfprtError
from sdfprt.baking import cluster as workers
from sdfprt.baking import stages
from sdfprt.baking.asset import Asset
from sdfprt.core import settings

SCENE = nets.scene()
ASSET = Asset(nets.random_net(), SCENE.hash)


class Cluster:
    """A scheduler and two workers without a nanny to start them again."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scheduler = self._start("scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(folder / "scheduler"))
        while not (folder / "scheduler").is_file() or not (folder / "scheduler").read_text().strip():
            assert self.scheduler.poll() is None, (folder / "log").read_text()
            time.sleep(0.05)
        self.address = json.loads((folder / "scheduler").read_text())["address"]
        self.workers = [self.worker(), self.worker()]

    def worker(self) -> subprocess.Popen:
        flags = ("--no-nanny", "--no-dashboard", "--nthreads", "1", "--local-directory", str(self.folder))
        return self._start("worker", self.address, *flags)

    def _start(self, which: str, *flags: str) -> subprocess.Popen:
        with (self.folder / "log").open("a") as log:
            code = f"from distributed.cli.dask_{which} import main; main()"
            paths = [str(Path(__file__).parent), str(Path(__file__).parents[1]), str(Path(sdfprt.__file__).parent.parent)]
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
            return subprocess.Popen([sys.executable, "-c", code, *flags], stdout=log, stderr=log, env=environment)

    def kill_one_when(self, happened) -> threading.Thread:
        """SIGKILL for the first worker as soon as `happened()`."""

        def run() -> None:
            while not happened():
                time.sleep(0.002)
            self.workers[0].send_signal(signal.SIGKILL)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        return thread

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path, monkeypatch) -> Iterator[Cluster]:
    monkeypatch.setattr(workers, "SECONDS", 120)  # a busy machine is no failure
    (tmp_path / "dask").mkdir()
    made = Cluster(tmp_path / "dask")
    yield made
    made.close()


def test_a_bake_on_a_cluster_that_loses_a_worker_is_the_local_bake_to_the_bit(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(settings.Surface, "resolution", 48)
    monkeypatch.setattr(settings.Fit, "held_out", 256)
    monkeypatch.setattr(stages, "CHUNK", 1000)
    monkeypatch.setattr(workers, "POINTS", 130)
    scene = Scene(glsl=nets.SPHERE_AND_BOX)

    def transfer(cache: str) -> list[np.ndarray]:
        return [np.load(path)["T"] for path in sorted((tmp_path / cache / "work").glob("transfer-*/*.npz"))]

    def run(cache: str, **options):
        monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / cache))
        return sdfprt.bake(scene, width=16, layers=3, points=20_000, rays=64, steps=30, **options)

    killer = cluster.kill_one_when(lambda: any((tmp_path / "far" / "work").glob("transfer-*/*.npz")))
    far = run("far", cluster=cluster.address)
    killer.join(60)
    assert cluster.workers[0].wait(60) == -signal.SIGKILL
    monkeypatch.setattr(stages, "CHUNK", 32_768)
    near = run("near")
    np.testing.assert_array_equal(np.concatenate(transfer("far")), np.concatenate(transfer("near")))
    assert far.net.digest == near.net.digest


def test_cells_that_a_cluster_fits_are_the_local_ones_to_the_bit(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(settings.Fit, "held_out", 256)
    monkeypatch.setattr(settings.Cells, "least", 60)
    monkeypatch.setattr(workers, "POINTS", 300)
    balls = [soups.ball(0.4 + 0.1 * k, (2 * k, 0.6, 0), 2) for k in range(4)]
    scene = soups.scene(soups.square(3.0, 0.0, 4).apply_translation([3, 0, 0]), *balls)

    def run(cache: str, **options):
        monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / cache))
        return sdfprt.bake(scene, width=8, layers=2, points=2000, rays=32, steps=60, cells=4, **options)

    far, near = run("far", cluster=cluster.address), run("near")
    assert near.info["networks"] > 1 and far.net.digest == near.net.digest
    assert Path(far.path).read_bytes() == Path(near.path).read_bytes()


def test_pictures_from_a_cluster_that_loses_a_worker_are_the_local_files(cluster, tmp_path):
    def run(name: str, kind: str, **options) -> dict[str, bytes]:
        folder = tmp_path / f"{name}-{kind}"
        entries = sdfprt.render_set(
            [SCENE], folder, ["studio", "overcast"], (0, 90), 3, materials=("diffuse", "phong:9"), size=(40, 32),
            kind=kind, assets=[ASSET], **options,
        )  # fmt: skip
        assert len(entries) == 24
        return {entry["file"]: (folder / entry["file"]).read_bytes() for entry in entries}

    # One file is there, the other 23 are not
    killer = cluster.kill_one_when(lambda: any((tmp_path / "far-exr").glob("*.exr")))
    assert run("far", "exr", cluster=cluster.address) == run("near", "exr")
    killer.join(60)
    assert cluster.workers[0].wait(60) == -signal.SIGKILL
    assert run("far", "png", cluster=cluster.address) == run("near", "png")


def test_a_scene_with_textures_works_in_another_process(cluster):
    values = np.random.default_rng(3).uniform(0.0, 0.2, (5, 6, 7)).astype(np.float16)
    glsl = "uniform sampler3D bumps;\nfloat sdf(vec3 p) { return length(p) - 0.5 - texture(bumps, 0.5 * p + 0.5).r; }"
    scene = Scene(glsl=glsl, textures={"bumps": values}, step=0.6)
    points = np.random.default_rng(0).uniform(-1, 1, (64, 3)).astype(np.float32)
    here = scene.distance(points)
    with workers.connect(cluster.address) as client:
        ((_, there),) = workers.each(client, Scene.distance, [(scene, points)])
    np.testing.assert_array_equal(here, there)


def test_a_task_that_fails_is_tried_again_and_then_its_own_error_comes(cluster, tmp_path):
    with workers.connect(cluster.address) as client:
        tasks = [(str(tmp_path / name), fails) for name, fails in (("a", 0), ("b", 2), ("c", 3))]
        assert dict(workers.each(client, fails_at_first, tasks)) == {0: 1, 1: 3, 2: 4}
        with pytest.raises(SdfprtError, match="time 4"):
            list(workers.each(client, fails_at_first, [(str(tmp_path / "d"), 9)]))


def fails_at_first(path: str, times: int) -> int:
    """How often it was called; fails as long as that is `times` or less."""
    with open(path, "a") as file:
        file.write(".")
    calls = os.path.getsize(path)
    if calls <= times:
        raise SdfprtError(f"time {calls}")
    return calls


def test_no_more_tasks_are_under_way_than_the_workers_can_chew(cluster):
    given, most = 0, 0

    def tasks():
        nonlocal given
        for _ in range(60):
            given += 1
            yield (0,)

    with workers.connect(cluster.address) as client:
        client.wait_for_workers(2)
        for done, _ in enumerate(workers.each(client, abs, tasks())):
            most = max(most, given - done)
    assert given == 60 and most <= workers.AHEAD * 2


def test_without_a_scheduler_or_workers_there_is_one_clear_error(monkeypatch, tmp_path):
    monkeypatch.setattr(workers, "SECONDS", 0.5)
    with pytest.raises(SdfprtError, match="no Dask scheduler"), workers.connect("tcp://127.0.0.1:9"):
        pass
    with pytest.raises(SdfprtError, match="expected a scheduler's address"), workers.connect("somewhere"):
        pass
