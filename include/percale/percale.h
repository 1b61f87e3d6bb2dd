// percale.h: the functions of percale, fast and collision-true cloth on CPU cores.
//
// Pointers are never NULL unless a comment allows it.
//
// Create a solver, add cloths, obstacles, pins and seams, call percale_solver_step once per frame and read
// the positions back. Nothing here prints, exits or keeps global state; different solvers may be used from
// different host threads at the same time, one solver from one thread at a time. The host's OpenMP settings
// and its floating-point control word are as before when a call returns.

#ifndef PERCALE_H
#define PERCALE_H

#include "percale/types.h"

#ifdef __cplusplus
extern "C" {
#endif

PERCALE_API const char *percale_version(void);                       ///< "0.1.0"
PERCALE_API const char *percale_result_string(PercaleResult result); ///< never NULL
PERCALE_API const char *percale_stage_name(PercaleStage stage);      ///< never NULL

// ---- solver ----

PERCALE_API PercaleSolverDef percale_solver_def_default(void);

/// Creates an empty scene. On failure *solver is NULL and the reason goes to def.log.
PERCALE_API PercaleResult percale_solver_create(PercaleSolverDef def, PercaleSolver **solver);
PERCALE_API void percale_solver_destroy(PercaleSolver *solver); ///< NULL is allowed

/// Advances the scene by `seconds` (> 0), in `substeps` equal parts. On failure the scene stays at the last
/// good substep, and the vertex or object at fault is named in percale_solver_last_error.
PERCALE_API PercaleResult percale_solver_step(PercaleSolver *solver, double seconds);

PERCALE_API PercaleResult percale_solver_set_thread_count(PercaleSolver *solver, int thread_count);
PERCALE_API PercaleProfile percale_solver_profile(const PercaleSolver *solver);
PERCALE_API PercaleCounters percale_solver_counters(const PercaleSolver *solver);
PERCALE_API PercaleBytes percale_solver_bytes(const PercaleSolver *solver);
PERCALE_API PercaleIsa percale_solver_isa(const PercaleSolver *solver); ///< the one in use, never AUTO

/// Judges the current state with the independent audit; takes far longer than a step.
PERCALE_API PercaleResult percale_solver_quality(PercaleSolver *solver, PercaleQuality *quality);

/// 64-bit digest over positions and velocities of all cloths in the caller's order: equal for any thread
/// count, compiler and instruction set (on the same C library: exp and atan2 take part).
PERCALE_API uint64_t percale_solver_hash(PercaleSolver *solver);

/// Checks the assembled model: finite points, masses, slots, indices and colours of the cloth's constraints;
/// the first violation is named in last_error.
PERCALE_API PercaleResult percale_solver_validate(PercaleSolver *solver);

/// Text of the last failed call on this solver, "" if the last step was good; valid until the next call.
PERCALE_API const char *percale_solver_last_error(const PercaleSolver *solver);

// ---- cloth ----

PERCALE_API PercaleMaterial percale_material_default(void);
PERCALE_API PercaleClothDef percale_cloth_def_default(void);
PERCALE_API PercaleResult percale_cloth_add(PercaleSolver *solver, const PercaleClothDef *def,
                                            PercaleCloth *cloth);
/// Also removes its pins and seams.
PERCALE_API PercaleResult percale_cloth_remove(PercaleSolver *solver, PercaleCloth cloth);
/// Copies positions (m) in the caller's order; stride in bytes, 0: 12.
PERCALE_API PercaleResult percale_cloth_get_positions(PercaleSolver *solver, PercaleCloth cloth,
                                                      float *positions, size_t stride);
PERCALE_API PercaleResult percale_cloth_get_velocities(PercaleSolver *solver, PercaleCloth cloth,
                                                       float *velocities, size_t stride);
/// Teleports: velocities and pins stay. Sewn vertices get the mean of their positions.
PERCALE_API PercaleResult percale_cloth_set_positions(PercaleSolver *solver, PercaleCloth cloth,
                                                      const float *positions, size_t stride);
PERCALE_API PercaleResult percale_cloth_set_velocities(PercaleSolver *solver, PercaleCloth cloth,
                                                       const float *velocities, size_t stride);
PERCALE_API PercaleResult percale_cloth_view(PercaleSolver *solver, PercaleCloth cloth,
                                             PercaleClothView *view);
PERCALE_API PercaleResult percale_cloth_set_material(PercaleSolver *solver, PercaleCloth cloth,
                                                     PercaleMaterial material);
PERCALE_API PercaleResult percale_cloth_set_layer(PercaleSolver *solver, PercaleCloth cloth, int32_t layer);
PERCALE_API PercaleResult percale_cloth_set_mask(PercaleSolver *solver, PercaleCloth cloth, uint32_t mask);

// ---- obstacle ----

PERCALE_API PercaleObstacleDef percale_obstacle_def_default(void);
PERCALE_API PercaleResult percale_obstacle_add(PercaleSolver *solver, const PercaleObstacleDef *def,
                                               PercaleObstacle *obstacle);
PERCALE_API PercaleResult percale_obstacle_remove(PercaleSolver *solver, PercaleObstacle obstacle);
/// Where its vertices are to be at the end of the next step; they go there in a straight line. With
/// `velocities`, theirs at that moment in m/s, they go along the cubic that begins with those of the step
/// before, or along the chord without such (Hermite): straight lines cut the corners of a limb that turns,
/// 7 mm of a metre in 13 degrees a step. An obstacle that is not moved again stands still.
PERCALE_API PercaleResult percale_obstacle_move(PercaleSolver *solver, PercaleObstacle obstacle,
                                                const float *positions, size_t stride,
                                                const float *velocities, size_t velocity_stride);
/// Rigid motion to the pose x -> rotation * x + translation of the positions it was added with, at the end of
/// the next step, interpolated as a rotation. `rotation` is a quaternion (x, y, z, w), normalised here.
/// An obstacle once moved by percale_obstacle_move can't be moved rigidly again.
PERCALE_API PercaleResult percale_obstacle_set_transform(PercaleSolver *solver, PercaleObstacle obstacle,
                                                         const double rotation[4],
                                                         const double translation[3]);

// ---- pin ----

PERCALE_API PercalePinDef percale_pin_def_default(void);
PERCALE_API PercaleResult percale_pin_add(PercaleSolver *solver, const PercalePinDef *def, PercalePin *pin);
PERCALE_API PercaleResult percale_pin_remove(PercaleSolver *solver, PercalePin pin);
/// Where the pinned vertices are to be at the end of the next step, in the order of the Def.
PERCALE_API PercaleResult percale_pin_move(PercaleSolver *solver, PercalePin pin, const float *targets,
                                           size_t stride);

// ---- seam ----

PERCALE_API PercaleSeamDef percale_seam_def_default(void);
PERCALE_API PercaleResult percale_seam_add(PercaleSolver *solver, const PercaleSeamDef *def,
                                           PercaleSeam *seam);
/// Cuts the seam open again; welded points part where they are.
PERCALE_API PercaleResult percale_seam_remove(PercaleSolver *solver, PercaleSeam seam);

// ---- untangle ----

PERCALE_API PercaleUntangleDef percale_untangle_def_default(void);

/// Takes cloth apart that goes through cloth or obstacles, as far as it comes apart; what remains is in the
/// report and no error. Only positions change, those of obstacles and pinned vertices don't; velocities stay,
/// since a correction is no motion. Inside of closed obstacles, behind open ones and on the wrong side of the
/// next lower layer is wrong; else the smaller of the parts that a contour cuts off; where it cuts off
/// nothing, it is made shorter (Baraff et al. 2003; Volino and Magnenat-Thalmann 2006; MATH.md, section 10).
PERCALE_API PercaleResult percale_solver_untangle(PercaleSolver *solver, const PercaleUntangleDef *def,
                                                  PercaleUntangleReport *report);

// ---- audit ----

/// Judges any state, without a solver: crossings, penetration, stretch. Fails only without memory.
PERCALE_API PercaleResult percale_audit(const PercaleAuditMesh *cloths, uint32_t cloth_count,
                                        const PercaleAuditMesh *obstacles, uint32_t obstacle_count,
                                        PercaleQuality *quality);

/// Per-vertex depth below the obstacles' surfaces, m, 0 where outside: what a picture colours.
PERCALE_API PercaleResult percale_audit_penetration(const PercaleAuditMesh *cloth,
                                                    const PercaleAuditMesh *obstacles,
                                                    uint32_t obstacle_count, float *depths);

#ifdef __cplusplus
}
#endif

#endif
