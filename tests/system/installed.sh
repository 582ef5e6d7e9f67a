#!/usr/bin/env bash
# Installs a build tree into a folder of its own and uses it as others do: the command from another
# folder, a plan by an installed robot, a project that finds the package.
#   installed.sh BUILD_TREE OTHER_PROJECT GENERATOR
set -euo pipefail
tree=$1
project=$2
generator=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
unset PREHEND_ROOT

cmake --install "$tree" --prefix "$scratch/prefix" --strip >"$scratch/installed.txt"
if grep -rIl --exclude-dir=archives "$(dirname "$tree")" "$scratch/prefix"; then
  echo "these files name the folder that prehend was built in" >&2
  exit 1
fi

mkdir "$scratch/elsewhere"
cd "$scratch/elsewhere"
export PATH=$scratch/prefix/bin:$PATH
prehend --version
prehend launch --check demo
prehend launch --check "$scratch/prefix/share/prehend/launch/" >/dev/null
prehend explain "$scratch/prefix/share/prehend/config/scenes/demo.yaml" --platform kr5_sdh >explained.txt

cmake -S "$project" -B build -G "$generator" -DCMAKE_PREFIX_PATH="$scratch/prefix" --log-level=WARNING
cmake --build build
build/pieces | grep 'a box of 288 cm^3 is 1 convex piece'
cat >hello.yaml <<'END'
nodes:
  - node: hello
    parameters: {word: "good day"}
END
PREHEND_NODE_PATH=$PWD/build prehend launch --check hello.yaml
if PREHEND_NODE_PATH=$PWD/build prehend launch --check demo.yaml scene:=nowhere 2>refused.txt; then
  echo "a scene that is not there was not refused" >&2
  exit 1
fi
grep -q nowhere refused.txt

mkdir refused
cat >refused/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(refused LANGUAGES C CXX)
find_package(prehend REQUIRED COMPONENTS no_such_thing)
END
if cmake -S refused -B refused/build -G "$generator" -DCMAKE_PREFIX_PATH="$scratch/prefix" >refused.txt 2>&1; then
  echo "a component that is not there was found" >&2
  exit 1
fi
grep -q "no library 'no_such_thing'" refused.txt
