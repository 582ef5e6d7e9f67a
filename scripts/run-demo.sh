#!/usr/bin/env bash
# The demonstration: a table of six things is cleared, and shown live in a browser, which is opened where there is a
# desktop. Ends with the report's exit code.
#   scripts/run-demo.sh PREHEND OUT [launch arguments]
set -uo pipefail
prehend=${1:?"usage: $0 PREHEND OUT [launch arguments]"}
out=${2:?"usage: $0 PREHEND OUT [launch arguments]"}
shift 2
port=8765
page=http://127.0.0.1:$port/

answers() { (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; }

open_page() {
  for _ in $(seq 200); do
    if answers; then
      xdg-open "$page" >/dev/null 2>&1
      return
    fi
    sleep 0.1
  done
}

rm -f "$out/summary.txt"
view=true
opening=
if answers; then
  echo "Something else answers at $page: the demonstration is not shown there."
  view=false
else
  echo "Watch it at $page"
  if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && command -v xdg-open >/dev/null; then
    open_page &
    opening=$!
  fi
fi
"$prehend" launch launch/demo.yaml scene:=table_objects task:=clear_table "view:=$view" "out:=$out" "$@"
status=$?
if [ -n "$opening" ]; then kill "$opening" 2>/dev/null; fi
cat "$out/summary.txt" 2>/dev/null
exit "$status"
