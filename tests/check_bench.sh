#!/bin/sh
# The benchmark program's contract: its list, its filter, what it refuses, and what its reports hold. Says nothing
# about speed.
#
#   check_bench.sh PERCALE_BENCH
set -eu
bench=$1
case $bench in /*) ;; *) bench=$PWD/$bench ;; esac
[ -x "$bench" ] || { echo "$bench is no program"; exit 1; }
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

# call ARGUMENTS...: runs percale-bench; $code is its exit code.
call()
{
    code=0
    "$bench" "$@" >"$said.out" 2>"$said.err" || code=$?
}

# accept ARGUMENTS...: exit 0 and nothing on stderr, which is no terminal here.
accept()
{
    call "$@"
    [ "$code" = 0 ] || complain "percale-bench $*: exit code $code: $(cat "$said.err")"
    [ ! -s "$said.err" ] || complain "percale-bench $*: on stderr: $(cat "$said.err")"
}

cheap="--benchmark_filter=barrier|drape_hang --benchmark_min_time=1x --sizes=100 --frames=1 --threads=1"

# refuse CODE CULPRIT ARGUMENTS...: that exit code, one line on stderr that names the culprit (an extended regular
# expression), nothing written.
refuse()
{
    expected=$1
    culprit=$2
    shift 2
    before=$(ls -RA)
    # shellcheck disable=SC2086 # a list of words
    case $1 in
    --*) set -- $cheap "$@" ;; # should it not be refused, then at least it doesn't measure everything
    esac
    call "$@"
    [ "$code" = "$expected" ] || complain "percale-bench $*: exit code $code instead of $expected"
    [ "$(wc -l <"$said.err")" = 1 ] || complain "percale-bench $*: not one line on stderr: $(cat "$said.err")"
    grep -qE "^percale: bench: .*($culprit)" "$said.err" ||
        complain "percale-bench $*: '$(cat "$said.err")' does not name $culprit"
    [ ! -s "$said.out" ] || complain "percale-bench $*: something on stdout"
    [ "$(ls -RA)" = "$before" ] || complain "percale-bench $*: something has been written"
}

# json FILE: strictly valid JSON without null: with strings, numbers and words as single letters, the innermost
# lists and objects become values until one value is left.
json()
{
    left=$(tr -d '\n' <"$1" | sed -E 's/"([^"\\]|\\.)*"/S/g; s/ +//g
        s/-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][+-]?[0-9]+)?/V/g; s/true|false/V/g
        :again
        s/\[(([VS],)*[VS])?\]/V/g; s/\{(S:[VS](,S:[VS])*)?\}/V/g; t again')
    [ "$left" = V ] || complain "$1 is no valid JSON: it leaves $left"
}

# values FILE KEY: what KEY has in a report, one line each, without quotation marks.
values()
{
    sed -nE "s/^ *\"$2\": \"?([^\",]*)\"?,?\$/\1/p" "$1"
}

# expect FILE KEY VALUES...: KEY has exactly these, in order.
expect()
{
    file=$1
    key=$2
    shift 2
    [ "$(values "$file" "$key" | tr '\n' ' ')" = "$* " ] ||
        complain "$file: $key is $(values "$file" "$key" | tr '\n' ' ')instead of $*"
}

# ---- what there is ----

accept --version
grep -qE '^percale-bench [0-9]+\.[0-9]+\.[0-9]+$' "$said.out" || complain "--version: $(cat "$said.out")"
accept --help
for word in --benchmark_filter --benchmark_out_format --frames --set --preset --sizes --threads interleaved; do
    grep -qe "$word" "$said.out" || complain "--help does not name $word"
done

accept --benchmark_list_tests --threads=1,2
for name in kernel/triad/262144 kernel/triad/67108864 kernel/stretch/40000 kernel/stretch/160000 \
    kernel/stretch/640000 kernel/bend/40000 kernel/barrier kernel/rays/40000 scene/drape_hang/16384 \
    scene/drape_obstacle/1048576 scene/drape_hang_tight/16384 scene/drape_obstacle_tight/16384 scene/dress/20000 \
    scene/flag/9600 scene/funnel/10000 scene/twist/10000 scene/cards/10000; do
    for threads in 1 2; do
        grep -qx "$name/threads:$threads" "$said.out" || complain "the list has no $name/threads:$threads"
    done
done
[ "$(grep -c 'coloring/.*/threads:1$' "$said.out")" = 3 ] || complain "the list has not three colourings"
[ "$(grep -c 'coloring/.*/threads:2$' "$said.out")" = 0 ] || complain "the list has a colouring with two threads"
[ -z "$(sort "$said.out" | uniq -d)" ] || complain "names stand twice in the list: $(sort "$said.out" | uniq -d)"
mv "$said.out" "$said.all"

# listed EXPECTED ARGUMENTS...: the list is what grep finds in the whole one.
listed()
{
    filter=$1
    shift
    call --benchmark_list_tests=true --threads=1,2 "--benchmark_filter=$filter"
    "$@" <"$said.all" | diff - "$said.out" >"$said.diff" || complain "filter $filter: $(cat "$said.diff")"
}
listed all cat
listed '' cat
listed 'stretch/.*:2$' grep 'stretch/.*:2$'
listed 'kernel/(triad|bend)' grep -E 'kernel/(triad|bend)'
listed '-scene|triad' grep -vE 'scene|triad'
accept --benchmark_list_tests --benchmark_filter='scene/d.*s[st]' --sizes=100,200 --threads=3
[ "$(tr '\n' ' ' <"$said.out")" = "scene/drape_obstacle/100/threads:3 scene/drape_obstacle/200/threads:3 \
scene/drape_obstacle_tight/100/threads:3 scene/drape_obstacle_tight/200/threads:3 \
scene/dress/100/threads:3 scene/dress/200/threads:3 " ] || complain "--sizes, --threads: $(cat "$said.out")"

# ---- refused ----

refuse 1 'nosuchentry' --benchmark_filter=nosuchentry
refuse 2 '--benchmark_filter.*\(' '--benchmark_filter=('
refuse 2 '--frobnicate' --frobnicate
refuse 2 '--benchmark_frobnicate=1' --benchmark_frobnicate=1
refuse 2 'extra' --benchmark_list_tests extra
refuse 2 'tradeoff: not in this version' tradeoff drape --out out
refuse 2 'compare: not in this version' compare old.json new.json
refuse 2 '--benchmark_list_tests.*maybe' --benchmark_list_tests=maybe
refuse 2 '--benchmark_min_time.*long' --benchmark_min_time=long
refuse 2 '--benchmark_min_time.*-1' --benchmark_min_time=-1
refuse 2 '--benchmark_min_time.*0' --benchmark_min_time=0x
refuse 2 '--benchmark_min_time' --benchmark_min_time
refuse 2 '--benchmark_repetitions.*0' --benchmark_repetitions=0
refuse 2 '--benchmark_format.*xml' --benchmark_format=xml
refuse 2 '--benchmark_out_format.*xml' --benchmark_out_format=xml
refuse 2 '--benchmark_out.*nowhere' --benchmark_out=nowhere/report.json
refuse 2 '--benchmark_out' --benchmark_out=
refuse 2 '--benchmark_color.*green' --benchmark_color=green
refuse 2 '--benchmark_time_unit.*h' --benchmark_time_unit=h
refuse 2 '--benchmark_context.*nothing' --benchmark_context=key=value,nothing
refuse 2 '--frames.*0' --frames=0
refuse 2 '--sizes.*1e6' --sizes=1e6
refuse 2 '--threads.*257' --threads=1,257
refuse 2 '--threads' --threads=1,,2
refuse 2 '--set.*substeps' --set=substeps
refuse 2 'substep' --set=substep=3
refuse 2 'fastest' --preset=fastest

# ---- a tiny scene: valid reports, the same state with one thread and two ----

tiny="--benchmark_filter=scene/drape_obstacle/ --sizes=400 --frames=3 --threads=1,2"
# shellcheck disable=SC2086 # lists of words
accept $tiny --benchmark_format=json --benchmark_context=answer=42,host=here --set=substeps=2 --preset=swift
cp "$said.out" report.json
json report.json
for key in date host_name executable num_cpus mhz_per_cpu cpu_scaling_enabled caches load_avg library_build_type cpu \
    isa isa_available compiler flags percale embree; do
    grep -q "^    \"$key\": " report.json || complain "the context has no $key"
done
values report.json date | grep -qE '^[0-9]{4}-[01][0-9]-[0-3][0-9]T[0-9:]{8}[+-][0-9]{2}:[0-9]{2}$' ||
    complain "no ISO date with offset: $(values report.json date)"
expect report.json answer 42
expect report.json host here
one=scene/drape_obstacle/400/threads:1
two=scene/drape_obstacle/400/threads:2
expect report.json name $one $two
expect report.json run_name $one $two
expect report.json run_type iteration iteration
expect report.json per_family_instance_index 0 1
expect report.json repetitions 1 1
expect report.json repetition_index 0 0
expect report.json threads 1 2
expect report.json iterations 2 2
expect report.json time_unit ms ms
expect report.json frames 3 3
expect report.json vertices 400 400
expect report.json nonfinite 0 0
for key in family_index real_time cpu_time ms_first ms_min ms_p90 ms_last60 ms_predict ms_detect ms_untangle ms_color \
    ms_solve ms_finish projections_per_frame candidates stencils_vf rays detections detections_skipped colors_max \
    overflow left_inside truncated penetration_max_mm ef_cloth_obstacle stretch_max contact_fraction peak_bytes; do
    [ "$(values report.json $key | wc -l)" = 2 ] || complain "report.json: not two of $key"
done
hash=$(values report.json label | head -n 1)
echo "$hash" | grep -qE '^[0-9a-f]{16}$' || complain "the label is no hash: $hash"
expect report.json label "$hash" "$hash"

# The preset says 2 substeps of 5 iterations, the table 20 of 1; --set wins over both.
projections=$(values report.json projections_stretch | head -n 1)
# shellcheck disable=SC2086
accept $tiny --benchmark_format=json --set=substeps=3 --preset=swift --threads=1
[ $((2 * $(values "$said.out" projections_stretch))) = $((3 * projections)) ] || complain "--set has not won"
# shellcheck disable=SC2086
accept $tiny --benchmark_format=json --threads=1
[ "$(values "$said.out" projections_stretch)" = $((2 * projections)) ] || complain "--preset, or the table, has no effect"

# Repetitions and their aggregates, which are all that is asked for on the screen; the file has all, replaces the old
# one as a whole and leaves nothing beside it.
mkdir out
echo old >out/report.json
ln out/report.json old
# shellcheck disable=SC2086
accept $tiny --threads=1 --benchmark_repetitions=2 --benchmark_display_aggregates_only --benchmark_out=out/report.json \
    --benchmark_enable_random_interleaving=false
[ "$(cat old)" = old ] || complain "--benchmark_out: the old file was written over, not replaced"
[ "$(ls -A out)" = report.json ] || complain "--benchmark_out left $(ls -A out)"
json out/report.json
expect out/report.json name $one $one ${one}_mean ${one}_median ${one}_stddev ${one}_cv ${one}_min
expect out/report.json run_type iteration iteration aggregate aggregate aggregate aggregate aggregate
expect out/report.json aggregate_name mean median stddev cv min
expect out/report.json aggregate_unit time time time percentage time
expect out/report.json repetition_index 0 1
expect out/report.json repetitions 2 2 2 2 2 2 2
[ "$(values out/report.json label | uniq | wc -l)" = 1 ] || complain "the labels of repetitions differ"
grep -q '^Benchmark  *Time  *CPU  *Iterations' "$said.out" || complain "no heading on the console"
[ "$(grep -c "^$one" "$said.out")" = 5 ] || complain "not five aggregates on the console: $(cat "$said.out")"
! grep -q "^$one " "$said.out" || complain "single repetitions on the console"

# shellcheck disable=SC2086
accept $tiny --threads=1 --benchmark_repetitions=2 --benchmark_report_aggregates_only --benchmark_format=csv \
    --benchmark_enable_random_interleaving --benchmark_time_unit=us
[ "$(sed 's/[^,]//g' "$said.out" | sort -u | wc -l)" = 1 ] || complain "CSV: lines of different lengths"
head -n 1 "$said.out" | grep -q '^name,iterations,real_time,cpu_time,time_unit,' || complain "CSV: no header"
[ "$(wc -l <"$said.out")" = 6 ] || complain "CSV: not five aggregates: $(cat "$said.out")"
[ "$(cut -d, -f5 "$said.out" | sort -u | tr '\n' ' ')" = "time_unit us " ] || complain "CSV: not in us"

# A scene that can't be built is an error of its entry; the others go on.
# shellcheck disable=SC2086
call $tiny --benchmark_filter='drape_obstacle/|barrier' --threads=1 --set=passes=1000 --benchmark_min_time=1x \
    --benchmark_format=json
[ "$code" = 1 ] || complain "a scene that can't be built: exit code $code"
grep -q "$one.*passes" "$said.err" || complain "a scene that can't be built: '$(cat "$said.err")'"
cp "$said.out" failed.json
json failed.json
expect failed.json name kernel/barrier/threads:1 $one
expect failed.json error_occurred true
grep -q '"error_message": ".*passes' failed.json || complain "no error_message: $(cat failed.json)"

# ---- kernels, one iteration each ----

accept --benchmark_filter='kernel/(stretch|bend|coloring|rays)/40000|barrier|triad/262144' --benchmark_min_time=1x \
    --threads=1,2 --benchmark_format=json
cp "$said.out" kernels.json
json kernels.json
expect kernels.json iterations 1 1 1 1 1 1 1 1 1 1 1
expect kernels.json constraints 119201 119201 118405 118405 119201
[ "$(values kernels.json items_per_second | wc -l)" = 9 ] || complain "not nine items_per_second"
[ "$(values kernels.json bytes_per_second | wc -l)" = 6 ] || complain "not six bytes_per_second"
[ "$(values kernels.json triad_fraction | wc -l)" = 4 ] || complain "not four triad_fraction"
[ "$(values kernels.json label | grep -cxE '[0-9a-f]{16}')" = 7 ] || complain "not seven hashes"
[ "$(values kernels.json label | sort -u | wc -l)" = 4 ] || complain "hashes differ between thread counts"
values kernels.json hit_fraction | grep -qE '^0\.0[23]' || complain "hit_fraction is not near 0.03"

# As many iterations as fill the time.
accept --benchmark_filter=barrier --benchmark_min_time=0.001s --threads=1 --benchmark_format=json \
    --benchmark_list_tests=false
[ "$(values "$said.out" iterations)" -gt 10 ] || complain "a barrier of one thread fills 1 ms: $(cat "$said.out")"

exit $status
