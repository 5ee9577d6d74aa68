"""The source tree as the checks see it."""

import os

# Folders that hold no sources of ours.
_SKIPPED = {".git", "runs", "external", "node_modules", "__pycache__"}


def files(root):
    """Paths of all source files, relative to root, sorted."""
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(
            name for name in folders
            if name not in _SKIPPED and not name.startswith("bazel-") and
            not os.path.islink(os.path.join(folder, name)))
        for name in names:
            path = os.path.join(folder, name)
            if os.path.isfile(path) and not os.path.islink(path):
                found.append(os.path.relpath(path, root))
    return sorted(found)


def read(root, path):
    """Text of a file."""
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()
