# SPDX-License-Identifier: BSD-3-Clause
# Sourced by run_tests and arm_tests. `stage TITLE` names what follows; `run COMMAND...` runs it: a failure is noted and the
# following stages still run. `finish` prints what failed in all and the counts of every ctest summary, and returns 1 if
# anything failed. A stage whose build failed does not run its tests: write `run build && run test`.
M100_STAGE=
M100_SUMMARIES=$(mktemp)
M100_FAILURES=$(mktemp)
trap 'rm -f "$M100_SUMMARIES" "$M100_FAILURES"' EXIT

stage() {
  M100_STAGE=$1
  printf '\n=== %s (%s s)\n' "$1" "$SECONDS"
}

run() {
  local output status=0
  output=$(mktemp)
  "$@" 2>&1 | tee "$output" || status=${PIPESTATUS[0]}
  if [ "$1" = ctest ]; then
    grep -E '^[0-9]+% tests passed' "$output" >>"$M100_SUMMARIES" || true
  fi
  if [ "$status" != 0 ]; then
    # ctest lists its failed tests as "  12 - name (Failed)"; of anything else the command itself is named.
    grep -E '^[[:space:]]+[0-9]+ - .*\((Failed|Timeout|Not Run|SEGFAULT|Subprocess aborted|ILLEGAL|NUMERICAL)' "$output" |
      sed "s|^[[:space:]]*|$M100_STAGE: |" >>"$M100_FAILURES" || echo "$M100_STAGE: $* (exit $status)" >>"$M100_FAILURES"
  fi
  rm -f "$output"
  return "$status"
}

finish() {
  local passed failed
  passed=$(sed -E 's/.*, ([0-9]+) tests? failed out of ([0-9]+)/\2 \1/' "$M100_SUMMARIES" | awk '{sum += $1 - $2} END {print sum + 0}')
  failed=$(wc -l <"$M100_FAILURES")  # tests, and commands that failed as a whole
  if [ -s "$M100_FAILURES" ]; then
    printf '\nFailed:\n'
    sed 's/^/  /' "$M100_FAILURES"
  fi
  printf '\n%s passed, %s failed\n' "$passed" "$failed"
  [ ! -s "$M100_FAILURES" ]
}
