// percale-bench: measures percale's kernels and scenes. The table of contents: flags, entries, measurement,
// report.

#include "bench_console.h"
#include "bench_context.h"
#include "bench_csv.h"
#include "bench_json.h"
#include "bench_run.h"
#include "bench_scene_run.h"
#include "cli/complaint.h"
#include "cli/destination.h"
#include "scene/output_file.h"

#include <string.h>

static const char HELP[] =
    "percale-bench: measures percale's kernels and scenes; flags and JSON are Google Benchmark's\n"
    "\n"
    "  --benchmark_list_tests           name the entries and stop\n"
    "  --benchmark_filter=<regex>       entries whose name matches (POSIX extended; 'all'); a leading '-' "
    "takes "
    "the others\n"
    "  --benchmark_min_time=<seconds>   a kernel is repeated until it has run so long (0.5); <n>x: n "
    "iterations\n"
    "  --benchmark_repetitions=<n>      measures everything n times. Repetitions are interleaved: the first "
    "of "
    "all\n"
    "                                   entries, then the second of all, since machines are noisy\n"
    "  --benchmark_enable_random_interleaving    the same in random order\n"
    "  --benchmark_report_aggregates_only        no single repetitions, only mean, median, stddev, cv and "
    "min\n"
    "  --benchmark_display_aggregates_only       the same on the screen; the file has all\n"
    "  --benchmark_format=console|json|csv       of standard output\n"
    "  --benchmark_out=<file>           a report in a file as well, written under a temporary name and "
    "renamed\n"
    "  --benchmark_out_format=console|json|csv   of that file (json)\n"
    "  --benchmark_color=auto|true|false\n"
    "  --benchmark_counters_tabular     counters in columns\n"
    "  --benchmark_time_unit=ns|us|ms|s (kernels ns, scenes ms)\n"
    "  --benchmark_context=<key>=<value>[,...]   noted in the report; may be given again\n"
    "  --help, --version\n"
    "\n"
    "percale's own; all but --threads are for the scene entries:\n"
    "  --threads=<n,n,...>              thread counts (1, 2 and the machine's cores)\n"
    "  --sizes=<n,n,...>                cloth vertices, instead of the entries' own\n"
    "  --frames=<n>                     steps of a run, instead of the entries' own\n"
    "  --preset=<name>                  swift, balanced or accurate\n"
    "  --set=<key>=<value>              any setting of the scene; may be given again\n"
    "\n"
    "  percale-bench tradeoff, percale-bench compare    not in this version\n"
    "\n"
    "The console shows a scene's most important counters, JSON and CSV all of them. An entry's label is a "
    "hash\n"
    "of its final state: a difference between repetitions or thread counts is an error.\n"
    "\n"
    "Exit codes: 0 done; 1 an entry failed, hashes differ, or no entry matches; 2 bad arguments.\n";

/// What the callbacks of a run need.
typedef struct Session {
    const char *executable;
    BenchFlags flags;
    BenchEntries entries;
    json_t *context;
    BenchConsole console; // standard output, when that is its format
} Session;

static void print_entry(void *user, const BenchEntry *entry)
{
    Session *session = user;
    if (session->flags.format == BENCH_CONSOLE && !bench_console_entry(&session->console, entry)) {
        (void)percale_complain(PERCALE_EXIT_FAILED, "bench: %s: out of memory", entry->name);
    }
}

static bool write_console(FILE *stream, const Session *session, bool aggregates_only)
{
    BenchConsole console =
        bench_console_begin(stream, &session->flags, session->context, &session->entries, aggregates_only);
    bool done = true;
    for (size_t index = 0; done && index < session->entries.count; ++index) {
        done = bench_console_entry(&console, &session->entries.items[index]);
    }
    return done;
}

static bool write_report(FILE *stream, const Session *session, int format, bool aggregates_only)
{
    if (format == BENCH_JSON) {
        return bench_json_write(stream, session->context, &session->entries, &session->flags,
                                aggregates_only);
    }
    if (format == BENCH_CSV) {
        return bench_csv_write(stream, &session->entries, &session->flags, aggregates_only);
    }
    return write_console(stream, session, aggregates_only);
}

static bool write_file(const Session *session, PercaleSceneError *error)
{
    const BenchFlags *flags = &session->flags;
    PercaleOutputFile file;
    if (flags->out == NULL) {
        return true;
    }
    if (!percale_output_open(&file, flags->out, error)) {
        return false;
    }
    if (write_report(file.stream, session, flags->out_format, flags->report_aggregates_only)) {
        return percale_output_commit(&file, error);
    }
    percale_output_discard(&file);
    (void)snprintf(error->text, sizeof error->text, "%s: can't be written", flags->out);
    return false;
}

/// Measures and reports; returns the exit code.
static int measure(Session *session)
{
    const BenchFlags *flags = &session->flags;
    bool aggregates_only = flags->report_aggregates_only || flags->display_aggregates_only;
    bool to_console = flags->format == BENCH_CONSOLE;
    PercaleSceneError error = {""};
    session->context = bench_context(session->executable, flags);
    if (to_console) {
        session->console =
            bench_console_begin(stdout, flags, session->context, &session->entries, aggregates_only);
    }
    int code = PERCALE_EXIT_DONE;
    if (!bench_run(&session->entries, flags, print_entry, session)) {
        code = percale_complain(PERCALE_EXIT_FAILED, "bench: out of memory");
    } else if (!to_console && !write_report(stdout, session, flags->format, aggregates_only)) {
        code = percale_complain(PERCALE_EXIT_FAILED, "bench: standard output can't be written");
    }
    if (code == PERCALE_EXIT_DONE && !write_file(session, &error)) {
        code = percale_complain(PERCALE_EXIT_FAILED, "bench: --benchmark_out: %s", error.text);
    }
    bool all_good = bench_all_good(&session->entries);
    bool labels_agree = bench_labels_agree(&session->entries);
    if (!all_good || !labels_agree) {
        code = PERCALE_EXIT_FAILED;
    }
    json_decref(session->context);
    return code;
}

static int list(const BenchEntries *entries)
{
    for (size_t index = 0; index < entries->count; ++index) {
        (void)printf("%s\n", entries->items[index].name);
    }
    return PERCALE_EXIT_DONE;
}

/// Everything that the user can get wrong.
static bool check(const Session *session, PercaleSceneError *error)
{
    const BenchFlags *flags = &session->flags;
    if (flags->out != NULL && !percale_destination_file("--benchmark_out", flags->out, error)) {
        return false;
    }
    for (size_t index = 0; index < session->entries.count; ++index) {
        const BenchEntry *entry = &session->entries.items[index];
        if (entry->scene != NULL && !bench_scene_check(entry, flags, error)) {
            return false;
        }
    }
    return true;
}

static int run_entries(Session *session)
{
    PercaleSceneError error = {""};
    const char *filter = session->flags.filter;
    if (!bench_entries_make(&session->flags, &session->entries, &error)) {
        return percale_complain(PERCALE_EXIT_FAILED, "bench: %s", error.text);
    }
    int code;
    if (!bench_entries_filter(&session->entries, filter, &error) || !check(session, &error)) {
        code = percale_complain(PERCALE_EXIT_USAGE, "bench: %s", error.text);
    } else if (session->entries.count == 0) {
        code =
            percale_complain(PERCALE_EXIT_FAILED, "bench: --benchmark_filter: no entry matches '%s'", filter);
    } else {
        code = session->flags.list_tests ? list(&session->entries) : measure(session);
    }
    bench_entries_free(&session->entries);
    return code;
}

static int dispatch(int argument_count, char **arguments)
{
    Session session = {.executable = arguments[0]};
    PercaleSceneError error = {""};
    const char *word = argument_count > 1 ? arguments[1] : "";
    if (strcmp(word, "tradeoff") == 0 || strcmp(word, "compare") == 0) {
        return percale_complain(PERCALE_EXIT_USAGE, "bench: %s: not in this version of percale", word);
    }
    if (!bench_flags_parse(argument_count - 1, arguments + 1, &session.flags, &error)) {
        return percale_complain(PERCALE_EXIT_USAGE, "bench: %s", error.text);
    }
    int code = PERCALE_EXIT_DONE;
    if (session.flags.help) {
        (void)fputs(HELP, stdout);
    } else if (session.flags.version) {
        (void)printf("percale-bench %s\n", percale_version());
    } else {
        code = run_entries(&session);
    }
    bench_flags_free(&session.flags);
    return code;
}

int main(int argument_count, char **arguments)
{
    int code = dispatch(argument_count, arguments);
    bool written = fflush(stdout) == 0 && !ferror(stdout);
    if (!written && code == PERCALE_EXIT_DONE) {
        return percale_complain(PERCALE_EXIT_FAILED, "bench: standard output can't be written");
    }
    return code;
}
