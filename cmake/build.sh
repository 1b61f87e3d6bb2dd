#!/bin/sh
# Builds one preset (default: release) into build/<preset>, after installing what is missing.
set -eu
cd "$(dirname "$0")/.."
preset=${1-release}

sh cmake/setup.sh
echo "build.sh: preset $preset"
cmake --preset "$preset"
cmake --build --preset "$preset" --parallel "$(nproc)"
