"""Rules of style that no compiler and no formatter checks.

Usage: text_lint.py ROOT

Of C++, protobuf, Python and shell sources: lines of at most 80 columns (but for
includes, addresses and text that cannot be broken), no tabs, no blanks at the
end of a line, a newline at the end of the file, TODOs with a name, at most 400
lines (tests: 500).
Of C++: include guards named after the path, no code in comments, tests
without sleeps. Python and shell scripts parse.
"""

import ast
import os
import re
import subprocess
import sys

import tree

_MAX_COLUMNS = 80
_MAX_LINES = 400
_MAX_TEST_LINES = 500
# Longer files, and why.
_LONG_FILES = {
    "learner/dispatcher/dispatcher.cc": "one state machine",
}
_CPP = (".h", ".cc")
_CHECKED = _CPP + (".proto", ".py", ".sh")
# A comment at its usual indentation that ends as statements do. Examples in
# comments are indented further.
_CODE = re.compile(
    r"^\s*// ?(?! )(?:return\b.*;|[\w:.>\[\]-]+ ?\(.*\);|"
    r"(?:if|for|while) ?\(.*[{;]|[\w:<>*& ]+ = [^=]*;|#include .*|"
    r"\}(?: else \{)?)$")
_SLEEP = re.compile(r"\b(?:absl::SleepFor|sleep_for|sleep_until|usleep)\b")


def _guard(path):
    return "SINEW_" + re.sub(r"[^A-Z0-9]", "_", path.upper()) + "_"


def _may_be_long(path, line):
    text = line.strip()
    return (text.startswith("#include") or "://" in text or
            path.endswith(".py") and len(text.split()) <= 2 or
            # One string literal or word that no formatter breaks.
            len(text.split()) == 1)


def _line_errors(path, number, line):
    where = f"{path}:{number}"
    if len(line) > _MAX_COLUMNS and not _may_be_long(path, line):
        yield f"{where}: expected {_MAX_COLUMNS} columns, found {len(line)}"
    if "\t" in line:
        yield f"{where}: tab"
    if line != line.rstrip():
        yield f"{where}: blanks at the end of the line"
    if re.search(r"\bTODO\b(?!\([A-Za-z])", line) and \
            not path.startswith("tools/lint/"):
        yield f"{where}: expected TODO(name), found no name"
    if path.endswith(_CPP) and _CODE.match(line):
        yield f"{where}: code in a comment: {line.strip()}"
    if path.endswith("_test.cc") and _SLEEP.search(line):
        yield f"{where}: a test that sleeps"


def _syntax_error(root, path, text):
    if path.endswith(".py"):
        try:
            ast.parse(text, path)
        except SyntaxError as error:
            return f"{path}:{error.lineno}: {error.msg}"
    if path.endswith(".sh") or text.startswith("#!/bin/bash"):
        result = subprocess.run(["bash", "-n", os.path.join(root, path)],
                                capture_output=True, text=True, check=False)
        if result.returncode != 0:
            return result.stderr.strip()
    return None


def file_errors(root, path):
    """All violations of one file."""
    text = tree.read(root, path)
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        yield from _line_errors(path, number, line)
    if text and not text.endswith("\n"):
        yield f"{path}: expected a newline at the end"
    most = _MAX_TEST_LINES if path.endswith("_test.cc") else _MAX_LINES
    if len(lines) > most + 1 and path not in _LONG_FILES:
        yield (f"{path}: expected at most {most} lines, "
               f"found {len(lines) - 1}")
    if path.endswith(".h") and "extern \"C\"" not in text and \
            not path.endswith("c_program.h"):
        guard = _guard(path)
        if f"#ifndef {guard}\n#define {guard}\n" not in text or \
                not text.endswith((f"#endif  // {guard}\n",
                                   f"#endif  /* {guard} */\n")):
            yield f"{path}: expected the include guard {guard}"
    syntax = _syntax_error(root, path, text)
    if syntax:
        yield syntax


def check(root):
    """All violations of a tree, and how many files were read."""
    errors = []
    count = 0
    for path in tree.files(root):
        if path.endswith(_CHECKED) or path in ("sinew", ".ci/run"):
            count += 1
            errors += file_errors(root, path)
    return errors, count


def main(arguments):
    errors, count = check(arguments[0])
    for error in errors:
        print(error, file=sys.stderr)
    print(f"{count} files, {len(errors)} violations")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
