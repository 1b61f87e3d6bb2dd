#include "bench_console.h"

#include "base/hash.h"
#include "bench_rows.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    AGGREGATE_WIDTH = 7, // of "_median" and "_stddev", which are added to a name
    TIME_WIDTH = 10,
    UNIT_WIDTH = 4,
    ITERATIONS_WIDTH = 12,
    COUNTER_WIDTH = 10, // at least
    NUMBER_SIZE = 32    // bytes of a number's text
};

// ECMA-48
static const char GREEN[] = "\033[32m";
static const char YELLOW[] = "\033[33m";
static const char CYAN[] = "\033[36m";
static const char RED[] = "\033[31m";
static const char PLAIN[] = "\033[m";

static void set_color(const BenchConsole *console, const char *color)
{
    if (console->is_colored) {
        (void)fputs(color, console->stream);
    }
}

// ---- numbers ----

/// About three digits, whatever the size.
static void format_time(double time, char text[NUMBER_SIZE])
{
    int decimals = time < 1.0 ? 3 : (time < 10.0 ? 2 : (time < 100.0 ? 1 : 0));
    (void)snprintf(text, NUMBER_SIZE, time > 9999999999.0 ? "%.*e" : "%.*f", decimals, time);
}

/// With k, M, G, T for the thousands.
static void format_rate(double rate, char text[NUMBER_SIZE])
{
    static const char *const prefixes[] = {"", "k", "M", "G", "T", "P"};
    size_t index = 0;
    while (rate >= 1000.0 && index + 1 < sizeof prefixes / sizeof prefixes[0]) {
        rate /= 1000.0;
        ++index;
    }
    (void)snprintf(text, NUMBER_SIZE, "%.5g%s/s", rate, prefixes[index]);
}

static void format_counter(const BenchCounter *counter, bool is_fraction, char text[NUMBER_SIZE])
{
    if (is_fraction) {
        (void)snprintf(text, NUMBER_SIZE, "%.2f%%", 100.0 * counter->value);
    } else if (counter->is_rate) {
        format_rate(counter->value, text);
    } else {
        (void)snprintf(text, NUMBER_SIZE, "%.6g", counter->value);
    }
}

// ---- headings ----

static int counter_width(const BenchCounter *counter)
{
    int length = (int)strlen(counter->name);
    return length > COUNTER_WIDTH ? length : COUNTER_WIDTH;
}

static void print_rule(const BenchConsole *console, int width)
{
    for (int place = 0; place < width; ++place) {
        (void)fputc('-', console->stream);
    }
    (void)fputc('\n', console->stream);
}

static int base_width(const BenchConsole *console)
{
    return console->name_width + 2 * (1 + TIME_WIDTH + 1 + UNIT_WIDTH) + 1 + ITERATIONS_WIDTH;
}

static void print_base_heading(const BenchConsole *console)
{
    (void)fprintf(console->stream, "%-*s %*s %*s %*s", console->name_width, "Benchmark",
                  TIME_WIDTH + 1 + UNIT_WIDTH, "Time", TIME_WIDTH + 1 + UNIT_WIDTH, "CPU", ITERATIONS_WIDTH,
                  "Iterations");
}

static void print_heading(const BenchConsole *console)
{
    static const char counters[] = " UserCounters...";
    int width = base_width(console) + (int)sizeof counters - 1;
    print_rule(console, width);
    print_base_heading(console);
    (void)fprintf(console->stream, "%s\n", counters);
    print_rule(console, width);
}

static void print_tabular_heading(const BenchConsole *console, const BenchResult *result)
{
    int width = base_width(console);
    for (size_t index = 0; index < result->counter_count; ++index) {
        width += result->counters[index].is_detail ? 0 : 1 + counter_width(&result->counters[index]);
    }
    print_rule(console, width);
    print_base_heading(console);
    for (size_t index = 0; index < result->counter_count; ++index) {
        const BenchCounter *counter = &result->counters[index];
        if (!counter->is_detail) {
            (void)fprintf(console->stream, " %*s", counter_width(counter), counter->name);
        }
    }
    (void)fputc('\n', console->stream);
    print_rule(console, width);
}

/// A new heading when the columns change.
static void update_heading(BenchConsole *console, const BenchResult *result)
{
    uint64_t hash = hash_start();
    for (size_t index = 0; index < result->counter_count; ++index) {
        for (const char *letter = result->counters[index].name; *letter != '\0'; ++letter) {
            hash = hash_add(hash, (uint32_t)(unsigned char)*letter);
        }
    }
    if (hash != console->heading) {
        print_tabular_heading(console, result);
        console->heading = hash;
    }
}

// ---- rows ----

static void print_counters(const BenchConsole *console, const BenchRow *row)
{
    for (size_t index = 0; index < row->result.counter_count; ++index) {
        const BenchCounter *counter = &row->result.counters[index];
        char text[NUMBER_SIZE];
        if (counter->is_detail) {
            continue;
        }
        format_counter(counter, row->is_fraction, text);
        if (console->flags->counters_tabular) {
            (void)fprintf(console->stream, " %*s", counter_width(counter), text);
        } else {
            (void)fprintf(console->stream, " %s=%s", counter->name, text);
        }
    }
}

static void print_time(const BenchConsole *console, const BenchRow *row, double seconds)
{
    BenchUnitName unit = bench_unit_of(row->entry, (BenchUnit)console->flags->time_unit);
    char text[NUMBER_SIZE];
    if (row->is_fraction) {
        (void)snprintf(text, sizeof text, "%.2f", 100.0 * seconds);
    } else {
        format_time(seconds * unit.per_second, text);
    }
    (void)fprintf(console->stream, " %*s %-*s", TIME_WIDTH, text, UNIT_WIDTH,
                  row->is_fraction ? "%" : unit.name);
}

static void print_row(const BenchConsole *console, const BenchRow *row)
{
    const BenchResult *result = &row->result;
    set_color(console, GREEN);
    (void)fprintf(console->stream, "%-*s", console->name_width, row->name);
    if (result->failed) {
        set_color(console, RED);
        (void)fprintf(console->stream, " ERROR OCCURRED: '%s'", result->error.text);
    } else {
        set_color(console, YELLOW);
        print_time(console, row, result->real_seconds);
        print_time(console, row, result->cpu_seconds);
        set_color(console, CYAN);
        (void)fprintf(console->stream, " %*" PRIu64, ITERATIONS_WIDTH, result->iterations);
        set_color(console, PLAIN);
        print_counters(console, row);
        if (result->label[0] != '\0') {
            (void)fprintf(console->stream, " %s", result->label);
        }
    }
    set_color(console, PLAIN);
    (void)fputc('\n', console->stream);
}

bool bench_console_entry(BenchConsole *console, const BenchEntry *entry)
{
    BenchRows rows;
    if (!bench_rows_make(entry, console->aggregates_only, &rows)) {
        return false;
    }
    for (size_t index = 0; index < rows.count; ++index) {
        if (console->flags->counters_tabular && !rows.items[index].result.failed) {
            update_heading(console, &rows.items[index].result);
        }
        print_row(console, &rows.items[index]);
    }
    (void)fflush(console->stream);
    bench_rows_free(&rows);
    return true;
}

// ---- the beginning ----

static const char *text_of(const json_t *context, const char *key)
{
    return json_string_value(json_object_get(context, key));
}

static void print_context(FILE *stream, const json_t *context)
{
    (void)fprintf(stream, "%s\n", text_of(context, "date"));
    (void)fprintf(stream, "Running %s\n", text_of(context, "executable"));
    (void)fprintf(stream, "Run on (%" JSON_INTEGER_FORMAT " X %" JSON_INTEGER_FORMAT " MHz CPU s), %s\n",
                  json_integer_value(json_object_get(context, "num_cpus")),
                  json_integer_value(json_object_get(context, "mhz_per_cpu")), text_of(context, "cpu"));
    (void)fprintf(stream, "percale %s, %s, %s build, %s\n", text_of(context, "percale"),
                  text_of(context, "isa"), text_of(context, "library_build_type"),
                  text_of(context, "compiler"));
}

static bool wants_color(FILE *stream, const BenchFlags *flags)
{
    if (flags->color == BENCH_COLOR_AUTO) {
        return isatty(fileno(stream)) != 0;
    }
    return flags->color == BENCH_COLOR_YES;
}

BenchConsole bench_console_begin(FILE *stream, const BenchFlags *flags, const json_t *context,
                                 const BenchEntries *entries, bool aggregates_only)
{
    BenchConsole console = {.stream = stream, .flags = flags, .aggregates_only = aggregates_only};
    console.is_colored = wants_color(stream, flags);
    for (size_t index = 0; index < entries->count; ++index) {
        int length = (int)strlen(entries->items[index].name);
        console.name_width = length > console.name_width ? length : console.name_width;
    }
    console.name_width += flags->repetitions > 1 ? AGGREGATE_WIDTH : 0;
    print_context(stream, context);
    if (!flags->counters_tabular) {
        print_heading(&console);
    }
    return console;
}
