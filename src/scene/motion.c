#include "scene/motion.h"

#include "scene/grow.h"
#include "scene/obj_file.h"
#include "scene/scene_error.h"

#include <math.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { NUMBER_WIDTH_LIMIT = 9 }; // digits of an OBJ sequence's numbers

// ---- transforms ----

PercaleTransform percale_transform_identity(void)
{
    return (PercaleTransform){.matrix = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
}

// Quarter turns are exact, so that turning a mesh by 90 degrees keeps its axes.
static void sine_and_cosine(double degrees, double *sine, double *cosine)
{
    const double quarters = nearbyint(degrees / 90.0);
    const double rest = (degrees - 90.0 * quarters) * (3.14159265358979323846 / 180.0);
    const int quarter = (int)(quarters - 4.0 * floor(quarters / 4.0));
    const double s = sin(rest);
    const double c = cos(rest);
    *sine = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
    *cosine = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
}

PercaleTransform percale_transform_make(double scale, const double degrees[3], const double translation[3])
{
    double s[3];
    double c[3];
    for (int axis = 0; axis < 3; ++axis) {
        sine_and_cosine(degrees[axis], &s[axis], &c[axis]);
    }
    // R = Rz Ry Rx
    PercaleTransform transform = {
        .matrix = {{c[2] * c[1], c[2] * s[1] * s[0] - s[2] * c[0], c[2] * s[1] * c[0] + s[2] * s[0]},
                   {s[2] * c[1], s[2] * s[1] * s[0] + c[2] * c[0], s[2] * s[1] * c[0] - c[2] * s[0]},
                   {-s[1], c[1] * s[0], c[1] * c[0]}}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            transform.matrix[row][column] *= scale;
        }
        transform.translation[row] = translation[row];
    }
    return transform;
}

// x = M (p + o) + t - o for p relative to the origin o: what doesn't depend on p is summed first, so that an
// identity leaves every bit as it is.
PercaleTransform percale_transform_from_file(const PercaleTransform *transform, const double origin[3],
                                             bool relative)
{
    PercaleTransform result = *transform;
    for (int row = 0; row < 3; ++row) {
        const double *m = transform->matrix[row];
        const double turned = relative ? m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2] : 0.0;
        result.translation[row] += turned - origin[row];
    }
    return result;
}

void percale_transform_point(const PercaleTransform *transform, const double from[3], float to[3])
{
    for (int row = 0; row < 3; ++row) {
        const double *m = transform->matrix[row];
        to[row] = (float)(m[0] * from[0] + m[1] * from[1] + m[2] * from[2] + transform->translation[row]);
    }
}

// ---- reading ----

static bool ends_with(const char *path, const char *suffix)
{
    const size_t length = strlen(path);
    const size_t suffix_length = strlen(suffix);
    return length >= suffix_length && strcasecmp(path + length - suffix_length, suffix) == 0;
}

static bool check_count(const char *path, uint32_t count, uint32_t expected, PercaleSceneError *error)
{
    return count == expected ||
           percale_scene_fail(error, "%s: %u points, but %u are to be moved", path, count, expected);
}

// A pattern: what stands before and behind its one %d or %04d, and how many digits at least.
typedef struct Pattern {
    const char *text;
    int before;
    int width;
    const char *behind;
} Pattern;

static bool parse_pattern(const char *path, Pattern *pattern, PercaleSceneError *error)
{
    const char *at = strchr(path, '%');
    *pattern = (Pattern){.text = path};
    if (at != NULL) {
        pattern->before = (int)(at - path);
        for (++at; *at >= '0' && *at <= '9' && pattern->width <= NUMBER_WIDTH_LIMIT; ++at) {
            pattern->width = 10 * pattern->width + (*at - '0');
        }
        pattern->behind = at + 1;
    }
    if (at == NULL || *at != 'd' || pattern->width > NUMBER_WIDTH_LIMIT || strchr(at, '%') != NULL) {
        return percale_scene_fail(
            error, "%s: an animation is a .pc2 file or an OBJ sequence \"name_%%04d.obj\"", path);
    }
    return true;
}

static char *frame_path(const Pattern *pattern, uint32_t frame)
{
    const size_t size = strlen(pattern->text) + 2 * (size_t)NUMBER_WIDTH_LIMIT + 2;
    char *path = malloc(size);
    if (path != NULL) {
        (void)snprintf(path, size, "%.*s%0*u%s", pattern->before, pattern->text, pattern->width, frame,
                       pattern->behind);
    }
    return path;
}

static bool append_frame(const char *path, uint32_t vertex_count, PercaleMotion *motion, uint32_t *capacity,
                         PercaleSceneError *error)
{
    PercaleObj obj;
    if (!percale_obj_load(path, false, &obj, error)) {
        return false;
    }
    const size_t per_sample = 3 * (size_t)vertex_count;
    bool done = check_count(path, obj.vertex_count, vertex_count, error);
    if (done) {
        double *world = percale_grow(motion->world, capacity, (uint64_t)motion->sample_count + 1,
                                     per_sample * sizeof *world);
        done = world != NULL || percale_scene_out_of_memory(error);
        motion->world = world != NULL ? world : motion->world;
    }
    if (done) {
        memcpy(motion->world + motion->sample_count * per_sample, obj.positions,
               per_sample * sizeof *motion->world);
        ++motion->sample_count;
    }
    percale_obj_free(&obj);
    return done;
}

static bool read_sequence(const char *path, uint32_t vertex_count, PercaleMotion *motion,
                          PercaleSceneError *error)
{
    Pattern pattern;
    uint32_t capacity = 0;
    bool more = parse_pattern(path, &pattern, error);
    if (!more) {
        return false;
    }
    while (more) {
        char *frame = frame_path(&pattern, motion->sample_count);
        bool read = frame != NULL || percale_scene_out_of_memory(error);
        more = read && (motion->sample_count == 0 || access(frame, F_OK) == 0);
        read = read && (!more || append_frame(frame, vertex_count, motion, &capacity, error));
        free(frame);
        if (!read) {
            return false;
        }
    }
    return true;
}

bool percale_motion_read(const char *path, uint32_t vertex_count, PercaleMotion *motion,
                         PercaleSceneError *error)
{
    *motion = (PercaleMotion){.vertex_count = vertex_count};
    bool done;
    if (ends_with(path, ".pc2")) {
        done = percale_pc2_read(path, &motion->cache, error) &&
               check_count(path, motion->cache.vertex_count, vertex_count, error);
        motion->sample_count = motion->cache.sample_count;
    } else {
        done = read_sequence(path, vertex_count, motion, error);
    }
    if (!done) {
        percale_motion_free(motion);
    }
    return done;
}

void percale_motion_free(PercaleMotion *motion)
{
    percale_point_cache_free(&motion->cache);
    free(motion->world);
    if (motion->release != NULL) {
        motion->release(motion->figure);
    }
    *motion = (PercaleMotion){0};
}

// ---- posing ----

static uint32_t held_sample(const PercaleMotion *motion, uint32_t frame)
{
    return frame < motion->sample_count ? frame : motion->sample_count - 1;
}

bool percale_motion_given(const PercaleMotion *motion)
{
    return motion->sample_count > 0 || motion->pose != NULL;
}

bool percale_motion_changes(const PercaleMotion *motion, uint32_t frame)
{
    if (motion->pose != NULL) {
        return true;
    }
    return motion->sample_count != 0 && held_sample(motion, frame) != motion->current;
}

void percale_motion_pose(PercaleMotion *motion, uint32_t frame, double frame_rate,
                         const PercaleTransform *transform, const double origin[3], float *positions)
{
    if (motion->pose != NULL) {
        motion->pose(motion->figure, frame / frame_rate, positions);
        return;
    }
    motion->current = held_sample(motion, frame);
    const PercaleTransform placed = percale_transform_from_file(transform, origin, motion->world == NULL);
    const size_t first = 3 * (size_t)motion->vertex_count * motion->current;
    for (size_t k = 0; k < 3 * (size_t)motion->vertex_count; k += 3) {
        double from[3];
        for (size_t axis = 0; axis < 3; ++axis) {
            from[axis] = motion->world != NULL ? motion->world[first + k + axis]
                                               : (double)motion->cache.samples[first + k + axis];
        }
        percale_transform_point(&placed, from, &positions[k]);
    }
}
