#include "render/ray_scene.h"

#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>

// m; a vertex farther away counts as not drawable: Embree's triangle test multiplies four lengths in float.
static const float FARTHEST = 1e6f;

/// One mesh, ready for rays.
typedef struct DrawnMesh {
    const PercalePictureMesh *mesh;
    uint32_t *triangles; // [3 * triangle_count], those that are drawn
    uint32_t triangle_count;
    PercaleVec3 *normals; // [vertex_count]
} DrawnMesh;

struct PercaleRayScene {
    RTCDevice device;
    RTCScene scene;
    DrawnMesh *drawn; // [mesh_count]; Embree's geomID is the index
    uint32_t mesh_count;
    PercaleRayBounds bounds;
};

static PercaleVec3 vertex_of(const PercalePictureMesh *mesh, uint32_t vertex)
{
    const float *position = mesh->positions + 3 * (size_t)vertex;
    return vec3(position[0], position[1], position[2]);
}

static bool is_drawable(PercaleVec3 point)
{
    return fabsf(point.x) <= FARTHEST && fabsf(point.y) <= FARTHEST && fabsf(point.z) <= FARTHEST;
}

static void collect_triangles(DrawnMesh *drawn)
{
    const PercalePictureMesh *mesh = drawn->mesh;
    for (uint32_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        const uint32_t *corner = mesh->triangles + 3 * (size_t)triangle;
        bool drawable = true;
        for (int k = 0; k < 3; ++k)
            drawable = drawable && corner[k] < mesh->vertex_count && is_drawable(vertex_of(mesh, corner[k]));
        if (!drawable)
            continue;
        for (size_t k = 0; k < 3; ++k)
            drawn->triangles[3 * (size_t)drawn->triangle_count + k] = corner[k];
        ++drawn->triangle_count;
    }
}

/// Sums of the facets' normals, weighted by their areas; made unit where a ray asks.
static void sum_normals(DrawnMesh *drawn)
{
    for (uint32_t triangle = 0; triangle < drawn->triangle_count; ++triangle) {
        const uint32_t *corner = drawn->triangles + 3 * (size_t)triangle;
        PercaleVec3 x0 = vertex_of(drawn->mesh, corner[0]);
        PercaleVec3 edge1 = vec3_subtract(vertex_of(drawn->mesh, corner[1]), x0);
        PercaleVec3 edge2 = vec3_subtract(vertex_of(drawn->mesh, corner[2]), x0);
        PercaleVec3 normal = vec3_cross(edge1, edge2);
        for (int k = 0; k < 3; ++k)
            drawn->normals[corner[k]] = vec3_add(drawn->normals[corner[k]], normal);
    }
    for (uint32_t vertex = 0; vertex < drawn->mesh->vertex_count; ++vertex)
        drawn->normals[vertex] = vec3_normalize(drawn->normals[vertex], vec3(0.0f, 0.0f, 0.0f));
}

static bool prepare_mesh(DrawnMesh *drawn, const PercalePictureMesh *mesh)
{
    drawn->mesh = mesh;
    drawn->triangles = malloc((3 * (size_t)mesh->triangle_count + 1) * sizeof *drawn->triangles);
    drawn->normals = calloc((size_t)mesh->vertex_count + 1, sizeof *drawn->normals);
    if (!drawn->triangles || !drawn->normals)
        return false;
    collect_triangles(drawn);
    sum_normals(drawn);
    return true;
}

static bool attach_mesh(const PercaleRayScene *scene, uint32_t index)
{
    const DrawnMesh *drawn = &scene->drawn[index];
    size_t vertex_count = drawn->mesh->vertex_count;
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                               3 * sizeof(float), vertex_count);
    uint32_t *triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                  3 * sizeof(uint32_t), drawn->triangle_count);
    if (!positions || !triangles) {
        rtcReleaseGeometry(geometry);
        return false;
    }
    for (size_t vertex = 0; vertex < vertex_count; ++vertex) {
        PercaleVec3 x = vertex_of(drawn->mesh, (uint32_t)vertex);
        if (!is_drawable(x))
            x = vec3(0.0f, 0.0f, 0.0f); // no triangle uses it
        positions[3 * vertex] = x.x;
        positions[3 * vertex + 1] = x.y;
        positions[3 * vertex + 2] = x.z;
    }
    for (size_t k = 0; k < 3 * (size_t)drawn->triangle_count; ++k)
        triangles[k] = drawn->triangles[k];
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene->scene, geometry, index);
    rtcReleaseGeometry(geometry); // the scene holds it
    return true;
}

static void widen_bounds(void *user, PercaleVec3 point)
{
    PercaleRayBounds *bounds = user;
    bounds->low =
        vec3(fminf(bounds->low.x, point.x), fminf(bounds->low.y, point.y), fminf(bounds->low.z, point.z));
    bounds->high =
        vec3(fmaxf(bounds->high.x, point.x), fmaxf(bounds->high.y, point.y), fmaxf(bounds->high.z, point.z));
}

void percale_ray_scene_visit(const PercaleRayScene *scene, void (*visit)(void *user, PercaleVec3 point),
                             void *user)
{
    for (uint32_t index = 0; index < scene->mesh_count; ++index) {
        const DrawnMesh *drawn = &scene->drawn[index];
        for (size_t k = 0; k < 3 * (size_t)drawn->triangle_count; ++k)
            visit(user, vertex_of(drawn->mesh, drawn->triangles[k]));
    }
}

/// Fills an empty scene; false with a text when something fails.
static bool fill_scene(PercaleRayScene *scene, const PercalePictureMesh *meshes, const char **reason)
{
    *reason = "out of memory";
    size_t drawn_count = 0;
    for (uint32_t index = 0; index < scene->mesh_count; ++index) {
        if (!prepare_mesh(&scene->drawn[index], &meshes[index]))
            return false;
        drawn_count += scene->drawn[index].triangle_count;
        if (scene->drawn[index].triangle_count > 0 && !attach_mesh(scene, index))
            return false;
    }
    *reason = "nothing to draw: no triangle is finite";
    if (drawn_count == 0)
        return false;
    rtcCommitScene(scene->scene);
    *reason = "Embree could not build its tree";
    if (rtcGetDeviceError(scene->device) != RTC_ERROR_NONE)
        return false;
    scene->bounds.low = vec3(INFINITY, INFINITY, INFINITY);
    scene->bounds.high = vec3(-INFINITY, -INFINITY, -INFINITY);
    percale_ray_scene_visit(scene, widen_bounds, &scene->bounds);
    return true;
}

PercaleRayScene *percale_ray_scene_create(const PercalePictureMesh *meshes, uint32_t mesh_count,
                                          PercaleSceneError *error)
{
    const char *reason = "out of memory";
    PercaleRayScene *scene = calloc(1, sizeof *scene);
    if (!scene)
        goto failed;
    scene->mesh_count = mesh_count;
    scene->drawn = calloc((size_t)mesh_count + 1, sizeof *scene->drawn);
    scene->device = rtcNewDevice("threads=1");
    if (!scene->drawn || !scene->device)
        goto failed;
    scene->scene = rtcNewScene(scene->device);
    rtcSetSceneFlags(scene->scene, RTC_SCENE_FLAG_ROBUST);
    if (fill_scene(scene, meshes, &reason))
        return scene;
failed:
    (void)snprintf(error->text, sizeof error->text, "picture: %s", reason);
    percale_ray_scene_free(scene);
    return NULL;
}

void percale_ray_scene_free(PercaleRayScene *scene)
{
    if (!scene)
        return;
    for (uint32_t index = 0; scene->drawn && index < scene->mesh_count; ++index) {
        free(scene->drawn[index].triangles);
        free(scene->drawn[index].normals);
    }
    if (scene->scene)
        rtcReleaseScene(scene->scene);
    if (scene->device)
        rtcReleaseDevice(scene->device);
    free(scene->drawn);
    free(scene);
}

PercaleRayBounds percale_ray_scene_bounds(const PercaleRayScene *scene)
{
    return scene->bounds;
}

static struct RTCRay ray_from(PercaleVec3 start, PercaleVec3 direction)
{
    struct RTCRay ray = {0};
    ray.org_x = start.x;
    ray.org_y = start.y;
    ray.org_z = start.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = INFINITY;
    ray.mask = 0xffffffffu;
    return ray;
}

/// Weighted mean of three corner vectors.
static PercaleVec3 interpolate(const PercaleVec3 *values, const uint32_t *corner, const float weight[3])
{
    PercaleVec3 sum = vec3_scale(values[corner[0]], weight[0]);
    sum = vec3_add(sum, vec3_scale(values[corner[1]], weight[1]));
    return vec3_add(sum, vec3_scale(values[corner[2]], weight[2]));
}

bool percale_ray_scene_hit(const PercaleRayScene *scene, PercaleVec3 start, PercaleVec3 direction,
                           PercaleRayHit *hit)
{
    struct RTCRayHit query = {.ray = ray_from(start, direction), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;

    const DrawnMesh *drawn = &scene->drawn[query.hit.geomID];
    const uint32_t *corner = drawn->triangles + 3 * (size_t)query.hit.primID;
    const float weight[3] = {1.0f - query.hit.u - query.hit.v, query.hit.u, query.hit.v};
    PercaleVec3 against = vec3_scale(direction, -1.0f);
    PercaleVec3 facet = vec3_normalize(vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z), against);
    PercaleVec3 normal = vec3_normalize(interpolate(drawn->normals, corner, weight), facet);
    hit->from_behind = vec3_dot(facet, against) < 0.0f;
    hit->facet = hit->from_behind ? vec3_scale(facet, -1.0f) : facet;
    hit->normal = vec3_dot(normal, hit->facet) < 0.0f ? vec3_scale(normal, -1.0f) : normal;
    hit->point = vec3_add(start, vec3_scale(direction, query.ray.tfar));
    hit->mesh = drawn->mesh;
    hit->heat = 0.0f;
    for (int k = 0; drawn->mesh->heat && k < 3; ++k)
        hit->heat += weight[k] * drawn->mesh->heat[corner[k]];
    return true;
}

bool percale_ray_scene_occluded(const PercaleRayScene *scene, PercaleVec3 start, PercaleVec3 direction)
{
    struct RTCRay ray = ray_from(start, direction);
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene->scene, &context, &ray);
    return ray.tfar < 0.0f;
}
