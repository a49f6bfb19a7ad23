#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks authority.pml with Spin. Usage: check.sh PROMELA SCRATCH WHAT
#   --sound    checks the tables that fly, on both command channels: no promise may be broken
#   --planted  checks tables with one wrong row each: every one has to break a promise
#   NAME       the same for this planted row only
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
promela=$(realpath "$1")
what=$3
mkdir -p "$2" && cd "$2"

# verify CHANNEL(1: Virtual RC, 0: movement) [generator's options]: prints Spin's count of states; returns 0 if correct.
verify() {
  local channel=$1
  shift
  "$promela" "$@" >tables.pml
  cp "$here/authority.pml" .
  spin -DVIRTUAL_RC="$channel" -a authority.pml >spin.txt || { cat spin.txt; exit 2; }
  ${CC:-cc} -O2 -w -DSAFETY -DNOFAIR -DNOREDUCE -DMEMLIM=2000 -o pan pan.c
  ./pan -m500000 -w24 >pan.txt 2>&1
  if grep -q 'max search depth too small\|out of memory\|Search not completed' pan.txt && ! grep -q 'errors: [1-9]' pan.txt; then
    cat pan.txt
    exit 2
  fi
  sed -n 's/^ *\([0-9.e+]*\) states, stored.*/\1 states/p' pan.txt
  grep -q 'errors: 0' pan.txt
}

failed=0
if [ "$what" = --sound ]; then
  for channel in 1 0; do
    if ! verify "$channel"; then
      echo "Virtual RC $channel: a promise is broken:"
      grep 'assertion violated' pan.txt || cat pan.txt
      spin -DVIRTUAL_RC="$channel" -t -p -g authority.pml >trail.txt 2>&1 || true
      echo "The steps that lead to it: $PWD/trail.txt"
      failed=1
    fi
  done
  exit $failed
fi
plants=$("$promela" --list)
[ "$what" = --planted ] || plants=$what
for plant in $plants; do
  found=
  for channel in 1 0; do
    verify "$channel" --plant "$plant" >/dev/null || found=$(sed -n 's/.*assertion violated \(.*\) (at.*/\1/p' pan.txt)
    [ -z "$found" ] || break
  done
  echo "planted $plant: ${found:-NOT FOUND}"
  [ -n "$found" ] || failed=1
done
exit $failed
