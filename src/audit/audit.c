// The audit from end to end: open the cloths, judge them alone, then against one obstacle after the other.

#include "audit/audit.h"

#include <fenv.h>
#include <math.h>

static const double MILLIMETRES = 1e3; // per metre

double percale_audit_percentile_99(double *values, size_t count)
{
    if (count == 0)
        return 0.0;
    // ceil(0.99 count) - 1 in whole numbers; by Hoare's selection, as the median cut of the tree.
    ptrdiff_t wanted = (ptrdiff_t)((99 * count + 99) / 100 - 1);
    ptrdiff_t first = 0;
    ptrdiff_t last = (ptrdiff_t)count - 1;
    while (first < last) {
        double pivot = values[wanted];
        ptrdiff_t i = first;
        ptrdiff_t j = last;
        while (i <= j) {
            while (values[i] < pivot)
                i++;
            while (values[j] > pivot)
                j--;
            if (i > j)
                break;
            double swapped = values[i];
            values[i++] = values[j];
            values[j--] = swapped;
        }
        if (j < wanted)
            first = i;
        if (i > wanted)
            last = j;
    }
    return values[wanted];
}

static bool open_trees(PercaleAuditScene *scene)
{
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        if (!percale_audit_tree_open(&scene->memory, &scene->cloths[cloth], &scene->trees[cloth]))
            return false;
    }
    return true;
}

// Vertices and sides of triangles are numbered with 32 bits.
static bool fits_numbers(const PercaleAuditMesh *meshes, uint32_t mesh_count)
{
    uint64_t vertex_count = 0;
    uint64_t side_count = 0;
    for (uint32_t mesh = 0; mesh < mesh_count; mesh++) {
        vertex_count += meshes[mesh].vertex_count;
        side_count += 3 * (uint64_t)meshes[mesh].triangle_count;
    }
    return vertex_count < UINT32_MAX && side_count < UINT32_MAX;
}

static bool scene_open(PercaleAuditScene *scene)
{
    const PercaleAuditMemory *memory = &scene->memory;
    if (!fits_numbers(scene->cloths, scene->cloth_count))
        return false;
    size_t cloth_count = scene->cloth_count;
    scene->first_vertex = percale_audit_allocate(memory, cloth_count + 1, sizeof *scene->first_vertex);
    scene->trees = percale_audit_allocate(memory, cloth_count, sizeof *scene->trees);
    if (!scene->first_vertex || !scene->trees)
        return false;
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++)
        scene->first_vertex[cloth + 1] = scene->first_vertex[cloth] + scene->cloths[cloth].vertex_count;
    size_t vertex_count = scene->first_vertex[cloth_count];
    scene->depths = percale_audit_allocate(memory, vertex_count, sizeof *scene->depths);
    scene->in_contact = percale_audit_allocate(memory, vertex_count, sizeof *scene->in_contact);
    return scene->depths && scene->in_contact;
}

static void scene_close(PercaleAuditScene *scene)
{
    const PercaleAuditMemory *memory = &scene->memory;
    for (uint32_t cloth = 0; scene->trees && cloth < scene->cloth_count; cloth++)
        percale_audit_tree_close(memory, &scene->trees[cloth]);
    percale_audit_release(memory, scene->trees);
    percale_audit_release(memory, scene->first_vertex);
    percale_audit_release(memory, scene->points);
    percale_audit_release(memory, scene->is_sewn);
    percale_audit_release(memory, scene->depths);
    percale_audit_release(memory, scene->in_contact);
}

static bool judge_cloths(PercaleAuditScene *scene, PercaleQuality *quality)
{
    if (!open_trees(scene) || !percale_audit_weld(scene) || !percale_audit_strain(scene, quality))
        return false;
    percale_audit_cross_cloths(scene, quality);
    return true;
}

static bool judge_obstacle(PercaleAuditScene *scene, const PercaleAuditMesh *obstacle, uint32_t index,
                           PercaleQuality *quality)
{
    PercaleAuditSurface surface = {.mesh = NULL};
    bool has_memory =
        fits_numbers(obstacle, 1) && percale_audit_surface_open(&scene->memory, obstacle, &surface);
    if (has_memory) {
        percale_audit_penetrate(scene, &surface);
        percale_audit_cross_obstacle(scene, &surface, index, quality);
        double stands_out = MILLIMETRES * percale_audit_stand_out(scene, &surface);
        quality->penetration_obstacle_mm = fmax(quality->penetration_obstacle_mm, stands_out);
    }
    percale_audit_surface_close(&scene->memory, &surface);
    return has_memory;
}

// Sums up the vertices; packs the depths of the finite ones to the front.
static void judge_vertices(PercaleAuditScene *scene, PercaleQuality *quality)
{
    size_t finite_count = 0;
    size_t contact_count = 0;
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        for (uint32_t vertex = 0; vertex < scene->cloths[cloth].vertex_count; vertex++) {
            size_t i = scene->first_vertex[cloth] + vertex;
            if (!percale_audit_is_finite(&scene->cloths[cloth], vertex)) {
                quality->nonfinite += 1.0;
                continue;
            }
            double depth = scene->depths[i];
            quality->penetration_max_mm = fmax(quality->penetration_max_mm, MILLIMETRES * depth);
            quality->vertices_inside += depth > 0.0 ? 1.0 : 0.0;
            contact_count += scene->in_contact[i];
            scene->depths[finite_count++] = depth;
        }
    }
    quality->penetration_p99_mm = MILLIMETRES * percale_audit_percentile_99(scene->depths, finite_count);
    if (finite_count > 0)
        quality->contact_fraction = (double)contact_count / (double)finite_count;
}

PercaleResult percale_audit_with(PercaleAuditMemory memory, const PercaleAuditMesh *cloths,
                                 uint32_t cloth_count, const PercaleAuditMesh *obstacles,
                                 uint32_t obstacle_count, PercaleQuality *quality,
                                 PercaleAuditCrossing *deepest)
{
    PercaleAuditScene scene = {.memory = memory, .cloths = cloths, .cloth_count = cloth_count};
    PercaleQuality judged = {.nonfinite = 0.0};
    fenv_t host; // the exact signs need round-to-nearest and denormals, whatever the host has set
    fegetenv(&host);
    fesetenv(FE_DFL_ENV);
    bool has_memory = scene_open(&scene) && judge_cloths(&scene, &judged);
    for (uint32_t obstacle = 0; has_memory && obstacle < obstacle_count; obstacle++)
        has_memory = judge_obstacle(&scene, &obstacles[obstacle], obstacle, &judged);
    if (has_memory) {
        judge_vertices(&scene, &judged);
        *quality = judged;
        if (deepest)
            *deepest = scene.deepest;
    }
    scene_close(&scene);
    fesetenv(&host);
    return has_memory ? PERCALE_OK : PERCALE_OUT_OF_MEMORY;
}

PercaleResult percale_audit(const PercaleAuditMesh *cloths, uint32_t cloth_count,
                            const PercaleAuditMesh *obstacles, uint32_t obstacle_count,
                            PercaleQuality *quality)
{
    PercaleAuditMemory memory = {NULL, NULL, NULL};
    return percale_audit_with(memory, cloths, cloth_count, obstacles, obstacle_count, quality, NULL);
}

PercaleResult percale_audit_penetration_with(PercaleAuditMemory memory, const PercaleAuditMesh *cloth,
                                             const PercaleAuditMesh *obstacles, uint32_t obstacle_count,
                                             float *depths)
{
    PercaleAuditScene scene = {.memory = memory, .cloths = cloth, .cloth_count = 1};
    fenv_t host;
    fegetenv(&host);
    fesetenv(FE_DFL_ENV);
    bool has_memory = scene_open(&scene);
    for (uint32_t obstacle = 0; has_memory && obstacle < obstacle_count; obstacle++) {
        PercaleAuditSurface surface = {.mesh = NULL};
        has_memory = fits_numbers(&obstacles[obstacle], 1) &&
                     percale_audit_surface_open(&memory, &obstacles[obstacle], &surface);
        if (has_memory)
            percale_audit_penetrate(&scene, &surface);
        percale_audit_surface_close(&memory, &surface);
    }
    for (uint32_t vertex = 0; has_memory && vertex < cloth->vertex_count; vertex++)
        depths[vertex] = (float)scene.depths[vertex];
    scene_close(&scene);
    fesetenv(&host);
    return has_memory ? PERCALE_OK : PERCALE_OUT_OF_MEMORY;
}

PercaleResult percale_audit_penetration(const PercaleAuditMesh *cloth, const PercaleAuditMesh *obstacles,
                                        uint32_t obstacle_count, float *depths)
{
    PercaleAuditMemory memory = {NULL, NULL, NULL};
    return percale_audit_penetration_with(memory, cloth, obstacles, obstacle_count, depths);
}
