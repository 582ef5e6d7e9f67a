#!/usr/bin/env bash
# Makes the Debian packages of a build tree: prehend, prehend-ros1, prehend-ros2, libprehend0.1, libprehend-dev,
# python3-prehend and prehend-doc, with the documentation site in it.
#   scripts/make-debs.sh BUILD OUT
set -euo pipefail
build=$(realpath "${1:?"usage: $0 BUILD OUT"}")
out=${2:?"usage: $0 BUILD OUT"}
root=$(realpath "$(dirname "$0")/..")
"$root/scripts/make-docs.sh" "$build" "$build/documentation_site"
cmake "$build" >/dev/null # what is packed depends on what is there
mkdir -p "$out"
rm -f "$out"/*.deb
cpack --config "$build/CPackConfig.cmake" -G DEB -B "$(realpath "$out")" | grep generated
