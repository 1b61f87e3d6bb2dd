#include "bench_json.h"

#include "bench_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 15 }; // of a number: more than any clock has

json_t *bench_json_number(double value)
{
    static const double WHOLE_MAX = 9007199254740992.0; // 2^53: up to here a double holds every whole number
    if (!isfinite(value)) {
        return json_integer(0);
    }
    if (value == floor(value) && fabs(value) < WHOLE_MAX) {
        return json_integer((json_int_t)value);
    }
    return json_real(value);
}

json_t *bench_json_text(const char *text)
{
    json_t *string = json_string(text);
    char *plain = string != NULL ? NULL : strdup(text);
    if (plain == NULL) {
        return string;
    }
    for (char *character = plain; *character != '\0'; ++character) {
        if ((unsigned char)*character >= 0x80) {
            *character = '?';
        }
    }
    string = json_string(plain);
    free(plain);
    return string;
}

static json_t *real(double value)
{
    return json_real(isfinite(value) ? value : 0.0);
}

static void add_identity(json_t *object, const BenchRow *row, const BenchFlags *flags)
{
    const BenchEntry *entry = row->entry;
    bool is_aggregate = row->aggregate != NULL;
    json_object_set_new(object, "name", bench_json_text(row->name));
    json_object_set_new(object, "family_index", json_integer(entry->family_index));
    json_object_set_new(object, "per_family_instance_index", json_integer(entry->instance_index));
    json_object_set_new(object, "run_name", bench_json_text(entry->name));
    json_object_set_new(object, "run_type", bench_json_text(is_aggregate ? "aggregate" : "iteration"));
    json_object_set_new(object, "repetitions", json_integer((json_int_t)flags->repetitions));
    if (!is_aggregate) {
        json_object_set_new(object, "repetition_index", json_integer(row->repetition));
    }
    json_object_set_new(object, "threads", json_integer(entry->thread_count));
    if (is_aggregate) {
        json_object_set_new(object, "aggregate_name", bench_json_text(row->aggregate));
        json_object_set_new(object, "aggregate_unit",
                            bench_json_text(row->is_fraction ? "percentage" : "time"));
    }
}

static json_t *json_of_row(const BenchRow *row, const BenchFlags *flags)
{
    const BenchResult *result = &row->result;
    BenchUnitName unit = bench_unit_of(row->entry, (BenchUnit)flags->time_unit);
    double factor = row->is_fraction ? 1.0 : unit.per_second;
    json_t *object = json_object();
    add_identity(object, row, flags);
    if (result->failed) {
        json_object_set_new(object, "error_occurred", json_true());
        json_object_set_new(object, "error_message", bench_json_text(result->error.text));
    }
    json_object_set_new(object, "iterations", json_integer((json_int_t)result->iterations));
    json_object_set_new(object, "real_time", real(factor * result->real_seconds));
    json_object_set_new(object, "cpu_time", real(factor * result->cpu_seconds));
    json_object_set_new(object, "time_unit", bench_json_text(unit.name));
    for (size_t index = 0; index < result->counter_count; ++index) {
        const BenchCounter *counter = &result->counters[index];
        json_object_set_new(object, counter->name, bench_json_number(counter->value));
    }
    if (result->label[0] != '\0') {
        json_object_set_new(object, "label", bench_json_text(result->label));
    }
    return object;
}

static bool add_rows(json_t *list, const BenchEntry *entry, const BenchFlags *flags, bool aggregates_only)
{
    BenchRows rows;
    if (!bench_rows_make(entry, aggregates_only, &rows)) {
        return false;
    }
    for (size_t index = 0; index < rows.count; ++index) {
        json_array_append_new(list, json_of_row(&rows.items[index], flags));
    }
    bench_rows_free(&rows);
    return true;
}

bool bench_json_write(FILE *stream, json_t *context, const BenchEntries *entries, const BenchFlags *flags,
                      bool aggregates_only)
{
    json_t *report = json_object();
    json_t *list = json_array();
    json_object_set(report, "context", context);
    json_object_set_new(report, "benchmarks", list);
    bool done = true;
    for (size_t index = 0; done && index < entries->count; ++index) {
        done = add_rows(list, &entries->items[index], flags, aggregates_only);
    }
    done = done && json_dumpf(report, stream, JSON_INDENT(2) | JSON_REAL_PRECISION(DIGITS)) == 0 &&
           fputc('\n', stream) != EOF;
    json_decref(report);
    return done;
}
