#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks that a program that ships does not depend on the folder in which it was built: the folder's name occurs nowhere
# in it, not even in debug information. A copy with the name added proves that the search finds it.
# Usage: holds_no_path.sh FOLDER PROGRAM...
set -euo pipefail
folder=$1
shift
planted=$(mktemp)
trap 'rm -f "$planted"' EXIT
failed=0
for program in "$@"; do
  if grep -aqF "$folder/" "$program"; then
    echo "$program contains the path of the checkout:"
    strings -a "$program" | grep -F "$folder/" | sort -u | head -n 20 || true
    failed=1
  fi
  { cat "$program"; printf '%s/firmware' "$folder"; } >"$planted"
  grep -aqF "$folder/" "$planted" || { echo "self-test: the search misses the path in a copy that contains it" && failed=1; }
done
exit $failed
