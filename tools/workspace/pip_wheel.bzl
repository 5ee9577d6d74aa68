"""A repository made of files out of pinned Python wheels."""

# Wheels name the oldest glibc that they run on; pip wants each tag spelt out.
_PLATFORMS = [
    "manylinux_2_28_x86_64",
    "manylinux_2_27_x86_64",
    "manylinux_2_25_x86_64",
    "manylinux_2_24_x86_64",
    "manylinux_2_18_x86_64",
    "manylinux_2_17_x86_64",
    "manylinux2014_x86_64",
    "manylinux2010_x86_64",
    "manylinux1_x86_64",
    "any",
]

def _pip_wheel_impl(ctx):
    cuda = ctx.os.environ.get("SINEW_TORCH", "cpu") == "cuda"
    wheels = dict(ctx.attr.wheels)
    include = list(ctx.attr.include)
    exclude = list(ctx.attr.exclude)
    if cuda and ctx.attr.cuda_wheels:
        wheels.update(ctx.attr.cuda_wheels)
        include += ctx.attr.cuda_include
    spec = struct(
        exclude = exclude,
        include = include,
        out = str(ctx.path(".")),
        platforms = _PLATFORMS,
        python = ctx.attr.python_version,
        wheels = wheels,
    )
    python = ctx.which("python3")
    if not python:
        fail("pip_wheel: no python3; apt-get install python3 python3-pip")
    result = ctx.execute(
        [python, ctx.path(Label("//tools/workspace:wheels.py")), spec.to_json()],
        timeout = 3600,
    )
    if result.return_code != 0:
        fail("@%s: %s" % (ctx.name, result.stderr or result.stdout))
    linkopts = ctx.attr.linkopts
    if cuda and ctx.attr.cuda_linkopts:
        linkopts = ctx.attr.cuda_linkopts
    ctx.template(
        "BUILD.bazel",
        ctx.attr.build_file,
        # Binaries find the libraries where they were unpacked: no copy of half
        # a gigabyte, and the wheels' own RPATHs stay right.
        substitutions = {
            "{LINKOPTS}": repr([o.replace("{ROOT}", str(ctx.path("."))) for o in linkopts]),
        },
        executable = False,
    )

pip_wheel = repository_rule(
    implementation = _pip_wheel_impl,
    attrs = {
        "build_file": attr.label(
            mandatory = True,
            doc = "BUILD file; {LINKOPTS} in it becomes the list of linkopts",
        ),
        "cuda_include": attr.string_list(
            doc = "further patterns where SINEW_TORCH=cuda",
        ),
        "cuda_linkopts": attr.string_list(
            doc = "linkopts where SINEW_TORCH=cuda",
        ),
        "cuda_wheels": attr.string_dict(
            doc = "further wheels where SINEW_TORCH=cuda",
        ),
        "exclude": attr.string_list(doc = "patterns of files left out"),
        "include": attr.string_list(
            default = ["*"],
            doc = "patterns of the files to unpack; * crosses folders",
        ),
        "linkopts": attr.string_list(
            doc = "how to link; {ROOT} is this repository's absolute path",
        ),
        "python_version": attr.string(
            default = "3.11",
            doc = "of the wheels, independent of the Python that fetches them",
        ),
        "wheels": attr.string_dict(
            mandatory = True,
            doc = "name==version to SHA-256",
        ),
    },
    environ = ["SINEW_TORCH"],
)
