#include "model/geodesic.h"

#include "model/mesh.h"

#include <math.h>

static const uint32_t NOT_QUEUED = UINT32_MAX;
static const uint32_t SETTLED = UINT32_MAX - 1;

// ---- heap: vertices by distance, the nearest first; ties by number, so that the order is always the same
// ----

static bool comes_before(const PercaleGeodesicFront *front, uint32_t a, uint32_t b)
{
    float da = front->distances[a];
    float db = front->distances[b];
    return da < db || (da <= db && a < b);
}

static void put(PercaleGeodesicFront *front, uint32_t place, uint32_t vertex)
{
    front->heap[place] = vertex;
    front->place[vertex] = place;
}

static void rise(PercaleGeodesicFront *front, uint32_t place)
{
    uint32_t vertex = front->heap[place];
    while (place > 0 && comes_before(front, vertex, front->heap[(place - 1) / 2])) {
        put(front, place, front->heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(front, place, vertex);
}

static uint32_t take_nearest(PercaleGeodesicFront *front)
{
    uint32_t first = front->heap[0];
    uint32_t vertex = front->heap[--front->count];
    front->place[first] = SETTLED;
    uint32_t place = 0;
    for (uint32_t child = 1; child < front->count; child = 2 * place + 1) {
        if (child + 1 < front->count && comes_before(front, front->heap[child + 1], front->heap[child])) {
            child++;
        }
        if (!comes_before(front, front->heap[child], vertex)) {
            break;
        }
        put(front, place, front->heap[child]);
        place = child;
    }
    if (front->count > 0) {
        put(front, place, vertex);
    }
    return first;
}

static void reach(PercaleGeodesicFront *front, uint32_t vertex, double distance, uint32_t nearest)
{
    bool is_new = front->place[vertex] == NOT_QUEUED;
    if (front->place[vertex] == SETTLED || !((float)distance <= front->radius) ||
        !(is_new || (float)distance < front->distances[vertex])) {
        return;
    }
    front->distances[vertex] = (float)distance;
    front->nearest[vertex] = nearest;
    if (is_new) {
        put(front, front->count, vertex);
        front->count++;
    }
    rise(front, front->place[vertex]);
}

// ---- triangles ----

/// Distance of corner c, when the straight line from the source to it passes between a and b; else INFINITY.
/// `ab`, `bc`, `ca` are lengths of sides, da and db distances of corners.
static double through_side(double ab, double bc, double ca, double da, double db)
{
    double source_x =
        (ab * ab + da * da - db * db) / (2.0 * ab); // a at the origin, b on the x axis, c above it
    double source_y2 = da * da - source_x * source_x;
    double c_x = (ab * ab + ca * ca - bc * bc) / (2.0 * ab);
    double c_y2 = ca * ca - c_x * c_x;
    double source_y = sqrt(source_y2 > 0.0 ? source_y2 : 0.0); // below it
    double c_y = sqrt(c_y2 > 0.0 ? c_y2 : 0.0);
    double height = source_y + c_y;
    double crossing = height > 0.0 ? source_x + (c_x - source_x) * source_y / height : source_x;
    double slack = 1e-6 * ab; // a line along a side may pass it on either hand
    if (!(crossing >= -slack && crossing <= ab + slack)) {
        return (double)INFINITY;
    }
    return sqrt((c_x - source_x) * (c_x - source_x) + height * height);
}

/// What a settled vertex tells the two others of a triangle.
static void spread(PercaleGeodesicFront *front, uint32_t triangle, uint32_t corner)
{
    const uint32_t *corners = front->mesh->triangles + 3 * (size_t)triangle;
    const float *lengths = front->mesh->lengths[triangle];
    uint32_t second = next_corner(corner);
    uint32_t third = next_corner(second);
    uint32_t a = corners[corner];
    double da = (double)front->distances[a];
    double ab = (double)lengths[corner];
    double bc = (double)lengths[second];
    double ca = (double)lengths[third];
    uint32_t b = corners[second];
    uint32_t c = corners[third];
    reach(front, b, da + ab, front->nearest[a]);
    reach(front, c, da + ca, front->nearest[a]);
    if (front->place[b] == SETTLED && front->nearest[b] == front->nearest[a]) {
        reach(front, c, through_side(ab, bc, ca, da, (double)front->distances[b]), front->nearest[a]);
    }
    if (front->place[c] == SETTLED && front->nearest[c] == front->nearest[a]) {
        reach(front, b, through_side(ca, bc, ab, da, (double)front->distances[c]), front->nearest[a]);
    }
}

static void spread_from(PercaleGeodesicFront *front, uint32_t vertex)
{
    const PercaleGeodesicMesh *mesh = front->mesh;
    for (uint32_t i = mesh->vertex_first_triangle[vertex]; i < mesh->vertex_first_triangle[vertex + 1]; i++) {
        uint32_t triangle = mesh->vertex_triangles[i];
        for (uint32_t corner = 0; corner < 3; corner++) {
            if (mesh->triangles[3 * (size_t)triangle + corner] == vertex) {
                spread(front, triangle, corner);
            }
        }
    }
}

/// Until nothing is left to reach.
static void settle_all(PercaleGeodesicFront *front)
{
    while (front->count > 0) {
        uint32_t vertex = take_nearest(front);
        if (front->reached != NULL) {
            front->reached[front->reached_count++] = vertex;
        }
        spread_from(front, vertex);
    }
}

bool percale_geodesic_run(const PercaleGeodesicMesh *mesh, const uint32_t *sources, uint32_t source_count,
                          PercaleMemory *memory, float *distances, uint32_t *nearest)
{
    PercaleGeodesicFront front = {
        .mesh = mesh, .radius = INFINITY, .distances = distances, .nearest = nearest};
    front.heap = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    front.place = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    bool complete = front.heap != NULL && front.place != NULL;
    for (uint32_t v = 0; complete && v < mesh->vertex_count; v++) {
        distances[v] = INFINITY;
        nearest[v] = UINT32_MAX;
        front.place[v] = NOT_QUEUED;
    }
    for (uint32_t s = 0; complete && s < source_count; s++) {
        reach(&front, sources[s], 0.0, s);
    }
    if (complete) {
        settle_all(&front);
    }
    percale_memory_free(memory, front.heap);
    percale_memory_free(memory, front.place);
    return complete;
}

bool percale_geodesic_open(PercaleGeodesicFront *front, const PercaleGeodesicMesh *mesh,
                           PercaleMemory *memory)
{
    *front = (PercaleGeodesicFront){.mesh = mesh};
    front->distances = percale_memory_new(memory, mesh->vertex_count, sizeof(float));
    front->nearest = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    front->heap = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    front->place = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    front->reached = percale_memory_new(memory, mesh->vertex_count, sizeof(uint32_t));
    if (front->distances == NULL || front->nearest == NULL || front->heap == NULL || front->place == NULL ||
        front->reached == NULL) {
        percale_geodesic_close(front, memory);
        return false;
    }
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        front->place[v] = NOT_QUEUED;
    }
    return true;
}

void percale_geodesic_close(PercaleGeodesicFront *front, PercaleMemory *memory)
{
    percale_memory_free(memory, front->distances);
    percale_memory_free(memory, front->nearest);
    percale_memory_free(memory, front->heap);
    percale_memory_free(memory, front->place);
    percale_memory_free(memory, front->reached);
    *front = (PercaleGeodesicFront){0};
}

void percale_geodesic_near(PercaleGeodesicFront *front, uint32_t source, float radius)
{
    for (uint32_t i = 0; i < front->reached_count; i++) {
        front->place[front->reached[i]] = NOT_QUEUED;
    }
    front->reached_count = 0;
    front->radius = radius;
    reach(front, source, 0.0, source);
    settle_all(front);
}
