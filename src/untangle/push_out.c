#include "untangle/push.h"

#include "detect/surface.h"

#include <string.h>

// What is inside of a closed obstacle is found from the edges that go through its surface, and on from there
// along edges, as long as the nearest point of the surface says so.

/// First of an obstacle's triangles among all.
static uint32_t first_face_of(const PercaleTangleMesh *mesh, uint32_t object)
{
    uint32_t first = mesh->cloth_triangle_count;
    for (uint32_t o = mesh->model->cloth_count; o < object; o++) {
        first += mesh->model->obstacles[o - mesh->model->cloth_count].triangle_count;
    }
    return first;
}

/// Outward normal of the obstacle where a point is nearest.
static Vec3 outward_at(const PercaleTangleStage *stage, uint32_t object, const PercaleNearestFace *nearest)
{
    const PercaleModel *model = stage->mesh->model;
    PercaleSurface surface = {.mesh = &model->obstacles[object - model->cloth_count], .points = stage->x};
    return percale_surface_normal(&surface, nearest->face - first_face_of(stage->mesh, object),
                                  nearest->closest.region);
}

/// Asks one point of a cloth; true in *inside when it is to go on from there.
static bool ask_point(PercaleTangleStage *stage, uint32_t object, uint32_t point, float thickness,
                      bool *inside)
{
    PercaleFaceChoice choice = {NULL, 0, object};
    Vec3 place = vec3_of(stage->x[point]);
    PercaleNearestFace nearest = percale_nearest_face(stage->search, true, stage->x, place, &choice);
    Vec3 outward = outward_at(stage, object, &nearest);
    Vec3 offset = vsub(place, nearest.foot);
    double distance = 0.5 * ((double)thickness + (double)stage->mesh->objects[object].thickness);
    *inside = vdot(offset, outward) < 0.0;
    if (!*inside && vlength(offset) > distance) {
        return true;
    }
    Vec3 direction = turned_normal(stage->mesh, stage->x, nearest.face);
    if (nearest.closest.region != REGION_FACE) {
        bool has_own = vlength(offset) > 0.1 * distance;
        direction = has_own ? vscale(*inside ? -1.0 : 1.0, vunit(offset)) : outward;
    }
    return percale_add_tangle_stencil(stage, point, nearest.face, nearest.closest.weights, direction,
                                      distance);
}

/// A flood of the cloth that is inside one obstacle.
typedef struct Inside {
    PercaleTangleStage *stage;
    uint32_t object;
    uint32_t begin, end; // of the stage's queue
} Inside;

static void reach(Inside *inside, uint32_t point)
{
    PercaleTangleStage *stage = inside->stage;
    if (point < stage->mesh->model->slot_count && !stage->is_inside[point]) {
        stage->is_inside[point] = 1; // asked, at least
        stage->queue[inside->end++] = point;
    }
}

static bool flood_inside(Inside *inside)
{
    PercaleTangleStage *stage = inside->stage;
    const PercaleTangleMesh *mesh = stage->mesh;
    memset(stage->is_inside, 0, mesh->model->point_count);
    for (size_t i = 0; i < stage->crossings->count; i++) {
        const PercaleTangleCrossing *crossing = &stage->crossings->items[i];
        if (mesh->object_of[crossing->face] == inside->object) {
            reach(inside, mesh->edges.vertices[crossing->edge][0]);
            reach(inside, mesh->edges.vertices[crossing->edge][1]);
        }
    }
    bool complete = true;
    for (; complete && inside->begin < inside->end; inside->begin++) {
        uint32_t point = stage->queue[inside->begin];
        const PercaleModel *model = mesh->model;
        bool is_inside = false;
        complete = ask_point(stage, inside->object, point, model->cloths[model->cloth_of[point]].thickness,
                             &is_inside);
        for (uint32_t k = mesh->first_edge[point]; is_inside && k < mesh->first_edge[point + 1]; k++) {
            const uint32_t *ends = mesh->edges.vertices[mesh->point_edges[k]];
            reach(inside, ends[0] == point ? ends[1] : ends[0]);
        }
    }
    return complete;
}

/// An obstacle's edge goes through a face of the cloth: the end that stands out pushes the face on.
static bool push_face(PercaleTangleStage *stage, const PercaleTangleCrossing *crossing)
{
    const PercaleTangleMesh *mesh = stage->mesh;
    const uint32_t *ends = mesh->edges.vertices[crossing->edge];
    Vec3 outward = vec3(0.0, 0.0, 0.0);
    for (uint32_t k = 0; k < triangles_of_edge(mesh, crossing->edge); k++) {
        outward = vadd(outward, turned_normal(mesh, stage->x, triangle_of_edge(mesh, crossing->edge, k)));
    }
    outward = vunit(outward);
    Vec3 way = vsub(vec3_of(stage->x[ends[1]]), vec3_of(stage->x[ends[0]]));
    Vec3 normal = turned_normal(mesh, stage->x, crossing->face);
    bool faces_out = vdot(normal, outward) > 0.0;
    uint32_t out = (vdot(way, normal) > 0.0) == faces_out ? 1 : 0;
    const uint32_t *corners = corners_of_triangle(mesh, crossing->face);
    PercaleClosest closest =
        percale_closest_on_triangle(vec3_of(stage->x[ends[out]]), vec3_of(stage->x[corners[0]]),
                                    vec3_of(stage->x[corners[1]]), vec3_of(stage->x[corners[2]]));
    double distance = distance_between(mesh, triangle_of_edge(mesh, crossing->edge, 0), crossing->face);
    return percale_add_tangle_stencil(stage, ends[out], crossing->face, closest.weights,
                                      vscale(-1.0, outward), distance);
}

bool percale_push_out(PercaleTangleStage *stage)
{
    const PercaleTangleMesh *mesh = stage->mesh;
    if (mesh->triangle_count == mesh->cloth_triangle_count) {
        return true;
    }
    bool complete = true;
    uint32_t object_count = mesh->model->cloth_count + mesh->model->obstacle_count;
    for (uint32_t object = mesh->model->cloth_count; complete && object < object_count; object++) {
        Inside inside = {stage, object, 0, 0};
        complete = !mesh->objects[object].is_closed || flood_inside(&inside);
    }
    for (size_t i = 0; complete && i < stage->crossings->count; i++) {
        const PercaleTangleCrossing *crossing = &stage->crossings->items[i];
        if (object_of_triangle(mesh, triangle_of_edge(mesh, crossing->edge, 0))->is_closed) {
            complete = push_face(stage, crossing);
        }
    }
    return complete;
}
