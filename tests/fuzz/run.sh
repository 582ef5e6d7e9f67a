#!/bin/sh
# run.sh PROGRAMS OUT SECONDS [NAME...]: runs each fuzz_* program of the folder PROGRAMS, or those
# named, for so long, from its committed corpus and with its dictionary, if it has one. New inputs are
# kept in OUT/NAME, findings in OUT/NAME-findings/. Other folders of inputs to begin with are in
# FUZZ_SEEDS: FUZZ_SEEDS=~/robots tests/fuzz/run.sh build-fuzz/bin out/fuzz 600 robot_urdf
set -u
programs=$1 out=$2 seconds=$3
shift 3
here=$(dirname "$0")
corpus=$here/corpus
status=0
[ $# -gt 0 ] || set -- $(for program in "$programs"/fuzz_*; do echo "${program##*/fuzz_}"; done)
for name in "$@"; do
  mkdir -p "$out/$name" "$out/$name-findings"
  echo "$name: $seconds s"
  dictionary=$here/dictionaries/$name.dict
  [ -f "$dictionary" ] && dictionary=-dict=$dictionary || dictionary=-verbosity=0
  if ! "$programs/fuzz_$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 \
      -max_len=16384 -verbosity=0 "$dictionary" -print_final_stats=1 \
      -artifact_prefix="$out/$name-findings/" "$out/$name" "$corpus/$name" ${FUZZ_SEEDS:-} \
      >"$out/$name.log" 2>&1; then
    status=1
    tail -40 "$out/$name.log"
    echo "$name: a finding in $out/$name-findings; mend it and keep the input in $corpus/$name"
  else
    grep number_of_executed_units "$out/$name.log"
  fi
done
exit $status
