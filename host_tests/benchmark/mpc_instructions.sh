#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Prints the instructions of one solve of one axis (x86-64, callgrind).
# Usage: mpc_instructions.sh PROGRAM flight|setpoint|cold double|float [FILE]
set -e
program=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
valgrind --tool=callgrind --combine-dumps=yes --dump-line=no --callgrind-out-file="$folder/out" "$program" "$@" 2>"$folder/log"
awk '
  /^desc: Trigger: Client Request:/ { split($0, t, ": "); split(t[4], w, / +/); path = w[1] }
  /^totals:/ { if (path != "") { n[path]++; v[path, n[path]] = $2; all[++m] = $2; if (changes > most) most = changes } path = "" }
  function sorted(count, from,   i, j, gap, x) {
    for (gap = int(count / 2); gap > 0; gap = int(gap / 2))
      for (i = gap + 1; i <= count; i++) {
        x = from[i]
        for (j = i; j > gap && from[j - gap] > x; j -= gap) from[j] = from[j - gap]
        from[j] = x
      }
  }
  function show(label, count, from) {
    sorted(count, from)
    late = int(count * 0.99 + 1)
    late = (late < count) ? late : count
    printf "%-12s %6d solves  median %6d  p99 %6d  worst %6d\n", label, count, from[int((count + 1) / 2)], from[late], from[count]
  }
  END {
    for (p in n) { for (i = 1; i <= n[p]; i++) one[i] = v[p, i]; show(p, n[p], one) }
    show("all", m, all)
  }' "$folder"/out*
