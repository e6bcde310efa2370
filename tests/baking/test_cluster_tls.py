"""A cluster over TLS on the loopback: who has the certificate gets results, who has none gets one clear error."""

import subprocess
from pathlib import Path

import dask
import distributed  # noqa: F401  (its settings have to be there before they are set)
import pytest
from test_cluster import Cluster

from sdfprt import SdfprtError
from sdfprt.baking import cluster as workers

ON = "distributed.comm"


def _certificate(folder: Path) -> dict[str, str | bool]:
    """A certificate that signs itself, as docs/cluster.md makes one with an authority; the settings that name it."""
    cert, key = folder / "cert.pem", folder / "key.pem"
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=sdfprt"]
    try:
        subprocess.run([*made, "-keyout", str(key), "-out", str(cert)], check=True, capture_output=True)
    except FileNotFoundError:
        pytest.skip("no openssl on this machine")
    own = {
        f"{ON}.tls.{role}.{part}": str(path)
        for role in ("scheduler", "worker", "client")
        for part, path in (("cert", cert), ("key", key))
    }
    return own | {f"{ON}.tls.ca-file": str(cert), f"{ON}.require-encryption": True, f"{ON}.default-scheme": "tls"}  # type: ignore[dict-item]


def test_over_tls_results_come_and_strangers_get_one_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    settings = _certificate(tmp_path)
    for name, value in settings.items():  # for the processes of scheduler and workers
        monkeypatch.setenv("DASK_" + name.upper().replace(".", "__").replace("-", "_"), str(value))
    monkeypatch.setattr(workers, "SECONDS", 120)  # a busy machine is no failure
    cluster = Cluster(tmp_path)
    try:
        assert cluster.address.startswith("tls://")
        with dask.config.set(settings), workers.connect(cluster.address) as client:
            assert dict(workers.each(client, abs, [(-3,), (4,)])) == {0: 3, 1: 4}
        monkeypatch.setattr(workers, "SECONDS", 3)
        with pytest.raises(SdfprtError, match="--cluster tls://"), workers.connect(cluster.address):
            pass
        with dask.config.set(settings), pytest.raises(SdfprtError, match="--cluster tcp://"):
            with workers.connect(cluster.address.replace("tls://", "tcp://")):
                pass
    finally:
        cluster.close()
