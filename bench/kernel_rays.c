// kernel_rays.c: short paths beside a sphere of 20,480 triangles, as vertices in motion near a body make
// them, in the order in which the solver's points stand.

#include "base/hash.h"
#include "bench_kernel.h"
#include "bench_random.h"
#include "detect/rays.h"
#include "model/order.h"
#include "scene/scene_error.h"
#include "scene/shapes.h"

#include <stdlib.h>

enum { SUBDIVISIONS = 5 };         // 20480 triangles
static const double RADIUS = 0.5;  // m
static const double LENGTH = 0.01; // m of a path: 1 % of the sphere's diameter

// A path of length L and any direction that starts h above a plane crosses it with the probability (1 - h /
// L) / 2; with h anywhere below H > L that makes L / (4 H) on average: 3 % here.
static const double HEIGHT = 0.01 / (4 * 0.03); // m

typedef struct RayRun {
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleMesh sphere;
    PercaleObstacleObject obstacle;
    PercaleRays *rays;
    f32x4 *from, *to; // [count]
    uint8_t *flags;   // [count]
    uint32_t count;
    int thread_count;
    uint64_t iterations; // asked for
    BenchTime time;      // they took
} RayRun;

static Vec3 random_direction(uint64_t *seed)
{
    for (;;) {
        double x = bench_random_signed(seed); // one after the other: arguments have no order
        double y = bench_random_signed(seed);
        double z = bench_random_signed(seed);
        Vec3 point = vec3(x, y, z);
        double length = vlength(point);
        if (length > 0.01 && length <= 1.0) { // inside the ball every direction is as likely
            return vscale(1.0 / length, point);
        }
    }
}

static void make_paths(RayRun *run, float *starts)
{
    uint64_t seed = 1;
    for (uint32_t i = 0; i < run->count; ++i) {
        double height = HEIGHT * bench_random(&seed);
        Vec3 from = vscale(RADIUS + height, random_direction(&seed));
        run->to[i] = f32x4_of(vadd(from, vscale(LENGTH, random_direction(&seed))), 0.0f);
        run->from[i] = f32x4_of(from, 0.0f);
        for (size_t axis = 0; axis < 3; ++axis) {
            starts[3 * (size_t)i + axis] = run->from[i][axis];
        }
    }
}

static void reorder(f32x4 *paths, f32x4 *scratch, const uint32_t *curve, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        scratch[i] = paths[curve[i]];
    }
    for (uint32_t i = 0; i < count; ++i) {
        paths[i] = scratch[i];
    }
}

static bool prepare_paths(RayRun *run)
{
    PercaleMemory *memory = &run->memory;
    run->from = percale_memory_new(memory, run->count, sizeof *run->from);
    run->to = percale_memory_new(memory, run->count, sizeof *run->to);
    run->flags = percale_memory_new(memory, run->count, sizeof *run->flags);
    float *starts = percale_memory_new(memory, run->count, 3 * sizeof *starts);
    uint32_t *curve = percale_memory_new(memory, run->count, sizeof *curve);
    f32x4 *scratch = percale_memory_new(memory, run->count, sizeof *scratch);
    bool done = run->from != NULL && run->to != NULL && run->flags != NULL && starts != NULL &&
                curve != NULL && scratch != NULL;
    if (done) {
        make_paths(run, starts);
        done = percale_order_along_curve(starts, run->count, memory, curve);
    }
    if (done) {
        reorder(run->from, scratch, curve, run->count);
        reorder(run->to, scratch, curve, run->count);
    }
    percale_memory_free(memory, starts);
    percale_memory_free(memory, curve);
    percale_memory_free(memory, scratch);
    return done;
}

static bool prepare_sphere(RayRun *run, PercaleSceneError *error)
{
    const double centre[3] = {0.0, 0.0, 0.0};
    if (!percale_icosphere_make("sphere", SUBDIVISIONS, RADIUS, centre, &run->sphere, error)) {
        return false;
    }
    run->obstacle = (PercaleObstacleObject){.vertex_count = run->sphere.vertex_count,
                                            .triangle_count = run->sphere.triangle_count,
                                            .base = run->sphere.positions,
                                            .triangles = run->sphere.triangles,
                                            .motion = MOTION_STATIC};
    PercaleObjects objects = {.obstacles = &run->obstacle, .obstacle_count = 1};
    PercaleMessage message = {""};
    PercaleResult result = percale_rays_create(&run->rays, &objects, &run->memory, &message);
    return result == PERCALE_OK || percale_scene_fail(error, "%s", message.text);
}

static void close_run(void *state)
{
    RayRun *run = state;
    percale_rays_destroy(run->rays, &run->memory);
    percale_memory_free(&run->memory, run->from);
    percale_memory_free(&run->memory, run->to);
    percale_memory_free(&run->memory, run->flags);
    percale_mesh_free(&run->sphere);
    free(run);
}

static void *open_run(uint64_t count, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    (void)budget;
    percale_scene_out_of_memory(error); // unless another reason is found
    RayRun *run = calloc(1, sizeof *run);
    if (run == NULL) {
        return NULL;
    }
    run->allocator = percale_allocator_default();
    run->memory.allocator = &run->allocator;
    run->count = (uint32_t)count;
    run->thread_count = thread_count;
    if (!prepare_paths(run) || !prepare_sphere(run, error)) {
        close_run(run);
        return NULL;
    }
    return run;
}

static void lead(PercaleTeam *team, void *context)
{
    RayRun *run = context;
    BenchTime start = bench_now();
    for (uint64_t round = 0; round < run->iterations; ++round) {
        percale_rays_cast(run->rays, 0, run->from, run->to, run->count, run->flags, team);
    }
    run->time = bench_since(start);
}

static BenchTime cast(void *state, uint64_t iterations)
{
    RayRun *run = state;
    PercaleCrowding crowding = {0, 0};
    run->iterations = iterations;
    percale_team_open(run->thread_count, &crowding, lead, run);
    return run->time;
}

static void report(const void *state, BenchResult *result)
{
    const RayRun *run = state;
    uint64_t hash = hash_start();
    uint32_t hits = 0;
    for (uint32_t i = 0; i < run->count; ++i) {
        hash = hash_add(hash, run->flags[i]);
        hits += run->flags[i];
    }
    bench_result_label(result, hash);
    bench_result_add_rate(result, "items_per_second", (double)run->count);
    bench_result_add(result, "hit_fraction", (double)hits / (double)run->count);
}

const BenchKernel bench_kernel_rays = {.name = "rays",
                                       .sizes = bench_sheet_sizes,
                                       .open = open_run,
                                       .body = cast,
                                       .report = report,
                                       .close = close_run};
