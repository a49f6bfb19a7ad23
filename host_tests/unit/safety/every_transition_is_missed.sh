#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A test of the tests: switches off every row of both safety tables, one after the other; the tests have to fail each
# time.
# Usage: every_transition_is_missed.sh PROGRAM   (unit_safety_transitions)
# Prints each row without which no test fails, and "rows: MISSED of ALL". Exit 1 if there is such a row.
set -euo pipefail
program=$1

"$program" --gtest_brief=1 >/dev/null || { echo "The tests fail with every row in place."; exit 1; }
# An unknown row must be refused; otherwise the loop below would count a usage error as a test that failed.
[ "$("$program" --without=failsafe:1000 2>/dev/null; echo $?)" = 2 ] || { echo "Row failsafe:1000 is accepted."; exit 1; }
all=0 missed=0
while read -r row what; do
  all=$((all + 1))
  status=0
  "$program" --gtest_brief=1 --gtest_fail_fast --without="$row" >/dev/null 2>&1 || status=$?
  if [ "$status" = 1 ]; then
    missed=$((missed + 1))
  else
    echo "No test misses row $row ($what); exit code $status."
  fi
done < <("$program" --rows)
echo "rows: $missed of $all"
[ "$all" -gt 0 ] && [ "$missed" = "$all" ]
