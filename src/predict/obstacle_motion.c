#include "predict/obstacle_motion.h"

#include "base/parallel.h"
#include "base/reduce.h"

static void blend(const double a[4], const double b[4], double t, double sign, double out[4])
{
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        out[k] = (1.0 - t) * a[k] + t * sign * b[k];
        sum += out[k] * out[k];
    }
    for (int k = 0; k < 4; k++) {
        out[k] /= sqrt(sum);
    }
}

/// Spherical interpolation by repeated halving: square roots only, so that every compiler gives the same
/// bits. The midpoint of a normalised sum is exact; after 16 halvings the rest of the arc is straight to
/// 1e-15.
static void rotate_between(const double from[4], const double to[4], double fraction, double out[4])
{
    enum { HALVINGS = 16 };
    double low[4] = {from[0], from[1], from[2], from[3]};
    double high[4];
    double cosine = from[0] * to[0] + from[1] * to[1] + from[2] * to[2] + from[3] * to[3];
    for (int k = 0; k < 4; k++) {
        high[k] = cosine < 0.0 ? -to[k] : to[k]; // the shorter way round
    }
    double width = 1.0;
    for (int i = 0; i < HALVINGS; i++) {
        double middle[4];
        blend(low, high, 0.5, 1.0, middle);
        width *= 0.5;
        bool upper = fraction >= width;
        fraction -= upper ? width : 0.0;
        for (int k = 0; k < 4; k++) {
            low[k] = upper ? middle[k] : low[k];
            high[k] = upper ? high[k] : middle[k];
        }
    }
    blend(low, high, fraction / width, 1.0, out);
}

PercalePose percale_motion_between(const PercalePose *from, const PercalePose *to, double fraction)
{
    if (fraction <= 0.0) {
        return *from;
    }
    if (fraction >= 1.0) {
        return *to;
    }
    PercalePose pose;
    rotate_between(from->rotation, to->rotation, fraction, pose.rotation);
    for (int axis = 0; axis < 3; axis++) {
        pose.translation[axis] =
            (1.0 - fraction) * from->translation[axis] + fraction * to->translation[axis];
    }
    return pose;
}

/// Rows of the rotation matrix of a unit quaternion.
static void matrix_of(const double q[4], Vec3 rows[3])
{
    double x = q[0];
    double y = q[1];
    double z = q[2];
    double w = q[3];
    rows[0] = vec3(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w));
    rows[1] = vec3(2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w));
    rows[2] = vec3(2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y));
}

static f32x4 rigid_point(const Vec3 rows[3], const double translation[3], const float *base)
{
    Vec3 p = {(double)base[0], (double)base[1], (double)base[2]};
    return (f32x4){(float)(vdot(rows[0], p) + translation[0]), (float)(vdot(rows[1], p) + translation[1]),
                   (float)(vdot(rows[2], p) + translation[2]), 0.0f};
}

static f32x4 point_at(const float *points, size_t at)
{
    return (f32x4){points[at], points[at + 1], points[at + 2], 0.0f};
}

/// From `from` to `to` in a straight line, or along the cubic with the velocities of both ends.
static f32x4 deformed_point(const PercaleObstacleObject *object, size_t at, float fraction, float seconds)
{
    f32x4 a = point_at(object->from, at);
    f32x4 b = point_at(object->to, at);
    if (!(fraction < 1.0f)) {
        return b;
    }
    if (object->velocity_to == NULL) {
        return a + (b - a) * fraction;
    }
    f32x4 end = point_at(object->velocity_to, at) * seconds;
    f32x4 begin = object->velocity_from != NULL ? point_at(object->velocity_from, at) * seconds : b - a;
    float square = fraction * fraction;
    float cube = square * fraction;
    return a + (b - a) * (3.0f * square - 2.0f * cube) + begin * (cube - 2.0f * square + fraction) +
           end * (cube - square);
}

/// What the chunks of a moving obstacle share.
typedef struct Motion {
    const PercaleObstacleObject *object;
    const f32x4 *before; // its points in the model, at the start of the substep
    f32x4 *predicted;
    bool rigid;
    Vec3 rows[3];
    double translation[3];
    float fraction, seconds;
    ReducedUint farthest2;
} Motion;

static void move_range(void *context, uint32_t first, uint32_t end)
{
    Motion *motion = context;
    float farthest2 = 0.0f;
    for (uint32_t i = first; i < end; i++) {
        size_t at = 3 * (size_t)i;
        motion->predicted[i] = motion->rigid
                                   ? rigid_point(motion->rows, motion->translation, motion->object->base + at)
                                   : deformed_point(motion->object, at, motion->fraction, motion->seconds);
        f32x4 moved = motion->predicted[i] - motion->before[i];
        float distance2 = dot3(moved, moved);
        farthest2 = distance2 > farthest2 ? distance2 : farthest2;
    }
    reduce_max_float(&motion->farthest2, farthest2);
}

float percale_motion_apply(PercaleModel *model, uint32_t obstacle, const PercaleObstacleObject *object,
                           double fraction, double seconds, PercaleTeam *team)
{
    uint32_t first = model->obstacles[obstacle].first_point;
    PercalePose pose = percale_motion_between(&object->pose_from, &object->pose_to, fraction);
    Motion motion = {.object = object,
                     .before = model->position + first,
                     .predicted = model->predicted + first,
                     .rigid = object->motion != MOTION_DEFORMING,
                     .translation = {pose.translation[0], pose.translation[1], pose.translation[2]},
                     .fraction = (float)fraction,
                     .seconds = (float)seconds};
    matrix_of(pose.rotation, motion.rows);
    percale_team_for(team, object->vertex_count, GRAIN, move_range, &motion);
    return sqrtf(reduced_float(&motion.farthest2));
}
