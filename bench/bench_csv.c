#include "bench_csv.h"

#include "bench_rows.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Names of counters, each once, in the order in which they turn up.
typedef struct Columns {
    const char **names;
    size_t count, capacity;
} Columns;

static const BenchCounter *find_counter(const BenchResult *result, const char *name)
{
    for (size_t index = 0; index < result->counter_count; ++index) {
        if (strcmp(result->counters[index].name, name) == 0) {
            return &result->counters[index];
        }
    }
    return NULL;
}

static bool has_column(const Columns *columns, const char *name)
{
    size_t index = 0;
    while (index < columns->count && strcmp(columns->names[index], name) != 0) {
        ++index;
    }
    return index < columns->count;
}

static bool add_column(Columns *columns, const char *name)
{
    if (has_column(columns, name)) {
        return true;
    }
    if (columns->count == columns->capacity) {
        size_t capacity = 2 * columns->capacity + BENCH_COUNTERS_MAX;
        const char **names = realloc(columns->names, capacity * sizeof *names);
        if (names == NULL) {
            return false;
        }
        columns->names = names;
        columns->capacity = capacity;
    }
    columns->names[columns->count++] = name;
    return true;
}

/// Google's file has these two first and always.
static bool find_columns(const BenchEntries *entries, Columns *columns)
{
    bool done = add_column(columns, "bytes_per_second") && add_column(columns, "items_per_second");
    for (size_t index = 0; index < entries->count; ++index) {
        const BenchEntry *entry = &entries->items[index];
        for (uint32_t repetition = 0; done && repetition < entry->result_count; ++repetition) {
            const BenchResult *result = &entry->results[repetition];
            for (size_t counter = 0; done && counter < result->counter_count; ++counter) {
                done = add_column(columns, result->counters[counter].name);
            }
        }
    }
    return done;
}

enum { STANDARD_COLUMNS = 2 }; // the two in front

static void print_quoted(FILE *stream, const char *text)
{
    (void)fputc('"', stream);
    for (; *text != '\0'; ++text) {
        if (*text == '"') {
            (void)fputc('"', stream);
        }
        (void)fputc(*text, stream);
    }
    (void)fputc('"', stream);
}

static void print_header(FILE *stream, const Columns *columns)
{
    (void)fputs("name,iterations,real_time,cpu_time,time_unit,bytes_per_second,items_per_second,label,"
                "error_occurred,error_message",
                stream);
    for (size_t index = STANDARD_COLUMNS; index < columns->count; ++index) {
        (void)fputc(',', stream);
        print_quoted(stream, columns->names[index]);
    }
    (void)fputc('\n', stream);
}

static void print_counter(FILE *stream, const BenchResult *result, const char *name)
{
    const BenchCounter *counter = find_counter(result, name);
    (void)fputc(',', stream);
    if (counter != NULL) {
        (void)fprintf(stream, "%.9g", isfinite(counter->value) ? counter->value : 0.0);
    }
}

static void print_row(FILE *stream, const BenchRow *row, const Columns *columns, const BenchFlags *flags)
{
    const BenchResult *result = &row->result;
    BenchUnitName unit = bench_unit_of(row->entry, (BenchUnit)flags->time_unit);
    double factor = row->is_fraction ? 1.0 : unit.per_second;
    print_quoted(stream, row->name);
    if (result->failed) {
        (void)fputs(",,,,", stream);
    } else {
        (void)fprintf(stream, ",%" PRIu64 ",%.9g,%.9g,%s", result->iterations, factor * result->real_seconds,
                      factor * result->cpu_seconds, unit.name);
    }
    print_counter(stream, result, columns->names[0]);
    print_counter(stream, result, columns->names[1]);
    (void)fputc(',', stream);
    if (result->label[0] != '\0') {
        print_quoted(stream, result->label);
    }
    (void)fputs(result->failed ? ",true," : ",,", stream);
    if (result->failed) {
        print_quoted(stream, result->error.text);
    }
    for (size_t index = STANDARD_COLUMNS; index < columns->count; ++index) {
        print_counter(stream, result, columns->names[index]);
    }
    (void)fputc('\n', stream);
}

bool bench_csv_write(FILE *stream, const BenchEntries *entries, const BenchFlags *flags, bool aggregates_only)
{
    Columns columns = {0};
    bool done = find_columns(entries, &columns);
    if (done) {
        print_header(stream, &columns);
    }
    for (size_t entry = 0; done && entry < entries->count; ++entry) {
        BenchRows rows = {0};
        done = bench_rows_make(&entries->items[entry], aggregates_only, &rows);
        for (size_t index = 0; index < rows.count; ++index) {
            print_row(stream, &rows.items[index], &columns, flags);
        }
        bench_rows_free(&rows);
    }
    free(columns.names);
    return done;
}
