"""Headers of other projects, parsed once per build instead of once per source.

More than half of the time of compiling a source of this tree went into reading
the standard library, abseil, protobuf and the like. A `precompiled_header`
holds what the compiler knows after reading such headers; the macros of
sinew.bzl hand it to each source (`-include-pch`). Sources still include what
they use: `--config=lint` builds without, and says what is missing.
"""

load("@bazel_tools//tools/build_defs/cc:action_names.bzl", "CPP_COMPILE_ACTION_NAME")
load("@bazel_tools//tools/cpp:toolchain_utils.bzl", "find_cpp_toolchain")

def _precompiled_header_impl(ctx):
    toolchain = find_cpp_toolchain(ctx)
    features = cc_common.configure_features(
        ctx = ctx,
        cc_toolchain = toolchain,
        requested_features = ctx.features,
        unsupported_features = ctx.disabled_features,
    )
    output = ctx.actions.declare_file(ctx.label.name + ".pch")

    # The flags that sources of this configuration get, sanitizers' and
    # layering_check's included: the compiler refuses the header where they differ.
    variables = cc_common.create_compile_variables(
        feature_configuration = features,
        cc_toolchain = toolchain,
        user_compile_flags = ctx.fragments.cpp.copts + ctx.fragments.cpp.cxxopts +
                             ["-fmodules-strict-decluse"] + ctx.attr.copts,
        use_pic = True,
    )
    flags = cc_common.get_memory_inefficient_command_line(
        feature_configuration = features,
        action_name = CPP_COMPILE_ACTION_NAME,
        variables = variables,
    ) + [
        # Templates once here, not in each source.
        "-fpch-instantiate-templates",
        # Other projects' warnings are theirs.
        "-w",
        # The same headers installed anew are the same headers.
        "-Xclang",
        "-fno-pch-timestamp",
    ]
    compiler = cc_common.get_tool_for_action(
        feature_configuration = features,
        action_name = CPP_COMPILE_ACTION_NAME,
    )

    # A header read from a file would be looked for in this action's sandbox ever
    # after; from a pipe, in no particular folder, it is the same bytes everywhere.
    # What it includes lies outside the tree.
    ctx.actions.run_shell(
        command = 'output="$1" compiler="$2" count="$3"; shift 3; ' +
                  'cat "${@:1:count}" | ' +
                  '(cd / && "${compiler}" -x c++-header "${@:count+1}" - -o -) ' +
                  '> "${output}"',
        arguments = [output.path, compiler, str(len(ctx.files.srcs))] +
                    [src.path for src in ctx.files.srcs] + flags,
        inputs = depset(
            ctx.files.srcs + [ctx.file._packages],
            transitive = [toolchain.all_files],
        ),
        outputs = [output],
        use_default_shell_env = True,
        mnemonic = "CppPrecompile",
        progress_message = "Precompiling " + ctx.label.name,
    )

    # As a header of those that depend on it, it is there when they compile.
    return [
        DefaultInfo(files = depset([output])),
        CcInfo(compilation_context = cc_common.create_compilation_context(
            headers = depset([output]),
        )),
    ]

precompiled_header = rule(
    implementation = _precompiled_header_impl,
    attrs = {
        "srcs": attr.label_list(
            mandatory = True,
            allow_files = [".h"],
            doc = "Headers, one after the other, that include what is to be " +
                  "precompiled; nothing of the tree.",
        ),
        "copts": attr.string_list(
            doc = "As those of the sources that it is for.",
        ),
        "_packages": attr.label(
            default = Label("@system//:packages.txt"),
            allow_single_file = True,
            doc = "Other versions of packages are other headers.",
        ),
        "_cc_toolchain": attr.label(
            default = Label("@bazel_tools//tools/cpp:current_cc_toolchain"),
        ),
    },
    fragments = ["cpp"],
    toolchains = ["@bazel_tools//tools/cpp:toolchain_type"],
    incompatible_use_toolchain_transition = True,
)
