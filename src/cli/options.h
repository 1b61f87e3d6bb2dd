// options.h: splits a command's arguments into options and words, and reads numbers from them.
//
//   in   argv after the command, the options that the command knows
//   out  a list in the order given; "--name value" and "--name=value" are the same

#ifndef PERCALE_OPTIONS_H
#define PERCALE_OPTIONS_H

#include "percale/scene.h"

typedef enum PercaleOptionValues {
    PERCALE_OPTION_SWITCH, ///< no value
    PERCALE_OPTION_VALUE,  ///< one value
    PERCALE_OPTION_LIST    ///< one or more values, up to the next option; becomes one item per value
} PercaleOptionValues;

typedef struct PercaleOptionKind {
    const char *name; ///< with its dashes; NULL ends a list of kinds
    PercaleOptionValues values;
} PercaleOptionKind;

typedef struct PercaleOption {
    const char *name;  ///< the kind's name; NULL: a word that belongs to no option
    const char *value; ///< NULL for a switch
} PercaleOption;

typedef struct PercaleOptions {
    PercaleOption *items;
    size_t count;
} PercaleOptions;

/// Free with percale_options_free; on failure there is nothing to free. Values point into `arguments`.
bool percale_options_parse(int argument_count, char **arguments, const PercaleOptionKind *kinds,
                           PercaleOptions *options, PercaleSceneError *error);
void percale_options_free(PercaleOptions *options);

/// The last item of that name (NULL: of the words), NULL when there is none.
const PercaleOption *percale_options_find(const PercaleOptions *options, const char *name);
/// Value of the last item of that name, NULL when there is none.
const char *percale_options_value(const PercaleOptions *options, const char *name);
/// Writes the values of all items of that name, in order, and returns their number; values may be NULL.
size_t percale_options_values(const PercaleOptions *options, const char *name, const char **values);

/// Plain digits within minimum..maximum, else an error that names the option. NULL text leaves *value alone.
bool percale_option_whole(const char *name, const char *text, const uint64_t range[2], uint64_t *value,
                          PercaleSceneError *error);
/// A finite number within minimum..maximum; NULL text leaves *value alone.
bool percale_option_number(const char *name, const char *text, const double range[2], double *value,
                           PercaleSceneError *error);

#endif
