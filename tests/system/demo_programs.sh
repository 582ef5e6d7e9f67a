#!/usr/bin/env bash
# Checks a launch file in a folder that has the named programs alone.
#   demo_programs.sh FOLDER_OF_PROGRAMS LAUNCH_FILE PROGRAM...
set -euo pipefail
programs=$1
launch_file=$2
shift 2
folder=$(mktemp -d "$programs/../only_XXXXXX")  # on the same file system: hard links
trap 'rm -rf "$folder"' EXIT
for program in "$@"; do ln "$programs/$program" "$folder/$program"; done
"$folder/prehend" launch --check "$launch_file"
