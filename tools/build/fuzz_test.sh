#!/bin/bash
# Runs a libFuzzer program as a test (sinew_cc_fuzz_test in sinew.bzl):
#
#   fuzz_test.sh FUZZER RUNS MAX_LEN SECONDS SEED... -- PATTERN...
#
# Inputs start from the seeds and from the smallest files below $SINEW_DATA
# whose paths match a pattern, cut to MAX_LEN. An input that fails is left in
# the test's outputs and printed in base64.
set -eu

fuzzer=$1 runs=$2 max_len=$3 seconds=$4
shift 4
max_real_files=100

corpus=$(mktemp -d "${TEST_TMPDIR:-/tmp}/corpus.XXXXXX")
real=$corpus/real
mkdir "$real"

seeds=0
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  cp "$1" "$corpus/seed$seeds"
  seeds=$((seeds + 1))
  shift
done
if [ "$seeds" = 0 ]; then
  echo "expected at least one seed, found none" >&2
  exit 2
fi
shift

if [ -z "${SINEW_DATA:-}" ]; then
  echo "SINEW_DATA is unset: no real files among the inputs"
else
  count=0
  for pattern in "$@"; do
    while IFS= read -r -d '' entry; do
      head -c "$max_len" "${entry#* }" > "$real/$count"
      count=$((count + 1))
    done < <(find -L "$SINEW_DATA" -type f -path "$SINEW_DATA/$pattern" \
                  -printf '%s %p\0' | sort -z -n | head -z -n "$max_real_files")
  done
  echo "$count real files among the inputs"
  if [ "$count" = 0 ] && [ $# -gt 0 ]; then
    echo "expected files like $* in $SINEW_DATA, found none" >&2
    exit 2
  fi
fi

# What crosses into Debian's uninstrumented libraries would be reported as
# overflowing containers.
export ASAN_OPTIONS=detect_container_overflow=0
exec "$fuzzer" -seed=1 -runs="$runs" -max_len="$max_len" \
  -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 \
  -print_final_stats=1 -verbosity=1 \
  -artifact_prefix="${TEST_UNDECLARED_OUTPUTS_DIR:-.}/" "$corpus" "$real"
