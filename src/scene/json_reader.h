// json_reader.h: JSON with the place of every value: errors name file, line and column.
//
//   in   the text of a file
//   out  members of objects, checked for type and range
//
// jansson parses, but forgets where a value stood; the place is found again in the text when an error needs
// it.

#ifndef PERCALE_JSON_READER_H
#define PERCALE_JSON_READER_H

#include "scene/text_file.h"

#include <jansson.h>

/// The way from the root to a value: its number among the members or elements of its parent.
typedef struct PercaleJsonPlace {
    const struct PercaleJsonPlace *parent; ///< NULL: the root
    size_t ordinal;
} PercaleJsonPlace;

typedef struct PercaleJsonReader {
    const char *path;
    PercaleText text;
    json_t *root; ///< an object
    PercaleSceneError *error;
} PercaleJsonReader;

/// A value and where it stands; value NULL: absent.
typedef struct PercaleJsonMember {
    json_t *value;
    PercaleJsonPlace place;
} PercaleJsonMember;

/// Parses the file, whose root must be an object; duplicate keys are refused.
bool percale_json_open(PercaleJsonReader *reader, const char *path, PercaleSceneError *error);
void percale_json_close(PercaleJsonReader *reader);

/// "path:line:column: message" at a value, or with `key` at the key before it.
bool percale_json_fail(const PercaleJsonReader *reader, const PercaleJsonPlace *place, bool key,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));

/// Refuses keys that are not in the '|'-separated list; `what` is "a cloth" for the message.
bool percale_json_check_keys(const PercaleJsonReader *reader, const PercaleJsonMember *object,
                             const char *known, const char *what);
/// The member of an object, with value NULL when it is absent. `object` must outlive the result.
PercaleJsonMember percale_json_member(const PercaleJsonMember *object, const char *key);
PercaleJsonMember percale_json_element(const PercaleJsonMember *array, size_t index);

/// Checked values; `name` is for the message.
bool percale_json_number(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         double minimum, double maximum, double *number);
bool percale_json_whole(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                        int64_t minimum, int64_t maximum, int64_t *number);
bool percale_json_string(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         const char **string);
bool percale_json_array(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name);
bool percale_json_object(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name);
/// Three numbers.
bool percale_json_vector(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         double limit, double vector[3]);

#endif
