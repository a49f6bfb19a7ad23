#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check.sh MESSAGE LINK-COMMAND...: the link must fail and say MESSAGE; MESSAGE "links": it must succeed.
set -u
message=$1
shift
output=$("$@" 2>&1)
status=$?
if [ "$message" = links ]; then
  [ $status -eq 0 ] || { printf 'must link, but:\n%s\n' "$output"; exit 1; }
  exit 0
fi
[ $status -ne 0 ] || { echo "linked, but must fail with: $message"; exit 1; }
case $output in
  *"$message"*) echo "refused as it must be: $message" ;;
  *) printf 'failed without "%s":\n%s\n' "$message" "$output"; exit 1 ;;
esac
