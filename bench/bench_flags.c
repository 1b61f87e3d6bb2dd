#include "bench_flags.h"

#include "cli/options.h"
#include "scene/scene_error.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const uint64_t REPETITIONS_RANGE[2] = {1, 10000};
static const uint64_t ITERATIONS_RANGE[2] = {1, 1000000000};
static const uint64_t FRAMES_RANGE[2] = {1, 1000000};
static const uint64_t SIZES_RANGE[2] = {1, 100000000};
static const uint64_t THREADS_RANGE[2] = {1, PERCALE_MAX_THREADS};
static const double SECONDS_RANGE[2] = {0.0, 86400.0};
static const double MIN_SECONDS = 0.5; // Google's default

/// How a flag's value is read into its field.
typedef bool Reader(const char *name, const char *value, void *field, PercaleSceneError *error);

// ---- readers ----

static bool is_one_of(const char *words, const char *value, int *place)
{
    size_t length = strlen(value);
    *place = 0;
    for (const char *word = words; *word != '\0'; ++*place) {
        size_t word_length = strcspn(word, "|");
        if (word_length == length && strncmp(word, value, length) == 0) {
            return true;
        }
        word += word_length;
        word += *word == '|';
    }
    return false;
}

static bool read_choice(const char *name, const char *words, const char *value, int *place,
                        PercaleSceneError *error)
{
    return is_one_of(words, value, place) ||
           percale_scene_fail(error, "%s: '%s' is none of %s", name, value, words);
}

/// The words that Google's flags take for yes and no. A flag alone is a yes.
static bool read_switch(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    int place = 0;
    if (value != NULL && !read_choice(name, "true|false|yes|no|on|off|1|0", value, &place, error)) {
        return false;
    }
    *(bool *)field = place % 2 == 0;
    return true;
}

static bool read_format(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    return read_choice(name, "console|json|csv", value, field, error);
}

static bool read_color(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    int place = 0;
    if (value != NULL && !read_choice(name, "auto|true|false|yes|no|on|off|1|0", value, &place, error)) {
        return false;
    }
    bool is_auto = value != NULL && place == 0;
    *(int *)field =
        is_auto ? BENCH_COLOR_AUTO : (place % 2 == 0 && place > 0 ? BENCH_COLOR_NO : BENCH_COLOR_YES);
    return true;
}

static bool read_unit(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    int place;
    if (!read_choice(name, "ns|us|ms|s", value, &place, error)) {
        return false;
    }
    *(int *)field = BENCH_UNIT_NS + place;
    return true;
}

/// Google's flag may be empty: that keeps everything.
static bool read_filter(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    (void)name;
    (void)error;
    *(const char **)field = *value == '\0' ? NULL : value;
    return true;
}

static bool read_text(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    (void)name;
    (void)error;
    *(const char **)field = value;
    return true;
}

/// "key=value"; the list has room for as many texts as there are arguments.
static bool read_pair(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    size_t length = strcspn(value, "=");
    if (length == 0 || value[length] == '\0') {
        return percale_scene_fail(error, "%s: '%s' is not key=value", name, value);
    }
    BenchTexts *texts = field;
    texts->items[texts->count++] = value;
    return true;
}

static bool read_pairs(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    for (const char *pair = value; *pair != '\0';) {
        size_t length = strcspn(pair, ",");
        const char *equals = memchr(pair, '=', length);
        if (equals == NULL || equals == pair) {
            return percale_scene_fail(error, "%s: '%s' is not key=value[,key=value]...", name, value);
        }
        pair += length;
        pair += *pair == ',';
    }
    return read_pair(name, value, field, error);
}

static bool read_repetitions(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    return percale_option_whole(name, value, REPETITIONS_RANGE, field, error);
}

static bool read_frames(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    return percale_option_whole(name, value, FRAMES_RANGE, field, error);
}

static bool has_number(const BenchNumbers *numbers, uint64_t number)
{
    size_t index = 0;
    while (index < numbers->count && numbers->items[index] != number) {
        ++index;
    }
    return index < numbers->count;
}

/// "n,n,..."; a number that is given twice counts once.
static bool read_numbers(const char *name, const char *value, const uint64_t range[2], BenchNumbers *numbers,
                         PercaleSceneError *error)
{
    numbers->count = 0;
    for (const char *rest = value; rest != NULL; rest = strchr(rest, ',')) {
        rest += *rest == ',' && rest != value;
        char text[24]; // a 64-bit number has up to 20 digits
        uint64_t number = 0;
        (void)snprintf(text, sizeof text, "%.*s", (int)strcspn(rest, ","), rest);
        if (!percale_option_whole(name, text, range, &number, error)) {
            return false;
        }
        if (has_number(numbers, number)) {
            continue;
        }
        if (numbers->count == BENCH_SIZES_MAX) {
            return percale_scene_fail(error, "%s: more than %d numbers", name, (int)BENCH_SIZES_MAX);
        }
        numbers->items[numbers->count++] = number;
    }
    return true;
}

static bool read_sizes(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    return read_numbers(name, value, SIZES_RANGE, field, error);
}

static bool read_threads(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    return read_numbers(name, value, THREADS_RANGE, field, error);
}

/// "0.5", "0.5s" or "100x".
static bool read_budget(const char *name, const char *value, void *field, PercaleSceneError *error)
{
    BenchBudget *budget = field;
    char text[32];
    size_t length = strlen(value);
    bool is_count = length > 1 && value[length - 1] == 'x';
    bool has_unit = is_count || (length > 1 && value[length - 1] == 's');
    *budget = (BenchBudget){.min_seconds = MIN_SECONDS};
    (void)snprintf(text, sizeof text, "%.*s", (int)(has_unit ? length - 1 : length), value);
    return is_count ? percale_option_whole(name, text, ITERATIONS_RANGE, &budget->iterations, error)
                    : percale_option_number(name, text, SECONDS_RANGE, &budget->min_seconds, error);
}

// ---- the table of flags ----

typedef struct Flag {
    const char *name;
    Reader *read;
    size_t offset; // of its field
} Flag;

#define FIELD(name) offsetof(BenchFlags, name)
static const Flag FLAGS[] = {
    {"--help", read_switch, FIELD(help)},
    {"--version", read_switch, FIELD(version)},
    {"--benchmark_list_tests", read_switch, FIELD(list_tests)},
    {"--benchmark_filter", read_filter, FIELD(filter)},
    {"--benchmark_min_time", read_budget, FIELD(budget)},
    {"--benchmark_repetitions", read_repetitions, FIELD(repetitions)},
    {"--benchmark_enable_random_interleaving", read_switch, FIELD(random_interleaving)},
    {"--benchmark_report_aggregates_only", read_switch, FIELD(report_aggregates_only)},
    {"--benchmark_display_aggregates_only", read_switch, FIELD(display_aggregates_only)},
    {"--benchmark_format", read_format, FIELD(format)},
    {"--benchmark_out", read_text, FIELD(out)},
    {"--benchmark_out_format", read_format, FIELD(out_format)},
    {"--benchmark_color", read_color, FIELD(color)},
    {"--benchmark_counters_tabular", read_switch, FIELD(counters_tabular)},
    {"--benchmark_time_unit", read_unit, FIELD(time_unit)},
    {"--benchmark_context", read_pairs, FIELD(contexts)},
    {"--frames", read_frames, FIELD(frames)},
    {"--set", read_pair, FIELD(settings)},
    {"--preset", read_text, FIELD(preset)},
    {"--sizes", read_sizes, FIELD(sizes)},
    {"--threads", read_threads, FIELD(threads)},
};
#undef FIELD

static const Flag *find_flag(const char *argument)
{
    size_t length = strcspn(argument, "=");
    for (size_t index = 0; index < sizeof FLAGS / sizeof FLAGS[0]; ++index) {
        if (strlen(FLAGS[index].name) == length && strncmp(FLAGS[index].name, argument, length) == 0) {
            return &FLAGS[index];
        }
    }
    return NULL;
}

static bool take_flag(const char *argument, BenchFlags *flags, PercaleSceneError *error)
{
    const Flag *flag = find_flag(argument);
    if (flag == NULL) {
        return percale_scene_fail(error, "unknown flag %s", argument);
    }
    const char *equals = strchr(argument, '=');
    bool needs_value = flag->read != read_switch && flag->read != read_color;
    bool may_be_empty = flag->read == read_filter;
    if (equals == NULL ? needs_value : equals[1] == '\0' && !may_be_empty) {
        return percale_scene_fail(error, "%s: its value is missing", flag->name);
    }
    void *field = (char *)flags + flag->offset;
    return flag->read(flag->name, equals == NULL ? NULL : equals + 1, field, error);
}

bool bench_flags_parse(int argument_count, char **arguments, BenchFlags *flags, PercaleSceneError *error)
{
    size_t room = (size_t)argument_count + 1;
    *flags = (BenchFlags){.budget = {.min_seconds = MIN_SECONDS}, .repetitions = 1, .out_format = BENCH_JSON};
    flags->contexts.items = calloc(room, sizeof *flags->contexts.items);
    flags->settings.items = calloc(room, sizeof *flags->settings.items);
    bool done = flags->contexts.items != NULL && flags->settings.items != NULL;
    if (!done) {
        percale_scene_out_of_memory(error);
    }
    for (int place = 0; done && place < argument_count; ++place) {
        done = take_flag(arguments[place], flags, error);
    }
    if (!done) {
        bench_flags_free(flags);
    }
    return done;
}

void bench_flags_free(BenchFlags *flags)
{
    free(flags->contexts.items);
    free(flags->settings.items);
    *flags = (BenchFlags){0};
}
