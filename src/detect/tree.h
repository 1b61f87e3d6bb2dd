// tree.h: the wide bounding volume hierarchy over triangles or edges.
//
//   in   primitives (triangles or edges), positions
//   out  boxes, eight children to a node; refit in place when the positions move
//
// Implicit: node i of a level has the children 8 i .. 8 i + 7 of the level below; the lowest level's children
// are primitives along a space-filling curve. No pointers, no rebuild while the mesh keeps them.

#ifndef PERCALE_TREE_H
#define PERCALE_TREE_H

#include "base/memory.h"
#include "base/simd.h"
#include "base/team.h"

enum { TREE_WIDTH = 8, TREE_LEVELS_MAX = 11, TREE_STACK = TREE_WIDTH * TREE_LEVELS_MAX };

typedef struct PercaleTreeNode {
    f32x8 low[3], high[3]; // boxes of the eight children by axis; an absent child has low = inf, high = -inf
} PercaleTreeNode;

typedef struct PercaleTree {
    uint32_t arity; // points of a primitive: 3 of a triangle, 2 of an edge
    uint32_t primitive_count;
    uint32_t *order; // [primitive_count] primitive at each place of the lowest level
    uint32_t level_count;
    uint32_t level_first[TREE_LEVELS_MAX]; // index of a level's first node; level 0 is the lowest
    uint32_t level_size[TREE_LEVELS_MAX];  // nodes
    PercaleTreeNode *nodes;
} PercaleTree;

/// primitives: [arity * primitive_count] indices into points. False without memory. Boxes are valid after a
/// refit.
bool percale_tree_build(PercaleTree *tree, const uint32_t *primitives, uint32_t arity,
                        uint32_t primitive_count, const f32x4 *points, PercaleMemory *memory);
void percale_tree_refit(PercaleTree *tree, const uint32_t *primitives, const f32x4 *points,
                        PercaleTeam *team);
/// Boxes over several places of the points.
void percale_tree_refit_swept(PercaleTree *tree, const uint32_t *primitives, const f32x4 *const *places,
                              int place_count, PercaleTeam *team);
void percale_tree_free(PercaleTree *tree, PercaleMemory *memory);

/// A growing list of nodes.
typedef struct PercaleNodeList {
    uint32_t *items;
    size_t count, capacity;
} PercaleNodeList;

/// All nodes of the lowest level with a child whose box touches the box, in a fixed order, appended to the
/// emptied list. False without memory.
bool percale_tree_overlap(const PercaleTree *tree, f32x4 low, f32x4 high, PercaleMemory *memory,
                          PercaleNodeList *list);

/// One entry of a traversal: a node of a level.
typedef struct PercaleTreeEntry {
    uint32_t level, node;
} PercaleTreeEntry;

static inline PercaleTreeEntry tree_root(const PercaleTree *tree)
{
    return (PercaleTreeEntry){tree->level_count - 1, 0};
}

static inline const PercaleTreeNode *tree_node(const PercaleTree *tree, PercaleTreeEntry entry)
{
    return &tree->nodes[tree->level_first[entry.level] + entry.node];
}

/// Squared distances of a point to the eight child boxes, infinite for absent children.
static inline f32x8 tree_box_distance2(const PercaleTreeNode *node, f32x4 point)
{
    f32x8 sum = {0};
    for (int axis = 0; axis < 3; axis++) {
        f32x8 below = node->low[axis] - point[axis];
        f32x8 above = point[axis] - node->high[axis];
        f32x8 out = max8(max8(below, above), (f32x8){0});
        sum += out * out;
    }
    return sum;
}

/// Whether the eight child boxes touch the box.
static inline i32x8 tree_box_overlaps(const PercaleTreeNode *node, f32x4 low, f32x4 high)
{
    i32x8 all = ~(i32x8){0};
    for (int axis = 0; axis < 3; axis++) {
        all &= at_most8(node->low[axis], all8(high[axis])) & at_most8(all8(low[axis]), node->high[axis]);
    }
    return all;
}

#endif
