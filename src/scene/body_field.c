#include "body_field.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// ---- the figure: a woman of 1.70 m in an A-pose, arms 45 degrees below the horizontal ----

/// Cones that melt into each other, then the group as a whole into the groups before it.
typedef struct Group {
    const PercaleRoundCone *cones;
    size_t cone_count;
    double center[3]; ///< m; a ball that holds the group, so that far points skip it
    double radius;    ///< m
    double blend;     ///< m; of the whole group with what comes before
    bool mirrored;    ///< stands for a left and a right one
} Group;

static const PercaleRoundCone TRUNK[] = {
    {{0, 0.94, -0.005}, {0, 1.09, 0.000}, 0.098, 0.074, 0.00, PERCALE_BONE_PELVIS},
    {{0, 1.09, 0.000}, {0, 1.29, -0.012}, 0.074, 0.096, 0.055, PERCALE_BONE_CHEST},
    {{0.064, 0.93, -0.005}, {0.041, 1.09, 0.000}, 0.096, 0.072, 0.04, PERCALE_BONE_PELVIS},
    {{-0.064, 0.93, -0.005}, {-0.041, 1.09, 0.000}, 0.096, 0.072, 0.04, PERCALE_BONE_PELVIS},
    {{0.041, 1.09, 0.000}, {0.058, 1.29, -0.012}, 0.072, 0.092, 0.055, PERCALE_BONE_CHEST},
    {{-0.041, 1.09, 0.000}, {-0.058, 1.29, -0.012}, 0.072, 0.092, 0.055, PERCALE_BONE_CHEST},
    // bust
    {{0.060, 1.275, 0.040}, {0.064, 1.240, 0.062}, 0.052, 0.050, 0.05, PERCALE_BONE_CHEST},
    {{-0.060, 1.275, 0.040}, {-0.064, 1.240, 0.062}, 0.052, 0.050, 0.05, PERCALE_BONE_CHEST},
    // seat
    {{0.056, 0.910, -0.048}, {0.060, 0.870, -0.045}, 0.078, 0.074, 0.05, PERCALE_BONE_PELVIS},
    {{-0.056, 0.910, -0.048}, {-0.060, 0.870, -0.045}, 0.078, 0.074, 0.05, PERCALE_BONE_PELVIS},
    // shoulder girdle
    {{0.020, 1.380, -0.020}, {0.136, 1.354, -0.016}, 0.058, 0.050, 0.05, PERCALE_BONE_CHEST},
    {{-0.020, 1.380, -0.020}, {-0.136, 1.354, -0.016}, 0.058, 0.050, 0.05, PERCALE_BONE_CHEST},
    {{0.026, 1.440, -0.030}, {0.095, 1.392, -0.022}, 0.030, 0.028, 0.05, PERCALE_BONE_CHEST},
    {{-0.026, 1.440, -0.030}, {-0.095, 1.392, -0.022}, 0.030, 0.028, 0.05, PERCALE_BONE_CHEST},
    // neck
    {{0, 1.400, -0.018}, {0, 1.535, 0.000}, 0.053, 0.047, 0.05, PERCALE_BONE_HEAD},
};

static const PercaleRoundCone HEAD[] = {
    {{0, 1.618, -0.018}, {0, 1.612, 0.014}, 0.084, 0.078, 0.00, PERCALE_BONE_HEAD},
    {{0, 1.598, 0.026}, {0, 1.546, 0.046}, 0.060, 0.041, 0.05, PERCALE_BONE_HEAD},
};

static const PercaleRoundCone UPPER_ARM[] = {
    {{0.166, 1.350, -0.014}, {0.357, 1.159, -0.014}, 0.050, 0.034, 0.00, PERCALE_BONE_UPPER_ARM},
};

static const PercaleRoundCone LOWER_ARM[] = {
    {{0.357, 1.159, -0.014}, {0.407, 1.107, -0.005}, 0.033, 0.035, 0.00, PERCALE_BONE_FOREARM},
    {{0.407, 1.107, -0.005}, {0.528, 0.985, 0.016}, 0.034, 0.023, 0.006, PERCALE_BONE_FOREARM},
    // palm, fingers, thumb
    {{0.535, 0.978, 0.008}, {0.578, 0.929, 0.006}, 0.022, 0.018, 0.02, PERCALE_BONE_HAND},
    {{0.535, 0.978, 0.028}, {0.580, 0.929, 0.042}, 0.022, 0.018, 0.02, PERCALE_BONE_HAND},
    {{0.578, 0.929, 0.010}, {0.618, 0.875, 0.018}, 0.018, 0.015, 0.02, PERCALE_BONE_HAND},
    {{0.580, 0.929, 0.038}, {0.620, 0.873, 0.038}, 0.018, 0.015, 0.02, PERCALE_BONE_HAND},
    {{0.543, 0.969, 0.040}, {0.566, 0.922, 0.068}, 0.018, 0.016, 0.02, PERCALE_BONE_HAND},
};

static const PercaleRoundCone LEG[] = {
    {{0.093, 0.880, 0.000}, {0.112, 0.490, 0.004}, 0.087, 0.048, 0.00, PERCALE_BONE_THIGH},
    {{0.112, 0.490, 0.004}, {0.119, 0.360, -0.016}, 0.047, 0.046, 0.010, PERCALE_BONE_SHIN},
    {{0.119, 0.360, -0.016}, {0.130, 0.090, -0.022}, 0.046, 0.029, 0.008, PERCALE_BONE_SHIN},
    {{0.130, 0.085, -0.022}, {0.131, 0.040, -0.038}, 0.032, 0.034, 0.02, PERCALE_BONE_FOOT},
    {{0.130, 0.070, -0.015}, {0.138, 0.034, 0.100}, 0.038, 0.028, 0.03, PERCALE_BONE_FOOT},
    {{0.125, 0.031, 0.095}, {0.132, 0.027, 0.155}, 0.028, 0.021, 0.02, PERCALE_BONE_FOOT},
    {{0.152, 0.030, 0.085}, {0.150, 0.026, 0.145}, 0.027, 0.020, 0.03, PERCALE_BONE_FOOT},
};

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const double ARM_BLEND = 0.035; // m; how far the armpit's web reaches

// The first two groups are what a bodice covers, with the head's neck; the arm below the elbow is skipped.
static const Group TRUNK_GROUP = {TRUNK, COUNT(TRUNK), {0, 1.19, 0}, 0.45, 0.0, false};
static const Group UPPER_ARM_GROUP = {UPPER_ARM, COUNT(UPPER_ARM), {0.262, 1.255, -0.014}, 0.20, 0.0, true};
static const Group LOWER_GROUPS[] = {
    {HEAD, COUNT(HEAD), {0, 1.60, 0.01}, 0.14, 0.03, false},
    {LOWER_ARM, COUNT(LOWER_ARM), {0.49, 1.02, 0.01}, 0.24, 0.006, true},
    {LEG, COUNT(LEG), {0.11, 0.48, 0.0}, 0.53, 0.04, true},
};

// ---- skeleton ----

typedef struct Joint {
    double position[3]; ///< m, the left one
    PercaleBone parent; ///< of the left one
    bool paired;        ///< the next entry is its mirror image
} Joint;

static const Joint JOINTS[PERCALE_BONE_COUNT] = {
    [PERCALE_BONE_PELVIS] = {{0, 0.95, -0.005}, PERCALE_BONE_PELVIS, false},
    [PERCALE_BONE_CHEST] = {{0, 1.09, -0.005}, PERCALE_BONE_PELVIS, false},
    [PERCALE_BONE_HEAD] = {{0, 1.45, -0.012}, PERCALE_BONE_CHEST, false},
    [PERCALE_BONE_UPPER_ARM] = {{0.158, 1.358, -0.014}, PERCALE_BONE_CHEST, true},
    [PERCALE_BONE_FOREARM] = {{0.357, 1.159, -0.014}, PERCALE_BONE_UPPER_ARM, true},
    [PERCALE_BONE_HAND] = {{0.531, 0.982, 0.017}, PERCALE_BONE_FOREARM, true},
    [PERCALE_BONE_THIGH] = {{0.090, 0.900, 0.000}, PERCALE_BONE_PELVIS, true},
    [PERCALE_BONE_SHIN] = {{0.112, 0.490, 0.000}, PERCALE_BONE_THIGH, true},
    [PERCALE_BONE_FOOT] = {{0.130, 0.085, -0.022}, PERCALE_BONE_SHIN, true},
};

static bool is_right(PercaleBone bone)
{
    return bone > PERCALE_BONE_PELVIS && JOINTS[bone - 1].paired;
}

static PercaleBone mirrored_bone(PercaleBone bone)
{
    return JOINTS[bone].paired ? (PercaleBone)(bone + 1) : bone;
}

void percale_bone_joint(PercaleBone bone, double joint[3])
{
    const bool right = is_right(bone);
    const double *left = JOINTS[right ? bone - 1 : bone].position;
    joint[0] = right ? -left[0] : left[0];
    joint[1] = left[1];
    joint[2] = left[2];
}

PercaleBone percale_bone_parent(PercaleBone bone)
{
    if (!is_right(bone)) {
        return JOINTS[bone].parent;
    }
    return mirrored_bone(JOINTS[bone - 1].parent);
}

// ---- distances ----

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Not fmax: a call for its treatment of NaN.
static double larger(double a, double b)
{
    return a > b ? a : b;
}

/// To [0, 1].
static double clamped(double t)
{
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

// The nearest ball of the cone is the one that minimises |p - center(t)| - radius(t) over t in [0, 1]; with
// x along the axis, y off it and the taper k = (r0 - r1) / length, that is t length = x + y k / sqrt(1 -
// k^2).
double percale_round_cone_distance(const PercaleRoundCone *cone, const double point[3], double gradient[3])
{
    const double axis[3] = {cone->end[0] - cone->start[0], cone->end[1] - cone->start[1],
                            cone->end[2] - cone->start[2]};
    const double from_start[3] = {point[0] - cone->start[0], point[1] - cone->start[1],
                                  point[2] - cone->start[2]};
    const double length = sqrt(dot(axis, axis));
    const double along = dot(from_start, axis) / length;
    const double off = sqrt(larger(dot(from_start, from_start) - along * along, 0.0));
    const double taper = (cone->start_radius - cone->end_radius) / length;
    const double t = clamped((along + off * taper / sqrt(1.0 - taper * taper)) / length);
    const double offset[3] = {from_start[0] - t * axis[0], from_start[1] - t * axis[1],
                              from_start[2] - t * axis[2]};
    const double distance = sqrt(dot(offset, offset));
    for (int k = 0; k < 3; k++) {
        gradient[k] = distance > 0.0 ? offset[k] / distance : (k == 1 ? 1.0 : 0.0);
    }
    return distance - (cone->start_radius + t * (cone->end_radius - cone->start_radius));
}

void percale_smooth_union(double *value, double gradient[3], double other, const double other_gradient[3],
                          double blend)
{
    const double gap = fabs(*value - other);
    const double overlap = gap < blend ? (blend - gap) / blend : 0.0;
    const double far_weight = 0.5 * overlap;
    const double other_weight = other < *value ? 1.0 - far_weight : far_weight;
    *value = (other < *value ? other : *value) - 0.25 * overlap * overlap * blend;
    for (int k = 0; k < 3; k++) {
        gradient[k] += other_weight * (other_gradient[k] - gradient[k]);
    }
}

/// Whether all balls of a cone, taken as large as its largest, are farther from the point than `limit`, m.
static bool is_beyond(const PercaleRoundCone *cone, const double point[3], double limit)
{
    static const double ROUNDING = 1e-9; // m
    const double axis[3] = {cone->end[0] - cone->start[0], cone->end[1] - cone->start[1],
                            cone->end[2] - cone->start[2]};
    const double from_start[3] = {point[0] - cone->start[0], point[1] - cone->start[1],
                                  point[2] - cone->start[2]};
    const double along = dot(from_start, axis) / dot(axis, axis);
    const double t = clamped(along);
    const double offset[3] = {from_start[0] - t * axis[0], from_start[1] - t * axis[1],
                              from_start[2] - t * axis[2]};
    const double reach = limit + larger(cone->start_radius, cone->end_radius) + ROUNDING;
    return reach < 0.0 || dot(offset, offset) > reach * reach;
}

// A cone too far to matter is skipped, as in join_group.
static double group_field(const Group *group, const double point[3], double gradient[3])
{
    double value = percale_round_cone_distance(&group->cones[0], point, gradient);
    for (size_t i = 1; i < group->cone_count; i++) {
        if (is_beyond(&group->cones[i], point, value + group->cones[i].blend)) {
            continue;
        }
        double cone_gradient[3];
        const double distance = percale_round_cone_distance(&group->cones[i], point, cone_gradient);
        percale_smooth_union(&value, gradient, distance, cone_gradient, group->cones[i].blend);
    }
    return value;
}

static double distance_to(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(d, d));
}

// Joins one group, on both sides if it is mirrored. A group too far to matter is skipped: that changes
// nothing, since the smooth union is the plain minimum there.
static void join_group(const Group *group, const double point[3], double blend, double *value,
                       double gradient[3])
{
    for (int side = 1; side >= (group->mirrored ? -1 : 1); side -= 2) {
        const double mirrored[3] = {side * point[0], point[1], point[2]};
        if (distance_to(mirrored, group->center) - group->radius > *value + blend) {
            continue;
        }
        double group_gradient[3];
        const double distance = group_field(group, mirrored, group_gradient);
        group_gradient[0] *= side;
        percale_smooth_union(value, gradient, distance, group_gradient, blend);
    }
}

double percale_body_field(const double point[3], double gradient[3])
{
    double value = group_field(&TRUNK_GROUP, point, gradient);
    join_group(&UPPER_ARM_GROUP, point, ARM_BLEND, &value, gradient);
    for (size_t i = 0; i < COUNT(LOWER_GROUPS); i++) {
        join_group(&LOWER_GROUPS[i], point, LOWER_GROUPS[i].blend, &value, gradient);
    }
    return value;
}

double percale_bodice_field(const double point[3], double arm_ease, double arm_blend, double gradient[3])
{
    PercaleRoundCone sleeve = UPPER_ARM[0];
    sleeve.end_radius += arm_ease;
    Group sleeve_group = UPPER_ARM_GROUP;
    sleeve_group.cones = &sleeve;
    sleeve_group.radius += arm_ease;
    double value = group_field(&TRUNK_GROUP, point, gradient);
    join_group(&sleeve_group, point, fmax(arm_blend, ARM_BLEND), &value, gradient);
    return value;
}

static void lower_bone_distances(const Group *group, const double point[3], int side,
                                 double distances[PERCALE_BONE_COUNT])
{
    const double mirrored[3] = {side * point[0], point[1], point[2]};
    for (size_t i = 0; i < group->cone_count; i++) {
        const PercaleBone left = group->cones[i].bone;
        const PercaleBone bone = side > 0 ? left : mirrored_bone(left);
        double gradient[3];
        const double distance = percale_round_cone_distance(&group->cones[i], mirrored, gradient);
        distances[bone] = fmin(distances[bone], distance);
    }
}

void percale_bone_distances(const double point[3], double distances[PERCALE_BONE_COUNT])
{
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        distances[bone] = HUGE_VAL;
    }
    lower_bone_distances(&TRUNK_GROUP, point, 1, distances);
    lower_bone_distances(&UPPER_ARM_GROUP, point, 1, distances);
    lower_bone_distances(&UPPER_ARM_GROUP, point, -1, distances);
    for (size_t i = 0; i < COUNT(LOWER_GROUPS); i++) {
        lower_bone_distances(&LOWER_GROUPS[i], point, 1, distances);
        if (LOWER_GROUPS[i].mirrored) {
            lower_bone_distances(&LOWER_GROUPS[i], point, -1, distances);
        }
    }
}
