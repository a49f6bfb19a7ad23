#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The top level holds the rooms of the README and nothing else. Usage: top_level.sh ROOT
set -eu
cd "$1"
odd=$(git ls-files 2>/dev/null | cut -d/ -f1 | sort -u |
  grep -vxE 'firmware|hal|protocol|host_tests|linker|CMakeLists\.txt|README\.md|CMakePresets\.json|LICENSE|\..*' || true)
[ -z "$odd" ] || { echo "no room of the project: $odd"; exit 1; }
