#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Counts the instructions per received byte in parser and telemetry decoder, with callgrind.
# usage: instructions.sh BENCHMARK_PROTOCOL   exit 1: a stream exceeds its limit; 77: valgrind is not installed
set -u
command -v valgrind >/dev/null || { echo "valgrind is not here"; exit 77; }
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT
result=0
# Each stream with its limit: the published figure plus 15 % for another compiler.
while read -r stream limit; do
  line=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='*receive*' "$1" --once "$stream" \
         2> "$counts")
  instructions=$(sed -n 's/.*Collected : *\([0-9]*\).*/\1/p' "$counts")
  bytes=$(sed -n 's/.*: \([0-9]*\) bytes.*/\1/p' <<< "$line")
  per_byte=$(awk -v i="$instructions" -v b="$bytes" 'BEGIN { printf "%.2f", i / b }')
  printf '%-30s %8s instructions per byte (limit %s)\n' "$stream" "$per_byte" "$limit"
  awk -v p="$per_byte" -v l="$limit" 'BEGIN { exit !(p <= l) }' || result=1
done <<'STREAMS'
clean_142_byte_frames 8.5
random_bytes 3.5
runs_of_start_bytes 30.2
headers_of_1023 14.1
densest_headers 107.8
frames_behind_false_headers 9.0
STREAMS
exit $result
