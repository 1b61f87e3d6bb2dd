#!/bin/sh
# An installed percale is found by find_package and by pkg-config, and a program built on it runs: with the
# shared library, the static one and the scene library. CC and CFLAGS are those that built percale.
#
#   check_install.sh CMAKE BUILD_FOLDER EXAMPLE.c
set -eu
cmake=$1
build=$2
example=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cmake" --install "$build" --prefix "$folder/prefix" >"$folder/install.log"
"$folder/prefix/bin/percale" scenes >"$folder/scenes.log" || { echo "the installed percale does not run"; exit 1; }

cp "$example" "$folder/main.c"
cat >"$folder/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(consumer LANGUAGES C)
find_package(percale 0.1 REQUIRED)
foreach(library percale percale_static scene)
  add_executable(use_${library} main.c)
  target_link_libraries(use_${library} PRIVATE percale::${library})
endforeach()
END
{
    "$cmake" -S "$folder" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/prefix" &&
        "$cmake" --build "$folder/build"
} >"$folder/build.log" 2>&1 || { cat "$folder/build.log"; exit 1; }
for library in percale percale_static scene; do
    echo "find_package, $library"
    "$folder/build/use_$library"
done

PKG_CONFIG_PATH=$(dirname "$(find "$folder/prefix" -name percale.pc)")
export PKG_CONFIG_PATH
echo "pkg-config"
# shellcheck disable=SC2046,SC2086 # flags are words
$CC ${CFLAGS-} "$folder/main.c" $(pkg-config --cflags --libs percale) -o "$folder/use_pkg_config"
LD_LIBRARY_PATH=$(pkg-config --variable=libdir percale) "$folder/use_pkg_config"
