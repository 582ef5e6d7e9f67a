#!/bin/sh
# run.sh PROGRAMS OUT SECONDS: runs each fuzz_* program of the folder PROGRAMS for so long, from its
# committed corpus on. New inputs are kept in OUT/NAME, findings in OUT/NAME-findings/.
set -u
programs=$1 out=$2 seconds=$3
corpus=$(dirname "$0")/corpus
status=0
for program in "$programs"/fuzz_*; do
  name=${program##*/fuzz_}
  mkdir -p "$out/$name" "$out/$name-findings"
  echo "$name: $seconds s"
  if ! "$program" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -max_len=8192 \
      -verbosity=0 -print_final_stats=1 -artifact_prefix="$out/$name-findings/" \
      "$out/$name" "$corpus/$name" >"$out/$name.log" 2>&1; then
    status=1
    tail -40 "$out/$name.log"
    echo "$name: a finding in $out/$name-findings; mend it and keep the input in $corpus/$name"
  else
    grep number_of_executed_units "$out/$name.log"
  fi
done
exit $status
