#!/bin/sh
# The demo: installs what is missing, builds, and lets a sewn dress walk on a mannequin for two seconds.
set -eu
cd "$(dirname "$0")/.."

sh cmake/build.sh
echo "demo.sh: 120 frames of the dress on 2 threads"
mkdir -p out
build/release/percale run dress --size 20000 --frames 120 --threads 2 --preset accurate \
    --out out/dress --json out/dress.json --picture out/dress.png

echo
echo "picture         out/dress.png"
echo "figures         out/dress.json"
echo "meshes, motion  out/dress/  (OBJ and PC2: Blender, Houdini, Maya and Marvelous Designer read them)"
