// audit.h: what the files of the audit share.
//
// The audit judges the engine, so it shares no code with its stages: own tree, own predicates, own distances,
// in double or exact. One thread, no state. No answer depends on the order of vertices, triangles and
// corners, but for the last bits of a distance.
//
// What is left out of everything: vertices with a NaN or infinite coordinate (counted as `nonfinite`), and
// triangles that have such a corner, the same corner twice, or a corner that does not exist.

#ifndef PERCALE_AUDIT_AUDIT_H
#define PERCALE_AUDIT_AUDIT_H

#include "audit/audit_surface.h"
#include "audit/audit_tree.h"
#include "percale/percale.h"

/// Two triangles that cross: of a cloth, and of a cloth or an obstacle.
typedef struct PercaleAuditCrossing {
    uint32_t cloth, triangle;
    uint32_t other, other_triangle;
    bool is_obstacle; ///< the other
    double depth; ///< m that one of them reaches through the other's plane, the lesser; 0: nothing crosses
} PercaleAuditCrossing;

/// One call's view of its meshes: the cloths' vertices in one row, their trees, and who is sewn to whom.
typedef struct PercaleAuditScene {
    PercaleAuditMemory memory;
    const PercaleAuditMesh *cloths; ///< [cloth_count]
    uint32_t cloth_count;
    size_t *first_vertex;    ///< [cloth_count + 1] where each cloth's vertices begin in the row
    PercaleAuditTree *trees; ///< [cloth_count]
    uint32_t *points;        ///< [vertices] welded point of each vertex, 0..point_count - 1
    uint8_t *is_sewn;        ///< [point_count] 1: several vertices are this point
    size_t point_count;
    double *depths;      ///< [vertices] m below the deepest obstacle, 0 outside
    uint8_t *in_contact; ///< [vertices] 1: close to an obstacle
    PercaleAuditCrossing deepest;
} PercaleAuditScene;

/// percale_audit with the memory of the caller's choice; a failure leaves *quality as it was. `deepest`: of
/// the pairs that cross; may be NULL.
PercaleResult percale_audit_with(PercaleAuditMemory memory, const PercaleAuditMesh *cloths,
                                 uint32_t cloth_count, const PercaleAuditMesh *obstacles,
                                 uint32_t obstacle_count, PercaleQuality *quality,
                                 PercaleAuditCrossing *deepest);

/// percale_audit_penetration with the memory of the caller's choice.
PercaleResult percale_audit_penetration_with(PercaleAuditMemory memory, const PercaleAuditMesh *cloth,
                                             const PercaleAuditMesh *obstacles, uint32_t obstacle_count,
                                             float *depths);

/// Numbers the welded points of all cloths: fills points, is_sewn and point_count; false without memory.
bool percale_audit_weld(PercaleAuditScene *scene);

/// Raises depths and in_contact by one obstacle.
void percale_audit_penetrate(PercaleAuditScene *scene, const PercaleAuditSurface *obstacle);

/// How far the obstacle's vertices stand out through the cloths, m: the largest.
double percale_audit_stand_out(const PercaleAuditScene *scene, const PercaleAuditSurface *obstacle);

/// Counts ef_cloth_cloth and ef_seam: each cloth with itself, and with those whose masks share a bit.
void percale_audit_cross_cloths(PercaleAuditScene *scene, PercaleQuality *quality);

/// Adds one obstacle to ef_cloth_obstacle; `index`: which.
void percale_audit_cross_obstacle(PercaleAuditScene *scene, const PercaleAuditSurface *obstacle,
                                  uint32_t index, PercaleQuality *quality);

/// Fills stretch_max and stretch_p99; false without memory.
bool percale_audit_strain(const PercaleAuditScene *scene, PercaleQuality *quality);

/// The value at index ceil(0.99 count) - 1 of the sorted list, 0 of none; reorders the values.
double percale_audit_percentile_99(double *values, size_t count);

#endif
