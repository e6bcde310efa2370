"""The network's CUDA kernel against numpy, by Triton's interpreter, which needs no card."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

APART = Path(sys.prefix) / "triton"  # where scripts/setup.sh puts it: in one process with Mesa's driver it crashes
SCRIPT = """
import numpy as np, torch, nets
from sdfprt.network import fused
net = nets.random_net()
rng = np.random.default_rng(0)
points = rng.uniform(-1, 1, (200, 3)).astype(np.float32)
normals = rng.normal(size=(200, 3)).astype(np.float32)
normals /= np.linalg.norm(normals, axis=1, keepdims=True)
expected = net.predict(points, normals)
packed = fused.Packed(net, "cpu")
planes = [torch.zeros(200, 4), torch.zeros(200, 4)]
for plane, values in zip(planes, (points, normals)):
    plane[:, :3] = torch.from_numpy(values)
planes[0][::2, 3] = 1.0
out = torch.full((200, packed.outputs), 7.0)
fused.run_into(out, packed, *planes, planes[0][:, 3])
error = np.abs(out[::2].numpy() - expected[::2]).max() / np.abs(expected).max()
assert error < 5e-3, error  # three products of 11-bit numbers in a row
assert (out[1::2] == 7.0).all()
whole = fused.run(packed, torch.from_numpy(points), torch.from_numpy(normals)).numpy()
assert np.abs(whole - expected).max() / np.abs(expected).max() < 5e-3
print("equal")
"""


@pytest.mark.skipif(
    not (APART.is_dir() or importlib.util.find_spec("triton")), reason="no Triton on this machine; CUDA builds of torch bring it"
)
def test_the_cuda_kernel_computes_the_network_where_something_was_hit():
    environment = {**os.environ, "TRITON_INTERPRET": "1", "PYTHONPATH": os.pathsep.join([*sys.path, str(APART)])}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, timeout=300)
    assert done.stdout.strip() == "equal", done.stderr[-800:]
