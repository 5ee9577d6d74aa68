#!/bin/bash
# Formats our C++ sources in place: tools/lint/format.sh [FILE...]
# Needs clang-format-19 (Debian, 0.1 MB beside clang-19); no other version, for
# each breaks lines its own way. Without files: all of the tree.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if [[ $# -gt 0 ]]; then
  exec clang-format-19 -i "$@"
fi
git ls-files -z '*.h' '*.cc' | xargs -0 clang-format-19 -i
