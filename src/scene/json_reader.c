#include "scene/json_reader.h"

#include "scene/scene_error.h"
#include "scene/settings.h"

#include <stdarg.h>
#include <string.h>

// ---- places: the text is known to be valid JSON here ----

static size_t skip_space(const char *text, size_t at)
{
    return at + strspn(text + at, " \t\r\n");
}

static size_t skip_string(const char *text, size_t at)
{
    ++at;
    while (text[at] != '"') {
        at += text[at] == '\\' ? 2 : 1;
    }
    return at + 1;
}

// Brackets are only counted: nothing recurses, however deep the text is.
static size_t skip_value(const char *text, size_t at)
{
    size_t depth = 0;
    do {
        if (text[at] == '"') {
            at = skip_string(text, at);
            continue;
        }
        depth += text[at] == '{' || text[at] == '[';
        depth -= text[at] == '}' || text[at] == ']';
        ++at;
    } while (depth > 0 || (text[at] != '\0' && strchr(",]} \t\r\n", text[at]) == NULL));
    return at;
}

// Offset of a place's value, and of the key before it.
static size_t find_place(const char *text, const PercaleJsonPlace *place, size_t *key)
{
    if (place->parent == NULL) {
        *key = skip_space(text, 0);
        return *key;
    }
    size_t at = find_place(text, place->parent, key);
    const bool object = text[at] == '{';
    for (size_t ordinal = 0;; ++ordinal) {
        at = skip_space(text, at + 1);
        *key = at;
        if (object) {
            at = skip_space(text, skip_string(text, at)) + 1;
            at = skip_space(text, at);
        }
        if (ordinal == place->ordinal) {
            return at;
        }
        at = skip_space(text, skip_value(text, at));
    }
}

bool percale_json_fail(const PercaleJsonReader *reader, const PercaleJsonPlace *place, bool key,
                       const char *format, ...)
{
    size_t key_at;
    const size_t value_at = find_place(reader->text.bytes, place, &key_at);
    unsigned line = 1;
    unsigned column = 1;
    for (size_t at = 0; at < (key ? key_at : value_at); ++at) {
        const bool continues = ((unsigned char)reader->text.bytes[at] & 0xC0U) == 0x80U; // of a UTF-8 letter
        column = reader->text.bytes[at] == '\n' ? 1 : column + !continues;
        line += reader->text.bytes[at] == '\n';
    }
    char message[sizeof reader->error->text];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(message, sizeof message, format, values);
    va_end(values);
    return percale_scene_fail(reader->error, "%s:%u:%u: %s", reader->path, line, column, message);
}

// ---- the file ----

bool percale_json_open(PercaleJsonReader *reader, const char *path, PercaleSceneError *error)
{
    *reader = (PercaleJsonReader){.path = path, .error = error};
    if (!percale_text_read(path, &reader->text, error)) {
        return false;
    }
    json_error_t problem;
    reader->root = json_loadb(reader->text.bytes, reader->text.size, JSON_REJECT_DUPLICATES, &problem);
    if (reader->root == NULL) {
        percale_scene_fail(error, "%s:%d:%d: %s", path, problem.line, problem.column, problem.text);
    } else if (!json_is_object(reader->root)) {
        percale_scene_fail(error, "%s:1:1: a scene must be an object { ... }", path);
    } else {
        return true;
    }
    percale_json_close(reader);
    return false;
}

void percale_json_close(PercaleJsonReader *reader)
{
    json_decref(reader->root);
    reader->root = NULL;
    percale_text_free(&reader->text);
}

// ---- members ----

bool percale_json_check_keys(const PercaleJsonReader *reader, const PercaleJsonMember *object,
                             const char *known, const char *what)
{
    PercaleJsonPlace place = {&object->place, 0};
    for (void *at = json_object_iter(object->value); at != NULL;
         at = json_object_iter_next(object->value, at)) {
        const char *key = json_object_iter_key(at);
        int length;
        const char *nearest = percale_nearest_name(known, key, &length);
        if (strlen(key) != (size_t)length || strncmp(key, nearest, (size_t)length) != 0) {
            return percale_json_fail(reader, &place, true,
                                     "unknown key \"%s\" in %s (did you mean \"%.*s\"?)", key, what, length,
                                     nearest);
        }
        ++place.ordinal;
    }
    return true;
}

// jansson keeps the members in the order of the text.
PercaleJsonMember percale_json_member(const PercaleJsonMember *object, const char *key)
{
    PercaleJsonMember member = {NULL, {&object->place, 0}};
    for (void *at = json_object_iter(object->value); at != NULL;
         at = json_object_iter_next(object->value, at)) {
        if (strcmp(json_object_iter_key(at), key) == 0) {
            member.value = json_object_iter_value(at);
            break;
        }
        ++member.place.ordinal;
    }
    return member;
}

PercaleJsonMember percale_json_element(const PercaleJsonMember *array, size_t index)
{
    return (PercaleJsonMember){json_array_get(array->value, index), {&array->place, index}};
}

bool percale_json_number(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         double minimum, double maximum, double *number)
{
    if (!json_is_number(member->value)) {
        return percale_json_fail(reader, &member->place, false, "%s must be a number", name);
    }
    *number = json_number_value(member->value);
    return (*number >= minimum && *number <= maximum) ||
           percale_json_fail(reader, &member->place, false, "%s = %.9g is out of range: %.9g to %.9g", name,
                             *number, minimum, maximum);
}

bool percale_json_whole(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                        int64_t minimum, int64_t maximum, int64_t *number)
{
    if (!json_is_integer(member->value)) {
        return percale_json_fail(reader, &member->place, false, "%s must be a whole number", name);
    }
    *number = json_integer_value(member->value);
    return (*number >= minimum && *number <= maximum) ||
           percale_json_fail(reader, &member->place, false, "%s = %lld is out of range: %lld to %lld", name,
                             (long long)*number, (long long)minimum, (long long)maximum);
}

bool percale_json_string(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         const char **string)
{
    *string = json_string_value(member->value);
    return *string != NULL ||
           percale_json_fail(reader, &member->place, false, "%s must be a text in quotes", name);
}

bool percale_json_array(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name)
{
    return json_is_array(member->value) ||
           percale_json_fail(reader, &member->place, false, "%s must be a list [ ... ]", name);
}

bool percale_json_object(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name)
{
    return json_is_object(member->value) ||
           percale_json_fail(reader, &member->place, false, "%s must be an object { ... }", name);
}

bool percale_json_vector(const PercaleJsonReader *reader, const PercaleJsonMember *member, const char *name,
                         double limit, double vector[3])
{
    if (!json_is_array(member->value) || json_array_size(member->value) != 3) {
        return percale_json_fail(reader, &member->place, false, "%s must be three numbers [x, y, z]", name);
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        const PercaleJsonMember element = percale_json_element(member, axis);
        if (!percale_json_number(reader, &element, name, -limit, limit, &vector[axis])) {
            return false;
        }
    }
    return true;
}
