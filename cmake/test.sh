#!/bin/sh
# The tests: installs what is missing, builds, and runs every test of the release build.
set -eu
cd "$(dirname "$0")/.."

sh cmake/build.sh
ctest --preset release --no-tests=error
