"""Checks ONNX models and runs them with onnxruntime.

Usage: onnx_check.py --packages DIR {MODEL INPUTS OUTPUTS}...

DIR holds the unpacked packages onnx, onnxruntime and what they need. INPUTS is
a safetensors file with one float32 tensor for each input of MODEL; OUTPUTS is
written as one with a tensor for each output. One thread, CPU only.

Exit code 0: all models checked and run. 1: the message on stderr names the
model and the cause. 2: usage.
"""

import json
import os
import struct
import sys


def fail(message):
    print("onnx_check: " + message, file=sys.stderr)
    sys.exit(1)


def read_tensors(path, np):
    """Float32 tensors of a safetensors file, by name."""
    with open(path, "rb") as file:
        size, = struct.unpack("<Q", file.read(8))
        header = json.loads(file.read(size))
        data = file.read()
    tensors = {}
    for name, entry in header.items():
        if name == "__metadata__":
            continue
        if entry["dtype"] != "F32":
            fail(f"{path}: tensor {name}: expected F32, found {entry['dtype']}")
        begin, end = entry["data_offsets"]
        tensors[name] = np.frombuffer(
            data[begin:end], dtype="<f4").reshape(entry["shape"])
    return tensors


def write_tensors(path, tensors, np):
    header = {}
    data = b""
    for name in sorted(tensors):
        value = np.ascontiguousarray(tensors[name], dtype="<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(tensors[name].shape),
                        "data_offsets": [len(data), len(data) + len(value)]}
        data += value
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + data)


def check_and_run(model, inputs, onnx, runtime, np):
    """Outputs of a model by name."""
    onnx.checker.check_model(model, full_check=True)
    options = runtime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    session = runtime.InferenceSession(model, options,
                                       providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    return dict(zip(names, session.run(names, read_tensors(inputs, np))))


def main(arguments):
    if (len(arguments) < 5 or arguments[0] != "--packages"
            or len(arguments) % 3 != 2):
        print(__doc__, file=sys.stderr)
        return 2
    sys.path.insert(0, arguments[1])
    # The packages write nothing beside themselves.
    sys.dont_write_bytecode = True
    try:
        import numpy as np
        import onnx
        import onnxruntime as runtime
    except ImportError as error:
        fail(f"{arguments[1]}: cannot import: {error}")
    runtime.set_default_logger_severity(3)
    for at in range(2, len(arguments), 3):
        model, inputs, outputs = arguments[at:at + 3]
        try:
            tensors = check_and_run(model, inputs, onnx, runtime, np)
        except Exception as error:  # Every one means: this model is no good.
            fail(f"{model}: {type(error).__name__}: {error}")
        temporary = outputs + ".part"
        write_tensors(temporary, tensors, np)
        os.replace(temporary, outputs)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
