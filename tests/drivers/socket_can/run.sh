#!/bin/sh
# run.sh PRELOAD COMMAND...: runs the command where there is a CAN interface vcan0: in this kernel when
# it has CAN and lets us make one, else in user-mode-linux (package user-mode-linux) on this very file
# system. Ends with the command's exit code; 77 when neither is possible
# (no package, or it does not boot on this processor).
set -u
preload=$1
shift
export PREHEND_VCAN=vcan0  # tells the tests that the interface must be there

if ip link show vcan0 >/dev/null 2>&1; then
  exec "$@"
fi
if (modprobe can-raw && modprobe vcan) >/dev/null 2>&1 && ip link add vcan0 type vcan 2>/dev/null; then
  trap 'ip link delete vcan0' EXIT
  ip link set vcan0 up
  "$@"
  exit $?
fi
if ! command -v linux.uml >/dev/null 2>&1; then
  echo "neither has this kernel CAN nor is user-mode-linux installed" >&2
  exit 77
fi

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for word in "$@"; do printf '%s\n' "$word"; done >"$scratch/command"
cat >"$scratch/init" <<END
#!/bin/sh
exec "$(cd "$(dirname "$0")" && pwd)/init.sh" "$scratch" "$(pwd)" "$PATH"
END
chmod +x "$scratch/init"
LD_PRELOAD=$preload timeout -k 5 "${UML_SECONDS:-200}" linux.uml rootfstype=hostfs rw mem="${UML_MEMORY:-1G}" \
  init="$scratch/init" con=null con0=fd:0,fd:1 quiet </dev/null >"$scratch/console" 2>&1
sed 's/\r$//' "$scratch/output" 2>/dev/null
if [ ! -e "$scratch/started" ]; then
  echo "user-mode-linux does not boot here:" >&2
  tail -30 "$scratch/console" >&2
  exit 77
fi
if [ ! -s "$scratch/status" ]; then
  echo "user-mode-linux did not run the command:" >&2
  tail -30 "$scratch/console" >&2
  exit 1
fi
exit "$(cat "$scratch/status")"
