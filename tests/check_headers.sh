#!/bin/sh
# Each public header compiles alone, twice in a row, without a warning, with the include folder as its only path.
#
#   check_headers.sh INCLUDE_FOLDER COMPILER [FLAG ...]
set -eu
include=$1
shift
count=0
for header in "$include"/percale/*.h; do
    name="percale/${header##*/}"
    printf '#include "%s"\n#include "%s"\n' "$name" "$name" |
        "$@" -I"$include" -Wall -Wextra -Wpedantic -Wshadow -Wundef -Werror -fsyntax-only - ||
        { echo "check_headers.sh: $name does not compile alone with: $*"; exit 1; }
    count=$((count + 1))
done
echo "$count headers"
