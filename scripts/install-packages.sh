#!/bin/sh
# Installs the Debian packages named in apt-packages.txt that are missing. Says what it will do.
set -eu
list="$(dirname "$0")/../apt-packages.txt"

if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "prehend: this is not a Debian system; install what apt-packages.txt names by hand." >&2
  exit 0
fi

missing=
for package in $(sed 's/#.*//' "$list"); do
  state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$state" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null 2>&1; then
    echo "prehend: these packages are missing and there is no sudo; as root, run" >&2
    echo "  apt-get install --no-install-recommends$missing" >&2
    exit 1
  fi
  as_root=sudo
fi

echo "prehend: installing missing packages with ${as_root:+sudo }apt-get:$missing"
$as_root apt-get update -qq
# shellcheck disable=SC2086 # the list is meant to be split into words
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
