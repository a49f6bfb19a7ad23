#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Prints the most expensive streams of a random search, in instructions per byte of parser and decoder, counted by
# callgrind.
# usage: worst_stream.sh WORST_STREAM [STREAMS LIMIT]   exit 1: a stream costs more than LIMIT; 77: valgrind is not
# installed
set -eu
command -v valgrind >/dev/null || { echo "valgrind is not here"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
valgrind --tool=callgrind --combine-dumps=yes --dump-line=no --callgrind-out-file="$folder/out" "$1" "${2:-40}" \
  2>"$folder/log"
awk '/^desc: Trigger: Client Request:/ { split($0, t, ": "); stream = t[4] }
     /^totals:/ { if (stream != "") { split(stream, w, " "); printf "%.2f %s %s\n", $2 / w[3], w[1], w[2] } stream = "" }' \
  "$folder"/out* | sort -rn > "$folder/all"
for family in $(cut -d' ' -f2 "$folder/all" | sort -u); do
  awk -v f="$family" '$2 == f { n++; if (n == 1) printf "%-14s dearest of", f; if (n == 1) { p = $1; s = $3 } }
                      END { printf " %d: %s instructions per byte (seed %s)\n", n, p, s }' "$folder/all"
done
awk -v limit="${3:-1e9}" 'NR == 1 { print "dearest of all: " $1 " (limit " limit ")"; exit !($1 <= limit) }' "$folder/all"
