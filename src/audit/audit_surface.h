// audit_surface.h: an obstacle as a surface: how deep a point lies in it, and how far away.
//
// Closed: every edge has exactly two triangles that run along it in opposite directions. Then a point is
// inside where the winding number exceeds 0.5, so bodies may cross themselves. Open: a point is inside where
// it lies behind the nearest feature (pseudonormal weighted by angle, Baerentzen and Aanaes 2005), not
// farther than PERCALE_AUDIT_OPEN_DEPTH; nothing is behind a rim. On the surface is not inside.

#ifndef PERCALE_AUDIT_AUDIT_SURFACE_H
#define PERCALE_AUDIT_AUDIT_SURFACE_H

#include "audit/audit_tree.h"

#define PERCALE_AUDIT_OPEN_DEPTH 5e-3       ///< m; what is farther behind an open obstacle is not inside
#define PERCALE_AUDIT_RIM        UINT32_MAX ///< in the place of a neighbour: there is none

typedef struct PercaleAuditSurface {
    const PercaleAuditMesh *mesh;
    PercaleAuditTree tree;
    double *face_normals;   ///< [3 * triangle_count] of length 1; 0 where there is no area
    double *vertex_normals; ///< [3 * vertex_count] weighted by angle, not of length 1; 0 without triangles
    uint32_t *neighbours;   ///< [3 * triangle_count] the triangle across the edge from corner k to k + 1
    uint8_t *is_rim;        ///< [vertex_count] 1: some edge of it has not two opposite triangles
    bool is_closed;
} PercaleAuditSurface;

typedef struct PercaleAuditPlace {
    double depth;    ///< m below the surface; 0 outside
    double distance; ///< m from the surface, on either side; INFINITY: farther than asked for
} PercaleAuditPlace;

/// False without memory; the surface is to be closed in either case.
bool percale_audit_surface_open(const PercaleAuditMemory *memory, const PercaleAuditMesh *mesh,
                                PercaleAuditSurface *surface);
void percale_audit_surface_close(const PercaleAuditMemory *memory, PercaleAuditSurface *surface);

/// Where a finite point is; the distance of one outside is looked for up to `reach` (m).
PercaleAuditPlace percale_audit_place(const PercaleAuditSurface *surface, const float point[3], double reach);

#endif
