"""A repository made of files out of pinned npm packages."""

def _npm_package_impl(ctx):
    spec = struct(
        include = ctx.attr.include,
        npm_wheel = ctx.attr.npm_wheel,
        out = str(ctx.path(".")),
        packages = ctx.attr.packages,
    )
    python = ctx.which("python3")
    if not python:
        fail("npm_package: no python3; apt-get install python3 python3-pip")

    # Found here so that a change of either fetches the repository anew.
    script = ctx.path(Label("//tools/workspace:npm.py"))
    ctx.path(Label("//tools/workspace:wheels.py"))
    result = ctx.execute([python, script, spec.to_json()], timeout = 1800)
    if result.return_code != 0:
        fail("@%s: %s" % (ctx.name, result.stderr or result.stdout))
    ctx.symlink(ctx.attr.build_file, "BUILD.bazel")

npm_package = repository_rule(
    implementation = _npm_package_impl,
    attrs = {
        "build_file": attr.label(mandatory = True, doc = "BUILD file"),
        "include": attr.string_list(
            default = ["*"],
            doc = "patterns of the files to unpack; * crosses folders",
        ),
        "npm_wheel": attr.string_dict(
            mandatory = True,
            doc = "wheel with npm for machines that have none: name==version to SHA-256",
        ),
        "packages": attr.string_dict(
            mandatory = True,
            doc = "name@version to the archive's SHA-512, base64 as npm prints it; " +
                  "unpacked into a folder of the package's name without \"@\"",
        ),
    },
    # What npm is, and where it asks, is the machine's business.
    environ = ["PATH"],
)
