#!/bin/sh
# A script of the robot editor's tests in Blender: run.sh BLENDER SCRIPT [ARGUMENT ...].
folder=$(dirname "$(readlink -f "$0")")
blender=$1
script=$2
shift 2
if ! [ -x "$blender" ]; then
  echo "Blender is not installed (apt-get install blender): the robot editor is not tried"
  exit 77
fi
if [ "$script" = import_all.py ] && [ $# = 0 ]; then
  set -- "${PREHEND_SHARED_DATA:-/none}"
fi
if [ "$script" = import_all.py ] && ! [ -d "$1/models" ]; then
  echo "There are no shared models (PREHEND_SHARED_DATA): none is imported"
  exit 77
fi
home=$(mktemp -d) || exit 1 # its preferences are nobody's
trap 'rm -rf "$home"' EXIT
HOME=$home timeout -k 5 600 "$blender" -b --factory-startup --python-exit-code 1 \
  --python "$folder/$script" -- "$@"
