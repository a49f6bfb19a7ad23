#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks that clang-format with the project's .clang-format would change no C++ file. Usage: format.sh ROOT
set -eu
cd "$1"
find firmware hal protocol host_tests \( -name '*.h' -o -name '*.cpp' \) -not -path '*/generated/*' -print0 |
  xargs -0 clang-format --dry-run --Werror
