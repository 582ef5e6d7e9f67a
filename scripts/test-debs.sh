#!/usr/bin/env bash
# Installs Debian packages of prehend in a Debian 12 that has nothing else, uses them there, and takes them away again. As root;
# needs debootstrap and Debian's mirror.
#   scripts/test-debs.sh DEBS    DEBS: the folder of scripts/make-debs.sh
set -euo pipefail
debs=$(realpath "${1:?"usage: $0 DEBS"}")
root=$(realpath "$(dirname "$0")/..")
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "test-debs: run it as root, with debootstrap installed" >&2
  exit 1
fi
clean=$(mktemp -d)
leave() {
  mountpoint -q "$clean/proc" && umount "$clean/proc"
  rm -rf --one-file-system "$clean"
}
trap leave EXIT

mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep -E '/debian/?$' | head -1)
debootstrap --variant=minbase --include=ca-certificates bookworm "$clean" "${mirror:-http://deb.debian.org/debian}" >"$clean.log" ||
  { cat "$clean.log" >&2; exit 1; }
rm "$clean.log"
cp /etc/apt/apt.conf.d/* "$clean/etc/apt/apt.conf.d/"
cp /etc/resolv.conf "$clean/etc/" 2>/dev/null || true
mount -t proc proc "$clean/proc"
mkdir "$clean/debs" "$clean/trial"
cp "$debs"/*.deb "$clean/debs/"
cp "$root/examples/project/pieces.cpp" "$clean/trial/"

cat >"$clean/trial/use.sh" <<'END'
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive
cd /trial
apt-get update -qq
apt-get install -y -qq --no-install-recommends /debs/prehend_*.deb >/dev/null
prehend --version
prehend launch --check demo
prehend explain /usr/share/prehend/config/scenes/demo.yaml >explained.txt
prehend plan --help >/dev/null
export PREHEND_REGISTRY=ipc:///trial/registry
timeout 100 prehend launch demo speed:=0 view:=false out:=/trial/demo >demo.txt 2>&1 || { tail -30 demo.txt; exit 1; }
ls /trial/demo/report.html
for deb in /debs/prehend-ros?_*.deb /debs/python3-prehend_*.deb /debs/libprehend0*.deb /debs/libprehend-dev_*.deb /debs/prehend-doc_*.deb; do
  [ -e "$deb" ] && apt-get install -y -qq --no-install-recommends "$deb" >/dev/null
done
python3 -c 'import prehend; print("Python:", prehend.__doc__.splitlines()[0])'
for bridge in /usr/lib/prehend/bin/ros[12]_bridge; do "$bridge" --help >/dev/null; done
g++ -std=c++20 pieces.cpp $(pkg-config --cflags --libs prehend) -o pieces
./pieces
ls /usr/share/doc/prehend/html/index.html
apt-get remove -y -qq 'prehend*' 'libprehend*' python3-prehend >/dev/null
if find / -xdev -path /proc -prune -o -name '*prehend*' -print | grep -vE '^/(debs|trial|var/(lib|log|cache))'; then
  echo "something is left" >&2
  exit 1
fi
END
chroot "$clean" /bin/bash /trial/use.sh
echo "installed, used and removed"
