// model.h: the scene as flat arrays, assembled from the objects that the caller added.
//
//   in   objects (the caller's order)
//   out  one array of points (cloth first, then obstacles), edges, hinges, open seams, obstacle meshes
//
// It is assembled anew when an object was added, removed or changed, when a seam has closed and after a
// failed step. Cloth vertices are renumbered along a space-filling curve; sewn vertices share one slot.

#ifndef PERCALE_MODEL_H
#define PERCALE_MODEL_H

#include "base/simd.h"
#include "model/coarse.h"
#include "model/mesh.h"
#include "model/near.h"
#include "model/object.h"

static const float SEAM_CLOSED = 1e-3f; // m; a sewn pair nearer than this becomes one point

typedef struct PercaleModelCloth {
    uint32_t *slots; // [vertex_count] caller's vertex -> slot
    uint32_t vertex_count;
    float thickness, friction;
    uint32_t mask;
    uint32_t rank; // of its layer among the cloths', from the body outwards
} PercaleModelCloth;

/// A triangle mesh that things collide with: an obstacle, or all cloth together.
typedef struct PercaleModelSurface {
    uint32_t first_point; // its vertices are points[first_point ..]
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t *triangles;         // [3 * triangle_count] points
    PercaleEdges edges;          // over its own vertex numbers
    uint32_t *vertex_first_face; // [vertex_count + 1] into vertex_faces
    uint32_t *vertex_faces;      // [3 * triangle_count] triangles around a vertex, ascending
    bool closed;                 // every edge has two triangles that run along it in opposite directions
    bool rigid, still;           // an obstacle that keeps its shape, and its place, too
    uint8_t *smooth_edges;       // [edges] of an obstacle, 1: two faces that turn by little, as added
    uint8_t *smooth_vertices;    // [vertex_count] of an obstacle, 1: all its edges are smooth
    float thickness, friction;
    uint32_t mask;
} PercaleModelSurface;

/// An unfinished seam pair.
typedef struct PercaleOpenSeam {
    uint32_t slots[2];
    uint32_t seam_index, pair_index; // of the object that it came from
} PercaleOpenSeam;

typedef struct PercaleModel {
    uint32_t slot_count;  // cloth points
    uint32_t point_count; // and obstacle points after them
    f32x4 *position;      // [point_count] m, inverse mass in 1/kg: the committed state
    f32x4 *velocity;      // [slot_count] m/s: committed
    f32x4 *predicted;     // [point_count] x*: where the running substep goes
    f32x4
        *next_velocity; // [slot_count] m/s; v*, which led to x* before any constraint; in finish the new one
    uint32_t *cloth_of; // [slot_count] index into cloths

    uint32_t cloth_count, obstacle_count;
    uint32_t rank_count; // of the cloths' layers
    PercaleModelCloth *cloths;
    PercaleModelSurface *obstacles;

    PercaleModelSurface cloth; // all cloth as a surface, with edges where pairs of features are looked for;
                               // its thickness, friction and mask are those of `cloths`
    float *triangle_areas;     // [cloth.triangle_count] m^2 at rest
    PercaleNear near;          // where pairs of features are looked for

    uint32_t edge_count;
    uint32_t (*edges)[2];    // [edge_count] slots; once batched, byte offsets of their points (see batch.h)
    float *edge_lengths;     // [edge_count] m at rest
    float *edge_compliances; // [edge_count] m/N; NULL when all are 0

    uint32_t hinge_count;
    uint32_t (*hinges)[4];    // [hinge_count] edge a, b, opposite c, d; slots or offsets like edges
    f32x4 *hinge_weights;     // [hinge_count] the bending vector is sum weights[k] x[hinges[k]]
    float *hinge_stiffnesses; // [hinge_count] N/m: flexural rigidity over the two areas

    uint32_t tether_layers; // tethers per slot; see tethers.h
    uint32_t tether_count;  // those that can act
    uint32_t
        *tether_anchors;   // [tether_layers * slot_count] byte offsets of the anchors' points; its own: none
    float *tether_lengths; // [tether_layers * slot_count] m; INFINITY: none

    PercaleCoarse coarse; // levels; once batched, links have byte offsets of their nodes

    uint32_t open_seam_count;
    PercaleOpenSeam *open_seams;

    uint32_t pinned_count;
    uint32_t *pinned_slots;        // [pinned_count]
    uint32_t (*pinned_sources)[2]; // [pinned_count] pin object's index, vertex in it
} PercaleModel;

/// The greatest thickness of a cloth, m.
static inline float thickest_cloth(const PercaleModel *model)
{
    float thickest = 0.0f;
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        thickest = fmaxf(thickest, model->cloths[c].thickness);
    }
    return thickest;
}

/// Byte offset of a slot's point, which is how kernels address it (it saves a shift for each point). So there
/// are at most POINTS_MAX points.
enum { POINT_BYTES = sizeof(f32x4), POINTS_MAX = (1 << 28) - 1 };

static inline uint32_t slot_at(uint32_t offset)
{
    return offset / POINT_BYTES;
}

/// What the solver asks for; the rest takes no memory.
typedef struct PercaleParts {
    bool bending, tethers;
    bool pairs;      // what cloth and edges need to collide with
    uint32_t levels; // coarse ones
} PercaleParts;

/// Builds the model; on failure it is left empty. Marks seam pairs that are closed as welded.
PercaleResult percale_model_assemble(PercaleModel *model, PercaleObjects *objects, PercaleParts parts,
                                     PercaleMemory *memory, PercaleMessage *message);

void percale_model_free(PercaleModel *model, PercaleMemory *memory);

/// Copies positions and velocities back into the objects.
void percale_model_store(const PercaleModel *model, PercaleObjects *objects);

/// Edges, hinges and their rest values (called by assemble); hinges and tethers where they are asked for.
bool percale_model_build_constraints(PercaleModel *model, const PercaleObjects *objects, PercaleParts parts,
                                     PercaleMemory *memory);

#endif
