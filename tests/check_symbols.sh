#!/bin/sh
# The shared library exports exactly what the public headers declare, and every symbol that a static library
# defines for others starts with percale_.
#
#   check_symbols.sh HEADER_FOLDER SHARED_LIBRARY STATIC_LIBRARY ...
set -eu
headers=$1
shared=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
status=0

# What sanitizers, gcov and OpenMP (.gomp_critical) add is theirs.
defined_symbols() { nm "$@" --defined-only --extern-only | awk 'NF == 3 && $3 !~ /^(_*(asan|odr_asan|tsan|ubsan|sanitizer|gcov|llvm)|[.]gomp_)/ { print $3 }'; }

# scene.h belongs to the scene library, which is static.
cat "$headers/percale.h" "$headers/geometry.h" | tr '\n' ' ' | sed 's/PERCALE_API/\n&/g' |
    sed -n 's/^PERCALE_API [^(]*[ *]\([a-z_0-9]*\)(.*/\1/p' | sort >"$folder/declared"
[ -s "$folder/declared" ] || { echo "no PERCALE_API found in $headers"; exit 1; }

defined_symbols --dynamic "$shared" | sort >"$folder/exported"
if ! diff "$folder/declared" "$folder/exported" >"$folder/difference"; then
    echo "declared in the headers (<), exported by $shared (>):"
    grep '^[<>]' "$folder/difference"
    status=1
fi

for library in "$@"; do
    defined_symbols "$library" | sort >"$folder/defined"
    [ -s "$folder/defined" ] || { echo "$library defines nothing"; status=1; }
    if grep -v '^percale_' "$folder/defined" >"$folder/foreign"; then
        echo "symbols of $library without the percale_ prefix:"
        cat "$folder/foreign"
        status=1
    fi
done
exit $status
