// body_field.h: the mannequin in its rest pose as a signed distance field: a smooth union of round cones.
//
//   in   a point, m (y up, feet on y = 0, facing +z, left is +x)
//   out  distance to the skin, negative inside; never more than the true distance
//
// The mannequin's mesh is its zero level, the dress's bodice a level just outside; the skeleton that carries
// both stands here too. Only + - * / and square roots: the same bits from every compiler.

#ifndef PERCALE_BODY_FIELD_H
#define PERCALE_BODY_FIELD_H

#include <stdint.h>

/// Bones, parents first. Left is +x; a left bone's mirror image follows it.
typedef enum PercaleBone {
    PERCALE_BONE_PELVIS = 0,
    PERCALE_BONE_CHEST,
    PERCALE_BONE_HEAD,
    PERCALE_BONE_UPPER_ARM,
    PERCALE_BONE_UPPER_ARM_RIGHT,
    PERCALE_BONE_FOREARM,
    PERCALE_BONE_FOREARM_RIGHT,
    PERCALE_BONE_HAND,
    PERCALE_BONE_HAND_RIGHT,
    PERCALE_BONE_THIGH,
    PERCALE_BONE_THIGH_RIGHT,
    PERCALE_BONE_SHIN,
    PERCALE_BONE_SHIN_RIGHT,
    PERCALE_BONE_FOOT,
    PERCALE_BONE_FOOT_RIGHT,
    PERCALE_BONE_COUNT
} PercaleBone;

/// The convex hull of two balls, and how softly it melts into what comes before it in the list.
typedef struct PercaleRoundCone {
    double start[3], end[3];         ///< m
    double start_radius, end_radius; ///< m
    double blend;                    ///< m; width of the smooth union
    PercaleBone bone;                ///< the bone that carries it
} PercaleRoundCone;

/// Where a bone turns, m, in the rest pose.
void percale_bone_joint(PercaleBone bone, double joint[3]);

/// The bone that a bone hangs on; the pelvis is its own.
PercaleBone percale_bone_parent(PercaleBone bone);

/// Distance to one round cone; its gradient has length 1.
double percale_round_cone_distance(const PercaleRoundCone *cone, const double point[3], double gradient[3]);

/// Quadratic smooth minimum: joins the field `other` into `value`, gradients alike. Equal to the smaller one
/// where they differ by more than `blend`, lower by at most blend / 4 where they are equal.
void percale_smooth_union(double *value, double gradient[3], double other, const double other_gradient[3],
                          double blend);

/// The whole body.
double percale_body_field(const double point[3], double gradient[3]);

/// Trunk, neck and upper arms alone, upper arms' elbow ends wider by `arm_ease`, arms joined to the trunk
/// with `arm_blend` (at least the body's own): never above the body's field where there is nothing but these.
double percale_bodice_field(const double point[3], double arm_ease, double arm_blend, double gradient[3]);

/// Distance to the nearest round cone that each bone carries.
void percale_bone_distances(const double point[3], double distances[PERCALE_BONE_COUNT]);

#endif
