#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks that install_packages waits while another apt holds the locks, continues when they are free, and finally gives
# up. Here apt-get, dpkg-query, sudo and sleep are scripts that record their arguments.
# Usage: install_packages_waits.sh FOLDER_OF_THE_PROJECT
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
script() { # NAME, TEXT
  printf '#!/bin/sh\n%s\n' "$2" >"$work/bin/$1"
  chmod +x "$work/bin/$1"
}
script dpkg-query 'exit 1'
script sudo 'exec "$@"'
script sleep "echo slept >>$work/asked"
script apt-get "echo \"\$*\" >>$work/asked
left=\$(cat $work/refusals)
[ \"\$left\" -gt 0 ] || exit 0
echo \$((left - 1)) >$work/refusals
echo 'E: Could not get lock /var/lib/apt/lists/lock. It is held by process 4711 (apt-get)' >&2
exit 100"

run() { # REFUSALS
  : >"$work/asked"
  echo "$1" >"$work/refusals"
  PATH="$work/bin:$PATH" "$project/host_tests/install_packages" tests >"$work/said" 2>&1
}
project=$1
fail() { echo "$1"; cat "$work/asked" "$work/said"; exit 1; }
run 3 || fail 'it gave up after three failures of apt-get'
[ "$(grep -c slept "$work/asked")" = 3 ] || fail 'it did not wait between its attempts'
[ "$(grep -c ' update' "$work/asked")" = 4 ] || fail 'apt-get update was not repeated until it succeeded'
[ "$(grep -c ' install -y' "$work/asked")" = 1 ] || fail 'packages were not installed once'
grep -q 'DPkg::Lock::Timeout' "$work/asked" || fail 'it does not wait for the lock of dpkg'
! run 1000 || fail 'it reports success although nothing was installed'
