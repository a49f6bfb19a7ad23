#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests the package's service under a real systemd, on an isolated copy of this machine: systemd is process 1 of its own
# namespaces (mounts, processes, names, network, cgroups), on an overlay of / in memory. There dpkg installs the
# package, and service_managed.py enables, uses, hangs, kills and stops the service by systemctl.
# Usage: service_manager.sh M100-LAB FILE.deb
# Exit code 0: passed. 1: failed. 77: not possible on this machine or for this user; a message gives the reason.
set -euo pipefail
here=$(dirname "$(realpath "$0")")
cannot() { echo "service manager: test skipped: $*"; exit 77; }

outside() {
  [ "$(id -u)" = 0 ] || cannot "it needs root"
  for program in unshare pivot_root systemctl python3 dpkg; do
    command -v "$program" >/dev/null || cannot "$program is missing"
  done
  [ -x /lib/systemd/systemd ] || cannot "systemd is not installed"
  unified=$(awk '$3 == "cgroup2" { print $2; exit }' /proc/mounts)
  [ -n "$unified" ] || cannot "no cgroup v2 hierarchy is mounted"
  unshare --mount --pid --fork --uts --ipc --net --cgroup true 2>/dev/null || cannot "namespaces are refused"
  work=$(mktemp -d)
  group=$unified$(sed -n 's/^0:://p' /proc/self/cgroup)/m100-service-manager.$$
  mkdir "$group" 2>/dev/null || cannot "a new cgroup is refused"
  trap 'rmdir "$group" || true; rm -rf "$work"' EXIT
  # The process joins the new cgroup before it makes its cgroup namespace, whose root is then this cgroup.
  bash -c 'echo $$ >"$0/cgroup.procs" && exec unshare --mount --pid --fork --kill-child --uts --ipc --net --cgroup "$@"' \
    "$group" "$0" --inside "$work" "$1" "$2" &
  code=0
  wait $! || code=$?
  cat "$work/said" 2>/dev/null || true
  for _ in $(seq 100); do [ -z "$(cat "$group/cgroup.procs")" ] && break; sleep 0.1; done
  find "$group" -mindepth 1 -depth -type d -exec rmdir {} +
  exit "$code"
}

# Runs as process 1 of its namespaces: prepares the machine, then becomes systemd.
inside() {
  work=$1 root=$1/root
  mount --make-rprivate /
  mkdir "$root" "$work/over"
  mount -t tmpfs tmpfs "$work/over"
  mkdir "$work/over/upper" "$work/over/work"
  mount -t overlay overlay -o "lowerdir=/,upperdir=$work/over/upper,workdir=$work/over/work" "$root" ||
    cannot "an overlay of / is refused"
  mount -t proc proc "$root/proc"
  mount --bind "$root/proc/sys" "$root/proc/sys"
  mount -o remount,bind,ro "$root/proc/sys"  # these settings belong to the whole machine
  mount -t sysfs -o ro sysfs "$root/sys"
  mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup" || cannot "cgroup v2 is refused"
  mount -t tmpfs tmpfs "$root/run"
  mount -t tmpfs tmpfs "$root/tmp"
  mount -t tmpfs -o mode=755 tmpfs "$root/dev"
  for node in "null 1 3" "zero 1 5" "full 1 7" "random 1 8" "urandom 1 9" "tty 5 0"; do
    read -r name major minor <<<"$node"
    mknod -m 666 "$root/dev/$name" c "$major" "$minor"
  done
  mkdir "$root/dev/pts" "$root/dev/shm" "$root/run/outside"
  mount -t devpts -o newinstance,ptmxmode=0666,mode=620,gid=5 devpts "$root/dev/pts"
  ln -s pts/ptmx "$root/dev/ptmx"
  mount --bind "$work" "$root/run/outside"
  mkdir "$root/opt/m100-test"
  cp "$2" "$root/opt/m100-test/m100-lab"
  cp "$3" "$root/opt/m100-test/m100.deb"
  cp "$here/service_managed.py" "$here/service_test.py" "$here/real_time.py" "$root/opt/m100-test/"
  # None of this machine's own services starts; of the default dependencies only the journal remains.
  rm -rf "$root"/{lib,etc}/systemd/system/*.{wants,requires} "$root"/etc/systemd/system/m100*
  for name in sysinit basic shutdown; do
    printf '[Unit]\nDescription=stand-in\nDefaultDependencies=no\n' >"$root/etc/systemd/system/$name.target"
  done
  printf 'Wants=systemd-journald.service\nAfter=systemd-journald.service\n' >>"$root/etc/systemd/system/sysinit.target"
  cat >"$root/etc/systemd/system/m100-test.service" <<END
[Unit]
Description=The test
[Service]
Type=oneshot
ExecStart=/bin/sh -c '/usr/bin/env python3 -B /opt/m100-test/service_managed.py /opt/m100-test/m100-lab /opt/m100-test/m100.deb; systemctl --force exit \$\$?'
Environment=PATH=$PATH
StandardOutput=file:/run/outside/said
StandardError=inherit
TimeoutStartSec=1200
END
  cd "$root"
  mkdir -p mnt
  pivot_root . mnt
  exec chroot . /usr/bin/env -i container=m100-test PATH="$PATH" /bin/sh -c \
    'umount -l /mnt; exec /lib/systemd/systemd --unit=m100-test.service --show-status=no' <dev/null >dev/null 2>&1
}

if [ "${1:-}" = --inside ]; then inside "$2" "$3" "$4"; else outside "$(realpath "$1")" "$(realpath "$2")"; fi
