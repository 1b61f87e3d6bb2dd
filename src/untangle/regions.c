#include "untangle/regions.h"

#include "base/radix_sort.h"

// A contour that ends inside goes on to a boundary where that is an edge away for each so many of its steps:
// it is the rim of one cloth that reaches a little beyond the rim of another.
enum { STEPS_PER_EDGE_OUT = 10, LONG_CONTOUR = 30 };

static void measure_areas(PercaleRegionFlood *flood, const f32x4 *x)
{
    const PercaleTangleMesh *mesh = flood->mesh;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *corners = corners_of_triangle(mesh, t);
        Vec3 a = vec3_of(x[corners[0]]);
        Vec3 normal = vcross(vsub(vec3_of(x[corners[1]]), a), vsub(vec3_of(x[corners[2]]), a));
        for (int k = 0; k < 3; k++) {
            flood->areas[corners[k]] += vlength(normal) / 6.0;
        }
    }
}

bool percale_region_flood_open(PercaleRegionFlood *flood, const PercaleTangleMesh *mesh, const f32x4 *x,
                               PercaleMemory *memory)
{
    uint32_t count = mesh->model->point_count;
    *flood = (PercaleRegionFlood){.mesh = mesh};
    flood->areas = percale_memory_new(memory, count, sizeof(double));
    flood->sides = percale_memory_new(memory, count, sizeof(uint32_t));
    flood->cut = percale_memory_new(memory, mesh->edges.edge_count, sizeof(uint32_t));
    flood->wall = percale_memory_new(memory, count, sizeof(uint32_t));
    flood->queue[0] = percale_memory_new(memory, count, sizeof(uint32_t));
    flood->queue[1] = percale_memory_new(memory, count, sizeof(uint32_t));
    bool complete = flood->areas != NULL && flood->sides != NULL && flood->cut != NULL &&
                    flood->wall != NULL && flood->queue[0] != NULL && flood->queue[1] != NULL;
    if (complete) {
        measure_areas(flood, x);
    } else {
        percale_region_flood_close(flood, memory);
    }
    return complete;
}

void percale_region_flood_close(PercaleRegionFlood *flood, PercaleMemory *memory)
{
    percale_memory_free(memory, flood->areas);
    percale_memory_free(memory, flood->sides);
    percale_memory_free(memory, flood->cut);
    percale_memory_free(memory, flood->wall);
    percale_memory_free(memory, flood->queue[0]);
    percale_memory_free(memory, flood->queue[1]);
    percale_memory_free(memory, flood->sorting);
    *flood = (PercaleRegionFlood){0};
}

/// One flood.
typedef struct Fill {
    PercaleRegionFlood *flood;
    uint32_t begin[2], end[2]; // of the queues
    double area[2];
    bool have_met; // the two sides are one
} Fill;

static void reach(Fill *fill, uint32_t point, uint32_t side)
{
    PercaleRegionFlood *flood = fill->flood;
    uint32_t label = 2 * flood->epoch + side;
    if (flood->sides[point] == label || flood->wall[point] == flood->wall_epoch) {
        return;
    }
    if (flood->sides[point] == (label ^ 1U)) {
        fill->have_met = true;
        return;
    }
    flood->sides[point] = label;
    flood->queue[side][fill->end[side]++] = point;
    fill->area[side] += flood->areas[point];
}

static void spread(Fill *fill, uint32_t side)
{
    const PercaleTangleMesh *mesh = fill->flood->mesh;
    uint32_t point = fill->flood->queue[side][fill->begin[side]++];
    for (uint32_t i = mesh->first_edge[point]; i < mesh->first_edge[point + 1]; i++) {
        uint32_t edge = mesh->point_edges[i];
        if (fill->flood->cut[edge] != fill->flood->epoch) {
            const uint32_t *ends = mesh->edges.vertices[edge];
            reach(fill, ends[0] == point ? ends[1] : ends[0], side);
        }
    }
}

/// The steps that cross an edge of the trace, sorted by edge and place on it; returns their number.
static size_t sort_steps(PercaleRegionFlood *flood, const PercaleContour *contour, uint32_t trace,
                         PercaleKeyed *steps)
{
    const double PLACES = 4294967295.0;
    size_t count = 0;
    for (uint32_t i = contour->first; i < contour->first + contour->count; i++) {
        const PercaleContourStep *step = &flood->contours->steps[i];
        if (step->trace == trace || contour->is_joined || is_folded(contour)) {
            const PercaleTangleCrossing *crossing = &flood->crossings->items[step->crossing];
            uint64_t place = (uint64_t)(crossing->along * PLACES);
            steps[count++] = (PercaleKeyed){(uint64_t)crossing->edge << 32 | place, i};
        }
    }
    percale_radix_sort(steps, steps + count, count);
    return count;
}

/// An edge's first point is on the side where its first crossing leaves it, its second where the last does.
static void begin_at_trace(Fill *fill, uint32_t trace, bool folded, const PercaleKeyed *steps, size_t count)
{
    PercaleRegionFlood *flood = fill->flood;
    for (size_t i = 0; i < count; i++) {
        uint32_t edge = (uint32_t)(steps[i].key >> 32);
        const PercaleContourStep *step = &flood->contours->steps[steps[i].value];
        bool is_back = folded && step->trace != trace; // behind the fold the curve runs the other way
        uint32_t left = is_back ? 1 - step->left : step->left;
        bool is_first = i == 0 || (uint32_t)(steps[i - 1].key >> 32) != edge;
        bool is_last = i + 1 == count || (uint32_t)(steps[i + 1].key >> 32) != edge;
        flood->cut[edge] = flood->epoch;
        if (is_first) {
            reach(fill, flood->mesh->edges.vertices[edge][0], left == 0 ? SIDE_LEFT : SIDE_RIGHT);
        }
        if (is_last) {
            reach(fill, flood->mesh->edges.vertices[edge][1], left == 1 ? SIDE_LEFT : SIDE_RIGHT);
        }
    }
}

// ---- walls ----

static bool is_boundary_point(const PercaleTangleMesh *mesh, uint32_t point)
{
    bool is_boundary = false;
    for (uint32_t i = mesh->first_edge[point]; i < mesh->first_edge[point + 1]; i++) {
        is_boundary = is_boundary || triangles_of_edge(mesh, mesh->point_edges[i]) != 2;
    }
    return is_boundary;
}

/// Lists the points of the shortest way, in edges, from a face to a boundary in queue[0]; returns their
/// number.
static uint32_t find_way_out(PercaleRegionFlood *flood, uint32_t face, uint32_t most)
{
    const PercaleTangleMesh *mesh = flood->mesh;
    uint32_t *points = flood->queue[0];
    uint32_t *from = flood->queue[1]; // places in the queue
    uint32_t end = 0;
    flood->epoch++;
    for (int k = 0; k < 3; k++) {
        from[end] = NO_INDEX;
        points[end++] = corners_of_triangle(mesh, face)[k];
        flood->sides[points[end - 1]] = 2 * flood->epoch;
    }
    uint32_t place = 0;
    uint32_t ring_end = end;
    uint32_t ring = 0;
    while (place < end && ring <= most && !is_boundary_point(mesh, points[place])) {
        uint32_t point = points[place];
        for (uint32_t i = mesh->first_edge[point]; i < mesh->first_edge[point + 1]; i++) {
            const uint32_t *ends = mesh->edges.vertices[mesh->point_edges[i]];
            uint32_t next = ends[0] == point ? ends[1] : ends[0];
            if (flood->sides[next] != 2 * flood->epoch) {
                flood->sides[next] = 2 * flood->epoch;
                from[end] = place;
                points[end++] = next;
            }
        }
        if (++place == ring_end) {
            ring_end = end;
            ring++;
        }
    }
    return place < end && ring <= most ? place : NO_INDEX;
}

/// Marks the way from a contour's end inside the surface to a boundary.
static void build_wall(PercaleRegionFlood *flood, const PercaleContour *contour, uint32_t end, uint32_t most)
{
    uint32_t step = end == 0 ? contour->first : contour->first + contour->count - 1;
    uint32_t face = flood->crossings->items[flood->contours->steps[step].crossing].face;
    uint32_t back = find_way_out(flood, face, most);
    for (; back != NO_INDEX; back = flood->queue[1][back]) {
        flood->wall[flood->queue[0][back]] = flood->wall_epoch;
    }
}

/// The walls are the loop vertices, and the ways on from where the curve ends inside the surface: any for one
/// that turns back at a loop vertex, else only short ones.
static void build_walls(PercaleRegionFlood *flood, const PercaleContour *contour, uint32_t trace)
{
    flood->wall_epoch++;
    for (uint32_t end = 0; end < 2; end++) {
        uint32_t loop = percale_loop_vertex(flood->contours, flood->mesh, contour, end);
        if (loop != NO_INDEX) {
            flood->wall[loop] = flood->wall_epoch;
        } else if (is_folded(contour)) {
            build_wall(flood, contour, end, NO_INDEX - 1);
        } else if (contour->ends[trace][end] == 'I' && contour->count >= LONG_CONTOUR) {
            build_wall(flood, contour, end, contour->count / STEPS_PER_EDGE_OUT);
        }
    }
}

// ---- flood ----

static bool is_done(const Fill *fill, uint32_t side)
{
    return fill->begin[side] == fill->end[side];
}

bool percale_region_find(PercaleRegionFlood *flood, uint32_t contour, uint32_t trace, uint32_t side,
                         PercaleMemory *memory, PercaleTangleRegion *region)
{
    const PercaleContour *cutter = &flood->contours->items[contour];
    if (!percale_memory_reserve(memory, &flood->sorting, &flood->sorting_capacity, 2 * (size_t)cutter->count,
                                sizeof(PercaleKeyed))) {
        return false;
    }
    build_walls(flood, cutter, trace);
    flood->epoch++;
    Fill fill = {.flood = flood};
    begin_at_trace(&fill, trace, is_folded(cutter), flood->sorting,
                   sort_steps(flood, cutter, trace, flood->sorting));
    bool wants_both = side == SIDE_SMALLER;
    uint32_t next = wants_both ? SIDE_LEFT : side;
    while (!fill.have_met && !is_done(&fill, next)) {
        spread(&fill, next);
        next = wants_both ? (uint32_t)(fill.area[SIDE_RIGHT] < fill.area[SIDE_LEFT]) : side;
    }
    *region = (PercaleTangleRegion){.is_cut_off = !fill.have_met && fill.end[next] > 0,
                                    .side = next,
                                    .count = fill.end[next],
                                    .points = flood->queue[next],
                                    .area = fill.area[next]};
    return true;
}
