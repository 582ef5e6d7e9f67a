#!/bin/sh
# init.sh SCRATCH FOLDER PATH: process 1 of user-mode-linux, started by run.sh. Makes vcan0, runs the
# command of SCRATCH/command (a word a line) in FOLDER, leaves output and exit code, switches off.
export PATH="$3:/usr/sbin:/usr/bin:/sbin:/bin"
export PREHEND_VCAN=vcan0
scratch=$1
: >"$scratch/started"
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t tmpfs tmpfs /dev/shm 2>/dev/null
mkdir -p /dev/pts && mount -t devpts devpts /dev/pts
modules=/usr/lib/uml/modules/$(uname -r)/kernel
for module in net/can/can.ko net/can/can-raw.ko drivers/net/can/dev/can-dev.ko drivers/net/can/vcan.ko; do
  insmod "$modules/$module" || echo "cannot load $module"
done
ip link set lo up
ip link add vcan0 type vcan && ip link set vcan0 up
cd "$2" || poweroff -f
set --
while IFS= read -r word; do set -- "$@" "$word"; done <"$scratch/command"
"$@" >"$scratch/output" 2>&1
echo $? >"$scratch/status"
sync
poweroff -f
