#!/usr/bin/env bash
# Runs the tests of a build tree: first those that a busy machine cannot make fail, one more than
# there are processors, since some of them wait; then those labelled realtime, one to a processor, which may run
# a second time. Ends with what did.
#   scripts/run-tests.sh BUILD_TREE [ctest's options]
set -uo pipefail
tree=${1:?"usage: $0 BUILD_TREE [options of ctest]"}
shift
log=$(mktemp)
trap 'rm -f "$log"' EXIT

ctest --test-dir "$tree" --output-on-failure --timeout 300 -j "$(($(nproc) + 1))" -LE realtime "$@"
steady=$?
ctest --test-dir "$tree" --output-on-failure --timeout 300 -j "$(nproc)" -L realtime --repeat until-pass:2 "$@" |
  tee "$log"
timed=${PIPESTATUS[0]}

failed=$(sed -nE 's/^.*Test +#[0-9]+: ([^ ]+) .*\*\*\*(Failed|Timeout|Exception).*/\1/p' "$log" | sort -u)
passed=$(sed -nE 's/^.*Test +#[0-9]+: ([^ ]+) .* Passed .*/\1/p' "$log" | sort -u)
again=$(comm -12 <(printf '%s\n' "$failed") <(printf '%s\n' "$passed") | sed '/^$/d')
if [ -n "$again" ]; then
  echo "Passed only the second time:"
  printf '  %s\n' $again
else
  echo "No test needed a second run."
fi
[ "$steady" -eq 0 ] && [ "$timed" -eq 0 ]
