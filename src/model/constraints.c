// Edges and hinges of the welded cloth with their rest values.

#include "model/model.h"
#include "model/tethers.h"

#include <string.h>

typedef struct RestTriangle {
    float lengths[3]; // m; side k from corner k to corner k + 1
    float compliance; // m/N
    float stiffness;  // N m
} RestTriangle;

/// Rest data of every triangle in model order (cloth after cloth).
static RestTriangle *gather_rest(const PercaleModel *model, const PercaleObjects *objects,
                                 PercaleMemory *memory)
{
    RestTriangle *rest = percale_memory_new(memory, model->cloth.triangle_count, sizeof(rest[0]));
    if (rest == NULL) {
        return NULL;
    }
    for (uint32_t c = 0, triangle = 0; c < model->cloth_count; c++) {
        const PercaleClothObject *object = &objects->cloths[c];
        for (uint32_t t = 0; t < object->triangle_count; t++, triangle++) {
            const float *lengths = object->rest_lengths + 3 * (size_t)t;
            rest[triangle] = (RestTriangle){{lengths[0], lengths[1], lengths[2]},
                                            object->material.stretch_compliance,
                                            object->material.bending_stiffness};
        }
    }
    return rest;
}

/// An edge's rest length and compliance are the means over its triangles (they differ only across a seam).
static bool build_edges(PercaleModel *model, const PercaleEdges *edges, const RestTriangle *rest,
                        PercaleMemory *memory)
{
    model->edges = percale_memory_new(memory, edges->edge_count, sizeof(model->edges[0]));
    model->edge_lengths = percale_memory_new(memory, edges->edge_count, sizeof(float));
    model->edge_compliances = percale_memory_new(memory, edges->edge_count, sizeof(float));
    if (model->edges == NULL || model->edge_lengths == NULL || model->edge_compliances == NULL) {
        return false;
    }
    bool compliant = false;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        double length = 0.0;
        double compliance = 0.0;
        uint32_t side_count = edges->first_side[e + 1] - edges->first_side[e];
        for (uint32_t i = edges->first_side[e]; i < edges->first_side[e + 1]; i++) {
            length += (double)rest[edges->sides[i] / 3].lengths[edges->sides[i] % 3];
            compliance += (double)rest[edges->sides[i] / 3].compliance;
        }
        model->edges[e][0] = edges->vertices[e][0];
        model->edges[e][1] = edges->vertices[e][1];
        model->edge_lengths[e] = (float)(length / side_count);
        model->edge_compliances[e] = (float)(compliance / side_count);
        compliant = compliant || model->edge_compliances[e] > 0.0f;
    }
    model->edge_count = edges->edge_count;
    if (!compliant) {
        percale_memory_free(memory, model->edge_compliances);
        model->edge_compliances = NULL;
    }
    return true;
}

/// Cotangents at the start and the end of a triangle's side, and the area, from its lengths.
static void side_cotangents(const RestTriangle *triangle, uint32_t side, double area, double cotangents[2])
{
    double edge = (double)triangle->lengths[side];
    double after = (double)triangle->lengths[next_corner(side)];
    double before = (double)triangle->lengths[next_corner(next_corner(side))];
    cotangents[0] = (edge * edge + before * before - after * after) / (4.0 * area);
    cotangents[1] = (edge * edge + after * after - before * before) / (4.0 * area);
}

/// Isometric bending (Bergou et al. 2006, eq. 3) as one vector constraint per inner edge, the rest shape
/// taken as flat. The paper's factor 3 belongs to Crouzeix-Raviart interpolation; on the vertices of a mesh
/// the energy D / 2 * |K x|^2 / (A0 + A1) is that of a plate bent to a cylinder (see MATH.md, section 5).
static void add_hinge(PercaleModel *model, const RestTriangle *rest, const uint32_t sides[2])
{
    const uint32_t *triangles = model->cloth.triangles;
    uint32_t hinge[4];
    double weights[4] = {0.0, 0.0, 0.0, 0.0};
    double area_sum = 0.0;
    hinge[0] = triangles[sides[0]];
    hinge[1] = triangles[sides[0] / 3 * 3 + next_corner(sides[0] % 3)];
    for (int k = 0; k < 2; k++) {
        uint32_t triangle = sides[k] / 3;
        uint32_t corner = sides[k] % 3;
        double area = (double)model->triangle_areas[triangle];
        double cotangents[2];
        side_cotangents(&rest[triangle], corner, area, cotangents);
        bool along = triangles[sides[k]] == hinge[0];
        weights[0] += along ? cotangents[1] : cotangents[0];
        weights[1] += along ? cotangents[0] : cotangents[1];
        weights[2 + k] = -(cotangents[0] + cotangents[1]);
        hinge[2 + k] = triangles[3 * triangle + next_corner(next_corner(corner))];
        area_sum += area;
    }
    double stiffness = 0.5 * ((double)rest[sides[0] / 3].stiffness + (double)rest[sides[1] / 3].stiffness);
    bool folded = hinge[2] == hinge[3]; // or a triangle that a seam between its own corners has made a line
    for (int k = 2; k < 4; k++) {
        folded = folded || hinge[k] == hinge[0] || hinge[k] == hinge[1];
    }
    if (stiffness <= 0.0 || folded) {
        return;
    }
    uint32_t h = model->hinge_count++;
    for (int k = 0; k < 4; k++) {
        model->hinges[h][k] = hinge[k];
        model->hinge_weights[h][k] = (float)weights[k];
    }
    model->hinge_weights[h][3] = -((model->hinge_weights[h][0] + model->hinge_weights[h][1]) +
                                   model->hinge_weights[h][2]); // the sum is 0 in float too
    model->hinge_stiffnesses[h] = (float)(stiffness / area_sum);
}

static bool build_hinges(PercaleModel *model, const PercaleEdges *edges, const RestTriangle *rest,
                         PercaleMemory *memory)
{
    uint32_t most = 0;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        most += edges->first_side[e + 1] - edges->first_side[e] - 1;
    }
    model->hinges = percale_memory_new(memory, most, sizeof(model->hinges[0]));
    model->hinge_weights = percale_memory_new(memory, most, sizeof(f32x4));
    model->hinge_stiffnesses = percale_memory_new(memory, most, sizeof(float));
    if (model->hinges == NULL || model->hinge_weights == NULL || model->hinge_stiffnesses == NULL) {
        return false;
    }
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        for (uint32_t i = edges->first_side[e]; i + 1 < edges->first_side[e + 1]; i++) {
            add_hinge(model, rest, edges->sides + i);
        }
    }
    return true;
}

static float mean_edge(const PercaleModel *model)
{
    double sum = 0.0;
    for (uint32_t e = 0; e < model->edge_count; e++) {
        sum += (double)model->edge_lengths[e];
    }
    return model->edge_count > 0 ? (float)(sum / model->edge_count) : 0.0f;
}

/// Tethers and coarse levels: along the triangles' sides, as each has them at rest.
static bool build_far(PercaleModel *model, const RestTriangle *rest, PercaleParts parts,
                      PercaleMemory *memory)
{
    bool levels = parts.levels > 0 && model->edge_compliances == NULL;
    if (!parts.tethers && !levels) {
        return true;
    }
    float(*lengths)[3] = percale_memory_new(memory, model->cloth.triangle_count, sizeof(lengths[0]));
    bool complete = lengths != NULL;
    for (uint32_t t = 0; complete && t < model->cloth.triangle_count; t++) {
        memcpy(lengths[t], rest[t].lengths, sizeof(lengths[t]));
    }
    PercaleGeodesicMesh mesh = {
        model->slot_count,          model->cloth.triangle_count,    model->cloth.triangles,
        (const float(*)[3])lengths, model->cloth.vertex_first_face, model->cloth.vertex_faces};
    complete = complete && (!parts.tethers || percale_tethers_build(model, &mesh, memory)) &&
               (!levels || percale_coarse_build(&model->coarse, &mesh, model->position, mean_edge(model),
                                                parts.levels, memory));
    percale_memory_free(memory, lengths);
    return complete;
}

bool percale_model_build_constraints(PercaleModel *model, const PercaleObjects *objects, PercaleParts parts,
                                     PercaleMemory *memory)
{
    PercaleModelSurface *cloth = &model->cloth;
    RestTriangle *rest = gather_rest(model, objects, memory);
    bool complete = rest != NULL &&
                    percale_edges_build(cloth->triangles, cloth->triangle_count, memory, &cloth->edges) &&
                    build_edges(model, &cloth->edges, rest, memory) &&
                    (!parts.bending || build_hinges(model, &cloth->edges, rest, memory)) &&
                    build_far(model, rest, parts, memory);
    if (!parts.pairs) {
        percale_edges_free(&cloth->edges, memory);
    }
    percale_memory_free(memory, rest);
    return complete;
}
