#include "untangle/trace_crossings.h"

#include "base/radix_sort.h"

/// Two pieces on one triangle.
typedef struct Couple {
    const PercaleTangleMesh *mesh;
    const PercaleTangleCrossings *crossings;
    const f32x4 *x;
    uint32_t triangle;
    const PercaleContourPiece *pieces[2];
} Couple;

static uint32_t trace_on(const PercaleContourPiece *piece, uint32_t triangle)
{
    return piece->triangles[0] == triangle ? piece->first_trace : 1 - piece->first_trace;
}

static bool do_pieces_meet(const PercaleContourPiece *a, const PercaleContourPiece *b)
{
    for (int k = 0; k < 4; k++) {
        if (a->crossings[k / 2] == b->crossings[k % 2]) {
            return true;
        }
    }
    return false;
}

/// Twice the area of the triangle a b c, seen along the normal.
static double turn_of(Vec3 normal, Vec3 a, Vec3 b, Vec3 c)
{
    return vdot(normal, vcross(vsub(b, a), vsub(c, a)));
}

static bool do_pieces_cross(const Couple *couple)
{
    if (do_pieces_meet(couple->pieces[0], couple->pieces[1])) {
        return false;
    }
    const uint32_t *corners = corners_of_triangle(couple->mesh, couple->triangle);
    Vec3 a = vec3_of(couple->x[corners[0]]);
    Vec3 normal = vcross(vsub(vec3_of(couple->x[corners[1]]), a), vsub(vec3_of(couple->x[corners[2]]), a));
    Vec3 end[2][2];
    for (uint32_t k = 0; k < 4; k++) {
        end[k / 2][k % 2] =
            percale_piece_end(couple->mesh, couple->crossings, couple->x, couple->pieces[k / 2], k % 2);
    }
    return turn_of(normal, end[0][0], end[0][1], end[1][0]) *
                   turn_of(normal, end[0][0], end[0][1], end[1][1]) <
               0.0 &&
           turn_of(normal, end[1][0], end[1][1], end[0][0]) *
                   turn_of(normal, end[1][0], end[1][1], end[0][1]) <
               0.0;
}

static void mark(PercaleContours *contours, const Couple *couple)
{
    const PercaleContourPiece *a = couple->pieces[0];
    const PercaleContourPiece *b = couple->pieces[1];
    bool is_one_trace =
        a->contour == b->contour && trace_on(a, couple->triangle) == trace_on(b, couple->triangle);
    for (int k = 0; k < 2; k++) {
        PercaleContour *contour = &contours->items[couple->pieces[k]->contour];
        if (contour->kind != CONTOUR_EIGHT) {
            contour->kind = is_one_trace ? CONTOUR_EIGHT : CONTOUR_CROSS;
        }
    }
}

bool percale_mark_trace_crossings(PercaleContours *contours, const PercaleTangleMesh *mesh,
                                  const PercaleTangleCrossings *crossings, const f32x4 *x,
                                  PercaleMemory *memory)
{
    size_t count = 2 * contours->piece_count;
    if (!percale_memory_reserve(memory, &contours->sorting, &contours->sorting_capacity, 2 * count,
                                sizeof(PercaleKeyed))) {
        return false;
    }
    PercaleKeyed *on = contours->sorting; // pieces by triangle
    for (uint32_t i = 0; i < count; i++) {
        on[i] = (PercaleKeyed){contours->pieces[i / 2].triangles[i % 2], i / 2};
    }
    percale_radix_sort(on, on + count, count);
    for (size_t i = 0; i < count; i++) {
        for (size_t j = i + 1; j < count && on[j].key == on[i].key; j++) {
            Couple couple = {mesh,
                             crossings,
                             x,
                             (uint32_t)on[i].key,
                             {&contours->pieces[on[i].value], &contours->pieces[on[j].value]}};
            if (do_pieces_cross(&couple)) {
                mark(contours, &couple);
            }
        }
    }
    return true;
}
