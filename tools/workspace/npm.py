"""Fetches pinned npm packages and unpacks chosen files of them.

Called by npm_package.bzl with one JSON argument:
  packages:  {"name@version": "base64 of the archive's SHA-512", ...}
  include:   shell patterns of the files to unpack; "*" crosses folders
  npm_wheel: {"name==version": "sha256"} with npm, where the machine has none
  out:       folder to unpack into, each package in a folder of its name
             (without "@")
"""

import base64
import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile

import wheels


def fail(message):
    sys.exit("npm_package: " + message)


def wheel_npm(spec, folder):
    """npm out of a wheel, as a command."""
    wheels.download({"wheels": spec["npm_wheel"], "python": "3.11",
                     "platforms": ["manylinux_2_28_x86_64", "any"]}, folder)
    for wheel in folder.glob("*.whl"):
        wheels.unpack(wheel, {"include": ["*/bin/node", "*/node_modules/npm/*"],
                              "exclude": [], "out": str(folder)})
    node = next(folder.glob("*/bin/node"), None)
    npm = next(folder.glob("*/lib/node_modules/npm/bin/npm-cli.js"), None)
    if node is None or npm is None:
        fail(f"{', '.join(spec['npm_wheel'])}: expected node and npm in it")
    node.chmod(0o755)
    return [str(node), str(npm)]


def pack(npm, package, folder):
    """The package's archive, fetched."""
    command = npm + ["pack", package, "--silent", "--ignore-scripts",
                     "--cache", str(folder / "cache")]
    try:
        # The folder has no package.json: npm's own settings alone count.
        result = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, timeout=900)
    except (OSError, subprocess.TimeoutExpired) as error:
        fail(f"cannot run {command[0]}: {error}")
    if result.returncode != 0:
        fail(f"could not fetch {package}; is the network, or the registry that "
             f"npm is set up for, reachable?\nnpm said:\n"
             f"{(result.stderr or result.stdout).strip()}")
    return folder / result.stdout.strip().splitlines()[-1]


def check(archive, package, expected):
    digest = hashlib.sha512(archive.read_bytes()).digest()
    found = base64.b64encode(digest).decode()
    if found != expected:
        fail(f"{package}: expected SHA-512 {expected}, found {found}: the file "
             "in the registry is not the one that we pinned")


def unpack(archive, package, spec):
    """Unpacks the chosen files, whose paths begin with "package/"."""
    # "@" begins the name of a repository in labels.
    name = package.rpartition("@")[0].lstrip("@")
    target = pathlib.Path(spec["out"]) / name
    count = 0
    with tarfile.open(archive) as files:
        for member in files:
            name = member.name.partition("/")[2]
            if not member.isfile() or ".." in pathlib.Path(name).parts:
                continue
            if not wheels.matches(name, spec["include"]):
                continue
            path = target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(files.extractfile(member).read())
            path.chmod(0o755 if member.mode & 0o100 else 0o644)
            count += 1
    if count == 0:
        fail(f"{package}: no file matches {spec['include']}")


def main():
    spec = json.loads(sys.argv[1])
    with tempfile.TemporaryDirectory(dir=spec["out"]) as name:
        folder = pathlib.Path(name)
        found = shutil.which("npm") and shutil.which("node")
        npm = [shutil.which("npm")] if found else wheel_npm(spec, folder)
        for package, digest in spec["packages"].items():
            archive = pack(npm, package, folder)
            check(archive, package, digest)
            unpack(archive, package, spec)


if __name__ == "__main__":
    main()
