#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A program that ships is the same from whatever folder it was built in: the folder's name stands nowhere in it, debug
# information included. That the search finds such a name is shown on a copy with the name put into it.
# Usage: holds_no_path.sh FOLDER PROGRAM...
set -euo pipefail
folder=$1
shift
planted=$(mktemp)
trap 'rm -f "$planted"' EXIT
failed=0
for program in "$@"; do
  if grep -aqF "$folder/" "$program"; then
    echo "$program holds the path of the checkout:"
    strings -a "$program" | grep -F "$folder/" | sort -u | head -n 20 || true
    failed=1
  fi
  { cat "$program"; printf '%s/firmware' "$folder"; } >"$planted"
  grep -aqF "$folder/" "$planted" || { echo "the search finds nothing in a copy that holds it" && failed=1; }
done
exit $failed
