#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests a package of host_tests/package: lintian finds neither error nor warning, dpkg installs it into a root folder of
# its own, and what it brings is used there. Usage: package_test.sh FILE.deb
set -euo pipefail
package=$(realpath "$1")
cd "$(dirname "$0")/.."
machine=$(dpkg-deb --field "$package" Architecture)
name=$(dpkg-deb --field "$package" Package)
version=$(dpkg-deb --field "$package" Version)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
fail() { echo "$(basename "$package"): $*" >&2; exit 1; }

if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error,warning "$package" || fail "lintian objects"
else
  echo "$(basename "$package"): SKIPPED lintian: it is not installed"
fi

if [ "$machine" = "$(dpkg --print-architecture)" ]; then  # the one line by which a person installs it
  apt-get -qq --simulate install "$package" >"$root/log" 2>&1 || { cat "$root/log"; fail "apt cannot install it"; }
fi
mkdir -p "$root/var/lib/dpkg/"{info,updates} "$root/etc"
: >"$root/var/lib/dpkg/status"
mkdir -p "$root/var/lib/dpkg" && echo "$machine" >"$root/var/lib/dpkg/arch"
[ "$machine" = "$(dpkg --print-architecture)" ] || foreign=(--force-architecture)
dpkg --root="$root" --force-not-root --force-depends "${foreign[@]}" --log=/dev/null --install "$package" >/dev/null 2>"$root/log" ||
  { cat "$root/log"; fail "cannot be installed"; }

case "$machine" in
  amd64) run=() ;;
  arm64) run=(qemu-aarch64) ;;
  armhf) run=(qemu-arm) ;;
esac
[ "$machine" != "$(dpkg --print-architecture)" ] || run=()

# What every package holds.
documents=$root/usr/share/doc/$name
[ -s "$documents/copyright" ] && zcat "$documents/changelog.gz" | grep -q "^$name ($version)" || fail "copyright or changelog is missing"

# knows_subcommands SECTION PROGRAM...: the manual page has a heading or a word for each subcommand of the program.
knows_subcommands() {
  local form=$1 page subcommands
  shift
  page=$(zcat "$root/usr/share/man/man1/$name.1.gz")
  subcommands=$("$@" --help | sed -n '/^Subcommands:/,$s/^  \([a-z][a-z-]*\)  *.*/\1/p')
  [ "$(wc -w <<<"$subcommands")" -ge 6 ] || fail "--help lists: $subcommands"
  for subcommand in $subcommands; do
    grep -qiE "^${form/SUBCOMMAND/$subcommand}" <<<"$page" || fail "$name.1 does not know $subcommand"
  done
}
# completes EXPECTED WORD...: the package's completion offers exactly this for the last word.
completes() {
  local expected=$1 offered
  shift
  offered=$(PATH=$root/usr/bin:$PATH bash -c '. "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _m100; echo "${COMPREPLY[*]}"' \
    "$root/usr/share/bash-completion/completions/$name" "$@")
  [ "$offered" = "$expected" ] || fail "completion offers '$offered' for '$*'"
}
# unit_is_sound UNIT SUBCOMMAND: the subcommand, whose help is in $root/help, has every option that the unit gives it, and
# systemd-analyze accepts the unit without a message; stand-ins replace the units and the shell that a board has.
unit_is_sound() {
  local option stand_in said unit=$root/lib/systemd/system/$1
  for option in $(grep '^ExecStart=' "$unit" | grep -o -- ' --[a-z-]*'); do
    grep -q -- "$option " "$root/help" || fail "$1 uses $option, which $2 does not know"
  done
  command -v systemd-analyze >/dev/null && [ "$machine" = amd64 ] || return 0
  mkdir -p "$root/bin"
  [ -e "$root/bin/sh" ] || install -m 755 /dev/null "$root/bin/sh"
  for stand_in in sysinit.target basic.target shutdown.target multi-user.target network-online.target system.slice; do
    printf '[Unit]\nDescription=stand-in\nDefaultDependencies=no\n' >"$root/lib/systemd/system/$stand_in"
  done
  said=$(systemd-analyze verify --man=no --root="$root" "$1" 2>&1) || fail "systemd-analyze: $said"
  [ -z "$said" ] || fail "systemd-analyze: $said"
}
removed() {
  dpkg --root="$root" --force-not-root --log=/dev/null --purge "$name" >/dev/null 2>&1 || fail "cannot be removed"
  [ ! -e "$root/usr/bin/$name" ] && [ ! -e "$root/usr/lib/cmake/m100" ] || fail "something is still there after the purge"
  echo "$(basename "$package"): installed, used and removed in a test root"
}

if [ "$name" = m100-lab ]; then
  share=$root/usr/share/m100-lab
  for file in "$documents/guide/README.md" "$documents/guide/worlds/quadrotor.py" \
    "$documents"/guide/{vehicle,flight,plant,column}_keys.md "$documents"/guide/{course,script}_words.md \
    "$documents"/guide/{frames_json,exit_codes,messages}.md \
    "$share/maps/px4.toml" "$share/columns/m100_csv.toml" "$share/flight/loop_train.ulg"; do
    [ -s "$file" ] || fail "${file#"$root"} is missing"
  done
  for file in $(grep -rhoE '\b(firmware|host_tests|protocol|build)/[A-Za-z0-9_/.]*\w' "$documents/guide" "$share/demonstration" | sort -u); do
    grep -qE "^#.*$file" "$share/demonstration" || [ -e "$documents/$file" ] || fail "the guide or the demonstration names $file"
  done
  knows_subcommands '\.SH OPTIONS OF SUBCOMMAND' "${run[@]}" "$root/usr/bin/m100-lab"
  if [ ${#run[@]} -gt 0 ]; then  # emulated: the demonstration starts further programs, so only its log is identified
    "${run[@]}" "$root/usr/bin/m100-lab" identify --log "$share/flight/loop_train.ulg" \
      --columns "$share/flight/columns.toml" --axis roll --declare second_order --split alternate:5 --refits 0 \
      >"$root/log" 2>&1 || { cat "$root/log"; fail "identify fails"; }
    tail -n 5 "$root/log"
    removed
    exit 0
  fi
  completes --columns m100-lab identify --colu
  completes 'roll' m100-lab identify --axis ro
  completes 'decode encode --help' m100-lab frames ''
  "$root/usr/bin/m100-lab" bridge --help >"$root/help"
  unit_is_sound m100-bridge.service bridge
  "$root/usr/bin/m100-lab" demo --out "$root/demo" >"$root/log" 2>&1 || { cat "$root/log"; fail "the demonstration fails"; }
  grep -q 'SIMULATED flight:' "$root/log" && [ -s "$root/demo/report.html" ] || fail "the demonstration leaves no page"
  [ ! -e "$root/demo/flown" ] || fail "the demonstration has not used the log of the package"
  tail -n 20 "$root/log"
  removed
  exit 0
fi
if [ "$name" = m100-dev ]; then
  if [ "$machine" = "$(dpkg --print-architecture)" ]; then
    cmake -S host_tests/consumer -B "$root/consumer" -DCMAKE_PREFIX_PATH="$root/usr" >"$root/log" &&
      cmake --build "$root/consumer" >>"$root/log" && "$root/consumer/mpc" || { cat "$root/log"; fail "a project cannot use it"; }
  fi
  removed
  exit 0
fi

m100() { "${run[@]}" "$root/usr/bin/m100" "$@"; }
file=$root/usr/bin/m100
[ -z "$(readelf --dynamic "$file" 2>/dev/null | grep NEEDED)" ] || fail "the program needs shared libraries"
[ -z "$(readelf --sections "$file" | grep -w .symtab)" ] || fail "the program is not stripped"

m100 --version | grep -q "^m100 $version " || fail "--version says: $(m100 --version)"
m100 --version | grep -q '^tables: ' || fail "--version does not mention the tables"

# The example files fit together, and the service finds its files.
examples=$root/usr/share/doc/m100/examples
m100 check --vehicle "$examples/vehicle.toml" --gains "$examples/gains.bin" --flight "$examples/flight.toml" >/dev/null ||
  fail "the examples do not agree"
code=0
m100 fly --port "$root/none" --pose-port "$root/none_either" --vehicle "$examples/vehicle.toml" --gains "$examples/gains.bin" \
  --flight "$examples/flight.toml" >/dev/null 2>"$root/log" || code=$?
[ "$code" = 2 ] || fail "fly without a port ends with $code"
grep -q "$root/none: no such serial port" "$root/log" || fail "fly without a port says: $(cat "$root/log")"

unit=$root/lib/systemd/system/m100.service
[ -s "$unit" ] || fail "the unit file is missing"
! grep -v '^#' "$unit" | grep -q -- --take-control || fail "the service takes control without an order"
grep -q '^Restart=on-failure' "$unit" && grep -q '^WatchdogSec=' "$unit" && grep -q '^KillMode=process' "$unit" ||
  fail "the unit file lacks Restart=on-failure, WatchdogSec= or KillMode=process"
# The environment file sets every variable of the unit.
for variable in $(grep -o '\$[{]*M100_[A-Z_]*' "$unit" | tr -d '${' | sort -u); do
  grep -q "^$variable=" "$root/etc/m100/m100.env" || fail "m100.env does not set $variable"
done
m100 fly --help >"$root/help"
unit_is_sound m100.service fly

# The manual page and the completion know every subcommand.
knows_subcommands '\.B SUBCOMMAND$' m100
courses=$(zcat "$root/usr/share/man/man5/m100-course.5.gz")
while read -r word; do
  grep -qF ".B $word" <<<"$courses" || fail "m100-course.5 does not know $word"
done < <(sed -n '/A course file has/,$s/^  \([a-z][a-z0-9_,]*\).*/\1/p' "$root/help")
bash -n "$root/usr/share/bash-completion/completions/m100"
[ "$machine" != amd64 ] || completes --pose-port m100 fly --pose-p
[ -s "$root/lib/udev/rules.d/60-m100.rules" ] || fail "the udev rules are missing"
[ -s "$root/usr/share/doc/m100/CHANGELOG.md" ] || fail "the changelog is missing"
removed
