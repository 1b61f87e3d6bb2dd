#include "model/mesh.h"

#include "base/radix_sort.h"

static uint32_t collect_sides(const uint32_t *triangles, uint32_t triangle_count, PercaleKeyed *items)
{
    uint32_t count = 0;
    for (uint32_t side = 0; side < 3 * triangle_count; side++) {
        uint32_t a = triangles[side];
        uint32_t b = triangles[side / 3 * 3 + next_corner(side % 3)];
        uint32_t low = a < b ? a : b;
        uint32_t high = a < b ? b : a;
        if (low != high) {
            items[count++] = (PercaleKeyed){(uint64_t)low << 32 | high, side};
        }
    }
    return count;
}

static uint32_t count_edges(const PercaleKeyed *items, uint32_t side_count)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < side_count; i++) {
        count += i == 0 || items[i].key != items[i - 1].key;
    }
    return count;
}

static void group_sides(const PercaleKeyed *items, uint32_t side_count, PercaleEdges *edges)
{
    uint32_t edge_count = 0;
    for (uint32_t i = 0; i < side_count; i++) {
        if (i == 0 || items[i].key != items[i - 1].key) {
            edges->vertices[edge_count][0] = (uint32_t)(items[i].key >> 32);
            edges->vertices[edge_count][1] = (uint32_t)items[i].key;
            edges->first_side[edge_count++] = i;
        }
        edges->sides[i] = items[i].value;
        edges->edge_of_side[items[i].value] = edge_count - 1;
    }
    edges->edge_count = edge_count;
    edges->first_side[edge_count] = side_count;
}

bool percale_edges_build(const uint32_t *triangles, uint32_t triangle_count, PercaleMemory *memory,
                         PercaleEdges *edges)
{
    size_t most = 3 * (size_t)triangle_count;
    *edges = (PercaleEdges){0};
    PercaleKeyed *items = percale_memory_new(memory, 2 * most, sizeof(items[0]));
    uint32_t side_count = 0;
    size_t edge_count = 0;
    if (items != NULL) {
        side_count = collect_sides(triangles, triangle_count, items);
        percale_radix_sort(items, items + most, side_count);
        edge_count = count_edges(items, side_count);
    }
    edges->vertices = percale_memory_new(memory, edge_count, sizeof(edges->vertices[0]));
    edges->first_side = percale_memory_new(memory, edge_count + 1, sizeof(edges->first_side[0]));
    edges->sides = percale_memory_new(memory, most, sizeof(edges->sides[0]));
    edges->edge_of_side = percale_memory_new(memory, most, sizeof(edges->edge_of_side[0]));
    bool complete = items != NULL && edges->vertices != NULL && edges->first_side != NULL &&
                    edges->sides != NULL && edges->edge_of_side != NULL;
    if (complete) {
        for (size_t side = 0; side < most; side++) {
            edges->edge_of_side[side] = UINT32_MAX;
        }
        group_sides(items, side_count, edges);
    } else {
        percale_edges_free(edges, memory);
    }
    percale_memory_free(memory, items);
    return complete;
}

void percale_edges_free(PercaleEdges *edges, PercaleMemory *memory)
{
    percale_memory_free(memory, edges->vertices);
    percale_memory_free(memory, edges->first_side);
    percale_memory_free(memory, edges->sides);
    percale_memory_free(memory, edges->edge_of_side);
    *edges = (PercaleEdges){0};
}
