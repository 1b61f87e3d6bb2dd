#include "detect/rays.h"

#include <string.h>

#include <embree3/rtcore.h>

enum { PACKET = 16 }; // paths per Embree call: the fastest width measured for short, incoherent paths

typedef struct RayScene {
    RTCScene scene;
    RTCGeometry geometry;
    float *vertices; // [3 * vertex_count] Embree's
    uint32_t vertex_count;
} RayScene;

struct PercaleRays {
    RTCDevice device;
    uint32_t scene_count;
    RayScene *scenes;
};

/// A fixed instruction set: Embree's hit flag at edges can differ between two of them. No threads of its own.
static const char *device_config(void)
{
    return __builtin_cpu_supports("avx2") ? "threads=1,isa=avx2" : "threads=1,isa=sse2";
}

/// Deforming obstacles are refit; REFIT needs all three settings at once, else Embree silently rebuilds.
static void add_deforming(RayScene *target)
{
    rtcSetSceneFlags(target->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(target->scene, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryBuildQuality(target->geometry, RTC_BUILD_QUALITY_REFIT);
}

static void add_in_own_space(RayScene *target)
{
    rtcSetSceneFlags(target->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(target->scene, RTC_BUILD_QUALITY_MEDIUM);
}

static void build_scene(RTCDevice device, RayScene *target, const PercaleObstacleObject *object)
{
    target->scene = rtcNewScene(device);
    target->geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    target->vertex_count = object->vertex_count;
    target->vertices = rtcSetNewGeometryBuffer(target->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                               3 * sizeof(float), object->vertex_count);
    const float *start = object->motion == MOTION_DEFORMING ? object->from : object->base;
    if (target->vertices != NULL) {
        memcpy(target->vertices, start, 3 * sizeof(float) * object->vertex_count);
    }
    if (object->motion == MOTION_DEFORMING) {
        add_deforming(target);
    } else {
        add_in_own_space(target);
    }
    rtcSetSharedGeometryBuffer(target->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               object->triangles, 0, 3 * sizeof(uint32_t), object->triangle_count);
    rtcCommitGeometry(target->geometry);
    rtcAttachGeometry(target->scene, target->geometry);
    rtcCommitScene(target->scene);
}

PercaleResult percale_rays_create(PercaleRays **rays, const PercaleObjects *objects, PercaleMemory *memory,
                                  PercaleMessage *message)
{
    PercaleRays *created = percale_memory_new(memory, 1, sizeof(*created));
    RayScene *scenes = percale_memory_new(memory, objects->obstacle_count, sizeof(scenes[0]));
    if (created == NULL || scenes == NULL) {
        percale_memory_free(memory, created);
        percale_memory_free(memory, scenes);
        return percale_fail_memory(message);
    }
    created->scenes = scenes;
    created->device = rtcNewDevice(device_config());
    if (created->device == NULL) {
        percale_rays_destroy(created, memory);
        return percale_fail(message, PERCALE_DEVICE_ERROR, "Embree gives no device (error %d)",
                            (int)rtcGetDeviceError(NULL));
    }
    created->scene_count = (uint32_t)objects->obstacle_count;
    for (uint32_t o = 0; o < created->scene_count; o++) {
        build_scene(created->device, &scenes[o], &objects->obstacles[o]);
    }
    enum RTCError error = rtcGetDeviceError(created->device);
    if (error != RTC_ERROR_NONE) {
        percale_rays_destroy(created, memory);
        return percale_fail(message, PERCALE_DEVICE_ERROR, "Embree can't build the obstacles (error %d)",
                            (int)error);
    }
    *rays = created;
    return PERCALE_OK;
}

void percale_rays_destroy(PercaleRays *rays, PercaleMemory *memory)
{
    if (rays == NULL) {
        return;
    }
    for (uint32_t o = 0; o < rays->scene_count; o++) {
        rtcReleaseGeometry(rays->scenes[o].geometry);
        rtcReleaseScene(rays->scenes[o].scene);
    }
    if (rays->device != NULL) {
        rtcReleaseDevice(rays->device);
    }
    percale_memory_free(memory, rays->scenes);
    percale_memory_free(memory, rays);
}

bool percale_rays_refit(PercaleRays *rays, uint32_t obstacle, const f32x4 *points)
{
    RayScene *target = &rays->scenes[obstacle];
    for (size_t i = 0; i < target->vertex_count; i++) {
        memcpy(target->vertices + 3 * i, &points[i], 3 * sizeof(float));
    }
    rtcUpdateGeometryBuffer(target->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(target->geometry);
    rtcCommitScene(target->scene);
    return rtcGetDeviceError(rays->device) == RTC_ERROR_NONE;
}

/// Debian's Embree aborts on components that are not finite or above 1.8e18.
static bool castable(f32x4 p)
{
    const float LIMIT = 1e18f;
    return fabsf(p[0]) < LIMIT && fabsf(p[1]) < LIMIT && fabsf(p[2]) < LIMIT;
}

static void cast_packet(RTCScene scene, const f32x4 *from, const f32x4 *to, uint32_t count, uint8_t *flags)
{
    struct RTCRay16 rays;
    _Alignas(64) int valid[PACKET];
    for (uint32_t i = 0; i < PACKET; i++) {
        bool cast = i < count && castable(from[i]) && castable(to[i]);
        f32x4 origin = cast ? from[i] : (f32x4){0};
        f32x4 path = cast ? to[i] - from[i] : (f32x4){0};
        valid[i] = cast ? -1 : 0;
        rays.org_x[i] = origin[0];
        rays.org_y[i] = origin[1];
        rays.org_z[i] = origin[2];
        rays.dir_x[i] = path[0];
        rays.dir_y[i] = path[1];
        rays.dir_z[i] = path[2];
        rays.tnear[i] = 0.0f;
        rays.tfar[i] = 1.0f;
        rays.time[i] = 0.0f;
        rays.mask[i] = UINT32_MAX;
        rays.id[i] = i;
        rays.flags[i] = 0;
    }
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded16(valid, scene, &context, &rays);
    for (uint32_t i = 0; i < count; i++) {
        flags[i] = valid[i] != 0 && rays.tfar[i] < 0.0f; // Embree sets tfar to -inf on any hit
    }
}

/// What the chunks of a cast share.
typedef struct Cast {
    RTCScene scene;
    const f32x4 *from, *to;
    uint8_t *flags;
} Cast;

static void cast_range(void *context, uint32_t begin, uint32_t end)
{
    const Cast *cast = context;
    for (uint32_t first = begin; first < end; first += PACKET) {
        uint32_t rest = end - first;
        cast_packet(cast->scene, cast->from + first, cast->to + first, rest < PACKET ? rest : PACKET,
                    cast->flags + first);
    }
}

void percale_rays_cast(const PercaleRays *rays, uint32_t obstacle, const f32x4 *from, const f32x4 *to,
                       uint32_t count, uint8_t *flags, PercaleTeam *team)
{
    enum { GRAIN_PATHS = 16 * PACKET };
    Cast cast = {rays->scenes[obstacle].scene, from, to, flags};
    percale_team_for(team, count, GRAIN_PATHS, cast_range, &cast);
}
