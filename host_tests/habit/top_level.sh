#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The top level holds what the design card names and nothing else. Usage: top_level.sh ROOT
set -eu
cd "$1"
odd=$(git ls-files 2>/dev/null | cut -d/ -f1 | sort -u |
  grep -vxE 'firmware|hal|protocol|host_tests|linker|CMakeLists\.txt|README\.md|CMakePresets\.json|LICENSE|\..*' || true)
[ -z "$odd" ] || { echo "not on the design card: $odd"; exit 1; }
