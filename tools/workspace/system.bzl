"""Debian's libraries as one repository, @system.

The headers lie in /usr/include, which the compiler searches (silently) by
itself, so most targets carry link options only. What a missing package would
turn into an error deep inside a compile is found here first.
"""

# A header that stands for the package, and the package.
_NEEDED = {
    "/usr/bin/grpc_cpp_plugin": "protobuf-compiler-grpc",
    "/usr/bin/protoc": "protobuf-compiler",
    "/usr/include/CLI/CLI.hpp": "libcli11-dev",
    "/usr/include/GL/osmesa.h": "libosmesa6-dev",
    "/usr/include/Random123/philox.h": "librandom123-dev",
    "/usr/include/absl/status/statusor.h": "libabsl-dev",
    "/usr/include/assimp/Importer.hpp": "libassimp-dev",
    "/usr/include/benchmark/benchmark.h": "libbenchmark-dev",
    "/usr/include/eigen3/Eigen/Core": "libeigen3-dev",
    "/usr/include/fmt/format.h": "libfmt-dev",
    "/usr/include/gmock/gmock.h": "libgmock-dev",
    "/usr/include/google/protobuf/message.h": "libprotobuf-dev",
    "/usr/include/grpcpp/grpcpp.h": "libgrpc++-dev",
    "/usr/include/gtest/gtest.h": "libgtest-dev",
    "/usr/include/nlohmann/json.hpp": "nlohmann-json3-dev",
    "/usr/include/onnx/onnx_pb.h": "libonnx-dev",
    "/usr/include/openssl/evp.h": "libssl-dev",
    "/usr/include/prometheus/registry.h": "prometheus-cpp-dev",
    "/usr/include/spdlog/spdlog.h": "libspdlog-dev",
    "/usr/include/stb/stb_image_write.h": "libstb-dev",
    "/usr/include/tinyxml2.h": "libtinyxml2-dev",
    "/usr/include/zip.h": "libzip-dev",
    "/usr/include/zstd.h": "libzstd-dev",
    "/usr/lib/llvm-19/bin/clang": "clang-19",
    "/usr/lib/llvm-19/bin/ld.lld": "lld-19",
}

# Of their headers much is in every source as well.
_COMPILED_IN = [
    "libc6-dev",
    "libstdc++-12-dev",
]

def _system_impl(ctx):
    missing = {
        package: path
        for path, package in _NEEDED.items()
        if not ctx.path(path).exists
    }
    if missing:
        fail("@system: these files are missing: %s\nto get them: apt-get install %s" % (
            ", ".join(missing.values()),
            " ".join(sorted(missing.keys())),
        ))

    # What is compiled from these headers and kept belongs to these versions.
    versions = ctx.execute(["dpkg-query", "--show"] + _NEEDED.values() + _COMPILED_IN)
    if versions.return_code:
        fail("@system: dpkg-query: " + versions.stderr)
    ctx.file("packages.txt", versions.stdout, executable = False)

    # Eigen alone hides below a folder of its own.
    ctx.symlink("/usr/include/eigen3", "eigen3")

    # Installed later than the others on many machines, whose compiler
    # configuration has not seen their headers in /usr/include.
    ctx.symlink("/usr/include/tinyxml2.h", "tinyxml2/tinyxml2.h")
    ctx.symlink("/usr/include/assimp", "assimp/assimp")
    ctx.symlink("/usr/include/zip.h", "zip/zip.h")
    ctx.symlink("/usr/include/zipconf.h", "zip/zipconf.h")
    ctx.symlink(ctx.attr.build_file, "BUILD.bazel")

system_libraries = repository_rule(
    implementation = _system_impl,
    attrs = {"build_file": attr.label(mandatory = True)},
    # Looks at the machine: fetched anew by `bazel sync --configure`.
    configure = True,
    local = True,
)
