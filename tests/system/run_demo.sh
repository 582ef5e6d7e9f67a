#!/usr/bin/env bash
# Checks scripts/run-demo.sh with a launch that only listens: what it is given, when a browser is opened, and that
# another's port is not taken.
#   run_demo.sh SOURCE_FOLDER
set -euo pipefail
cd "$1"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Says its arguments; answers at the viewer's port where it is to show itself; ends as the report would.
cat > "$folder/prehend" <<'PROGRAM'
#!/usr/bin/env python3
import socket, sys, time
open(sys.argv[0] + ".said", "w").write(" ".join(sys.argv[1:]))
if "view:=true" in sys.argv:
    listener = socket.create_server(("127.0.0.1", 8765))
    time.sleep(3)
sys.exit(3)
PROGRAM
cat > "$folder/xdg-open" <<'PROGRAM'
#!/bin/sh
echo "$1" > "$(dirname "$0")/opened"
PROGRAM
chmod +x "$folder/prehend" "$folder/xdg-open"
PATH="$folder:$PATH"

fail() { echo "FAILED: $1"; exit 1; }
run() { status=0; "$@" > "$folder/output" || status=$?; }

if (exec 3<>/dev/tcp/127.0.0.1/8765) 2>/dev/null; then echo "SKIPPED: somebody uses port 8765"; exit 77; fi

run env DISPLAY=:0 scripts/run-demo.sh "$folder/prehend" "$folder/out" speed:=0
[ "$status" -eq 3 ] || fail "the exit code is $status, not the report's"
grep -q "task:=clear_table view:=true out:=$folder/out speed:=0" "$folder/prehend.said" || fail "$(cat "$folder/prehend.said")"
grep -q "http://127.0.0.1:8765/" "$folder/output" || fail "the page's address is not said"
[ "$(cat "$folder/opened")" = "http://127.0.0.1:8765/" ] || fail "no browser was opened on a desktop"

rm "$folder/opened"
run env -u DISPLAY -u WAYLAND_DISPLAY scripts/run-demo.sh "$folder/prehend" "$folder/out"
[ ! -e "$folder/opened" ] || fail "a browser was opened without a desktop"

python3 -c 'import socket, time; s = socket.create_server(("127.0.0.1", 8765)); time.sleep(60)' &
other=$!
for _ in $(seq 100); do
  if (exec 3<>/dev/tcp/127.0.0.1/8765) 2>/dev/null; then break; fi
  sleep 0.1
done
run env DISPLAY=:0 scripts/run-demo.sh "$folder/prehend" "$folder/out"
kill "$other"
wait "$other" 2>/dev/null || true
grep -q "view:=false" "$folder/prehend.said" || fail "another's port was taken"
grep -q "Something else answers" "$folder/output" || fail "that the port is another's is not said"
[ ! -e "$folder/opened" ] || fail "another's page was opened"
