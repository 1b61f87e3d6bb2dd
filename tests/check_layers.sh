#!/bin/sh
# The folders of src/ form floors: who may include whom. Prints every include that breaks a rule.
#
#   check_layers.sh SOURCE_FOLDER
#
# An engine folder includes itself and the engine folders before it; but audit shares no code with the stages,
# which it judges. scene, render and cli stand on the public headers, not on the engine's, each on those before
# it. A file name without a folder means the same folder. Embree stays behind detect/rays.c and render.
set -eu
cd "$1"
engine="base model predict detect untangle color solve finish audit state"
status=0

complain()
{
    echo "$*"
    status=1
}

# Prints "file included" for every #include "..." of the C files given by find's arguments.
quoted_includes()
{
    find "$@" -name '*.[ch]' -exec grep -HoE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"[^"]+"' {} + |
        sed -E 's/:[^"]*"/ /; s/"$//' | sort
}

# check_folder FOLDER ALLOWED: FOLDER includes only what lies in the folders ALLOWED, and percale/.
check_folder()
{
    [ -d "$1" ] || return 0
    includes=$(quoted_includes "$1")
    while read -r file included; do
        case $included in
        "" | percale/*) ;;
        */*) case " $2 " in *" ${included%/*} "*) ;; *) complain "$file includes $included" ;; esac ;;
        *) [ -f "${file%/*}/$included" ] || complain "$file includes $included, which is not in its folder" ;;
        esac
    done <<EOF_INCLUDES
$includes
EOF_INCLUDES
}

floors=""
for folder in $engine; do
    floors="$floors $folder"
    case $folder in
    audit) check_folder audit "base model audit" ;;
    *) check_folder "$folder" "$floors" ;;
    esac
done
check_folder scene "scene"
check_folder render "scene render"
check_folder cli "scene render cli"

# The pipeline and the solver, in src/ itself, see the whole engine and nothing above it.
for outer in scene render cli; do
    for file in *.[ch]; do
        ! grep -qE "#[[:space:]]*include[[:space:]]*\"$outer/" "$file" 2>/dev/null || complain "$file includes $outer/"
    done
done

for folder in *; do
    [ ! -d "$folder" ] || case " $engine scene render cli " in
    *" $folder "*) ;;
    *) complain "src/$folder is in no floor: give it one in tests/check_layers.sh" ;;
    esac
done

embree=$(grep -rlE '#[[:space:]]*include[[:space:]]*[<"]embree' . | grep -vE '^\./(detect/rays\.c|render/.*)$' | sort)
[ -z "$embree" ] || complain "Embree is included beside detect/rays.c and render:" "$embree"

repeated=$(find . -name '*.[ch]' | sed 's|.*/||' | sort | uniq -d)
[ -z "$repeated" ] || complain "file names that stand twice in src:" "$repeated"

exit $status
