#!/bin/sh
# Installs the Debian packages that percale needs, where they are missing; the one list of them.
#
#   sh cmake/setup.sh         what it takes to build and to test
#   sh cmake/setup.sh ci      that, and what .ci/run uses besides
#
# Does nothing when all is there. Without apt-get it only says what is needed.
set -eu

# libtbb-dev (asked for by Embree's CMake package) and zlib1g-dev (by libpng's) come as their dependencies.
# g++ is for one test alone: the public headers compile as C++.
packages="gcc libc6-dev make cmake pkg-config libembree-dev libjansson-dev libpng-dev check g++"
# libomp-dev: clang's OpenMP and libarcher; libclang-rt-dev: its sanitizers; llvm: llvm-symbolizer.
ci_packages="clang clang-format clang-tidy libomp-dev libclang-rt-dev llvm shellcheck"

case "${1-}" in
"") ;;
ci) packages="$packages $ci_packages" ;;
*) echo "setup.sh: unknown argument '$1' (only 'ci' is known)" >&2; exit 2 ;;
esac

if ! command -v apt-get >/dev/null; then
    echo "setup.sh: no apt-get here; going on as if these were installed: $packages"
    exit 0
fi

missing=""
for package in $packages; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "setup.sh: run as root, or install first:$missing" >&2; exit 1; }
    as_root=sudo
fi

# A mirror may stumble: everything is tried a second time.
apt_get()
{
    set -- $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y "$@"
    "$@" </dev/null || { echo "setup.sh: once more: $*"; sleep 5; "$@" </dev/null; }
}

echo "setup.sh: installing with apt-get:$missing"
apt_get update || echo "setup.sh: going on with the package lists that are here"
# shellcheck disable=SC2086 # the list is split into packages on purpose
apt_get install --no-install-recommends $missing
