#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests the package as a user receives it: it is installed from the build into a scratch prefix and moved to another
# folder; a separate project must find it there, link it and run. No exported file may contain an absolute path of this
# machine. If a library is not built, the installation must name it and the target to build before it copies anything.
# Usage: check.sh SOURCE BUILD CXX_FLAGS
set -euo pipefail
source=$1 build=$2 flags=${3:-}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
quietly() { "$@" >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }; }

quietly cmake --install "$build" --prefix "$scratch/prefix"
mv "$scratch/prefix" "$scratch/moved"
# An absolute path begins with a slash that follows no name, no variable and no other path.
if grep -rnE '(^|[^A-Za-z0-9_.}/*>])/[A-Za-z0-9_]' --include='*.cmake' "$scratch/moved"; then
  echo 'an exported file names a place of this machine'
  exit 1
fi
mapfile -t libraries < <(find "$scratch/moved" -name '*.a')
[ -n "$flags" ] || "$source/host_tests/habit/holds_no_path.sh" "$source" "${libraries[@]}"

quietly cmake -S "$source/host_tests/consumer" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$scratch/moved" \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS="$flags"
quietly cmake --build "$scratch/build"
for example in consumer parser observer mpc; do
  quietly "$scratch/build/$example"
done

# The programs stand in the same prefix.
[ -n "$flags" ] || { quietly "$scratch/moved/bin/m100" --version && quietly "$scratch/moved/bin/m100-lab" --version; }

# The same programs, built with pkg-config instead of CMake.
export PKG_CONFIG_PATH=$(dirname "$(find "$scratch/moved" -name m100.pc)")
for example in parser observer mpc; do
  # shellcheck disable=SC2046
  quietly "${CXX:-c++}" -std=c++20 $flags "$source/host_tests/consumer/$example.cpp" -o "$scratch/$example" $(pkg-config --cflags --libs m100)
  quietly "$scratch/$example"
done

# Installing a build in which one library is missing must fail.
mkdir "$scratch/partial"
cp "$build/cmake_install.cmake" "$scratch/partial"
sed "1s/.*/${scratch//\//\\/}\/libm100_not_built.a/" "$build/installed_files.txt" >"$scratch/partial/installed_files.txt"
sed -i "s#$build/installed_files.txt#$scratch/partial/installed_files.txt#" "$scratch/partial/cmake_install.cmake"
if cmake -DCMAKE_INSTALL_PREFIX="$scratch/nothing" -P "$scratch/partial/cmake_install.cmake" >"$scratch/log" 2>&1; then
  echo 'a partial build was installed'
  exit 1
fi
grep -q 'libm100_not_built.a is not built: run cmake --build .* --target installed_modules' <(tr -s '\n ' ' ' <"$scratch/log") ||
  { cat "$scratch/log" && exit 1; }
[ ! -e "$scratch/nothing" ] || { echo 'something was copied before the check' && exit 1; }
