// A single pass over the text with a cursor; indices are checked against the counts once these are known.

#include "scene/obj_file.h"

#include "scene/grow.h"
#include "scene/number_text.h"
#include "scene/output_file.h"
#include "scene/scene_error.h"
#include "scene/text_file.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    MAX_VERTEX_NUMBERS = 7,  // x y z w, or x y z and a colour; beyond that it is no vertex
    COUNT_LIMIT = INT32_MAX, // vertices and triangles
    SMALL_FACE = 32,         // corners up to which all pairs are compared
    SHOWN_BYTES = 40,        // of a bad word in a message: it may be long or binary
    UV_NONE = 0              // texture indices are stored from 1 on
};

// The three lists that a corner refers to.
typedef enum ListKind { LIST_VERTEX = 0, LIST_UV, LIST_NORMAL, LIST_COUNT } ListKind;

static const char *const list_names[LIST_COUNT] = {"vertex", "texture", "normal"};

typedef struct List {
    uint32_t count;        // so far
    uint32_t largest;      // largest index seen, from 1
    uint64_t largest_line; // where
} List;

typedef struct Corner {
    uint32_t vertex; // from 0
    uint32_t uv;     // from 1; UV_NONE
} Corner;

typedef struct Reader {
    const char *path;
    PercaleSceneError *error;
    const char *at, *end;
    uint64_t line;
    List lists[LIST_COUNT];
    double *positions;
    uint32_t position_capacity; // vertices
    float *uvs;                 // [2 * lists[LIST_UV].count]
    uint32_t uv_capacity;
    uint32_t *triangles;
    uint32_t *triangle_uvs; // [3 * triangle_count], from 1; UV_NONE
    uint32_t triangle_count;
    uint32_t triangle_capacity, triangle_uv_capacity;
    Corner *corners; // of the face being read
    uint32_t *sorted;
    uint32_t corner_capacity, sorted_capacity;
} Reader;

// ---- cursor ----

static size_t line_break_at(const Reader *reader, const char *at)
{
    if (at < reader->end && *at == '\n') {
        return 1;
    }
    return at + 1 < reader->end && at[0] == '\r' && at[1] == '\n' ? 2 : 0;
}

// A backslash before the line break continues the statement.
static void skip_blanks(Reader *reader)
{
    for (;;) {
        const size_t line_break =
            reader->at < reader->end && *reader->at == '\\' ? line_break_at(reader, reader->at + 1) : 0;
        if (line_break != 0) {
            reader->at += 1 + line_break;
            ++reader->line;
        } else if (reader->at < reader->end && (*reader->at == ' ' || *reader->at == '\t')) {
            ++reader->at;
        } else {
            return;
        }
    }
}

static bool at_statement_end(const Reader *reader)
{
    return reader->at >= reader->end || *reader->at == '#' || line_break_at(reader, reader->at) != 0;
}

static void skip_line(Reader *reader)
{
    const bool comment = reader->at < reader->end && *reader->at == '#';
    while (reader->at < reader->end) {
        const bool continues = !comment && *reader->at == '\\' && line_break_at(reader, reader->at + 1) != 0;
        if (continues) {
            skip_blanks(reader);
        } else if (*reader->at == '\n') {
            ++reader->at;
            ++reader->line;
            return;
        } else {
            ++reader->at;
        }
    }
}

// Length of the word at the cursor.
static int word_length(const Reader *reader)
{
    const char *at = reader->at;
    while (at < reader->end && strchr(" \t\r\n", *at) == NULL && *at != '\0') {
        ++at;
    }
    return (int)(at - reader->at);
}

static int shown_length(const Reader *reader)
{
    const int length = word_length(reader);
    return length < SHOWN_BYTES ? length : SHOWN_BYTES;
}

static bool starts_with(const Reader *reader, const char *keyword)
{
    const size_t length = strlen(keyword);
    if ((size_t)(reader->end - reader->at) < length || memcmp(reader->at, keyword, length) != 0) {
        return false;
    }
    const char *next = reader->at + length;
    return next >= reader->end || strchr(" \t\r\n\\", *next) != NULL;
}

static bool out_of_memory(const Reader *reader)
{
    return percale_scene_out_of_memory(reader->error);
}

// ---- statements ----

// The numbers of a statement up to its end; count is how many there were.
static bool read_numbers(Reader *reader, double *numbers, int limit, int *count)
{
    *count = 0;
    for (skip_blanks(reader); !at_statement_end(reader); skip_blanks(reader)) {
        if (*count == limit) {
            return percale_scene_fail(reader->error, "%s:%llu: more than %d numbers", reader->path,
                                      (unsigned long long)reader->line, limit);
        }
        const char *at = reader->at;
        const bool read = percale_number_parse(&at, reader->end, &numbers[*count]);
        if (!read || at - reader->at != word_length(reader) || fabs(numbers[*count]) > (double)FLT_MAX) {
            return percale_scene_fail(reader->error, "%s:%llu: \"%.*s\" is not a usable number", reader->path,
                                      (unsigned long long)reader->line, shown_length(reader), reader->at);
        }
        reader->at = at;
        ++*count;
    }
    return true;
}

static bool read_vertex(Reader *reader)
{
    double numbers[MAX_VERTEX_NUMBERS];
    int count;
    const uint64_t line = reader->line;
    if (!read_numbers(reader, numbers, MAX_VERTEX_NUMBERS, &count)) {
        return false;
    }
    if (count < 3 || count == 5) {
        return percale_scene_fail(reader->error, "%s:%llu: a vertex needs 3 coordinates, here are %d numbers",
                                  reader->path, (unsigned long long)line, count);
    }
    List *list = &reader->lists[LIST_VERTEX];
    if (list->count >= COUNT_LIMIT) {
        return percale_scene_fail(reader->error, "%s:%llu: too many vertices", reader->path,
                                  (unsigned long long)line);
    }
    double *positions = percale_grow(reader->positions, &reader->position_capacity, (uint64_t)list->count + 1,
                                     3 * sizeof *positions);
    if (positions == NULL) {
        return out_of_memory(reader);
    }
    reader->positions = positions;
    memcpy(&positions[3 * (size_t)list->count], numbers, 3 * sizeof *numbers);
    ++list->count;
    return true;
}

static bool read_uv(Reader *reader)
{
    double numbers[3];
    int count;
    const uint64_t line = reader->line;
    if (!read_numbers(reader, numbers, 3, &count)) {
        return false;
    }
    if (count < 2) {
        return percale_scene_fail(reader->error, "%s:%llu: texture coordinates need 2 numbers, here are %d",
                                  reader->path, (unsigned long long)line, count);
    }
    List *list = &reader->lists[LIST_UV];
    float *uvs = percale_grow(reader->uvs, &reader->uv_capacity, (uint64_t)list->count + 1, 2 * sizeof *uvs);
    if (uvs == NULL || list->count >= COUNT_LIMIT) {
        return out_of_memory(reader);
    }
    reader->uvs = uvs;
    uvs[2 * (size_t)list->count] = (float)numbers[0];
    uvs[2 * (size_t)list->count + 1] = (float)numbers[1];
    ++list->count;
    return true;
}

// One index of a corner, from 1 as in the file or negative: counted back from the latest.
static bool read_index(Reader *reader, ListKind kind, uint32_t *index)
{
    const char *at = reader->at;
    const bool negative = at < reader->end && *at == '-';
    uint64_t number = 0;
    at += negative;
    const char *first = at;
    for (; at < reader->end && *at >= '0' && *at <= '9'; ++at) {
        number = number <= COUNT_LIMIT ? 10 * number + (uint64_t)(*at - '0') : number;
    }
    const bool ends = at >= reader->end || strchr(" \t\r\n/\\", *at) != NULL;
    if (at == first || !ends) {
        return percale_scene_fail(reader->error, "%s:%llu: \"%.*s\" is not a corner of a face", reader->path,
                                  (unsigned long long)reader->line, shown_length(reader), reader->at);
    }
    List *list = &reader->lists[kind];
    if (number == 0 || number > (negative ? list->count : COUNT_LIMIT)) {
        return percale_scene_fail(reader->error, "%s:%llu: %s index %.*s is out of range (%u so far)",
                                  reader->path, (unsigned long long)reader->line, list_names[kind],
                                  (int)(at - reader->at), reader->at, list->count);
    }
    *index = negative ? list->count + 1 - (uint32_t)number : (uint32_t)number;
    if (*index > list->largest) {
        list->largest = *index;
        list->largest_line = reader->line;
    }
    reader->at = at;
    return true;
}

static bool take_slash(Reader *reader)
{
    const bool slash = reader->at < reader->end && *reader->at == '/';
    reader->at += slash;
    return slash;
}

static bool read_corner(Reader *reader, Corner *corner)
{
    uint32_t index = 0;
    *corner = (Corner){.uv = UV_NONE};
    if (!read_index(reader, LIST_VERTEX, &index)) {
        return false;
    }
    corner->vertex = index - 1;
    if (!take_slash(reader)) {
        return true;
    }
    const bool normal_only = take_slash(reader);
    if (!normal_only && !read_index(reader, LIST_UV, &corner->uv)) {
        return false;
    }
    if (normal_only || take_slash(reader)) {
        return read_index(reader, LIST_NORMAL, &index);
    }
    return true;
}

static int compare_indices(const void *a, const void *b)
{
    const uint32_t left = *(const uint32_t *)a;
    const uint32_t right = *(const uint32_t *)b;
    return (left > right) - (left < right);
}

static uint32_t repeated_of_few(const Corner *corners, uint32_t count)
{
    uint32_t repeated = 0;
    for (uint32_t i = 1; i < count; ++i) {
        for (uint32_t j = 0; j < i; ++j) {
            repeated = corners[i].vertex == corners[j].vertex ? corners[i].vertex + 1 : repeated;
        }
    }
    return repeated;
}

// The number in the file of a vertex that the face has twice; 0: none.
static bool find_repeated(Reader *reader, uint32_t count, uint32_t *repeated)
{
    if (count <= SMALL_FACE) {
        *repeated = repeated_of_few(reader->corners, count);
        return true;
    }
    uint32_t *sorted = percale_grow(reader->sorted, &reader->sorted_capacity, count, sizeof *sorted);
    if (sorted == NULL) {
        return out_of_memory(reader);
    }
    reader->sorted = sorted;
    for (uint32_t i = 0; i < count; ++i) {
        sorted[i] = reader->corners[i].vertex;
    }
    qsort(sorted, count, sizeof *sorted, compare_indices);
    for (uint32_t i = 1; i < count; ++i) {
        *repeated = sorted[i] == sorted[i - 1] ? sorted[i] + 1 : *repeated;
    }
    return true;
}

static bool add_fan(Reader *reader, uint32_t corner_count)
{
    const uint64_t needed = (uint64_t)reader->triangle_count + corner_count - 2;
    if (needed > COUNT_LIMIT) {
        return percale_scene_fail(reader->error, "%s:%llu: too many faces", reader->path,
                                  (unsigned long long)reader->line);
    }
    uint32_t *triangles =
        percale_grow(reader->triangles, &reader->triangle_capacity, needed, 3 * sizeof *triangles);
    reader->triangles = triangles != NULL ? triangles : reader->triangles;
    uint32_t *uvs =
        percale_grow(reader->triangle_uvs, &reader->triangle_uv_capacity, needed, 3 * sizeof *uvs);
    reader->triangle_uvs = uvs != NULL ? uvs : reader->triangle_uvs;
    if (triangles == NULL || uvs == NULL) {
        return out_of_memory(reader);
    }
    for (uint32_t k = 2; k < corner_count; ++k) {
        const Corner fan[3] = {reader->corners[0], reader->corners[k - 1], reader->corners[k]};
        for (int c = 0; c < 3; ++c) {
            triangles[3 * (size_t)reader->triangle_count + (size_t)c] = fan[c].vertex;
            uvs[3 * (size_t)reader->triangle_count + (size_t)c] = fan[c].uv;
        }
        ++reader->triangle_count;
    }
    return true;
}

static bool read_face(Reader *reader)
{
    const uint64_t line = reader->line;
    uint32_t count = 0;
    for (skip_blanks(reader); !at_statement_end(reader); skip_blanks(reader)) {
        Corner *corners =
            percale_grow(reader->corners, &reader->corner_capacity, (uint64_t)count + 1, sizeof *corners);
        if (corners == NULL) {
            return out_of_memory(reader);
        }
        reader->corners = corners;
        if (!read_corner(reader, &corners[count])) {
            return false;
        }
        ++count;
    }
    if (count < 3) {
        return percale_scene_fail(reader->error, "%s:%llu: a face needs at least 3 corners, here are %u",
                                  reader->path, (unsigned long long)line, count);
    }
    uint32_t repeated = 0;
    if (!find_repeated(reader, count, &repeated)) {
        return false;
    }
    if (repeated != 0) {
        return percale_scene_fail(reader->error, "%s:%llu: the face has vertex %u twice", reader->path,
                                  (unsigned long long)line, repeated);
    }
    return add_fan(reader, count);
}

static bool read_statement(Reader *reader)
{
    skip_blanks(reader);
    bool understood = true;
    if (starts_with(reader, "v")) {
        reader->at += 1;
        understood = read_vertex(reader);
    } else if (starts_with(reader, "vt")) {
        reader->at += 2;
        understood = read_uv(reader);
    } else if (starts_with(reader, "f")) {
        reader->at += 1;
        understood = read_face(reader);
    } else if (starts_with(reader, "vn") && reader->lists[LIST_NORMAL].count < COUNT_LIMIT) {
        ++reader->lists[LIST_NORMAL].count;
    }
    if (understood) {
        skip_line(reader);
    }
    return understood;
}

// ---- the whole ----

static bool check_lists(Reader *reader, bool surface)
{
    for (int kind = 0; kind < LIST_COUNT; ++kind) {
        const List *list = &reader->lists[kind];
        if (list->largest > list->count) {
            return percale_scene_fail(reader->error, "%s:%llu: %s index %u is out of range (the file has %u)",
                                      reader->path, (unsigned long long)list->largest_line, list_names[kind],
                                      list->largest, list->count);
        }
    }
    if (reader->lists[LIST_VERTEX].count == 0) {
        return percale_scene_fail(reader->error, "%s: no vertices: not an OBJ mesh", reader->path);
    }
    if (surface && reader->triangle_count == 0) {
        return percale_scene_fail(reader->error, "%s: no faces", reader->path);
    }
    return true;
}

// The first corner that has texture coordinates gives its vertex them.
static void assign_uv(const Reader *reader, uint32_t vertex, uint32_t uv, uint32_t *chosen, PercaleObj *obj)
{
    if (chosen[vertex] == UV_NONE) {
        chosen[vertex] = uv;
        return;
    }
    const float *first = &reader->uvs[2 * (size_t)(chosen[vertex] - 1)];
    const float *other = &reader->uvs[2 * (size_t)(uv - 1)];
    if ((first[0] != other[0] || first[1] != other[1]) && vertex < obj->uv_split_vertex) {
        obj->uv_split_vertex = vertex;
    }
}

static bool assign_uvs(const Reader *reader, PercaleObj *obj)
{
    const size_t vertex_count = obj->vertex_count;
    obj->uv_split_vertex = obj->vertex_count;
    obj->uv_missing_vertex = obj->vertex_count;
    if (reader->lists[LIST_UV].largest == 0) {
        obj->uv_missing_vertex = 0;
        return true;
    }
    uint32_t *chosen = percale_array_new(vertex_count, sizeof *chosen);
    obj->uvs = percale_array_new(vertex_count, 2 * sizeof *obj->uvs);
    if (chosen == NULL || obj->uvs == NULL) {
        free(chosen);
        return out_of_memory(reader);
    }
    for (size_t corner = 0; corner < 3 * (size_t)reader->triangle_count; ++corner) {
        if (reader->triangle_uvs[corner] != UV_NONE) {
            assign_uv(reader, reader->triangles[corner], reader->triangle_uvs[corner], chosen, obj);
        }
    }
    for (size_t vertex = vertex_count; vertex-- > 0;) {
        if (chosen[vertex] == UV_NONE) {
            obj->uv_missing_vertex = (uint32_t)vertex;
        } else {
            memcpy(&obj->uvs[2 * vertex], &reader->uvs[2 * (size_t)(chosen[vertex] - 1)],
                   2 * sizeof *obj->uvs);
        }
    }
    free(chosen);
    return true;
}

static bool read_all(Reader *reader, bool surface, PercaleObj *obj)
{
    while (reader->at < reader->end) {
        if (!read_statement(reader)) {
            return false;
        }
    }
    if (!check_lists(reader, surface)) {
        return false;
    }
    obj->name = percale_base_name(reader->path);
    obj->vertex_count = reader->lists[LIST_VERTEX].count;
    obj->triangle_count = reader->triangle_count;
    obj->positions = reader->positions;
    obj->triangles = reader->triangles;
    reader->positions = NULL;
    const bool assigned = assign_uvs(reader, obj);
    reader->triangles = NULL;
    return assigned && (obj->name != NULL || out_of_memory(reader));
}

bool percale_obj_load(const char *path, bool surface, PercaleObj *obj, PercaleSceneError *error)
{
    *obj = (PercaleObj){0};
    PercaleText text;
    if (!percale_text_read(path, &text, error)) {
        return false;
    }
    Reader reader = {
        .path = path, .error = error, .at = text.bytes, .end = text.bytes + text.size, .line = 1};
    const bool done = read_all(&reader, surface, obj);
    free(reader.positions);
    free(reader.uvs);
    free(reader.triangles);
    free(reader.triangle_uvs);
    free(reader.corners);
    free(reader.sorted);
    percale_text_free(&text);
    if (!done) {
        percale_obj_free(obj);
    }
    return done;
}

void percale_obj_free(PercaleObj *obj)
{
    free(obj->name);
    free(obj->positions);
    free(obj->uvs);
    free(obj->triangles);
    *obj = (PercaleObj){0};
}

void percale_mesh_free(PercaleMesh *mesh)
{
    free(mesh->name);
    free(mesh->positions);
    free(mesh->uvs);
    free(mesh->triangles);
    *mesh = (PercaleMesh){0};
}

bool percale_obj_read(const char *path, const double origin[3], PercaleMesh *mesh, PercaleSceneError *error)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    *mesh = (PercaleMesh){0};
    PercaleObj obj;
    if (!percale_obj_load(path, true, &obj, error)) {
        return false;
    }
    const double *shift = origin != NULL ? origin : zero;
    float *positions = percale_array_new(3 * (uint64_t)obj.vertex_count, sizeof *positions);
    if (positions == NULL) {
        percale_obj_free(&obj);
        return percale_scene_out_of_memory(error);
    }
    for (size_t k = 0; k < 3 * (size_t)obj.vertex_count; ++k) {
        positions[k] = (float)(obj.positions[k] - shift[k % 3]);
    }
    *mesh = (PercaleMesh){.name = obj.name,
                          .positions = positions,
                          .uvs = obj.uvs,
                          .vertex_count = obj.vertex_count,
                          .triangles = obj.triangles,
                          .triangle_count = obj.triangle_count};
    free(obj.positions);
    return true;
}

static void write_obj(FILE *stream, const float *positions, uint32_t vertex_count, const uint32_t *triangles,
                      uint32_t triangle_count, const double origin[3])
{
    for (size_t vertex = 0; vertex < vertex_count; ++vertex) {
        char numbers[3][PERCALE_NUMBER_TEXT_SIZE];
        for (size_t axis = 0; axis < 3; ++axis) {
            (void)percale_number_format(numbers[axis], (double)positions[3 * vertex + axis] +
                                                           (origin != NULL ? origin[axis] : 0.0));
        }
        (void)fprintf(stream, "v %s %s %s\n", numbers[0], numbers[1], numbers[2]);
    }
    for (size_t corner = 0; corner < 3 * (size_t)triangle_count; corner += 3) {
        (void)fprintf(stream, "f %u %u %u\n", triangles[corner] + 1, triangles[corner + 1] + 1,
                      triangles[corner + 2] + 1);
    }
}

bool percale_obj_write(const char *path, const float *positions, uint32_t vertex_count,
                       const uint32_t *triangles, uint32_t triangle_count, const double origin[3],
                       PercaleSceneError *error)
{
    PercaleOutputFile file;
    if (!percale_output_open(&file, path, error)) {
        return false;
    }
    write_obj(file.stream, positions, vertex_count, triangles, triangle_count, origin);
    return percale_output_commit(&file, error);
}
