// Scene files. First the keys of an object are checked, then its values read one after the other; files are
// read at once, so that indices can be checked against them.

#include "scene/grow.h"
#include "scene/json_reader.h"
#include "scene/obj_file.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"

#include <string.h>

enum { FRAME_LIMIT = 10000000 };
static const double farthest = 1e9; // m; translation

static const char scene_keys[] = "frame_rate|frames|cloths|obstacles|settings";
static const char cloth_keys[] = "name|obj|density|stretch_compliance|bending_stiffness|thickness|friction|"
                                 "layer|mask|rest|pins|seams|translate|rotate|scale";
static const char obstacle_keys[] = "name|obj|animation|friction|thickness|mask|translate|rotate|scale";
static const char pin_keys[] = "vertices|animation";

static const PercaleSettingIndex own_settings[PERCALE_OWN_COUNT] = {
    [PERCALE_OWN_DENSITY] = PERCALE_SET_DENSITY,
    [PERCALE_OWN_STRETCH_COMPLIANCE] = PERCALE_SET_STRETCH_COMPLIANCE,
    [PERCALE_OWN_BENDING_STIFFNESS] = PERCALE_SET_BENDING_STIFFNESS,
    [PERCALE_OWN_THICKNESS] = PERCALE_SET_THICKNESS,
    [PERCALE_OWN_FRICTION] = PERCALE_SET_FRICTION,
};

// What is being read: the file, and the object with the error's words for it.
typedef struct Object {
    const PercaleJsonReader *reader;
    PercaleJsonMember json;
    PercaleSceneItem *item;
} Object;

// Relative paths start at the folder of the scene file.
static char *resolve_path(const PercaleJsonReader *reader, const char *name)
{
    const char *slash = strrchr(reader->path, '/');
    const size_t folder = name[0] == '/' || slash == NULL ? 0 : (size_t)(slash - reader->path) + 1;
    const size_t size = folder + strlen(name) + 1;
    char *path = malloc(size);
    if (path != NULL) {
        (void)snprintf(path, size, "%.*s%s", (int)folder, reader->path, name);
    } else {
        percale_scene_out_of_memory(reader->error);
    }
    return path;
}

// ---- what cloths and obstacles share ----

static bool is_file_name(const char *name)
{
    for (const char *at = name; *at != '\0'; ++at) {
        if (*at == '/' || *at == '\\' || (unsigned char)*at < ' ') {
            return false;
        }
    }
    return name[0] != '\0' && name[0] != '.';
}

static bool load_obj(const PercaleJsonReader *reader, const char *name, PercaleObj *obj)
{
    char *path = resolve_path(reader, name);
    const bool done = path != NULL && percale_obj_load(path, true, obj, reader->error);
    free(path);
    return done;
}

// A texture atlas is no pattern: every vertex must have one place in it.
static bool check_pattern(const Object *object, const PercaleObj *obj)
{
    const PercaleJsonMember rest = percale_json_member(&object->json, "rest");
    const char *kind = json_string_value(rest.value);
    if (kind == NULL || strcmp(kind, "uv") != 0) {
        return true;
    }
    if (obj->uv_missing_vertex < obj->vertex_count) {
        return percale_json_fail(object->reader, &rest.place, false,
                                 "rest \"uv\": vertex %u of %s has no texture coordinates",
                                 obj->uv_missing_vertex, obj->name);
    }
    return obj->uv_split_vertex == obj->vertex_count ||
           percale_json_fail(object->reader, &rest.place, false,
                             "rest \"uv\": vertex %u of %s has two different texture coordinates: no flat "
                             "pattern",
                             obj->uv_split_vertex, obj->name);
}

static bool read_mesh(const Object *object)
{
    const PercaleJsonMember file = percale_json_member(&object->json, "obj");
    const char *name;
    PercaleObj obj;
    if (file.value == NULL) {
        return percale_json_fail(object->reader, &object->json.place, false, "\"obj\" is missing here");
    }
    if (!percale_json_string(object->reader, &file, "obj", &name) || !load_obj(object->reader, name, &obj)) {
        return false;
    }
    if (!check_pattern(object, &obj)) {
        percale_obj_free(&obj);
        return false;
    }
    object->item->file = obj.positions;
    object->item->mesh = (PercaleMesh){.name = obj.name,
                                       .uvs = obj.uvs,
                                       .vertex_count = obj.vertex_count,
                                       .triangles = obj.triangles,
                                       .triangle_count = obj.triangle_count};
    object->item->mesh.positions =
        percale_array_new(3 * (uint64_t)obj.vertex_count, sizeof *object->item->mesh.positions);
    return object->item->mesh.positions != NULL || percale_scene_out_of_memory(object->reader->error);
}

static bool read_name(const Object *object)
{
    const PercaleJsonMember member = percale_json_member(&object->json, "name");
    const char *name;
    if (member.value == NULL) {
        return true;
    }
    if (!percale_json_string(object->reader, &member, "name", &name)) {
        return false;
    }
    if (!is_file_name(name)) {
        return percale_json_fail(object->reader, &member.place, false,
                                 "name \"%s\" can't be the name of a file", name);
    }
    char *copy = strdup(name);
    if (copy == NULL) {
        return percale_scene_out_of_memory(object->reader->error);
    }
    free(object->item->mesh.name);
    object->item->mesh.name = copy;
    return true;
}

static bool read_transform(const Object *object)
{
    double translation[3] = {0.0, 0.0, 0.0};
    double degrees[3] = {0.0, 0.0, 0.0};
    double scale = 1.0;
    const PercaleJsonMember translate = percale_json_member(&object->json, "translate");
    const PercaleJsonMember rotate = percale_json_member(&object->json, "rotate");
    const PercaleJsonMember size = percale_json_member(&object->json, "scale");
    if (translate.value != NULL &&
        !percale_json_vector(object->reader, &translate, "translate", farthest, translation)) {
        return false;
    }
    if (rotate.value != NULL && !percale_json_vector(object->reader, &rotate, "rotate", 1e6, degrees)) {
        return false;
    }
    if (size.value != NULL && !percale_json_number(object->reader, &size, "scale", 1e-6, 1e6, &scale)) {
        return false;
    }
    object->item->transform = percale_transform_make(scale, degrees, translation);
    return true;
}

static bool read_own_values(const Object *object, const PercaleSettings *settings)
{
    for (int own = 0; own < PERCALE_OWN_COUNT; ++own) {
        const PercaleSetting *setting = &settings->items[own_settings[own]];
        const PercaleJsonMember member = percale_json_member(&object->json, setting->name);
        double value;
        if (member.value == NULL) {
            continue;
        }
        if (!percale_json_number(object->reader, &member, setting->name, setting->minimum, setting->maximum,
                                 &value)) {
            return false;
        }
        object->item->own[own] = (float)value;
        object->item->has_own[own] = true;
    }
    const PercaleJsonMember member = percale_json_member(&object->json, "mask");
    int64_t mask = object->item->mask;
    if (member.value != NULL && !percale_json_whole(object->reader, &member, "mask", 0, UINT32_MAX, &mask)) {
        return false;
    }
    object->item->mask = (uint32_t)mask;
    return true;
}

static bool read_motion(const PercaleJsonReader *reader, const PercaleJsonMember *member, uint32_t count,
                        PercaleMotion *motion)
{
    const char *name;
    if (member->value == NULL) {
        return true;
    }
    if (!percale_json_string(reader, member, "animation", &name)) {
        return false;
    }
    char *path = resolve_path(reader, name);
    const bool done = path != NULL && percale_motion_read(path, count, motion, reader->error);
    free(path);
    return done;
}

// ---- cloths ----

static bool read_rest(const Object *object)
{
    const PercaleJsonMember rest = percale_json_member(&object->json, "rest");
    const char *kind = "mesh";
    PercaleObj obj;
    if (rest.value != NULL && !percale_json_string(object->reader, &rest, "rest", &kind)) {
        return false;
    }
    if (strcmp(kind, "mesh") == 0 || strcmp(kind, "uv") == 0) {
        object->item->rest = kind[0] == 'u' ? PERCALE_REST_UV : PERCALE_REST_MESH;
        return true;
    }
    if (!load_obj(object->reader, kind, &obj)) {
        return false;
    }
    object->item->rest = PERCALE_REST_POINTS;
    object->item->rest_file = obj.positions;
    obj.positions = NULL;
    const uint32_t count = obj.vertex_count;
    percale_obj_free(&obj);
    return count == object->item->mesh.vertex_count ||
           percale_json_fail(object->reader, &rest.place, false,
                             "the rest shape %s has %u vertices, the cloth %u", kind, count,
                             object->item->mesh.vertex_count);
}

static bool read_vertex(const Object *object, const PercaleJsonMember *member, const char *what,
                        uint32_t *vertex)
{
    const PercaleMesh *mesh = &object->item->mesh;
    int64_t index;
    if (!percale_json_whole(object->reader, member, what, INT64_MIN, INT64_MAX, &index)) {
        return false;
    }
    *vertex = (uint32_t)index;
    return (index >= 0 && index < mesh->vertex_count) ||
           percale_json_fail(object->reader, &member->place, false,
                             "%s %lld is out of range: \"%s\" has vertices 0 to %u", what, (long long)index,
                             mesh->name, mesh->vertex_count - 1);
}

// One group from a list of vertices; `pinned` marks those of all groups.
static bool read_pin_vertices(const Object *object, const PercaleJsonMember *list, bool *pinned)
{
    const size_t count = json_array_size(list->value);
    if (count == 0 || count > object->item->mesh.vertex_count) {
        return percale_json_fail(object->reader, &list->place, false,
                                 "%zu pins for the %u vertices of \"%s\"", count,
                                 object->item->mesh.vertex_count, object->item->mesh.name);
    }
    PercalePinGroup *group = percale_scene_add_pins(object->item, (uint32_t)count, object->reader->error);
    if (group == NULL) {
        return false;
    }
    for (size_t k = 0; k < count; ++k) {
        const PercaleJsonMember element = percale_json_element(list, k);
        uint32_t vertex;
        if (!read_vertex(object, &element, "pin", &vertex)) {
            return false;
        }
        if (pinned[vertex]) {
            return percale_json_fail(object->reader, &element.place, false, "pin %u is there twice", vertex);
        }
        pinned[vertex] = true;
        group->vertices[k] = vertex;
    }
    return true;
}

static bool read_pin_group(const Object *object, const PercaleJsonMember *json, bool *pinned)
{
    if (!percale_json_object(object->reader, json, "a group of pins") ||
        !percale_json_check_keys(object->reader, json, pin_keys, "a group of pins")) {
        return false;
    }
    const PercaleJsonMember vertices = percale_json_member(json, "vertices");
    if (vertices.value == NULL) {
        return percale_json_fail(object->reader, &json->place, false, "\"vertices\" is missing here");
    }
    if (!percale_json_array(object->reader, &vertices, "vertices") ||
        !read_pin_vertices(object, &vertices, pinned)) {
        return false;
    }
    const PercaleJsonMember animation = percale_json_member(json, "animation");
    PercalePinGroup *group = &object->item->pins[object->item->pin_count - 1];
    return read_motion(object->reader, &animation, group->count, &group->motion);
}

// A list of vertices, one group, or a list of groups.
static bool read_pin_groups(const Object *object, const PercaleJsonMember *pins, bool *pinned)
{
    if (json_is_object(pins->value)) {
        return read_pin_group(object, pins, pinned);
    }
    if (!percale_json_array(object->reader, pins, "pins")) {
        return false;
    }
    const size_t count = json_array_size(pins->value);
    if (count > 0 && json_is_integer(json_array_get(pins->value, 0))) {
        return read_pin_vertices(object, pins, pinned);
    }
    for (size_t k = 0; k < count; ++k) {
        const PercaleJsonMember group = percale_json_element(pins, k);
        if (!read_pin_group(object, &group, pinned)) {
            return false;
        }
    }
    return true;
}

static bool read_pins(const Object *object)
{
    const PercaleJsonMember pins = percale_json_member(&object->json, "pins");
    if (pins.value == NULL) {
        return true;
    }
    bool *pinned = percale_array_new(object->item->mesh.vertex_count, sizeof *pinned);
    if (pinned == NULL) {
        return percale_scene_out_of_memory(object->reader->error);
    }
    const bool done = read_pin_groups(object, &pins, pinned);
    free(pinned);
    return done;
}

static bool read_seam_pair(const Object *object, const PercaleJsonMember *pair, uint32_t vertices[2])
{
    if (!json_is_array(pair->value) || json_array_size(pair->value) != 2) {
        return percale_json_fail(object->reader, &pair->place, false, "a seam pair must be [vertex, vertex]");
    }
    for (size_t end = 0; end < 2; ++end) {
        const PercaleJsonMember element = percale_json_element(pair, end);
        if (!read_vertex(object, &element, "seam vertex", &vertices[end])) {
            return false;
        }
    }
    return vertices[0] != vertices[1] ||
           percale_json_fail(object->reader, &pair->place, false, "vertex %u is sewn to itself", vertices[0]);
}

static bool read_seams(const Object *object)
{
    const PercaleJsonMember seams = percale_json_member(&object->json, "seams");
    if (seams.value == NULL) {
        return true;
    }
    if (!percale_json_array(object->reader, &seams, "seams")) {
        return false;
    }
    const size_t count = json_array_size(seams.value);
    if (count > INT32_MAX) {
        return percale_json_fail(object->reader, &seams.place, false, "too many seam pairs");
    }
    object->item->seams = percale_array_new(count, sizeof *object->item->seams);
    if (object->item->seams == NULL) {
        return percale_scene_out_of_memory(object->reader->error);
    }
    for (size_t k = 0; k < count; ++k) {
        const PercaleJsonMember pair = percale_json_element(&seams, k);
        if (!read_seam_pair(object, &pair, object->item->seams[k])) {
            return false;
        }
    }
    object->item->seam_count = (uint32_t)count;
    return true;
}

static bool read_layer(const Object *object)
{
    const PercaleJsonMember member = percale_json_member(&object->json, "layer");
    int64_t layer = object->item->layer;
    if (member.value != NULL &&
        !percale_json_whole(object->reader, &member, "layer", INT32_MIN, INT32_MAX, &layer)) {
        return false;
    }
    object->item->layer = (int32_t)layer;
    return true;
}

// Output files carry the names of the cloths.
static bool check_unique_name(const Object *object, const PercaleScene *scene)
{
    for (uint32_t other = 0; other + 1 < scene->cloth_count; ++other) {
        if (strcmp(scene->cloths[other].mesh.name, object->item->mesh.name) == 0) {
            return percale_json_fail(object->reader, &object->json.place, false,
                                     "there are two cloths \"%s\": give them different names",
                                     object->item->mesh.name);
        }
    }
    return true;
}

static bool read_cloth(PercaleScene *scene, const PercaleJsonReader *reader, PercaleJsonMember json)
{
    if (!percale_json_object(reader, &json, "a cloth") ||
        !percale_json_check_keys(reader, &json, cloth_keys, "a cloth")) {
        return false;
    }
    const Object object = {reader, json, percale_scene_add_cloth(scene, reader->error)};
    return object.item != NULL && read_mesh(&object) && read_name(&object) &&
           check_unique_name(&object, scene) && read_transform(&object) &&
           read_own_values(&object, &scene->settings) && read_layer(&object) && read_rest(&object) &&
           read_pins(&object) && read_seams(&object);
}

static bool read_obstacle(PercaleScene *scene, const PercaleJsonReader *reader, PercaleJsonMember json)
{
    if (!percale_json_object(reader, &json, "an obstacle") ||
        !percale_json_check_keys(reader, &json, obstacle_keys, "an obstacle")) {
        return false;
    }
    const Object object = {reader, json, percale_scene_add_obstacle(scene, reader->error)};
    if (object.item == NULL || !read_mesh(&object) || !read_name(&object) || !read_transform(&object) ||
        !read_own_values(&object, &scene->settings)) {
        return false;
    }
    const PercaleJsonMember animation = percale_json_member(&object.json, "animation");
    return read_motion(reader, &animation, object.item->mesh.vertex_count, &object.item->motion);
}

// ---- the scene ----

typedef bool ReadItem(PercaleScene *scene, const PercaleJsonReader *reader, PercaleJsonMember json);

static bool read_list(PercaleScene *scene, const PercaleJsonReader *reader, const PercaleJsonMember *root,
                      const char *key, ReadItem *read)
{
    const PercaleJsonMember list = percale_json_member(root, key);
    if (list.value == NULL) {
        return true;
    }
    if (!percale_json_array(reader, &list, key)) {
        return false;
    }
    for (size_t k = 0; k < json_array_size(list.value); ++k) {
        if (!read(scene, reader, percale_json_element(&list, k))) {
            return false;
        }
    }
    return true;
}

// A number, or three of them.
static bool read_number_setting(PercaleSettings *settings, uint32_t index, const PercaleJsonReader *reader,
                                const PercaleJsonMember *member, PercaleSceneError *problem, bool *assigned)
{
    const PercaleSetting *setting = &settings->items[index];
    double value[3] = {0.0, 0.0, 0.0};
    const bool read =
        setting->kind == PERCALE_SETTING_VECTOR
            ? percale_json_vector(reader, member, setting->name, setting->maximum, value)
            : percale_json_number(reader, member, setting->name, setting->minimum, setting->maximum, value);
    *assigned = read && percale_settings_assign(settings, index, value, problem);
    return read;
}

static bool read_setting(PercaleSettings *settings, const PercaleJsonReader *reader,
                         const PercaleJsonMember *member, const char *key)
{
    PercaleSceneError problem;
    const uint32_t index = percale_settings_find(settings, key, &problem);
    if (index == settings->count) {
        return percale_json_fail(reader, &member->place, true, "%s", problem.text);
    }
    const PercaleSetting *setting = &settings->items[index];
    const bool is_switch = setting->kind == PERCALE_SETTING_SWITCH;
    bool assigned = false;
    if (!is_switch && setting->kind != PERCALE_SETTING_CHOICE) {
        if (!read_number_setting(settings, index, reader, member, &problem, &assigned)) {
            return false;
        }
    } else if (json_is_string(member->value)) {
        assigned = percale_settings_assign_text(settings, index, json_string_value(member->value), &problem);
    } else if (is_switch && json_is_boolean(member->value)) {
        const double value[3] = {json_is_true(member->value) ? 1.0 : 0.0};
        assigned = percale_settings_assign(settings, index, value, &problem);
    } else {
        return percale_json_fail(reader, &member->place, false, "%s must be one of %s, in quotes", key,
                                 is_switch ? "on|off" : setting->choices);
    }
    return assigned || percale_json_fail(reader, &member->place, false, "%s", problem.text);
}

static bool read_settings(PercaleScene *scene, const PercaleJsonReader *reader, const PercaleJsonMember *root)
{
    const PercaleJsonMember rate = percale_json_member(root, "frame_rate");
    if (rate.value != NULL && !read_setting(&scene->settings, reader, &rate, "frame_rate")) {
        return false;
    }
    const PercaleJsonMember object = percale_json_member(root, "settings");
    if (object.value == NULL) {
        return true;
    }
    if (!percale_json_object(reader, &object, "settings")) {
        return false;
    }
    PercaleJsonMember member = {NULL, {&object.place, 0}};
    for (void *at = json_object_iter(object.value); at != NULL;
         at = json_object_iter_next(object.value, at)) {
        member.value = json_object_iter_value(at);
        if (!read_setting(&scene->settings, reader, &member, json_object_iter_key(at))) {
            return false;
        }
        ++member.place.ordinal;
    }
    return true;
}

static uint32_t longer(uint32_t samples, const PercaleMotion *motion)
{
    return motion->sample_count > samples ? motion->sample_count : samples;
}

// Without a count of its own a scene lasts as long as its longest animation.
static bool read_frames(PercaleScene *scene, const PercaleJsonReader *reader, const PercaleJsonMember *root)
{
    const PercaleJsonMember member = percale_json_member(root, "frames");
    uint32_t longest = 0;
    for (uint32_t index = 0; index < scene->obstacle_count; ++index) {
        longest = longer(longest, &scene->obstacles[index].motion);
    }
    for (uint32_t index = 0; index < scene->cloth_count; ++index) {
        for (uint32_t group = 0; group < scene->cloths[index].pin_count; ++group) {
            longest = longer(longest, &scene->cloths[index].pins[group].motion);
        }
    }
    int64_t frames = longest > 1 ? (int64_t)longest - 1 : (int64_t)scene->default_frames;
    if (member.value != NULL && !percale_json_whole(reader, &member, "frames", 1, FRAME_LIMIT, &frames)) {
        return false;
    }
    scene->default_frames = (uint32_t)frames;
    return true;
}

static bool read_scene(PercaleScene *scene, const PercaleJsonReader *reader)
{
    const PercaleJsonMember root = {reader->root, {NULL, 0}};
    if (!percale_json_check_keys(reader, &root, scene_keys, "a scene") ||
        !read_settings(scene, reader, &root) || !read_list(scene, reader, &root, "cloths", read_cloth) ||
        !read_list(scene, reader, &root, "obstacles", read_obstacle) || !read_frames(scene, reader, &root)) {
        return false;
    }
    return scene->cloth_count > 0 || percale_json_fail(reader, &root.place, false, "the scene has no cloths");
}

bool percale_scene_read_json(PercaleScene *scene, const char *path, PercaleSceneError *error)
{
    PercaleJsonReader reader;
    if (!percale_json_open(&reader, path, error)) {
        return false;
    }
    const bool done = read_scene(scene, &reader);
    percale_json_close(&reader);
    return done;
}
