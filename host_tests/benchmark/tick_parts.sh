#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Prints the instructions of each part of a tick (x86-64, callgrind): median and worst of 1000 ticks without the first.
# A tick is counted from its beginning to the beginning of the next, so some ten instructions of the loop around it are
# included.
#   host_tests/benchmark/tick_parts.sh build/host-release/host_tests/property/tick_cost
set -e
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for run in 'axis double' 'axis float' 'axis fixed' 'ekf double' 'ekf float' 'ekf fixed' 'law double' 'law float' \
  'window double' 'window float' 'sticks float'; do
  rm -f "$folder"/*
  # shellcheck disable=SC2086
  valgrind --tool=callgrind --combine-dumps=yes --dump-line=no --dump-before='*one_tick*' \
    --callgrind-out-file="$folder/out" "$program" $run >/dev/null 2>"$folder/log"
  awk -v run="$run" '
    /^desc: Trigger: --dump-before/ { wanted = 1 }
    /^totals:/ { if (wanted && ticks++ > 1) print $2; wanted = 0 }' "$folder"/out* | sort -n |
    awk -v run="$run" '{ v[NR] = $1 } END { printf "%-14s %5d ticks  median %6d  worst %6d\n", run, NR, v[int((NR + 1) / 2)], v[NR] }'
done
