// mannequin.c: the walk moves bones, smooth weights carry the skin along (linear blend skinning).

#include "mannequin.h"

#include "body_field.h"
#include "iso_surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double CELL = 0.0150; // m; gives about 20,000 triangles
static const double BOX_LOWER[3] = {-0.72, -0.063125,
                                    -0.241875}; // m; holds the rest pose with a cell to spare
static const double BOX_UPPER[3] = {0.72, 1.77, 0.25};

static const double WEIGHT_REACH = 0.05; // m; a bone so much farther than the nearest has no say
static const int WEIGHT_SMOOTHINGS = 12; // rounds of averaging over the skin: a joint bends over about 10 cm

// The walk. Angles in radians, at full stride.
static const double TURN = 6.283185307179586;
static const double STRIDE_SECONDS = 1.1; // two steps
static const double BLEND_SECONDS = 0.9;  // from standing to full stride
static const double JUMP_TIME = 1.0;      // s
static const double JUMP_RATE = 60.0;     // 1/s; the jump is over within one frame

static const double HIP_SWING = 0.34;
static const double HIP_LEAN = 0.05;     // the legs swing about a little forward of vertical
static const double KNEE_BEND = 0.10;    // of the standing leg
static const double KNEE_LIFT = 0.75;    // more, when the leg comes forward
static const double KNEE_LEAD = 0.20;    // how long before mid-swing the knee is bent most
static const double ANKLE_SHARE = 0.70;  // of the leg's tilt that the ankle takes back
static const double PELVIS_TURN = 0.07;  // about y, towards the leg in front
static const double PELVIS_LIST = 0.035; // about z, down on the side of the swinging leg
static const double CHEST_TURN = 0.08;   // against the pelvis
static const double PELVIS_SWAY = 0.012; // m
static const double ARM_DROP = 0.10;     // from the A-pose; more would bring the hands to the skirt
static const double ARM_SWING = 0.22;
static const double ELBOW_BEND = 0.30;
static const double ELBOW_SWING = 0.15;
static const double HAND_BEND = 0.12;

// Points on a sole, left foot: heel, ball, toe. The lowest of the six stays on the floor.
#define SOLE_POINTS 3
static const double SOLE[SOLE_POINTS][3] = {
    {0.131, 0.004, -0.050}, {0.140, 0.003, 0.095}, {0.130, 0.004, 0.155}};
static const double FLOOR_SOFTNESS = 0.006; // m; how gently the weight goes from one foot to the other

struct PercaleMannequin {
    double jump;
    double speed;
    uint32_t vertex_count;
    float *rest;    ///< [3 * vertex_count] m
    float *weights; ///< [vertex_count][PERCALE_BONE_COUNT], each row sums to 1
};

typedef struct Turn {
    double m[3][3];
} Turn;

/// x -> turn x + shift
typedef struct Motion {
    Turn turn;
    double shift[3]; ///< m
} Motion;

static const Motion STILL = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0}};
static const double X_AXIS[3] = {1, 0, 0};
static const double Y_AXIS[3] = {0, 1, 0};
static const double Z_AXIS[3] = {0, 0, 1};

// ---- small linear algebra ----

static void apply(const Motion *motion, const double point[3], double moved[3])
{
    for (int i = 0; i < 3; i++) {
        const double *row = motion->turn.m[i];
        moved[i] = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + motion->shift[i];
    }
}

// Rotation by an angle about an axis of length 1 (Rodrigues).
static Turn rotation(const double axis[3], double angle)
{
    const double c = cos(angle);
    const double s = sin(angle);
    const double cross[3][3] = {{0, -axis[2], axis[1]}, {axis[2], 0, -axis[0]}, {-axis[1], axis[0], 0}};
    Turn turn;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            turn.m[i][j] = (i == j ? c : 0.0) + s * cross[i][j] + (1.0 - c) * axis[i] * axis[j];
        }
    }
    return turn;
}

// First b, then a.
static Turn product(Turn a, Turn b)
{
    Turn c;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
        }
    }
    return c;
}

// The bone turns about its joint, then goes where its parent goes.
static void hang_on(const Motion *parent, PercaleBone bone, Turn turn, Motion motions[PERCALE_BONE_COUNT])
{
    double joint[3];
    percale_bone_joint(bone, joint);
    const Motion about_zero = {turn, {0, 0, 0}};
    double turned[3];
    apply(&about_zero, joint, turned);
    const double shift[3] = {joint[0] - turned[0], joint[1] - turned[1], joint[2] - turned[2]};
    motions[bone].turn = product(parent->turn, turn);
    apply(parent, shift, motions[bone].shift);
}

// ---- the walk ----

// 0 before 0, 1 after 1, with no speed and no acceleration at either end.
static double ease_in(double t)
{
    const double s = fmin(fmax(t, 0.0), 1.0);
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

/// How far one side's joints are bent: positive is forward (hip, shoulder, elbow, ankle up), backward for the
/// knee.
typedef struct LimbAngles {
    double hip, knee, ankle, shoulder, drop, elbow, hand;
} LimbAngles;

static LimbAngles limb_angles(double phase, double amount)
{
    const double bend = 0.5 * (1.0 + cos(phase + KNEE_LEAD));
    LimbAngles a;
    a.hip = amount * (HIP_SWING * sin(phase) + HIP_LEAN);
    a.knee = amount * (KNEE_BEND + KNEE_LIFT * bend * bend);
    a.ankle = ANKLE_SHARE * (a.knee - a.hip);
    a.shoulder = -amount * ARM_SWING * sin(phase);
    a.drop = amount * ARM_DROP;
    a.elbow = amount * (ELBOW_BEND - ELBOW_SWING * sin(phase));
    a.hand = amount * HAND_BEND;
    return a;
}

// The axis about which an arm bends forward, right-handed: at right angles to its rest direction and the
// front.
static void forward_axis(PercaleBone bone, PercaleBone next, double axis[3])
{
    double from[3];
    double to[3];
    percale_bone_joint(bone, from);
    percale_bone_joint(next, to);
    const double x = to[0] - from[0];
    const double y = to[1] - from[1];
    const double length = sqrt(x * x + y * y);
    axis[0] = y / length;
    axis[1] = -x / length;
    axis[2] = 0.0;
}

static void pose_leg(int side, const LimbAngles *a, Motion motions[PERCALE_BONE_COUNT])
{
    const int right = side < 0 ? 1 : 0;
    const PercaleBone thigh = (PercaleBone)(PERCALE_BONE_THIGH + right);
    const PercaleBone shin = (PercaleBone)(PERCALE_BONE_SHIN + right);
    const PercaleBone foot = (PercaleBone)(PERCALE_BONE_FOOT + right);
    hang_on(&motions[PERCALE_BONE_PELVIS], thigh, rotation(X_AXIS, -a->hip), motions);
    hang_on(&motions[thigh], shin, rotation(X_AXIS, a->knee), motions);
    hang_on(&motions[shin], foot, rotation(X_AXIS, -a->ankle), motions);
}

static void pose_arm(int side, const LimbAngles *a, Motion motions[PERCALE_BONE_COUNT])
{
    const int right = side < 0 ? 1 : 0;
    const PercaleBone upper_arm = (PercaleBone)(PERCALE_BONE_UPPER_ARM + right);
    const PercaleBone forearm = (PercaleBone)(PERCALE_BONE_FOREARM + right);
    const PercaleBone hand = (PercaleBone)(PERCALE_BONE_HAND + right);
    const Turn swing = rotation(X_AXIS, -a->shoulder);
    const Turn drop = rotation(Z_AXIS, -side * a->drop);
    double axis[3];
    forward_axis(upper_arm, forearm, axis);
    hang_on(&motions[PERCALE_BONE_CHEST], upper_arm, product(swing, drop), motions);
    hang_on(&motions[upper_arm], forearm, rotation(axis, a->elbow), motions);
    hang_on(&motions[forearm], hand, rotation(axis, a->hand), motions);
}

// Height of the lowest sole point, smoothly.
static double floor_height(const Motion motions[PERCALE_BONE_COUNT])
{
    double sum = 0.0;
    for (int side = 1; side >= -1; side -= 2) {
        const Motion *foot = &motions[PERCALE_BONE_FOOT + (side < 0 ? 1 : 0)];
        for (int i = 0; i < SOLE_POINTS; i++) {
            const double point[3] = {side * SOLE[i][0], SOLE[i][1], SOLE[i][2]};
            double moved[3];
            apply(foot, point, moved);
            sum += exp(-moved[1] / FLOOR_SOFTNESS);
        }
    }
    return -FLOOR_SOFTNESS * log(sum);
}

static double standing_height(void)
{
    Motion motions[PERCALE_BONE_COUNT];
    motions[PERCALE_BONE_FOOT] = STILL;
    motions[PERCALE_BONE_FOOT_RIGHT] = STILL;
    return floor_height(motions);
}

// walked: s of the walk; the jump has its own clock.
static void pose_bones(double walked, double leap, Motion motions[PERCALE_BONE_COUNT])
{
    const double amount = ease_in(walked / BLEND_SECONDS);
    const double phase = TURN * (walked / STRIDE_SECONDS);
    const double forward = amount * sin(phase); // of the left leg
    const double aside = amount * cos(phase);

    const Turn pelvis =
        product(rotation(Y_AXIS, -PELVIS_TURN * forward), rotation(Z_AXIS, -PELVIS_LIST * aside));
    const Turn chest = product(rotation(Y_AXIS, CHEST_TURN * forward), rotation(Z_AXIS, PELVIS_LIST * aside));
    const Turn head = rotation(Y_AXIS, -(CHEST_TURN - PELVIS_TURN) * forward); // looks ahead
    hang_on(&STILL, PERCALE_BONE_PELVIS, pelvis, motions);
    hang_on(&motions[PERCALE_BONE_PELVIS], PERCALE_BONE_CHEST, chest, motions);
    hang_on(&motions[PERCALE_BONE_CHEST], PERCALE_BONE_HEAD, head, motions);
    for (int side = 1; side >= -1; side -= 2) {
        const LimbAngles angles = limb_angles(side > 0 ? phase : phase + 0.5 * TURN, amount);
        pose_leg(side, &angles, motions);
        pose_arm(side, &angles, motions);
    }

    const double lift = standing_height() - floor_height(motions);
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        motions[bone].shift[0] += leap - PELVIS_SWAY * aside;
        motions[bone].shift[1] += lift;
    }
}

// ---- skin ----

static void nearest_bone_weights(const float *rest, float *weights)
{
    const double point[3] = {(double)rest[0], (double)rest[1], (double)rest[2]};
    double distances[PERCALE_BONE_COUNT];
    percale_bone_distances(point, distances);
    double nearest = HUGE_VAL;
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        nearest = fmin(nearest, distances[bone]);
    }
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        const double w = fmax(1.0 - (distances[bone] - nearest) / WEIGHT_REACH, 0.0);
        weights[bone] = (float)(w * w);
    }
}

static void normalize(float *weights)
{
    double sum = 0.0;
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        sum += (double)weights[bone];
    }
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        weights[bone] = (float)((double)weights[bone] / sum);
    }
}

// Each round adds to every vertex's weights those of its neighbours.
static bool make_weights(PercaleMannequin *mannequin, const PercaleMesh *mesh)
{
    const size_t n = mesh->vertex_count;
    float *sums = malloc(n * PERCALE_BONE_COUNT * sizeof *sums);
    if (!sums) {
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        nearest_bone_weights(mannequin->rest + 3 * i, mannequin->weights + PERCALE_BONE_COUNT * i);
        normalize(mannequin->weights + PERCALE_BONE_COUNT * i);
    }
    for (int round = 0; round < WEIGHT_SMOOTHINGS; round++) {
        memcpy(sums, mannequin->weights, n * PERCALE_BONE_COUNT * sizeof *sums);
        for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
            const size_t next = i % 3 == 2 ? i - 2 : i + 1;
            float *sum = sums + PERCALE_BONE_COUNT * (size_t)mesh->triangles[i];
            const float *weights = mannequin->weights + PERCALE_BONE_COUNT * (size_t)mesh->triangles[next];
            for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
                sum[bone] += weights[bone];
            }
        }
        for (size_t i = 0; i < n; i++) {
            normalize(sums + PERCALE_BONE_COUNT * i);
        }
        memcpy(mannequin->weights, sums, n * PERCALE_BONE_COUNT * sizeof *sums);
    }
    free(sums);
    return true;
}

// Only how far the bones move the point is blended, so that the rest pose stays bit for bit what it is.
static void skin_point(const Motion motions[PERCALE_BONE_COUNT], const float *weights, double point[3])
{
    double shift[3] = {0, 0, 0};
    for (int bone = 0; bone < PERCALE_BONE_COUNT; bone++) {
        if (weights[bone] > 0.0F) {
            double moved[3];
            apply(&motions[bone], point, moved);
            for (int k = 0; k < 3; k++) {
                shift[k] += (double)weights[bone] * (moved[k] - point[k]);
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        point[k] += shift[k];
    }
}

void percale_mannequin_pose(const PercaleMannequin *mannequin, double seconds, float *positions)
{
    Motion motions[PERCALE_BONE_COUNT];
    const double since_start = fmax(seconds, 0.0);
    const double leap = mannequin->jump * fmin(fmax((since_start - JUMP_TIME) * JUMP_RATE, 0.0), 1.0);
    pose_bones(mannequin->speed * since_start, leap, motions);
    for (size_t i = 0; i < mannequin->vertex_count; i++) {
        const float *rest = mannequin->rest + 3 * i;
        double point[3] = {(double)rest[0], (double)rest[1], (double)rest[2]};
        skin_point(motions, mannequin->weights + PERCALE_BONE_COUNT * i, point);
        for (size_t k = 0; k < 3; k++) {
            positions[3 * i + k] = (float)point[k];
        }
    }
}

PercaleMannequin *percale_mannequin_make(double jump, double speed, PercaleMesh *mesh,
                                         PercaleSceneError *error)
{
    memset(mesh, 0, sizeof *mesh);
    if (!isfinite(jump)) {
        (void)snprintf(error->text, sizeof error->text, "mannequin: jump is not a finite number of metres");
        return NULL;
    }
    if (!isfinite(speed)) {
        (void)snprintf(error->text, sizeof error->text, "mannequin: speed is not a finite number");
        return NULL;
    }
    PercaleMannequin *mannequin = calloc(1, sizeof *mannequin);
    bool good = mannequin && percale_iso_surface(percale_body_field, BOX_LOWER, BOX_UPPER, CELL, mesh);
    if (good) {
        const size_t n = mesh->vertex_count;
        mannequin->jump = jump;
        mannequin->speed = speed;
        mannequin->vertex_count = mesh->vertex_count;
        mannequin->rest = malloc(3 * n * sizeof *mannequin->rest);
        mannequin->weights = malloc(n * PERCALE_BONE_COUNT * sizeof *mannequin->weights);
        mesh->name = malloc(sizeof "mannequin");
        good = mannequin->rest && mannequin->weights && mesh->name;
        if (good) {
            memcpy(mesh->name, "mannequin", sizeof "mannequin");
            memcpy(mannequin->rest, mesh->positions, 3 * n * sizeof *mannequin->rest);
            good = make_weights(mannequin, mesh);
        }
    }
    if (!good) {
        (void)snprintf(error->text, sizeof error->text, "mannequin: no skin could be made (out of memory)");
        percale_mannequin_free(mannequin);
        percale_mesh_free(mesh);
        return NULL;
    }
    return mannequin;
}

void percale_mannequin_free(PercaleMannequin *mannequin)
{
    if (mannequin) {
        free(mannequin->rest);
        free(mannequin->weights);
        free(mannequin);
    }
}
