"""Fetches pinned wheels with pip and unpacks chosen files of them.

Called by pip_wheel.bzl with one JSON argument:
  wheels:   {"name==version": "sha256", ...}
  include:  shell patterns of the files to unpack; "*" crosses folders
  exclude:  patterns of files left out although included
  python, platforms: tags the wheels were built for, whatever runs this script
  out:      folder to unpack into
"""

import fnmatch
import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile


def fail(message):
    sys.exit("pip_wheel: " + message)


def download(spec, folder):
    """Downloads all wheels; pip itself compares each with its hash."""
    lock = folder / "requirements.txt"
    lock.write_text("".join(f"{name} --hash=sha256:{digest}\n"
                            for name, digest in spec["wheels"].items()))
    command = [sys.executable, "-m", "pip", "download", "--quiet",
               "--disable-pip-version-check", "--no-deps", "--require-hashes",
               "--only-binary=:all:", "--implementation=cp",
               "--python-version=" + spec["python"],
               "--abi=cp" + spec["python"].replace(".", ""), "--abi=abi3",
               "--abi=none", "--dest", str(folder), "-r", str(lock)]
    command += ["--platform=" + tag for tag in spec["platforms"]]
    try:
        result = subprocess.run(command, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True)
    except OSError as error:
        fail(f"cannot run {command[0]}: {error}")
    if result.returncode == 0:
        return
    hint = "is the network, or the index that pip is set up for, reachable?"
    if "No module named pip" in result.stdout:
        hint = "pip is missing: apt-get install python3-pip"
    elif "DO NOT MATCH THE HASHES" in result.stdout:
        hint = "the file on the index is not the one that we pinned"
    fail(f"could not download {', '.join(spec['wheels'])}; {hint}\n"
         f"pip said:\n{result.stdout.strip()}")


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def unpack(wheel, spec):
    """Unpacks the chosen files; returns how many."""
    count = 0
    with zipfile.ZipFile(wheel) as archive:
        for member in archive.namelist():
            if member.endswith("/") or not matches(member, spec["include"]):
                continue
            if matches(member, spec["exclude"]):
                continue
            archive.extract(member, spec["out"])
            count += 1
    return count


def main():
    spec = json.loads(sys.argv[1])
    # Beside the result: /tmp may be small, and torch is not.
    with tempfile.TemporaryDirectory(dir=spec["out"]) as folder:
        download(spec, pathlib.Path(folder))
        for wheel in sorted(pathlib.Path(folder).glob("*.whl")):
            if unpack(wheel, spec) == 0:
                fail(f"{wheel.name}: no file matches {spec['include']}")


if __name__ == "__main__":
    main()
