#!/usr/bin/env bash
# Installs a build tree into a folder of its own and uses it as others do: the command from another
# folder, a plan by an installed robot, a project that finds the package, plug-ins and a hand of one's
# own (examples/README.md).
#   installed.sh BUILD_TREE SOURCE_TREE GENERATOR
set -euo pipefail
tree=$1
source=$2
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

cmake -S "$source/examples/project" -B build -G "$generator" -DCMAKE_PREFIX_PATH="$scratch/prefix" --log-level=WARNING
cmake --build build
build/pieces | grep 'a box of 288 cm^3 is 1 convex piece'

# The same by pkg-config, from the one library; what is visible of it is prehend's (and what ELF keeps unique).
export PKG_CONFIG_PATH=$scratch/prefix/lib/pkgconfig
read -ra flags < <(pkg-config --cflags --libs prehend)
c++ -std=c++20 "$source/examples/project/pieces.cpp" "${flags[@]}" -o pieces_shared
LD_LIBRARY_PATH=$scratch/prefix/lib ./pieces_shared | grep 'a box of 288 cm^3 is 1 convex piece'
cat >talks.cpp <<'END'
#include <iostream>

#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

int main() {
  using namespace prehend;
  try {
    robot::read_platform("nowhere.yaml");
  } catch (const geometry::InputError& error) {
    std::cout << error.what() << "\n";
  }
  msgs::Wrench wrench;
  wrench.mutable_wrench()->mutable_force()->set_x(2);
  try {
    graph::Node node({.name = "talks", .registry = "ipc://nobody",
                      .registry_timeout = std::chrono::milliseconds(100)});
  } catch (const std::exception& error) {
    std::cout << wrench.ShortDebugString() << ": " << error.what() << "\n";
  }
}
END
c++ -std=c++20 talks.cpp "${flags[@]}" -o talks
LD_LIBRARY_PATH=$scratch/prefix/lib ./talks >talked.txt
grep -q 'nowhere.yaml does not exist' talked.txt
grep -q 'x: 2.*no registry answers' talked.txt
if nm -D --defined-only "$scratch/prefix/lib/libprehend.so" | awk '$2 != "u" { print $3 }' |
  grep -vE 'N7prehend|7prehend|8foxglove|descriptor_table'; then
  echo "the library shows symbols that are not its own" >&2
  exit 1
fi

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

# A driver, and its device: it says nothing to who comes first, and hangs up; then it measures, with a line that is none.
cp -r "$source/examples/driver" driver
cmake -S driver -B driver/build -G "$generator" -DCMAKE_PREFIX_PATH="$scratch/prefix" --log-level=WARNING
cmake --build driver/build
cat >device.py <<'END'
import socket, sys, time
listening = socket.create_server(("127.0.0.1", 0))
print(listening.getsockname()[1], flush=True)
listening.accept()[0].close()
peer = listening.accept()[0]
try:
    for _ in range(2000):
        peer.sendall(b"1 2 3 0.1 0.2 0.3\nnot a measurement\n")
        time.sleep(0.01)
except OSError:
    pass
END
python3 device.py >port.txt &
device=$!
for _ in $(seq 100); do [ -s port.txt ] && break; sleep 0.05; done
cat >driver.yaml <<END
nodes:
  - node: line_wrench
    parameters: {line: "tcp://127.0.0.1:$(cat port.txt)"}
END
export PREHEND_REGISTRY=ipc://$scratch/registry
PREHEND_NODE_PATH=$PWD/driver/build timeout 60 prehend launch driver.yaml >driver.txt 2>&1 &
launched=$!
for _ in $(seq 100); do prehend node list >/dev/null 2>&1 && break; sleep 0.1; done
timeout 30 prehend topic echo /wrench -n 1 --wait --json | tee wrench.txt
kill -INT "$launched"
wait "$launched" || true
kill "$device" 2>/dev/null || true
unset PREHEND_REGISTRY
grep -q '"z": *3' wrench.txt

# Copies, as nothing but the installed headers is to be found from there.
examples=(grasp/example motion/example simulation/engines/example simulation/sensors/example simulation/example)
for example in "${examples[@]}"; do
  copy=$scratch/plug_ins/${example//\//_}
  mkdir -p "$copy"
  cp "$source/prehend/$example"/* "$copy"
  cmake -S "$copy" -B plug_ins/"$example" -G "$generator" -DPREHEND_SOURCE="$scratch/prefix/include/prehend" \
    --log-level=WARNING
  cmake --build plug_ins/"$example"
done
cp -r "$source/examples/hand" hand
plan=(prehend plan hand/crate.ply --hand hand/wide_gripper.yaml)
"${plan[@]}" | grep -E '^[1-9][0-9]* grasps$'
PREHEND_GENERATORS=$PWD/plug_ins/grasp/example "${plan[@]}" --generators from_the_top | grep from_the_top
if "${plan[@]}" --generators from_the_top 2>refused.txt; then
  echo "a generator that is nowhere was not refused" >&2
  exit 1
fi
grep -q from_the_top refused.txt
sed 's/^actuated:/closing: fingertips\n&/' hand/wide_gripper.yaml >hand/by_fingertips.yaml
PREHEND_CLOSINGS=$PWD/plug_ins/grasp/example prehend plan hand/crate.ply --hand hand/by_fingertips.yaml |
  grep -E '^[1-9][0-9]* grasps$'
sed -E 's/0\.055? /0.03 /g' hand/crate.ply >narrow.ply
PREHEND_PLANNERS=$PWD/plug_ins/motion/example PREHEND_CHECKERS=$PWD/plug_ins/motion/example \
  prehend plan narrow.ply --platform kr5_sdh --path-planner one_stop --collision-checker turned_boxes |
  grep 'The arm takes grasp'
if prehend plan hand/crate.ply --hand pg70 >refused.txt; then
  echo "the PG70 does not open that far" >&2
  exit 1
fi
grep 'exceeds the gripper' refused.txt
cat >lone.yaml <<END
gripper: $scratch/prefix/share/prehend/config/robots/pg70_dsa.yaml
physics: {engine: lone_body}
tactile: {sensor: dead_rows}
objects:
  - {name: box, shape: box, size: [0.06, 0.05, 0.1], mass: 0.3, friction: 0.7, x: 0, y: 0}
END
export PREHEND_SENSORS=$PWD/plug_ins/simulation/sensors/example
PREHEND_ENGINES=$PWD/plug_ins/simulation/engines/example prehend explain lone.yaml >explained.txt
grep lone_body explained.txt
if prehend explain lone.yaml >refused.txt 2>&1; then
  echo "an engine that is nowhere was not refused" >&2
  exit 1
fi
grep -q lone_body refused.txt

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
