#!/usr/bin/env bash
# Makes the documentation site from docs/, the READMEs, and what programs and headers say of themselves. Any warning, as of
# a link that leads nowhere, is an error.
#   scripts/make-docs.sh BUILD OUT [--without-library]
# BUILD: the build tree, with all programs and the Python package; OUT: a folder that it writes, OUT/html/index.html first.
set -euo pipefail
build=$(realpath "${1:?"usage: $0 BUILD OUT [--without-library]"}")
out=${2:?"usage: $0 BUILD OUT [--without-library]"}
root=$(realpath "$(dirname "$0")/..")
library=yes
[ "${3:-}" = --without-library ] && library=
for program in sphinx-build ${library:+doxygen}; do
  if ! command -v "$program" >/dev/null; then
    echo "make-docs: $program is missing: scripts/install-packages.sh installs it" >&2
    exit 1
  fi
done

rm -rf "$out"
mkdir -p "$out/source"
out=$(realpath "$out")
source=$out/source
# Pages and pictures keep their places, so that links between them are the same here and in the repository.
(cd "$root" && git ls-files -z -- '*.md' '*.svg' '*.png' 2>/dev/null || find . -name '*.md' -print0) |
  (cd "$root" && xargs -0 cp --parents -t "$source")
/usr/bin/python3 "$root/docs/site/repository_links.py" "$root" "$source"
cp "$root/docs/site/index.md" "$source/index.md"
rm -rf "$source/docs/site"
{
  echo "# Further pages"
  echo
  echo '```{toctree}'
  echo ':maxdepth: 1'
  echo
  (cd "$source" && find . -name '*.md' -not -path './docs/[!R]*' -not -name index.md | sed 's|^\./||; s|\.md$||' |
    grep -vE '^(README|CHANGELOG|launch/README|config/README|more)$' | sort)
  echo '```'
} > "$source/more.md"

if [ -n "$library" ]; then
  (cd "$root" && { cat docs/site/Doxyfile; echo "OUTPUT_DIRECTORY = $out/doxygen"; } | doxygen - > "$out/doxygen.log" 2>&1)
fi
/usr/bin/python3 "$root/docs/site/make_reference.py" "$build/bin" "$root" "$source/reference" ${library:+--xml "$out/doxygen/xml"}
PREHEND_VERSION=$(sed -n 's/^ *project(prehend VERSION \([0-9.]*\).*/\1/p; s/^ *VERSION \([0-9.]*\)$/\1/p' "$root/CMakeLists.txt" | head -1)
export PREHEND_VERSION PYTHONPATH=$build/python
mkdir "$source/gallery"
/usr/bin/python3 "$root/docs/site/make_gallery.py" "$root" "$source/gallery"
/usr/bin/python3 -m sphinx -q -W --keep-going -b html -c "$root/docs/site" -d "$out/trees" "$source" "$out/html"
echo "$out/html/index.html"
