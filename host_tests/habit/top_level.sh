#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks that the top level holds only the folders and files that the README names. Usage: top_level.sh ROOT
set -eu
cd "$1"
odd=$(git ls-files 2>/dev/null | cut -d/ -f1 | sort -u |
  grep -vxE 'firmware|hal|protocol|host_tests|linker|CMakeLists\.txt|README\.md|CMakePresets\.json|LICENSE|\..*' || true)
[ -z "$odd" ] || { echo "does not belong to the top level: $odd"; exit 1; }
