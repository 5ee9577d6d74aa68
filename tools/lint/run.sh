#!/bin/bash
# Runs a check on the source tree: run.sh SCRIPT [ARGUMENT...]
# The tree is where the runfile BUILD.bazel really lies.
set -euo pipefail
script="$1"
shift
exec python3 -I -B -c '
import os, runpy, sys
folder, script = sys.argv[1:3]
sys.path.insert(0, folder)
sys.argv = [script] + sys.argv[3:]
runpy.run_path(os.path.join(folder, script), run_name="__main__")
' "$(dirname "$(readlink -f "tools/lint/${script}")")" "${script}" \
  $([[ "${script}" == lint_test.py ]] ||
    dirname "$(readlink -f BUILD.bazel)") "$@"
