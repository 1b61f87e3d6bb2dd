#include "audit/audit_tree.h"

#include <math.h>

static const size_t LEAF_TRIANGLES = 4; // more: too many boxes overlap; fewer: the nodes outweigh the mesh

typedef struct Item {
    float centre[3]; // m, of the box
    uint32_t triangle;
} Item;

typedef struct Builder {
    const PercaleAuditMesh *mesh;
    PercaleAuditTree *tree;
    Item *items; // [triangle_count]
} Builder;

bool percale_audit_is_finite(const PercaleAuditMesh *mesh, uint32_t vertex)
{
    const float *point = mesh->positions + 3 * (size_t)vertex;
    return isfinite(point[0]) && isfinite(point[1]) && isfinite(point[2]);
}

bool percale_audit_is_usable(const PercaleAuditMesh *mesh, uint32_t triangle)
{
    const uint32_t *corners = mesh->triangles + 3 * (size_t)triangle;
    for (size_t k = 0; k < 3; k++) {
        if (corners[k] >= mesh->vertex_count || corners[k] == corners[(k + 1) % 3] ||
            !percale_audit_is_finite(mesh, corners[k]))
            return false;
    }
    return true;
}

static void grow_box(PercaleAuditNode *box, const float low[3], const float high[3])
{
    for (size_t axis = 0; axis < 3; axis++) {
        box->low[axis] = low[axis] < box->low[axis] ? low[axis] : box->low[axis];
        box->high[axis] = high[axis] > box->high[axis] ? high[axis] : box->high[axis];
    }
}

static const PercaleAuditNode EMPTY_BOX = {
    .low = {INFINITY, INFINITY, INFINITY},
    .high = {-INFINITY, -INFINITY, -INFINITY},
};

static void grow_by_triangle(PercaleAuditNode *box, const PercaleAuditMesh *mesh, uint32_t triangle)
{
    for (size_t k = 0; k < 3; k++) {
        const float *corner = mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + k];
        grow_box(box, corner, corner);
    }
}

// Hoare's selection: afterwards nothing before `middle` is larger and nothing after it smaller.
static void split_at(Item *items, ptrdiff_t first, ptrdiff_t last, ptrdiff_t middle, size_t axis)
{
    while (first < last) {
        float pivot = items[middle].centre[axis];
        ptrdiff_t i = first;
        ptrdiff_t j = last;
        while (i <= j) {
            while (items[i].centre[axis] < pivot)
                i++;
            while (items[j].centre[axis] > pivot)
                j--;
            if (i > j)
                break;
            Item swapped = items[i];
            items[i++] = items[j];
            items[j--] = swapped;
        }
        if (j < middle)
            first = i;
        if (i > middle)
            last = j;
    }
}

static size_t longest_axis(const Item *items, size_t count)
{
    PercaleAuditNode box = EMPTY_BOX;
    for (size_t i = 0; i < count; i++)
        grow_box(&box, items[i].centre, items[i].centre);
    size_t longest = 0;
    for (size_t axis = 1; axis < 3; axis++) {
        if ((double)box.high[axis] - (double)box.low[axis] >
            (double)box.high[longest] - (double)box.low[longest])
            longest = axis;
    }
    return longest;
}

static void build_leaf(const Builder *builder, PercaleAuditNode *node, size_t begin, size_t end)
{
    PercaleAuditTree *tree = builder->tree;
    node->first = (uint32_t)begin;
    node->count = (uint32_t)(end - begin);
    for (size_t i = begin; i < end; i++) {
        uint32_t triangle = builder->items[i].triangle;
        grow_by_triangle(node, builder->mesh, triangle);
        tree->triangles[i] = triangle;
        for (size_t k = 0; k < 3; k++)
            tree->corners[3 * i + k] = builder->mesh->triangles[3 * (size_t)triangle + k];
    }
}

// Calls itself at most 32 deep: each half has half the triangles.
static void build_node(const Builder *builder, size_t begin, size_t end)
{
    PercaleAuditTree *tree = builder->tree;
    uint32_t self = tree->node_count++;
    PercaleAuditNode *node = &tree->nodes[self];
    *node = EMPTY_BOX;
    if (end - begin <= LEAF_TRIANGLES) {
        build_leaf(builder, node, begin, end);
        return;
    }
    size_t middle = begin + (end - begin) / 2;
    size_t axis = longest_axis(builder->items + begin, end - begin);
    split_at(builder->items, (ptrdiff_t)begin, (ptrdiff_t)end - 1, (ptrdiff_t)middle, axis);
    build_node(builder, begin, middle);
    node->first = tree->node_count;
    build_node(builder, middle, end);
    const PercaleAuditNode *left = &tree->nodes[self + 1];
    const PercaleAuditNode *right = &tree->nodes[node->first];
    grow_box(node, left->low, left->high);
    grow_box(node, right->low, right->high);
}

static uint32_t list_items(const PercaleAuditMesh *mesh, Item *items)
{
    uint32_t count = 0;
    for (uint32_t triangle = 0; triangle < mesh->triangle_count; triangle++) {
        if (!percale_audit_is_usable(mesh, triangle))
            continue;
        PercaleAuditNode box = EMPTY_BOX;
        grow_by_triangle(&box, mesh, triangle);
        for (size_t axis = 0; axis < 3; axis++)
            items[count].centre[axis] = 0.5f * box.low[axis] + 0.5f * box.high[axis];
        items[count++].triangle = triangle;
    }
    return count;
}

bool percale_audit_tree_open(const PercaleAuditMemory *memory, const PercaleAuditMesh *mesh,
                             PercaleAuditTree *tree)
{
    size_t count = mesh->triangle_count;
    *tree = (PercaleAuditTree){.positions = mesh->positions};
    // A split leaf had more than LEAF_TRIANGLES, so there are at most half as many leaves as triangles.
    tree->nodes = percale_audit_allocate(memory, count, sizeof *tree->nodes);
    tree->triangles = percale_audit_allocate(memory, count, sizeof *tree->triangles);
    tree->corners = percale_audit_allocate(memory, 3 * count, sizeof *tree->corners);
    Item *items = percale_audit_allocate(memory, count, sizeof *items);
    bool has_memory = tree->nodes && tree->triangles && tree->corners && items;
    if (has_memory) {
        tree->triangle_count = list_items(mesh, items);
        Builder builder = {mesh, tree, items};
        if (tree->triangle_count > 0)
            build_node(&builder, 0, tree->triangle_count);
    }
    percale_audit_release(memory, items);
    return has_memory;
}

void percale_audit_tree_close(const PercaleAuditMemory *memory, PercaleAuditTree *tree)
{
    percale_audit_release(memory, tree->nodes);
    percale_audit_release(memory, tree->triangles);
    percale_audit_release(memory, tree->corners);
    *tree = (PercaleAuditTree){.node_count = 0};
}
