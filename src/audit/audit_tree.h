// audit_tree.h: the audit's own tree of boxes over the triangles of one mesh.
//
//   in   a mesh
//   out  nodes from the root down, each followed by its left half; triangles in the order of the leaves

#ifndef PERCALE_AUDIT_AUDIT_TREE_H
#define PERCALE_AUDIT_AUDIT_TREE_H

#include "audit/audit_memory.h"

/// Room for a walk: every step down leaves one node waiting, and 2^32 triangles halve 32 times at most.
#define PERCALE_AUDIT_STACK 64

typedef struct PercaleAuditNode {
    float low[3];
    float high[3];
    uint32_t first; ///< leaf: its first triangle; else: the right child (the left one follows the node)
    uint32_t count; ///< leaf: its triangles; else 0
} PercaleAuditNode;

typedef struct PercaleAuditTree {
    const float *positions;
    PercaleAuditNode *nodes;
    uint32_t node_count;     ///< 0: no usable triangle
    uint32_t triangle_count; ///< usable ones
    uint32_t *triangles;     ///< [triangle_count] the mesh's number of each, in the order of the leaves
    uint32_t *corners;       ///< [3 * triangle_count] likewise
} PercaleAuditTree;

bool percale_audit_is_finite(const PercaleAuditMesh *mesh, uint32_t vertex);

/// Are its corners three different finite vertices?
bool percale_audit_is_usable(const PercaleAuditMesh *mesh, uint32_t triangle);

/// False without memory; the tree is to be closed in either case.
bool percale_audit_tree_open(const PercaleAuditMemory *memory, const PercaleAuditMesh *mesh,
                             PercaleAuditTree *tree);
void percale_audit_tree_close(const PercaleAuditMemory *memory, PercaleAuditTree *tree);

/// The float coordinates of a corner (0..2) of a triangle, numbered as in the leaves.
static inline const float *percale_audit_corner(const PercaleAuditTree *tree, size_t triangle, size_t corner)
{
    return tree->positions + 3 * (size_t)tree->corners[3 * triangle + corner];
}

#endif
