"""Actions of a bundle's prior and decoder by its ONNX files alone.

Usage: sample_with_onnx.py BUNDLE STATES NOISE ACTIONS

Text files with a row a line. STATES: what sinew_self_observation gives; NOISE:
N(0, 1), as wide as the latent. ACTIONS, which is written, gives joint targets
by the manifest's "action".
"""
import sys

import numpy as np
import onnxruntime


def run(graph, outputs, **inputs):
    """Outputs of BUNDLE/GRAPH.onnx; its weights lie beside it."""
    session = onnxruntime.InferenceSession(
        f"{sys.argv[1]}/{graph}.onnx", providers=["CPUExecutionProvider"])
    return session.run(outputs, inputs)


own, noise = (np.loadtxt(path, np.float32, ndmin=2) for path in sys.argv[2:4])
mean, std = run("prior", ["mean", "std"], self_observation=own)
latent = mean + std * noise
(action,) = run("decoder", ["action"], self_observation=own, latent=latent)
# The same in one model.
(joined,) = run("sample", ["action"], self_observation=own, noise=noise)
np.testing.assert_allclose(joined, action, rtol=1e-4, atol=1e-5)
np.savetxt(sys.argv[4], action)
