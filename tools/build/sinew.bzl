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

def sinew_cc_library(name, srcs = [], hdrs = [], deps = [], copts = [], features = [], **kwargs):
    """A library of own code; arguments are cc_library's."""
    native.cc_library(
        name = name,
        srcs = srcs,
        hdrs = hdrs,
        copts = _copts(copts),
        features = _FEATURES + features,
        deps = deps,
        **kwargs
    )

def sinew_cc_binary(name, srcs = [], deps = [], copts = [], features = [], **kwargs):
    """A program of own code; arguments are cc_binary's."""
    native.cc_binary(
        name = name,
        srcs = srcs,
        copts = _copts(copts),
        features = _FEATURES + features,
        deps = deps,
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
    native.cc_test(
        name = name,
        size = size,
        srcs = srcs if srcs != None else [name + ".cc"],
        copts = _copts(copts),
        # Read by --config=asan and --config=tsan through their *_OPTIONS.
        data = data + ["//tools/build:suppressions"],
        features = _FEATURES + features,
        linkstatic = True,
        deps = deps + ["@system//:gmock", "@system//:gtest"] +
               (["@system//:gtest_main"] if main else []),
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
