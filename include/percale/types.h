// types.h: definitions, handles, results, stages and counters of percale.
//
// Units are SI: metres, seconds, kilograms. Positions are float32 relative to the solver's `origin`.
// Every Def comes from its default function; set what you need and pass it on. Arrays named in a Def are
// read during the call only and stay the caller's.

#ifndef PERCALE_TYPES_H
#define PERCALE_TYPES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define PERCALE_API
#else
#define PERCALE_API __attribute__((visibility("default")))
#endif

#define PERCALE_VERSION_MAJOR 0
#define PERCALE_VERSION_MINOR 1
#define PERCALE_VERSION_PATCH 0

#define PERCALE_MAX_THREADS 256
#define PERCALE_MAX_LEVELS  8

/// What a call that can fail on the caller's data returns. The text with the culprit is in
/// percale_solver_last_error.
typedef enum PercaleResult {
    PERCALE_OK = 0,
    PERCALE_INVALID_ARGUMENT, ///< an argument or a mesh is unusable; nothing has changed
    PERCALE_INVALID_HANDLE,   ///< no such cloth, obstacle, pin or seam
    PERCALE_UNSUPPORTED,      ///< a feature that this version does not have
    PERCALE_OUT_OF_MEMORY,    ///< nothing has changed
    PERCALE_NOT_FINITE,       ///< the state would have become NaN or infinite; the last good substep is kept
    PERCALE_DEVICE_ERROR      ///< Embree reported an error
} PercaleResult;

typedef struct PercaleSolver PercaleSolver;

/// Handles. 0 is no object; a handle is never reused.
typedef struct PercaleCloth {
    uint32_t id;
} PercaleCloth;
typedef struct PercaleObstacle {
    uint32_t id;
} PercaleObstacle;
typedef struct PercalePin {
    uint32_t id;
} PercalePin;
typedef struct PercaleSeam {
    uint32_t id;
} PercaleSeam;

typedef void PercaleLogFunction(void *user, const char *text);
typedef void *PercaleAllocateFunction(void *user, size_t size, size_t alignment);
typedef void PercaleReleaseFunction(void *user, void *memory);

/// Continuous collision detection.
typedef enum PercaleCcd {
    PERCALE_CCD_OFF = 0,
    PERCALE_CCD_RAY,  ///< vertex paths cast with Embree in the frame of the obstacle
    PERCALE_CCD_EXACT ///< no rays, but conservative tests in double of straight ways, of obstacles as they
                      ///< move, too, and of cloth against cloth, edges included
} PercaleCcd;

/// When contact candidates are found anew.
typedef enum PercaleReuse {
    PERCALE_REUSE_AUTO = 0, ///< while the bound on the relative motion holds, they are kept
    PERCALE_REUSE_ALWAYS,   ///< never kept: every collision pass detects; the state is the same
    PERCALE_REUSE_AUDIT     ///< kept as with auto, and each pass detects pairs of the cloth anew beside that:
                            ///< what only this finds is counted as missed, and changes nothing
} PercaleReuse;

typedef enum PercaleIsa {
    PERCALE_ISA_AUTO = 0, ///< the widest that this machine and this build have
    PERCALE_ISA_SSE2,
    PERCALE_ISA_AVX2,
    PERCALE_ISA_AVX512
} PercaleIsa;

typedef struct PercaleSolverDef {
    uint32_t size;    ///< sizeof(PercaleSolverDef), set by the default function and checked
    double origin[3]; ///< m; the world position of the solver's (0, 0, 0): for the host, positions are
                      ///< relative to it
    float gravity[3]; ///< m/s^2
    float wind[3];    ///< m/s; velocity of the air; (0, 0, 0) means no air at all
    float damping;    ///< 1/s; velocities decay as exp(-damping t)
    float speed_max;  ///< m/s; a vertex is never faster than this
    int substeps;     ///< per step, 1..1000
    int iterations;   ///< solver sweeps per substep, 1..1000
    int passes;       ///< collision passes per step, 1..substeps * iterations; 0: one per substep
    int thread_count; ///< 1..PERCALE_MAX_THREADS
    PercaleReuse reuse;
    PercaleCcd ccd;
    PercaleIsa isa;
    int vertex_face;    ///< 1: cloth vertices collide with obstacles
    int edge_edge;      ///< 1: edges collide with edges, and obstacle vertices with cloth faces
    int self_collision; ///< 1: cloth collides with cloth; its edges too where edge_edge is 1
    int guard;          ///< 1: what has passed after the last sweep is put back; 0: left to the next contacts
    int guard_passes;   ///< 1: cloth is guarded from cloth, and from obstacles' edges, only when a collision
                      ///< pass is about to come and at the end of a step, over the whole way since; contacts
                      ///< of its features are those of the pass until then. 0: in each substep
    int untangle; ///< 1: cloth that goes through cloth it collides with is taken apart over the steps
    int tethers;  ///< 1: no vertex is farther from a pin than the cloth is long (where it has no compliance)
    int bending;  ///< 1: cloth resists bending
    int levels;   ///< 0..PERCALE_MAX_LEVELS; coarse levels of cloth without compliance, each with a sixteenth
                  ///< of the points of the one below, that are pulled to their lengths before each substep's
                  ///< sweeps: less stretch for little time (MATH.md, section 4); 3 suit 100,000 vertices
    PercaleLogFunction *log; ///< one line per error or warning, and where percale_solver_quality finds
                             ///< crossings, without a newline; NULL: silent
    void *log_user;
    /// May be called from the solver's worker threads: it has to be thread-safe. Memory is aligned as asked.
    PercaleAllocateFunction *allocate; ///< NULL: the C library's; both or none
    PercaleReleaseFunction *release;
    void *allocator_user;
} PercaleSolverDef;

typedef struct PercaleMaterial {
    float density;            ///< kg/m^2, > 0
    float stretch_compliance; ///< m/N, >= 0, along each edge; 0 is inextensible
    float bending_stiffness;  ///< N m, >= 0; flexural rigidity
    float thickness; ///< m; distance kept between two surfaces; 0: a fifth of the median rest edge (in
                     ///< percale_cloth_set_material: as before)
    float friction;  ///< Coulomb coefficient, >= 0; a pair takes the geometric mean
} PercaleMaterial;

typedef struct PercaleClothDef {
    uint32_t size;
    const char *name;       ///< for messages; may be NULL
    const float *positions; ///< [vertex_count] points of three floats, m
    size_t position_stride; ///< bytes from one point to the next; 0: 12
    uint32_t vertex_count;
    const uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
    const float *rest_positions; ///< rest shape, like positions; NULL: the positions
    size_t rest_stride;
    const float *rest_uvs;   ///< [2 * vertex_count] m; flat pattern as the rest shape; NULL: none
    const float *velocities; ///< m/s; NULL: at rest
    size_t velocity_stride;
    PercaleMaterial material;
    int32_t layer; ///< order from the body outwards: a cloth yields to those of lower layers, not they to it
    uint32_t mask; ///< two objects collide when their masks share a bit
} PercaleClothDef;

typedef struct PercaleObstacleDef {
    uint32_t size;
    const char *name;
    const float *positions;
    size_t position_stride;
    uint32_t vertex_count;
    const uint32_t *triangles; ///< counter-clockwise seen from the side where cloth may be
    uint32_t triangle_count;
    float friction;
    float thickness; ///< m; a pair keeps the mean of its two thicknesses
    uint32_t mask;
} PercaleObstacleDef;

/// Vertices of a cloth held at points that the caller moves.
typedef struct PercalePinDef {
    uint32_t size;
    PercaleCloth cloth;
    const uint32_t *vertices; ///< [vertex_count], the caller's vertex order
    uint32_t vertex_count;
    const float *targets; ///< [vertex_count] points, m; NULL: where the vertices are now
    size_t target_stride;
} PercalePinDef;

/// Pairs of vertices sewn together. A pair pulls itself shut; closed within 1 mm it becomes one point.
typedef struct PercaleSeamDef {
    uint32_t size;
    PercaleCloth cloth_a;
    PercaleCloth cloth_b;       ///< may be cloth_a
    const uint32_t *vertices_a; ///< [pair_count]
    const uint32_t *vertices_b; ///< [pair_count]
    uint32_t pair_count;
} PercaleSeamDef;

/// Zero-copy view of the state in solver order, valid until the next call that changes the solver.
typedef struct PercaleClothView {
    const float *positions;  ///< [4 * slot]: x, y, z (m, relative to origin), inverse mass (1/kg)
    const float *velocities; ///< [4 * slot]: x, y, z (m/s), unused
    const uint32_t *order;   ///< [vertex_count]: caller's vertex -> slot; many-to-one where seams have welded
    uint32_t vertex_count;
} PercaleClothView;

/// The stages of a step, in order; percale_stage_name gives their names.
typedef enum PercaleStage {
    PERCALE_STAGE_PREDICT = 0,
    PERCALE_STAGE_DETECT,
    PERCALE_STAGE_UNTANGLE,
    PERCALE_STAGE_COLOR,
    PERCALE_STAGE_SOLVE,
    PERCALE_STAGE_FINISH,
    PERCALE_STAGE_COUNT
} PercaleStage;

/// Wall-clock times of the last step.
typedef struct PercaleProfile {
    double stage_seconds[PERCALE_STAGE_COUNT];
    double step_seconds;
} PercaleProfile;

// The one list of work counters: X(name). The report writes them under these names, in this order.
#define PERCALE_COUNTERS(X) \
    X(projections)          \
    X(projections_stretch)  \
    X(projections_bend)     \
    X(projections_tether)   \
    X(projections_link)     \
    X(projections_seam)     \
    X(projections_contact)  \
    X(candidates)           \
    X(stencils_vf)          \
    X(stencils_ee)          \
    X(rays)                 \
    X(detections)           \
    X(detections_skipped)   \
    X(missed)               \
    X(born_crossed)         \
    X(pinched)              \
    X(left_inside)          \
    X(left_crossed)         \
    X(truncated)            \
    X(colors_max)           \
    X(overflow)             \
    X(last_crossed_frame)

/// Work done since the solver was created. born_crossed: edges and faces of the cloth that cross, and
/// nothing tells how that came (looked for where edge_edge is 1); pinched: cloth vertices that two surfaces
/// of obstacles left no room and that were held between them, in each substep; colors_max: the most colours
/// that contacts needed; last_crossed_frame: steps that were done when cloth was last seen to go through
/// cloth, as far as untangling looks (every triangle within 10 steps); 0 as well where that was at the start
/// or never; missed: with reuse=always, vertices near an obstacle that a kept bound of their distance would
/// have left out, with reuse=audit, stencils of pairs that kept candidates have left out (it is 0, or a
/// bound is wrong; with fewer passes than substeps, too); overflow: contacts that fitted into none; counters
/// of features that this version does not have stay 0.
typedef struct PercaleCounters {
#define PERCALE_COUNTER_FIELD(name) uint64_t name;
    PERCALE_COUNTERS(PERCALE_COUNTER_FIELD)
#undef PERCALE_COUNTER_FIELD
} PercaleCounters;

// The one list of quality figures: X(name).
#define PERCALE_QUALITIES(X)   \
    X(penetration_max_mm)      \
    X(penetration_p99_mm)      \
    X(penetration_obstacle_mm) \
    X(vertices_inside)         \
    X(ef_cloth_cloth)          \
    X(ef_cloth_obstacle)       \
    X(ef_seam)                 \
    X(stretch_max)             \
    X(stretch_p99)             \
    X(contact_fraction)        \
    X(nonfinite)

/// The audit's judgement of one state; counts are whole numbers.
///
/// penetration_max_mm, _p99_mm: depth of a cloth vertex below the obstacle's surface, over all cloth
/// vertices. penetration_obstacle_mm: how far an obstacle vertex stands out through the cloth: distance along
/// its inward normal, up to 20 mm and inside the body, to the first cloth triangle. vertices_inside: winding
/// number > 0.5 for closed obstacles, nearest feature's sign within 5 mm for open ones. ef_cloth_cloth,
/// ef_cloth_obstacle: pairs of triangles that share no (welded) vertex and cross; ef_seam: pairs that share a
/// sewn vertex and cross beside it, counted apart. stretch_max, stretch_p99: l / l0 - 1 over unique edges,
/// seams excluded. contact_fraction: share of cloth vertices within 1.5 thicknesses of an obstacle.
/// nonfinite: cloth vertices with a NaN or infinite coordinate.
typedef struct PercaleQuality {
#define PERCALE_QUALITY_FIELD(name) double name;
    PERCALE_QUALITIES(PERCALE_QUALITY_FIELD)
#undef PERCALE_QUALITY_FIELD
} PercaleQuality;

/// How percale_solver_untangle works.
typedef struct PercaleUntangleDef {
    uint32_t size;
    int rounds;   ///< 1..1000; looking and moving, at most so often
    int sweeps;   ///< 1..1000; over the constraints in each round, each after a collision pass of its own
    int patience; ///< 1..100; rounds without a better state after which it is left as it is
} PercaleUntangleDef;

/// What percale_solver_untangle has done. A contour is a curve along which two surfaces go through each
/// other.
typedef struct PercaleUntangleReport {
    uint64_t ef_before,
        ef_after; ///< pairs of triangles that share no point and cross; never more than before
    uint64_t contours_before, contours_after;
    double length_before, length_after; ///< m, of the contours
    int iterations;                     ///< rounds
    double momentum_drift;   ///< |sum m dx| / sum m |dx| over the cloths; 0 in exact arithmetic, but where
                             ///< obstacles or pins have held
    double displacement_max; ///< m
    double seconds;          ///< that it took
} PercaleUntangleReport;

/// Bytes in use, by owner.
typedef struct PercaleBytes {
    uint64_t model;
    uint64_t detect;
    uint64_t color;
    uint64_t solve;
    uint64_t arena;
} PercaleBytes;

/// One cloth or obstacle as the audit sees it: plain arrays, the caller's order.
typedef struct PercaleAuditMesh {
    const float *positions; ///< [3 * vertex_count] m
    uint32_t vertex_count;
    const uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
    const float *rest_lengths; ///< [3 * triangle_count] m; rest length of the edge from corner k to corner k
                               ///< + 1; NULL: no stretch is judged
    const uint32_t *weld; ///< [vertex_count] one number per welded point, shared across the cloths of the
                          ///< audit; NULL: nothing is sewn (welded points are numbered apart)
    float thickness;      ///< m
    uint32_t mask;
} PercaleAuditMesh;

#ifdef __cplusplus
}
#endif

#endif
