#include "cli/options.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool same_name(const char *a, const char *b)
{
    return a && b ? strcmp(a, b) == 0 : a == b;
}

/// The kind of "--name" or "--name=value"; NULL when the command doesn't know it.
static const PercaleOptionKind *find_kind(const PercaleOptionKind *kinds, const char *argument)
{
    size_t length = strcspn(argument, "=");
    for (; kinds->name; ++kinds)
        if (strlen(kinds->name) == length && strncmp(kinds->name, argument, length) == 0)
            return kinds;
    return NULL;
}

static bool is_option(const char *argument)
{
    return argument[0] == '-' && argument[1] != '\0'; // "-" alone is standard output
}

static void append(PercaleOptions *options, const char *name, const char *value)
{
    options->items[options->count++] = (PercaleOption){name, value};
}

/// Takes the option at arguments[0] with its values; returns the number of arguments used, 0 on failure.
static int take_option(int argument_count, char **arguments, const PercaleOptionKind *kinds,
                       PercaleOptions *options, PercaleSceneError *error)
{
    const PercaleOptionKind *kind = find_kind(kinds, arguments[0]);
    const char *equals = strchr(arguments[0], '=');
    if (!kind) {
        (void)snprintf(error->text, sizeof error->text, "unknown option %s", arguments[0]);
        return 0;
    }
    if (kind->values == PERCALE_OPTION_SWITCH) {
        if (equals)
            (void)snprintf(error->text, sizeof error->text, "%s takes no value", kind->name);
        append(options, kind->name, NULL);
        return equals ? 0 : 1;
    }
    int used = 1;
    if (equals) {
        append(options, kind->name, equals + 1);
    } else {
        const int most = kind->values == PERCALE_OPTION_VALUE ? 2 : argument_count;
        while (used < most && used < argument_count && strncmp(arguments[used], "--", 2) != 0)
            append(options, kind->name, arguments[used++]);
    }
    if ((equals && equals[1] == '\0') || (!equals && used == 1)) {
        (void)snprintf(error->text, sizeof error->text, "%s: its value is missing", kind->name);
        return 0;
    }
    return used;
}

bool percale_options_parse(int argument_count, char **arguments, const PercaleOptionKind *kinds,
                           PercaleOptions *options, PercaleSceneError *error)
{
    options->count = 0;
    options->items =
        calloc((size_t)argument_count + 1, sizeof *options->items); // an item per argument at most
    if (!options->items) {
        (void)snprintf(error->text, sizeof error->text, "out of memory");
        return false;
    }
    for (int place = 0; place < argument_count;) {
        int used = 1;
        if (is_option(arguments[place]))
            used = take_option(argument_count - place, arguments + place, kinds, options, error);
        else
            append(options, NULL, arguments[place]);
        if (used == 0) {
            percale_options_free(options);
            return false;
        }
        place += used;
    }
    return true;
}

void percale_options_free(PercaleOptions *options)
{
    free(options->items);
    *options = (PercaleOptions){0};
}

const PercaleOption *percale_options_find(const PercaleOptions *options, const char *name)
{
    for (size_t index = options->count; index > 0; --index)
        if (same_name(options->items[index - 1].name, name))
            return &options->items[index - 1];
    return NULL;
}

const char *percale_options_value(const PercaleOptions *options, const char *name)
{
    const PercaleOption *option = percale_options_find(options, name);
    return option ? option->value : NULL;
}

size_t percale_options_values(const PercaleOptions *options, const char *name, const char **values)
{
    size_t count = 0;
    for (size_t index = 0; index < options->count; ++index) {
        if (!same_name(options->items[index].name, name))
            continue;
        if (values)
            values[count] = options->items[index].value;
        ++count;
    }
    return count;
}

bool percale_option_whole(const char *name, const char *text, const uint64_t range[2], uint64_t *value,
                          PercaleSceneError *error)
{
    if (!text)
        return true;
    if (*text == '\0' || strspn(text, "0123456789") != strlen(text)) {
        (void)snprintf(error->text, sizeof error->text,
                       "%s: '%s' is not a whole number (%" PRIu64 "..%" PRIu64 ")", name, text, range[0],
                       range[1]);
        return false;
    }
    errno = 0;
    unsigned long long number = strtoull(text, NULL, 10);
    if (errno != 0 || number < range[0] || number > range[1]) {
        (void)snprintf(error->text, sizeof error->text, "%s: %s is not within %" PRIu64 "..%" PRIu64, name,
                       text, range[0], range[1]);
        return false;
    }
    *value = number;
    return true;
}

bool percale_option_number(const char *name, const char *text, const double range[2], double *value,
                           PercaleSceneError *error)
{
    if (!text)
        return true;
    char *end = NULL;
    double number = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(number) || number < range[0] || number > range[1]) {
        (void)snprintf(error->text, sizeof error->text, "%s: '%s' is not a number within %g..%g", name, text,
                       range[0], range[1]);
        return false;
    }
    *value = number;
    return true;
}
