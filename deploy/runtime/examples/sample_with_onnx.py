"""Actions of a bundle's prior and decoder by its ONNX files alone.

Usage: sample_with_onnx.py BUNDLE STATES NOISE ACTIONS

Text files with a row a line. STATES: what sinew_self_observation gives; NOISE:
N(0, 1), as wide as the latent. ACTIONS, which is written, gives joint targets
by the manifest's "action".
"""
import hashlib
import json
import pathlib
import sys

import numpy as np
import onnxruntime

bundle = pathlib.Path(sys.argv[1])
files = json.loads((bundle / "manifest.json").read_text())["files"]


def checked(name):
    """Path of a file of the bundle, if it is as the manifest has it."""
    found = hashlib.sha256((bundle / name).read_bytes()).hexdigest()
    if found != files[name]:
        sys.exit(f"{bundle / name}: SHA-256: expected {files[name]}, "
                 f"found {found}")
    return bundle / name


def run(graph, outputs, **inputs):
    """Outputs of BUNDLE/GRAPH.onnx."""
    session = onnxruntime.InferenceSession(
        checked(f"{graph}.onnx"), providers=["CPUExecutionProvider"])
    return session.run(outputs, inputs)


checked("weights.safetensors")  # of all graphs, beside them
own, noise = (np.loadtxt(path, np.float32, ndmin=2) for path in sys.argv[2:4])
mean, std = run("prior", ["mean", "std"], self_observation=own)
latent = mean + std * noise
(action,) = run("decoder", ["action"], self_observation=own, latent=latent)
# The same in one model.
(joined,) = run("sample", ["action"], self_observation=own, noise=noise)
np.testing.assert_allclose(joined, action, rtol=1e-4, atol=1e-5)
np.savetxt(sys.argv[4], action)
