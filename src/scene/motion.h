// motion.h: where the points of an obstacle or of a group of pins are at a frame.
//
//   in   a PC2 file, an OBJ sequence, or a figure that is computed
//   out  positions relative to the origin, float32
//
// Sample k is frame k of the scene; past the last sample nothing moves any more. The coordinates of OBJ files
// are world coordinates, those of PC2 files are relative to the origin; both are scaled,
// turned and shifted in the world.

#ifndef PERCALE_MOTION_H
#define PERCALE_MOTION_H

#include "percale/scene.h"

typedef struct PercaleTransform {
    double matrix[3][3]; ///< rotation times scale
    double translation[3];
} PercaleTransform;

PercaleTransform percale_transform_identity(void);
/// Scale, then rotation about x, then y, then z by `degrees`, then translation.
PercaleTransform percale_transform_make(double scale, const double degrees[3], const double translation[3]);
/// The same transform between coordinates as they are in a file and coordinates relative to origin;
/// `relative`: the file's are relative to the origin too.
PercaleTransform percale_transform_from_file(const PercaleTransform *transform, const double origin[3],
                                             bool relative);
void percale_transform_point(const PercaleTransform *transform, const double from[3], float to[3]);

/// A figure's pose; positions [3 * vertex_count].
typedef void PercalePoseFunction(const void *figure, double seconds, float *positions);
typedef void PercaleFigureRelease(void *figure);

/// Zeroed: nothing moves. Either samples from files or a figure.
typedef struct PercaleMotion {
    PercalePointCache cache; ///< PC2; samples NULL: none
    double *world;           ///< [sample_count][3 * vertex_count] of an OBJ sequence; NULL: none
    uint32_t vertex_count;
    uint32_t sample_count; ///< 0: no samples
    void *figure;
    PercalePoseFunction *pose;
    PercaleFigureRelease *release;
    uint32_t current; ///< the sample that the points were last moved to
} PercaleMotion;

/// Reads "name.pc2", or the OBJ sequence "name_%04d.obj" from number 0 up to the last one there. The count of
/// its points must be `vertex_count`.
bool percale_motion_read(const char *path, uint32_t vertex_count, PercaleMotion *motion,
                         PercaleSceneError *error);
void percale_motion_free(PercaleMotion *motion); ///< leaves it zeroed

/// Whether the points ever move.
bool percale_motion_given(const PercaleMotion *motion);
/// Whether the points are somewhere else at `frame` than where they were last moved to.
bool percale_motion_changes(const PercaleMotion *motion, uint32_t frame);
/// Positions at `frame` (the last sample held), which counts as moved to.
void percale_motion_pose(PercaleMotion *motion, uint32_t frame, double frame_rate,
                         const PercaleTransform *transform, const double origin[3], float *positions);

#endif
