// Builds what stands around the triangles of an obstacle: normals, neighbours, rims.

#include "audit/audit_surface.h"

#include <math.h>

#include "audit/audit_pairs.h"
#include "audit/audit_vector.h"

static void add_corner_normals(PercaleAuditSurface *surface, uint32_t triangle)
{
    const uint32_t *corners = surface->mesh->triangles + 3 * (size_t)triangle;
    double x[3][3];
    for (size_t k = 0; k < 3; k++)
        load_point(surface->mesh->positions, corners[k], x[k]);
    for (size_t k = 0; k < 3; k++) {
        double next[3];
        double previous[3];
        double normal[3];
        subtract(x[(k + 1) % 3], x[k], next);
        subtract(x[(k + 2) % 3], x[k], previous);
        cross(next, previous, normal);
        double area = sqrt(dot(normal, normal));
        if (!(area > 0.0))
            continue;
        double angle = atan2(area, dot(next, previous));
        for (size_t axis = 0; axis < 3; axis++) {
            surface->face_normals[3 * (size_t)triangle + axis] = normal[axis] / area;
            surface->vertex_normals[3 * (size_t)corners[k] + axis] += angle * normal[axis] / area;
        }
    }
}

static void set_normals(PercaleAuditSurface *surface)
{
    for (uint32_t i = 0; i < surface->tree.triangle_count; i++)
        add_corner_normals(surface, surface->tree.triangles[i]);
}

// One pair (lower vertex, upper vertex) per side of a triangle; the item is 3 * triangle + corner.
static size_t list_sides(const PercaleAuditSurface *surface, PercaleAuditPair *sides)
{
    size_t count = 0;
    for (size_t i = 0; i < surface->tree.triangle_count; i++) {
        uint32_t triangle = surface->tree.triangles[i];
        const uint32_t *corners = surface->tree.corners + 3 * i;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = corners[k];
            uint32_t b = corners[(k + 1) % 3];
            sides[count].first = a < b ? a : b;
            sides[count].second = a < b ? b : a;
            sides[count++].item = 3 * triangle + k;
        }
    }
    return count;
}

static void join_sides(PercaleAuditSurface *surface, const PercaleAuditPair *sides, size_t count)
{
    const uint32_t *triangles = surface->mesh->triangles;
    surface->is_closed = true;
    size_t end = 0;
    for (size_t begin = 0; begin < count; begin = end) {
        end = percale_audit_run_end(sides, count, begin);
        uint32_t one = sides[begin].item;
        uint32_t other = sides[end - 1].item;
        // A side's corner is where it starts: two opposite sides start at different ends.
        if (end - begin == 2 && triangles[one] != triangles[other]) {
            surface->neighbours[one] = other / 3;
            surface->neighbours[other] = one / 3;
            continue;
        }
        surface->is_closed = false;
        surface->is_rim[sides[begin].first] = 1;
        surface->is_rim[sides[begin].second] = 1;
        for (size_t i = begin; i < end; i++)
            surface->neighbours[sides[i].item] = PERCALE_AUDIT_RIM;
    }
}

static bool set_neighbours(const PercaleAuditMemory *memory, PercaleAuditSurface *surface)
{
    size_t side_count = 3 * (size_t)surface->tree.triangle_count;
    PercaleAuditPair *sides = percale_audit_allocate(memory, side_count, sizeof *sides);
    if (!sides)
        return false;
    list_sides(surface, sides);
    bool has_memory = percale_audit_sort_pairs(memory, sides, side_count, surface->mesh->vertex_count);
    if (has_memory)
        join_sides(surface, sides, side_count);
    percale_audit_release(memory, sides);
    return has_memory;
}

bool percale_audit_surface_open(const PercaleAuditMemory *memory, const PercaleAuditMesh *mesh,
                                PercaleAuditSurface *surface)
{
    size_t corner_count = 3 * (size_t)mesh->triangle_count;
    *surface = (PercaleAuditSurface){.mesh = mesh};
    if (!percale_audit_tree_open(memory, mesh, &surface->tree))
        return false;
    surface->face_normals = percale_audit_allocate(memory, corner_count, sizeof(double));
    surface->vertex_normals = percale_audit_allocate(memory, 3 * (size_t)mesh->vertex_count, sizeof(double));
    surface->neighbours = percale_audit_allocate(memory, corner_count, sizeof *surface->neighbours);
    surface->is_rim = percale_audit_allocate(memory, mesh->vertex_count, sizeof *surface->is_rim);
    if (!surface->face_normals || !surface->vertex_normals || !surface->neighbours || !surface->is_rim)
        return false;
    set_normals(surface);
    return set_neighbours(memory, surface);
}

void percale_audit_surface_close(const PercaleAuditMemory *memory, PercaleAuditSurface *surface)
{
    percale_audit_tree_close(memory, &surface->tree);
    percale_audit_release(memory, surface->face_normals);
    percale_audit_release(memory, surface->vertex_normals);
    percale_audit_release(memory, surface->neighbours);
    percale_audit_release(memory, surface->is_rim);
    *surface = (PercaleAuditSurface){.mesh = NULL};
}
