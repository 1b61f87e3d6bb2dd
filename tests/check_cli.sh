#!/bin/sh
# The command line's contract: what it refuses, with which words and exit code, and what a good run writes.
#
#   check_cli.sh PERCALE
set -eu
percale=$1
case $percale in /*) ;; *) percale=$PWD/$percale ;; esac
[ -x "$percale" ] || { echo "$percale is no program"; exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
said=$folder/said # what the last command printed: $said.out, $said.err
mkdir "$folder/here"
cd "$folder/here"
status=0

complain()
{
    echo "$*"
    status=1
}

# call ARGUMENTS...: runs percale; $code is its exit code.
call()
{
    code=0
    "$percale" "$@" >"$said.out" 2>"$said.err" || code=$?
}

# ---- input files, good and bad ----

# A sheet of four vertices above a table of four.
cat >sheet.obj <<'EOF_OBJ'
v 0 1 0
v 1 1 0
v 1 1 1
v 0 1 1
f 1 3 2
f 1 4 3
EOF_OBJ
cat >table.obj <<'EOF_OBJ'
v -2 0 -2
v 3 0 -2
v 3 0 3
v -2 0 3
f 1 3 2
f 1 4 3
EOF_OBJ
# A sheet that hangs through the first one: its lower rim is below.
cat >hung.obj <<'EOF_OBJ'
v 0.2 0.9 0.4
v 0.8 0.9 0.45
v 0.2 1.7 0.5
v 0.8 1.7 0.5
f 1 2 3
f 2 4 3
EOF_OBJ
echo '[[0, 99]]' >seams.json
sed 's/^v 1 1 1$/v 1 nan 1/' sheet.obj >nan.obj
sed 's/^f 1 4 3$/f 1 4 9/' sheet.obj >index.obj
sed 's/^f 1 4 3$/f 1 4 4/' sheet.obj >twice.obj
sed 's/^v 0 1 1$/v 0.5 1 0.5/' sheet.obj >flat.obj
head -n 3 sheet.obj >less.obj
: >empty.obj

# scene FILE OBJ [MORE]: writes a scene file with one cloth; MORE goes into the cloth.
scene()
{
    printf '{ "frames": 3,\n  "cloths": [ { "name": "sheet", "obj": "%s"%s } ],\n' "$2" "${3:-}" >"$1"
    printf '  "obstacles": [ { "name": "table", "obj": "table.obj" } ] }\n' >>"$1"
}
scene good.json sheet.obj
scene missing.json nowhere.obj
scene nan.json nan.obj
scene index.json index.obj
scene empty.json empty.obj
scene twice.json twice.obj
scene flat.json flat.obj
scene pin.json sheet.obj ', "pins": [ 17 ]'
scene key.json sheet.obj ', "thicknes": 0.002'
printf '{ "frames": 3, "cloths": [ ] }\n' >no_cloth.json
printf '{ "frames": 3,\n' >torn.json

# ---- refused: exit 2, one line on stderr that names the culprit, nothing written ----

# refuse CULPRIT ARGUMENTS...: CULPRIT is an extended regular expression.
refuse()
{
    culprit=$1
    shift
    before=$(ls -RA)
    call "$@"
    [ "$code" = 2 ] || complain "percale $*: exit code $code instead of 2"
    [ "$(wc -l <"$said.err")" = 1 ] || complain "percale $*: not one line on stderr: $(cat "$said.err")"
    grep -qE "^percale: .*($culprit)" "$said.err" ||
        complain "percale $*: '$(cat "$said.err")' does not name $culprit"
    [ ! -s "$said.out" ] || complain "percale $*: something on stdout"
    [ "$(ls -RA)" = "$before" ] || complain "percale $*: something has been written"
}

# refuse_run CULPRIT ARGUMENTS...: with every kind of output asked for.
refuse_run()
{
    culprit=$1
    shift
    refuse "$culprit" run "$@" --out out --json report.json --picture picture.png
}

refuse 'command'
refuse 'frobnicate' frobnicate
refuse 'scene' run
refuse 'nowhere' scenes nowhere
refuse '--frobnicate' scenes --frobnicate

refuse_run 'nosuchscene' nosuchscene
refuse_run 'nowhere\.json' nowhere.json
refuse_run 'nowhere\.obj' missing.json
refuse_run 'nan\.obj.*3' nan.json
refuse_run 'index\.obj.*6' index.json
refuse_run 'empty\.obj' empty.json
refuse_run 'cloth' no_cloth.json
refuse_run 'key\.json.*2.*thicknes' key.json
refuse_run 'torn\.json' torn.json
refuse_run 'sheet.*17|17.*sheet' pin.json
refuse_run 'twice\.obj:6.*4' twice.json
refuse_run 'triangle 1' flat.json

refuse_run 'extra' good.json extra
refuse_run '--frobnicate' good.json --frobnicate
refuse_run '--threads.*0' good.json --threads 0
refuse_run '--threads.*257' good.json --threads=257
refuse_run '--threads.*100000000' good.json --threads 100000000
refuse_run '--threads.*99999999999999999999' good.json --threads 99999999999999999999
refuse_run '--size.*128\*128' drape --size '128*128'
refuse_run '--size.*0' drape --size 0
refuse_run '--size.*-5' drape --size -5
refuse_run '--size.*1e6' drape --size 1e6
refuse_run '--size.*1000000000' drape --size 1000000000
refuse_run '--frames.*0' good.json --frames 0
refuse_run '--frames.*many' good.json --frames many
refuse_run '--audit.*0' good.json --audit 0
refuse_run '--quiet' good.json --quiet=no
refuse_run '--format.*abc' good.json --format abc
refuse_run '--heat.*mud' good.json --heat mud
refuse_run 'fastest' good.json --preset fastest
refuse_run 'no_value' good.json --set no_value
refuse_run '=1' good.json --set =1
refuse_run 'substep' good.json --set substep=3
refuse_run 'substeps' good.json --set substeps=0
refuse_run 'substeps' good.json --set substeps=two
refuse_run 'friction' good.json --set friction=nan
refuse_run 'friction' good.json --set friction=-1
refuse_run 'reuse' good.json --set reuse=sometimes
refuse_run 'gravity' good.json --set gravity=1,2
refuse_run 'passes' good.json --set substeps=2 --set iterations=3 --set passes=7

# What is not built yet is known by name, and refused.
refuse_run '--error-below' good.json --error-below 1
refuse_run '--resume' good.json --resume state
refuse_run '--capsule' good.json --capsule capsule
refuse_run 'untangle' good.json --set untangle=perhaps

# Untangling: what is missing, unreadable or unknown.
refuse '--out' untangle sheet.obj
refuse 'no cloth' untangle --out out
refuse 'nowhere\.obj' untangle nowhere.obj --out out
refuse 'nan\.obj.*2|nan\.obj.*3' untangle nan.obj --out out
refuse 'flat|area' untangle flat.obj --out out
refuse "two cloths are named 'sheet'" untangle sheet.obj sheet.obj --out out
refuse 'thickness' untangle sheet.obj --out out --set thickness=-1
refuse 'friction' untangle sheet.obj --out out --set friction=1
refuse '--threads' untangle sheet.obj --out out --threads 0
refuse 'seams\.json.*pair 0' untangle sheet.obj --out out --seams seams.json
refuse 'table\.obj.*line' untangle sheet.obj --out out --seams table.obj
refuse '--json.*nowhere' untangle sheet.obj --out out --json nowhere/report.json

# Where results can't go.
refuse '--out.*sheet\.obj' run good.json --out sheet.obj
refuse '--out' run good.json --out=
refuse '--out' run good.json --out
refuse '--out.*sheet\.obj/out' run good.json --out sheet.obj/out
refuse '--json.*nowhere' run good.json --out out --json nowhere/report.json
refuse '--json' run good.json --out out --json .
refuse '--picture.*nowhere' run good.json --out out --picture nowhere/picture.png
sed 's/"name": "sheet"/"name": "..\/sheet"/' good.json >parent.json
refuse '\.\./sheet' run parent.json --out out

refuse '--cloth' audit
refuse 'sheet\.obj' audit sheet.obj
refuse 'nowhere\.obj' audit --cloth nowhere.obj --json report.json
refuse 'nan\.obj' audit --cloth sheet.obj nan.obj --json report.json
refuse 'index\.obj' audit --cloth sheet.obj --obstacle index.obj --json report.json
refuse 'less\.obj.*3.*sheet\.obj.*4|less\.obj' audit --cloth sheet.obj --rest less.obj
refuse '--rest.*1.*2' audit --cloth sheet.obj --cloth sheet.obj --rest sheet.obj
refuse '--thickness.*thick' audit --cloth sheet.obj --thickness thick
refuse '--thickness.*-1' audit --cloth sheet.obj --thickness -1
refuse '--json.*nowhere' audit --cloth sheet.obj --json nowhere/report.json

# ---- accepted ----

# accept ARGUMENTS...: exit 0 and nothing on stderr, which is no terminal here.
accept()
{
    call "$@"
    [ "$code" = 0 ] || complain "percale $*: exit code $code: $(cat "$said.err")"
    [ ! -s "$said.err" ] || complain "percale $*: on stderr: $(cat "$said.err")"
}

# keys FILE: the keys of a report, in its order.
keys()
{
    sed -n 's/^ *"\([a-z_0-9]*\)":.*/\1/p' "$1"
}

# same_keys FILE KEYS...: FILE has exactly these, in this order.
same_keys()
{
    file=$1
    shift
    printf '%s\n' "$@" >"$said.keys"
    keys "$file" | diff "$said.keys" - >"$said.diff" || complain "keys of $file: $(cat "$said.diff")"
    ! grep -qiE '(nan|inf|null)[,} ]*$' "$file" || complain "$file: NaN, Infinity or null"
}

quality="penetration_max_mm penetration_p99_mm penetration_obstacle_mm vertices_inside ef_cloth_cloth
    ef_cloth_obstacle ef_seam stretch_max stretch_p99 contact_fraction nonfinite"

accept --version
grep -qE '^percale [0-9]+\.[0-9]+\.[0-9]+$' "$said.out" || complain "--version: $(cat "$said.out")"
accept --help
for word in scenes run audit untangle --error-below --resume --capsule --picture; do
    grep -qe "$word" "$said.out" || complain "--help does not name $word"
done
accept scenes
for word in drape dress layers; do
    grep -qE "^$word +[^ ]" "$said.out" || complain "scenes does not list $word"
done
accept scenes drape
grep -qE '^thickness +0\.002 +m +' "$said.out" || complain "scenes drape: no default, unit and range of thickness"

# A report has every key, in order; the point cache every frame and the start; the picture is a PNG.
settings=$("$percale" scenes good.json | sed -n '2,/^$/s/^\([a-z_]*\) .*/\1/p')
accept run good.json --frames 4 --threads 1 --preset=balanced --set substeps=2 --set iterations=1 --set passes=2 \
    --audit 2 --out results/deep --json report.json --picture picture.png --heat stretch
grep -q 'state hash' "$said.out" || complain "run: no table on stdout"
# shellcheck disable=SC2086 # lists of words
same_keys report.json percale scene preset threads isa frames vertices triangles obstacle_triangles settings \
    $settings ms_per_frame_median ms_per_frame_p90 ms_per_frame_last60 stage_ms predict detect untangle color \
    solve finish work projections projections_stretch projections_bend projections_tether projections_link projections_seam \
    projections_contact candidates stencils_vf stencils_ee rays detections detections_skipped missed \
    born_crossed pinched left_inside left_crossed truncated colors_max overflow last_crossed_frame quality $quality quality_last \
    $quality bytes model detect color solve arena peak_bytes state_hash
for pair in 'threads 1' 'frames 4' 'vertices 4' 'triangles 2' 'obstacle_triangles 2' 'substeps 2'; do
    grep -qE "^ *\"${pair% *}\": ${pair#* }," report.json || complain "report.json: $pair expected"
done
grep -qE '"state_hash": "[0-9a-f]{16}"' report.json || complain "report.json: state_hash is not 16 hex digits"
[ "$(ls -A results/deep)" = "sheet.obj
sheet.pc2" ] || complain "--out: $(ls -A results/deep)"
# 32 bytes of header, then 5 samples of 4 vertices of 12 bytes
[ "$(wc -c <results/deep/sheet.pc2)" = 272 ] || complain "sheet.pc2 does not have 5 samples"
[ "$(head -c 8 picture.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] || complain "picture.png is no PNG"

# The same run again, once more to standard output alone: the same state.
hash=$(sed -n 's/.*"state_hash": //p' report.json)
accept run good.json --frames 4 --threads 2 --set substeps=2 --set iterations=1 --set passes=2 --json -
head -c 1 "$said.out" | grep -q '{' || complain "--json -: something before the JSON"
[ "$(tail -n 1 "$said.out")" = "}" ] || complain "--json -: something after the JSON"
[ "$(sed -n 's/.*"state_hash": //p' "$said.out")" = "$hash" ] || complain "another hash with two threads"

accept run good.json --quiet --format obj --out frames
[ ! -s "$said.out" ] || complain "--quiet prints"
[ "$(cd frames && echo *)" = "sheet_0000.obj sheet_0001.obj sheet_0002.obj sheet_0003.obj" ] ||
    complain "--format obj: $(ls -A frames)"

accept audit --cloth sheet.obj --rest sheet.obj --obstacle table.obj --json audit.json
grep -q penetration_max_mm "$said.out" || complain "audit: no table on stdout"
# shellcheck disable=SC2086 # a list of words
same_keys audit.json percale cloths obstacles vertices triangles obstacle_triangles thickness quality $quality
# Untangling writes the cloths under their names and nothing else, and what it writes is clean.
accept untangle sheet.obj hung.obj --obstacle table.obj --out apart --json apart.json --threads 1
grep -q 'pairs before, after' "$said.out" || complain "untangle: no table on stdout"
[ "$(ls -A apart)" = "hung.obj
sheet.obj" ] || complain "untangle --out: $(ls -A apart)"
# shellcheck disable=SC2086 # lists of words
same_keys apart.json percale threads isa cloths obstacles vertices triangles obstacle_triangles settings thickness \
    layers rounds sweeps patience ef_before ef_after iterations momentum_drift displacement_max_mm contours_before \
    contours_after contour_length_before_mm contour_length_after_mm ms quality_before $quality quality $quality state_hash
grep -qE '^ *"ef_before": [1-9]' apart.json || complain "untangle: nothing crossed before"
grep -qE '^ *"ef_after": 0,' apart.json || complain "untangle: something crosses after"
accept audit --cloth apart/sheet.obj apart/hung.obj --json -
grep -qE '"ef_cloth_cloth": 0,' "$said.out" || complain "untangle: what it has written crosses"
cp sheet.obj same.obj
call untangle sheet.obj same.obj hung.obj --set rounds=1 --set sweeps=1 --set thickness=0 --quiet --out apart
[ "$code" = 0 ] || [ "$code" = 1 ] || complain "untangle: exit code $code"
[ ! -s "$said.out" ] || complain "untangle --quiet: something on stdout"
accept audit --cloth sheet.obj --cloth=table.obj --json -
grep -q '"cloths": 2,' "$said.out" || complain "audit: not two cloths"

exit $status
