"""The macros that all BUILD files use: own code's flags live here only."""

# lint: errors too strict for every day, on demand.
_LINT = [
    "-Wconversion",
    "-Wno-sign-conversion",
    "-Wdeprecated",
    "-Wextra-semi",
    "-Wimplicit-fallthrough",
    "-Wnon-virtual-dtor",
    "-Woverloaded-virtual",
    "-Wrange-loop-analysis",
    "-Wshadow-all",
    "-Wunreachable-code",
]

_OWN_COPTS = [
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wthread-safety",
    "-Werror=thread-safety",
    # Generated code is included as a user header; treat it as a system one.
    "--system-header-prefix=proto/",
]

# A target sees only the headers of the targets that it names.
_FEATURES = ["layering_check"]

def _copts(copts):
    return _OWN_COPTS + select({
        "//tools/build:lint": _LINT,
        "//conditions:default": [],
    }) + copts

# A test's own source runs once; what it tests is optimised as ever.
TEST_COPTS = ["-O0"]

def _precompiled(headers, srcs = None):
    """Flags and dependency of a precompiled header of tools/build.

    Args:
      headers: its name.
      srcs: sources that it is for; without C++ among them, there is none.
    """
    if srcs != None and not [src for src in srcs if src.endswith(".cc")]:
        return struct(copts = [], deps = [])
    return struct(
        copts = select({
            "//tools/build:precompiled": [
                "-include-pch",
                "$(BINDIR)/tools/build/%s.pch" % headers,
            ],
            "//conditions:default": [],
        }),
        deps = select({
            "//tools/build:precompiled": ["//tools/build:" + headers],
            "//conditions:default": [],
        }),
    )

def _headers_of(deps):
    """The precompiled header for sources of these dependencies."""
    return "command_headers" if "@system//:cli11" in deps else "library_headers"

def sinew_cc_library(name, srcs = [], hdrs = [], deps = [], copts = [], features = [], **kwargs):
    """A library of own code; arguments are cc_library's."""
    precompiled = _precompiled(_headers_of(deps), srcs)
    native.cc_library(
        name = name,
        srcs = srcs,
        hdrs = hdrs,
        copts = _copts(copts) + precompiled.copts,
        features = _FEATURES + features,
        deps = deps + precompiled.deps,
        **kwargs
    )

def sinew_cc_binary(name, srcs = [], deps = [], copts = [], features = [], **kwargs):
    """A program of own code; arguments are cc_binary's."""
    precompiled = _precompiled(_headers_of(deps), srcs)
    native.cc_binary(
        name = name,
        srcs = srcs,
        copts = _copts(copts) + precompiled.copts,
        features = _FEATURES + features,
        deps = deps + precompiled.deps,
        **kwargs
    )

def sinew_cc_test(name, srcs = None, deps = [], data = [], copts = [], features = [], size = "small", main = True, **kwargs):
    """A GoogleTest program; gtest, gmock and their main need no mention.

    Args:
      name: of the test; `<name>.cc` is its source unless srcs says otherwise.
      srcs: sources.
      deps: what is tested.
      data: files that it reads.
      copts: further compiler flags.
      features: further features.
      size: how long it may take; small is a minute.
      main: False for a test with a main of its own.
      **kwargs: cc_test's other arguments.
    """
    precompiled = _precompiled("test_headers")
    native.cc_test(
        name = name,
        size = size,
        srcs = srcs if srcs != None else [name + ".cc"],
        copts = _copts(TEST_COPTS + copts) + precompiled.copts,
        # Read by --config=asan and --config=tsan through their *_OPTIONS.
        data = data + ["//tools/build:suppressions"],
        features = _FEATURES + features,
        linkstatic = True,
        deps = deps + ["@system//:gmock", "@system//:gtest"] +
               (["@system//:gtest_main"] if main else []) + precompiled.deps,
        **kwargs
    )

# The code under test and the fuzzer's own: coverage of edges, heap and stack
# errors.
_FUZZ_COPTS = [
    "-fsanitize=fuzzer-no-link,address",
    "-fno-omit-frame-pointer",
    "-g1",
]

def sinew_cc_fuzz_test(name, code, deps, srcs = None, seeds = [], data = [], runs = 20000, max_len = 8192, seconds = 6, tags = [], **kwargs):
    """A decoder under libFuzzer, bounded: an ordinary test of a few seconds.

    The code under test is compiled again, for coverage and address errors, so
    it comes as sources; its deps are linked as they are. Inputs start from the
    seeds and, where SINEW_DATA is set, from real files below it; larger ones
    are cut to max_len. Runs are the same each time (fixed seed) unless the
    machine is too slow for them. The program itself is `<name>_fuzzer`, for
    longer runs by hand:

        bazel run //PACKAGE:NAME_fuzzer -- -max_total_time=600 /tmp/corpus

    Args:
      name: of the test; `<name>.cc`, with LLVMFuzzerTestOneInput, is its source
        unless srcs says otherwise.
      code: sources and headers of the code under test: files of this package
        or filegroups of others.
      deps: what code and srcs need besides.
      srcs: sources with LLVMFuzzerTestOneInput.
      seeds: small files in the tree to start from, at least one.
      data: names of real files below SINEW_DATA, as find's -path takes them,
        e.g. ["motions/*.bvh"].
      runs: inputs to try, seeds included.
      max_len: bytes of the longest input.
      seconds: no new input is tried after that.
      tags: of both targets.
      **kwargs: sh_test's other arguments.
    """

    # Two sanitizers do not fit into one program.
    tags = tags + ["no_tsan"]
    native.cc_binary(
        name = name + "_fuzzer",
        testonly = True,
        srcs = (srcs if srcs != None else [name + ".cc"]) + code,
        copts = _copts(_FUZZ_COPTS),
        features = _FEATURES,
        linkopts = [
            "-fsanitize=fuzzer,address",
            "-fsanitize-link-c++-runtime",
        ],
        linkstatic = True,
        tags = tags,
        deps = deps,
    )
    native.sh_test(
        name = name,
        size = "small",
        srcs = ["//tools/build:fuzz_test.sh"],
        args = [
            "$(rootpath :%s_fuzzer)" % name,
            str(runs),
            str(max_len),
            str(seconds),
        ] + ["$(rootpaths %s)" % seed for seed in seeds] + ["--"] +
               ["'%s'" % pattern for pattern in data],
        data = [":%s_fuzzer" % name] + seeds,
        tags = tags,
        **kwargs
    )

def sinew_page_files(name, files, namespace, **kwargs):
    """A page's files as string constants of a header, `<name>.h`.

    Args:
      name: of the library.
      files: names of the constants to labels of the files.
      namespace: that the constants are in.
      **kwargs: cc_library's other arguments.
    """
    header = name + ".h"
    guard = "SINEW_%s_%s_H_" % (
        native.package_name().upper().replace("/", "_"),
        name.upper(),
    )
    lines = [
        "echo '#ifndef %s'" % guard,
        "echo '#define %s'" % guard,
        "echo 'namespace %s {'" % namespace,
    ]
    for constant, label in files.items():
        lines += [
            "echo 'inline constexpr char %s[] = R\"page_file('" % constant,
            "cat $(execpath %s)" % label,
            "echo ')page_file\";'",
        ]
    lines += [
        "echo '}  // namespace %s'" % namespace,
        "echo '#endif'",
    ]
    native.genrule(
        name = name + "_gen",
        srcs = files.values(),
        outs = [header],
        cmd = "{\n" + "\n".join(lines) + "\n} > $@",
    )
    native.cc_library(
        name = name,
        hdrs = [header],
        **kwargs
    )

def _schema(label):
    """The label of a proto library's .proto files, its deps' included."""
    if ":" in label:
        return label + "_schema"
    return label + ":" + label.split("/")[-1] + "_schema"

def sinew_proto_library(name, srcs, deps = [], grpc = False, visibility = None, **kwargs):
    """C++ of .proto files, by Debian's protoc.

    Imports and includes are relative to the workspace: "proto/sinew/v1/x.proto"
    becomes "proto/sinew/v1/x.pb.h" (and "x.grpc.pb.h" with grpc). The .proto
    files themselves, with those of deps, are `<name>_schema`.

    Args:
      name: of the cc_library.
      srcs: .proto files of this package.
      deps: other sinew_proto_library targets that srcs import.
      grpc: whether srcs define services.
      visibility: of all the targets.
      **kwargs: cc_library's other arguments.
    """
    testonly = kwargs.get("testonly", False)
    native.filegroup(
        name = name + "_schema",
        testonly = testonly,
        srcs = srcs + [_schema(dep) for dep in deps],
        visibility = visibility,
    )
    stems = [src[:-len(".proto")] for src in srcs]
    hdrs = [stem + ".pb.h" for stem in stems]
    ccs = [stem + ".pb.cc" for stem in stems]
    plugin = ""
    if grpc:
        hdrs += [stem + ".grpc.pb.h" for stem in stems]
        ccs += [stem + ".grpc.pb.cc" for stem in stems]
        plugin = ("--plugin=protoc-gen-grpc=/usr/bin/grpc_cpp_plugin " +
                  "--grpc_out=$(GENDIR) ")
    native.genrule(
        name = name + "_gen",
        testonly = testonly,
        srcs = srcs + [name + "_schema"],
        outs = hdrs + ccs,
        cmd = "/usr/bin/protoc -I. -I/usr/include --cpp_out=$(GENDIR) " +
              plugin + " ".join(["$(execpath %s)" % src for src in srcs]),
        message = "Generating C++ of",
        visibility = ["//visibility:private"],
    )
    native.cc_library(
        name = name,
        srcs = ccs,
        hdrs = hdrs,
        copts = ["-w"],
        # A dependency on generated code brings its libraries along.
        deps = deps + ["@system//:protobuf"] +
               (["@system//:grpc"] if grpc else []),
        visibility = visibility,
        **kwargs
    )
