#include "untangle/contours.h"

#include "base/radix_sort.h"
#include "untangle/trace_crossings.h"

#include <assert.h>

const char *percale_contour_kind_name(PercaleContourKind kind)
{
    static const char *const NAMES[CONTOUR_KINDS] = {"Closed", "BBII", "BIBI", "BLI", "LL", "Cross", "Eight"};
    return NAMES[kind];
}

// ---- pieces ----

static uint32_t list_pairs(const PercaleTangleMesh *mesh, const PercaleTangleCrossings *crossings,
                           PercaleKeyed *pairs)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < crossings->count; i++) {
        const PercaleTangleCrossing *crossing = &crossings->items[i];
        for (uint32_t k = 0; k < triangles_of_edge(mesh, crossing->edge); k++) {
            uint32_t own = triangle_of_edge(mesh, crossing->edge, k);
            uint32_t low = own < crossing->face ? own : crossing->face;
            uint32_t high = own < crossing->face ? crossing->face : own;
            pairs[count++] = (PercaleKeyed){(uint64_t)low << 32 | high, i};
        }
    }
    return count;
}

static void note_piece(PercaleContours *contours, uint32_t crossing, uint32_t piece)
{
    uint32_t *pieces = contours->pieces_of[crossing];
    pieces[pieces[0] == NO_INDEX ? 0 : 1] = piece;
}

static void group_pairs(PercaleContours *contours, const PercaleTangleMesh *mesh, const PercaleKeyed *pairs,
                        uint32_t count)
{
    contours->piece_count = 0;
    contours->pair_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i > 0 && pairs[i].key == pairs[i - 1].key) {
            PercaleContourPiece *piece = &contours->pieces[contours->piece_count - 1];
            assert(piece->crossings[1] == NO_INDEX);
            piece->crossings[1] = pairs[i].value;
        } else {
            uint32_t low = (uint32_t)(pairs[i].key >> 32);
            uint32_t high = (uint32_t)pairs[i].key;
            contours->pieces[contours->piece_count++] =
                (PercaleContourPiece){{low, high}, {pairs[i].value, NO_INDEX}, NO_INDEX, 0};
            contours->pair_count += !do_triangles_meet(mesh, low, high);
        }
        note_piece(contours, pairs[i].value, (uint32_t)contours->piece_count - 1);
    }
}

static bool build_pieces(PercaleContours *contours, const PercaleTangleMesh *mesh,
                         const PercaleTangleCrossings *crossings, PercaleMemory *memory)
{
    size_t most = 0;
    for (size_t i = 0; i < crossings->count; i++) {
        most += triangles_of_edge(mesh, crossings->items[i].edge);
    }
    if (!percale_memory_reserve(memory, &contours->sorting, &contours->sorting_capacity, 2 * most,
                                sizeof(PercaleKeyed)) ||
        !percale_memory_reserve(memory, &contours->pieces, &contours->piece_capacity, most,
                                sizeof(contours->pieces[0])) ||
        !percale_memory_reserve(memory, &contours->pieces_of, &contours->pieces_of_capacity, crossings->count,
                                sizeof(contours->pieces_of[0]))) {
        return false;
    }
    for (size_t i = 0; i < crossings->count; i++) {
        contours->pieces_of[i][0] = contours->pieces_of[i][1] = NO_INDEX;
    }
    PercaleKeyed *pairs = contours->sorting;
    uint32_t count = list_pairs(mesh, crossings, pairs);
    percale_radix_sort(pairs, pairs + most, count);
    group_pairs(contours, mesh, pairs, count);
    return true;
}

// ---- chains ----

/// A walk along a contour.
typedef struct Walk {
    PercaleContours *contours;
    const PercaleTangleMesh *mesh;
    const PercaleTangleCrossings *crossings;
    PercaleContour contour;
    uint32_t index;        // of the contour
    uint32_t piece;        // where it is
    uint32_t triangles[2]; // of that piece, by trace
    uint32_t last_step[2]; // with an edge of each trace; NO_INDEX: none yet
} Walk;

/// Which end of the edge is left of who goes out of a triangle over it (or into it: `goes_in`), seen from the
/// side to which its piece of cloth is turned.
static uint32_t left_by_turn(const Walk *walk, uint32_t edge, uint32_t triangle, bool goes_in)
{
    const uint32_t *corners = corners_of_triangle(walk->mesh, triangle);
    const uint32_t *ends = walk->mesh->edges.vertices[edge];
    bool runs_along = false; // the triangle's side, as the edge does
    for (int k = 0; k < 3; k++) {
        runs_along = runs_along || (corners[k] == ends[0] && corners[(k + 1) % 3] == ends[1]);
    }
    return (runs_along == (walk->mesh->turns[triangle] > 0)) != goes_in ? 1 : 0;
}

/// Which end of the edge is left, from the edge before it on the same trace: where both are sides of one
/// triangle, the corner that they share stays on its side; back over the same edge, everything is turned
/// round. The first is left by the turn of the surface, so that two traces on one surface agree.
static uint32_t left_end(const Walk *walk, const PercaleContourStep *step)
{
    uint32_t edge = walk->crossings->items[step->crossing].edge;
    if (walk->last_step[step->trace] == NO_INDEX) {
        bool goes_in = step->before == NO_INDEX;
        return left_by_turn(walk, edge, goes_in ? step->after : step->before, goes_in);
    }
    const PercaleContourStep *last = &walk->contours->steps[walk->last_step[step->trace]];
    uint32_t before = walk->crossings->items[last->crossing].edge;
    if (before == edge) {
        return 1 - last->left;
    }
    const uint32_t *old = walk->mesh->edges.vertices[before];
    const uint32_t *new = walk->mesh->edges.vertices[edge];
    uint32_t shared = new[0] == old[0] || new[0] == old[1] ? 0 : 1;
    bool is_left = new[shared] == old[last->left];
    return is_left ? shared : 1 - shared;
}

static void add_step(Walk *walk, uint32_t crossing, uint32_t trace, uint32_t before, uint32_t after)
{
    PercaleContours *contours = walk->contours;
    PercaleContourStep step = {crossing, trace, before, after, 0};
    step.left = left_end(walk, &step);
    walk->last_step[trace] = (uint32_t)contours->step_count;
    contours->steps[contours->step_count++] = step;
    walk->contour.count++;
}

static void take_piece(Walk *walk, uint32_t piece)
{
    PercaleContourPiece *taken = &walk->contours->pieces[piece];
    taken->contour = walk->index;
    taken->first_trace = walk->triangles[0] == taken->triangles[0] ? 0 : 1;
    walk->piece = piece;
}

/// Goes over the crossing into the next piece; false where the contour ends.
static bool cross_edge(Walk *walk, uint32_t crossing)
{
    const PercaleTangleCrossing *met = &walk->crossings->items[crossing];
    uint32_t trace = met->face == walk->triangles[1] ? 0 : 1;
    assert(met->face == walk->triangles[1 - trace]);
    uint32_t before = walk->triangles[trace];
    uint32_t after = triangle_beyond(walk->mesh, met->edge, before);
    add_step(walk, crossing, trace, before, after);
    if (after == NO_INDEX) {
        walk->contour.ends[trace][1] = 'B';
        walk->contour.ends[1 - trace][1] = 'I';
        return false;
    }
    walk->triangles[trace] = after;
    const uint32_t *pieces = walk->contours->pieces_of[crossing];
    uint32_t next = pieces[0] == walk->piece ? pieces[1] : pieces[0];
    PercaleContourPiece *piece = &walk->contours->pieces[next];
    if (piece->contour != NO_INDEX) {
        walk->contour.is_closed = true;
        walk->contour.is_joined = walk->triangles[0] != walk->contour.triangles[0];
        return false;
    }
    take_piece(walk, next);
    return true;
}

/// From the piece's end `entry` (0 or 1) on; `begins_at_edge`: there the contour begins, at a boundary.
static void walk_from(Walk *walk, uint32_t piece, uint32_t entry, bool begins_at_edge)
{
    PercaleContours *contours = walk->contours;
    const PercaleContourPiece *first = &contours->pieces[piece];
    uint32_t crossing = first->crossings[entry];
    uint32_t face = begins_at_edge ? walk->crossings->items[crossing].face : first->triangles[1];
    walk->index = (uint32_t)contours->count;
    walk->triangles[1] = face;
    walk->triangles[0] = first->triangles[0] == face ? first->triangles[1] : first->triangles[0];
    walk->last_step[0] = walk->last_step[1] = NO_INDEX;
    walk->contour = (PercaleContour){.first = (uint32_t)contours->step_count,
                                     .triangles = {walk->triangles[0], walk->triangles[1]}};
    take_piece(walk, piece);
    if (begins_at_edge) {
        add_step(walk, crossing, 0, NO_INDEX, walk->triangles[0]);
        walk->contour.ends[0][0] = 'B';
        walk->contour.ends[1][0] = 'I';
    } else if (crossing == NO_INDEX) {
        walk->contour.ends[0][0] = walk->contour.ends[1][0] = 'L';
    }
    bool goes_on = true;
    while (goes_on) {
        const uint32_t *ends = contours->pieces[walk->piece].crossings;
        uint32_t next = ends[0] == crossing ? ends[1] : ends[0];
        if (next == NO_INDEX) {
            walk->contour.ends[0][1] = walk->contour.ends[1][1] = 'L';
            break;
        }
        crossing = next;
        goes_on = cross_edge(walk, crossing);
    }
    contours->items[contours->count++] = walk->contour;
}

static bool ends_at_boundary(const Walk *walk, uint32_t crossing)
{
    return crossing != NO_INDEX && triangles_of_edge(walk->mesh, walk->crossings->items[crossing].edge) != 2;
}

/// Contours that have ends are found from them, in the order of their pieces; the others are closed.
static void chain(Walk *walk)
{
    PercaleContours *contours = walk->contours;
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t i = 0; i < contours->piece_count; i++) {
            const PercaleContourPiece *piece = &contours->pieces[i];
            if (piece->contour != NO_INDEX) {
                continue;
            }
            if (pass == 1) {
                walk_from(walk, i, 0, false);
            } else if (piece->crossings[1] == NO_INDEX) {
                walk_from(walk, i, 1, false);
            } else if (ends_at_boundary(walk, piece->crossings[0])) {
                walk_from(walk, i, 0, true);
            } else if (ends_at_boundary(walk, piece->crossings[1])) {
                walk_from(walk, i, 1, true);
            }
        }
    }
}

// ---- lengths and kinds ----

static PercaleContourKind kind_of(const PercaleContour *contour)
{
    if (contour->is_closed) {
        return contour->is_joined ? CONTOUR_EIGHT : CONTOUR_CLOSED;
    }
    bool begins_loop = contour->ends[0][0] == 'L';
    bool ends_loop = contour->ends[0][1] == 'L';
    if (begins_loop || ends_loop) {
        return begins_loop && ends_loop ? CONTOUR_LL : CONTOUR_BLI;
    }
    return contour->ends[0][0] == contour->ends[0][1] ? CONTOUR_BBII : CONTOUR_BIBI;
}

/// The point that two triangles share.
static uint32_t shared_point(const PercaleTangleMesh *mesh, const PercaleContourPiece *piece)
{
    const uint32_t *a = corners_of_triangle(mesh, piece->triangles[0]);
    const uint32_t *b = corners_of_triangle(mesh, piece->triangles[1]);
    uint32_t shared = 0;
    for (uint32_t k = 0; k < 9; k++) {
        shared = are_sewn_together(mesh, a[k / 3], b[k % 3]) ? k / 3 : shared;
    }
    return a[shared];
}

uint32_t percale_loop_vertex(const PercaleContours *contours, const PercaleTangleMesh *mesh,
                             const PercaleContour *contour, uint32_t end)
{
    uint32_t step = end == 0 ? contour->first : contour->first + contour->count - 1;
    if (contour->ends[0][end] != 'L') {
        return NO_INDEX;
    }
    const uint32_t *pieces = contours->pieces_of[contours->steps[step].crossing];
    for (int k = 0; k < 2; k++) {
        if (pieces[k] != NO_INDEX && contours->pieces[pieces[k]].crossings[1] == NO_INDEX) {
            return shared_point(mesh, &contours->pieces[pieces[k]]);
        }
    }
    return NO_INDEX;
}

Vec3 percale_piece_end(const PercaleTangleMesh *mesh, const PercaleTangleCrossings *crossings, const f32x4 *x,
                       const PercaleContourPiece *piece, uint32_t end)
{
    if (piece->crossings[end] != NO_INDEX) {
        return percale_crossing_point(mesh, &crossings->items[piece->crossings[end]], x);
    }
    return vec3_of(x[shared_point(mesh, piece)]);
}

bool percale_contours_build(PercaleContours *contours, const PercaleTangleMesh *mesh,
                            const PercaleTangleCrossings *crossings, const f32x4 *x, PercaleMemory *memory)
{
    contours->count = 0;
    contours->step_count = 0;
    if (!build_pieces(contours, mesh, crossings, memory) ||
        !percale_memory_reserve(memory, &contours->items, &contours->capacity, contours->piece_count,
                                sizeof(contours->items[0])) ||
        !percale_memory_reserve(memory, &contours->steps, &contours->step_capacity, 2 * contours->piece_count,
                                sizeof(contours->steps[0]))) {
        return false;
    }
    Walk walk = {.contours = contours, .mesh = mesh, .crossings = crossings};
    chain(&walk);
    for (size_t i = 0; i < contours->count; i++) {
        contours->items[i].kind = kind_of(&contours->items[i]);
    }
    for (size_t i = 0; i < contours->piece_count; i++) {
        const PercaleContourPiece *piece = &contours->pieces[i];
        Vec3 way = vsub(percale_piece_end(mesh, crossings, x, piece, 1),
                        percale_piece_end(mesh, crossings, x, piece, 0));
        contours->items[piece->contour].length += vlength(way);
        contours->items[piece->contour].pair_count +=
            !do_triangles_meet(mesh, piece->triangles[0], piece->triangles[1]);
    }
    return percale_mark_trace_crossings(contours, mesh, crossings, x, memory);
}

double percale_contours_length(const PercaleContours *contours)
{
    double sum = 0.0;
    for (size_t i = 0; i < contours->count; i++) {
        sum += contours->items[i].length;
    }
    return sum;
}

void percale_contours_free(PercaleContours *contours, PercaleMemory *memory)
{
    percale_memory_free(memory, contours->items);
    percale_memory_free(memory, contours->steps);
    percale_memory_free(memory, contours->pieces);
    percale_memory_free(memory, contours->pieces_of);
    percale_memory_free(memory, contours->sorting);
    *contours = (PercaleContours){0};
}
