// The differences of one feature's points to the other's move on straight lines, too, and the features are as
// far apart as the hull of the differences is from zero: a triangle for a vertex and a face, a parallelogram
// for two edges. A direction n in which all of the hull is beyond zero by more than the separation proves
// that they are apart. So does a direction n(t) that turns over an interval of time: with n of degree 2 the
// products n(t) . r(t) are cubics, and they are positive where their four Bernstein coefficients are.
//
// How n is found proves nothing and needs no care; the coefficients do, and have a margin for their rounding.
// The search goes forward from proved time to proved time, as far as the distance seems to last, and by less
// where the proof fails.

#include "detect/impact_time.h"

#include "percale/geometry.h"

#include <string.h>

enum {
    CORNERS_MOST = 4,
    INTERVALS_MOST = 256 // proofs tried before the answer is "perhaps"; nearly all queries need one to ten
};

// Share of sum |n_c| (R_c + separation), R_c the largest difference on axis c, that a Bernstein coefficient
// may be off by: its rounding is below 9.1 units of 2^-53, derived in src/MATH.md, section 9.
static const double ROUNDING = 10 * 0x1p-53;

// A distance below this share of the way is none: 2000 times nearer than 1e-9. Nor is one that a proof could
// not tell from rounding, by this factor.
static const double NEAR_OF_WAY = 0x1p-41;
static const double NEAR_OF_ROUNDING = 1.25;

// Differences beyond this could overflow in a product of three, and are reported as touching.
static const double LARGEST = 1e60;

// So are features whose differences are all below this: it is far above what flushed denormals lose, and its
// products with ROUNDING still are.
static const double SMALLEST = 1e-250;

// A direction that is shorter is none: the square of its length has lost digits to underflow.
static const double SHORTEST_DIRECTION = 1e-120;

// Squared sine of the angle below which a hull is thin: its normal's rounding is 1e-16 / sine.
static const double THIN = 1e-10;

// Below this a hull counts as its sides for its nearest point: either way it is off by up to 1e-8 of its
// size.
static const double LINE = 1e-16;

static const double ADVANCE = 0.99;      // of the time that the distance seems to last
static const double SHRINK = 0.5;        // of an interval without a proof
static const double SHORTEST = 0x1p-48;  // an interval that is not tried any more
static const double GOOD_ENOUGH = 0.875; // of the distance, as seen along a direction: no other is looked for

/// The differences: the hull's corners in cyclic order, at the start and the end.
typedef struct Hull {
    Vec3 ends[2][CORNERS_MOST];
    int count; // 3 or 4
    double separation;
    Vec3 low; // box around both poses
    Vec3 high;
    Vec3 sizes; // largest coordinates in it
} Hull;

/// Parts of a hull: sides are counted from SIDE_0, corners from CORNER_0; side k leads to corner k + 1.
enum { INSIDE = 0, SIDE_0 = 1, CORNER_0 = SIDE_0 + CORNERS_MOST };

/// A direction on a part of the hull.
typedef struct Direction {
    int part;
    Vec3 n;
    Vec3 u, v;     // n = u x v, unless it is that of a corner
    double length; // of n
    double gap;    // by which the whole hull is farther along n than the separation
    bool thin;     // across a hull that is nearly a line
} Direction;

/// The hull at a time.
typedef struct Pose {
    double time;
    Vec3 corners[CORNERS_MOST];
    double weights[CORNERS_MOST]; // of the point nearest to zero
    Direction best;               // in which the hull seems to be farthest from zero
} Pose;

// As the machine's own instructions; fmin and fmax are calls. Neither sees a NaN.
static double smaller(double a, double b)
{
    return a < b ? a : b;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static int after(const Hull *hull, int k)
{
    return k + 1 < hull->count ? k + 1 : 0;
}

// ---- a direction ----

/// Nearest point to zero on side k: its squared distance, and its place from 0 to 1.
static double nearest_on_side(const Hull *hull, const Pose *pose, int k, double *place)
{
    Vec3 from = pose->corners[k];
    Vec3 side = vsub(pose->corners[after(hull, k)], from);
    double length2 = vdot(side, side);
    double t = length2 > 0.0 ? -vdot(from, side) / length2 : 0.0;
    *place = t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0;
    Vec3 nearest = vadd(from, vscale(*place, side));
    return vdot(nearest, nearest);
}

/// n without what it has along w.
static Vec3 square_to(Vec3 n, Vec3 w)
{
    return vsub(n, vscale(vdot(n, w) / vdot(w, w), w));
}

/// Across the hull, away from zero. A parallelogram's corner 2 is not needed. When the hull is thin, the
/// product's rounding leans n along it.
static void go_across(const Hull *hull, const Pose *pose, Direction *direction)
{
    Vec3 u = vsub(pose->corners[1], pose->corners[0]);
    Vec3 v = vsub(pose->corners[hull->count - 1], pose->corners[0]);
    Vec3 n = vcross(u, v);
    double uu = vdot(u, u);
    double vv = vdot(v, v);
    direction->thin = vdot(n, n) < THIN * uu * vv;
    n = direction->thin ? square_to(n, uu > vv ? u : v) : n;
    bool towards = vdot(n, pose->corners[0]) < 0.0;
    direction->n = towards ? vscale(-1.0, n) : n;
    direction->u = towards ? vscale(-1.0, u) : u;
    direction->v = v;
}

/// Square to side k, towards its point nearest to zero, as long as the side; v is a unit vector. So n turns
/// linearly when all moves in a plane. Near zero the first product has only rounding left along the side:
/// hence twice.
static void go_across_side(const Hull *hull, const Pose *pose, int k, Direction *direction)
{
    Vec3 n = pose->corners[k];
    Vec3 side = vsub(pose->corners[after(hull, k)], n);
    n = square_to(square_to(n, side), side); // no number for a side without length
    direction->u = side;
    direction->v = vunit(vcross(n, side));
    direction->n = vcross(side, direction->v);
}

static void go(const Hull *hull, const Pose *pose, int part, Direction *direction)
{
    direction->part = part;
    direction->thin = false;
    if (part == INSIDE) {
        go_across(hull, pose, direction);
    } else if (part < CORNER_0) {
        go_across_side(hull, pose, part - SIDE_0, direction);
    } else {
        direction->n = pose->corners[part - CORNER_0];
    }
    double least = vdot(direction->n, pose->corners[0]);
    for (int k = 1; k < hull->count; k++) {
        least = smaller(least, vdot(direction->n, pose->corners[k]));
    }
    direction->length = vlength(direction->n);
    bool valid = direction->length > SHORTEST_DIRECTION;
    direction->gap = valid ? least / direction->length - hull->separation : -HUGE_VAL;
}

/// Takes the direction of this part when the hull is farther along it than along the one before.
static void keep_farther(const Hull *hull, Pose *pose, int part)
{
    Direction direction;
    go(hull, pose, part, &direction);
    if (direction.gap > pose->best.gap) {
        pose->best = direction;
    }
}

/// The foot of the perpendicular from zero, when it is inside the hull; weights its corners. A hull that is
/// as good as a line has none.
static bool weigh_foot(const Hull *hull, Pose *pose)
{
    Vec3 from = pose->corners[0];
    Vec3 u = vsub(pose->corners[1], from);
    Vec3 v = vsub(pose->corners[hull->count - 1], from);
    Vec3 n = vcross(u, v);
    double n2 = vdot(n, n);
    double s = vdot(n, vcross(v, from)) / n2;
    double t = vdot(n, vcross(from, u)) / n2;
    if (!(s > 0.0 && t > 0.0 && n2 > LINE * vdot(u, u) * vdot(v, v))) {
        return false;
    }
    double *weights = pose->weights;
    if (hull->count == 3) {
        weights[0] = 1.0 - s - t;
        weights[1] = s;
        weights[2] = t;
        return weights[0] > 0.0;
    }
    weights[0] = (1.0 - s) * (1.0 - t);
    weights[1] = s * (1.0 - t);
    weights[2] = s * t;
    weights[3] = (1.0 - s) * t;
    return s < 1.0 && t < 1.0;
}

/// Weights of the point nearest to zero, and the part of the hull on which it lies. Returns its distance.
static double find_nearest(const Hull *hull, Pose *pose, int *part)
{
    if (weigh_foot(hull, pose)) {
        *part = INSIDE;
        return 0.0; // the direction across is the best there is
    }
    double best2 = HUGE_VAL;
    double best_place = 0.0;
    int best = 0;
    for (int k = 0; k < hull->count; k++) {
        double place;
        double distance2 = nearest_on_side(hull, pose, k, &place);
        if (distance2 < best2) {
            best2 = distance2;
            best_place = place;
            best = k;
        }
    }
    memset(pose->weights, 0, sizeof(pose->weights));
    pose->weights[best] = 1.0 - best_place;
    pose->weights[after(hull, best)] = best_place;
    *part = best_place <= 0.0   ? CORNER_0 + best
            : best_place >= 1.0 ? CORNER_0 + after(hull, best)
                                : SIDE_0 + best;
    return sqrt(best2);
}

/// The hull at a time, and the direction in which it seems to be farthest from zero.
static void take_pose(const Hull *hull, double time, Pose *pose)
{
    pose->time = time;
    for (int k = 0; k < hull->count; k++) {
        pose->corners[k] = vadd(vscale(1.0 - time, hull->ends[0][k]), vscale(time, hull->ends[1][k]));
    }
    pose->best = (Direction){.gap = -HUGE_VAL};
    int part;
    double distance = find_nearest(hull, pose, &part);
    keep_farther(hull, pose, part);
    if (!pose->best.thin && pose->best.gap + hull->separation >= GOOD_ENOUGH * distance) {
        return;
    }
    // so near, or so thin, that rounding may have named the wrong part
    keep_farther(hull, pose, INSIDE);
    for (int k = 0; k < hull->count; k++) {
        keep_farther(hull, pose, SIDE_0 + k);
        keep_farther(hull, pose, CORNER_0 + k);
    }
}

// ---- the proof ----

/// Bounds the rounding of n . r - |n| separation, for all corners and times.
static double rounding_along(const Hull *hull, Vec3 n)
{
    Vec3 size = {fabs(n.x), fabs(n.y), fabs(n.z)};
    return ROUNDING * (vdot(size, hull->sizes) + (size.x + size.y + size.z) * hull->separation);
}

/// How a direction goes on to the next: with the part of the hull on which both stand, or evenly.
typedef enum Turn { WITH_THE_HULL, EVENLY } Turn;

/// In Bernstein form. Any three vectors would do for the proof. The hull's own direction may turn over in
/// between, as that of two edges does when they turn through parallel: then evenly.
static void turn(const Direction *a, const Direction *b, Turn how, Vec3 n[3])
{
    bool same = a->part == b->part;
    n[0] = same ? a->n : vscale(1.0 / a->length, a->n);
    n[2] = same ? b->n : vscale(1.0 / b->length, b->n);
    n[1] = vscale(0.5, vadd(n[0], n[2]));
    if (how == WITH_THE_HULL && same && a->part < CORNER_0) {
        Vec3 middle = vscale(0.5, vadd(vcross(a->u, b->v), vcross(b->u, a->v)));
        n[1] = vdot(middle, n[0]) > 0.0 && vdot(middle, n[2]) > 0.0 ? middle : n[1];
    }
}

/// True proves that the hull is farther from zero than the separation from this pose to the end: one plane is
/// in between at both, and all moves on straight lines.
static bool stays_behind_plane(const Hull *hull, const Pose *pose)
{
    Vec3 n = pose->best.n;
    double least = hull->separation * pose->best.length;
    double margin = rounding_along(hull, n);
    if (!(margin > SMALLEST)) {
        return false;
    }
    for (int k = 0; k < hull->count; k++) {
        double now = vdot(n, pose->corners[k]) - least;
        double at_end = vdot(n, hull->ends[1][k]) - least;
        if (!(now > margin && at_end > margin)) {
            return false;
        }
    }
    return true;
}

/// True proves that the hull is farther from zero than the separation at all times from one pose to the next.
static bool stays_apart_along(const Hull *hull, const Pose *a, const Direction *along_a, const Pose *b,
                              const Direction *along_b, Turn how)
{
    Vec3 n[3];
    double least[3]; // what n . r has to exceed
    double margin = 0.0;
    turn(along_a, along_b, how, n);
    for (int i = 0; i < 3; i++) {
        margin = larger(margin, rounding_along(hull, n[i]));
        least[i] = hull->separation * vlength(n[i]);
    }
    if (!(margin > SMALLEST)) {
        return false;
    }
    for (int k = 0; k < hull->count; k++) {
        const Vec3 *r = &a->corners[k];
        const Vec3 *s = &b->corners[k];
        double first = vdot(n[0], *r) - least[0];
        double second = 2.0 * (vdot(n[1], *r) - least[1]) + (vdot(n[0], *s) - least[0]);
        double third = 2.0 * (vdot(n[1], *s) - least[1]) + (vdot(n[2], *r) - least[2]);
        double fourth = vdot(n[2], *s) - least[2];
        if (!(first > margin && second > 3.0 * margin && third > 3.0 * margin && fourth > margin)) {
            return false;
        }
    }
    return true;
}

/// Tries the poses' best directions, then those across the hull. A thin hull's own turn has no digits left
/// where little of it happens.
static bool stays_apart(const Hull *hull, const Pose *a, const Pose *b)
{
    bool thin = a->best.thin || b->best.thin;
    if (stays_apart_along(hull, a, &a->best, b, &b->best, WITH_THE_HULL) ||
        (thin && stays_apart_along(hull, a, &a->best, b, &b->best, EVENLY))) {
        return true;
    }
    if (a->best.part == INSIDE && b->best.part == INSIDE) {
        return false;
    }
    Direction across_a;
    Direction across_b;
    go(hull, a, INSIDE, &across_a);
    go(hull, b, INSIDE, &across_b);
    return across_a.gap > 0.0 && across_b.gap > 0.0 &&
           stays_apart_along(hull, a, &across_a, b, &across_b, WITH_THE_HULL);
}

// ---- the search ----

/// Boxes the hull. False where it can't be computed with.
static bool measure(Hull *hull)
{
    Vec3 low = hull->ends[0][0];
    Vec3 high = low;
    double sum = hull->separation; // NaN wherever one is
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < hull->count; k++) {
            Vec3 r = hull->ends[i][k];
            sum += r.x + r.y + r.z;
            low = vec3(smaller(low.x, r.x), smaller(low.y, r.y), smaller(low.z, r.z));
            high = vec3(larger(high.x, r.x), larger(high.y, r.y), larger(high.z, r.z));
        }
    }
    hull->low = low;
    hull->high = high;
    hull->sizes = vec3(larger(-low.x, high.x), larger(-low.y, high.y), larger(-low.z, high.z));
    double size = larger(larger(hull->sizes.x, hull->sizes.y), hull->sizes.z);
    return isfinite(sum) && size < LARGEST && hull->separation >= 0.0 && hull->separation < LARGEST;
}

/// On one axis, all of one feature beyond the other at both ends: so in between. Rounding keeps order, so a
/// difference is rounded above the separation only if it is above it.
static bool apart_along_an_axis(const Hull *hull)
{
    double separation = hull->separation + SMALLEST;
    const Vec3 *low = &hull->low;
    const Vec3 *high = &hull->high;
    return low->x > separation || low->y > separation || low->z > separation || high->x < -separation ||
           high->y < -separation || high->z < -separation;
}

static double way_of(const Hull *hull)
{
    double way = 0.0;
    for (int k = 0; k < hull->count; k++) {
        Vec3 by = vsub(hull->ends[1][k], hull->ends[0][k]);
        way = larger(way, larger(larger(fabs(by.x), fabs(by.y)), fabs(by.z)));
    }
    return way;
}

/// The time for which the distance lasts when the nearest points go on as they are.
static double reach_of(const Hull *hull, const Pose *pose)
{
    double at_end = 0.0;
    for (int k = 0; k < hull->count; k++) {
        at_end += pose->weights[k] * vdot(pose->best.n, hull->ends[1][k]);
    }
    at_end = at_end / pose->best.length - hull->separation;
    double rest = 1.0 - pose->time;
    return at_end > 0.0 ? rest : ADVANCE * rest * pose->best.gap / (pose->best.gap - at_end);
}

/// Whether the hull is as good as within the separation.
static bool is_near(const Hull *hull, const Pose *pose, double way)
{
    double rounding = rounding_along(hull, pose->best.n) / pose->best.length;
    return !(pose->best.gap > larger(NEAR_OF_WAY * way, NEAR_OF_ROUNDING * rounding));
}

/// False: they stay apart. Else `pose` is the last that is proved to be reached without coming near.
static bool comes_near(const Hull *hull, Pose *pose)
{
    double way = way_of(hull);
    double width = 0.0;
    take_pose(hull, 0.0, pose);
    bool moved = true;
    for (int i = 0; i < INTERVALS_MOST; i++) {
        if (moved && is_near(hull, pose, way)) {
            return true;
        }
        if (moved && stays_behind_plane(hull, pose)) {
            return false;
        }
        width = moved ? reach_of(hull, pose) : SHRINK * width;
        if (!(width > SHORTEST)) {
            return true;
        }
        Pose next;
        take_pose(hull, smaller(pose->time + width, 1.0), &next);
        moved = stays_apart(hull, pose, &next);
        if (moved && next.time >= 1.0) {
            return false;
        }
        if (moved) {
            *pose = next;
        }
    }
    return true;
}

/// As comes_near; the pose of what can't be computed with is all zero.
static bool find_impact(Hull *hull, Pose *pose)
{
    if (!measure(hull)) {
        *pose = (Pose){.weights = {1.0}};
        return true;
    }
    return !apart_along_an_axis(hull) && comes_near(hull, pose);
}

/// From zero to the hull is from the first feature to the second: the normal leads back.
static Vec3 normal_of(const Pose *pose)
{
    return pose->best.gap > 0.0 ? vscale(-1.0 / pose->best.length, pose->best.n) : vec3(0.0, 0.0, 0.0);
}

bool percale_vertex_face_impact_time(const Vec3 *from, const Vec3 *to, double separation,
                                     PercaleImpact *impact)
{
    Hull hull;
    hull.count = 3;
    hull.separation = separation;
    for (int k = 0; k < 3; k++) {
        hull.ends[0][k] = vsub(from[1 + k], from[0]);
        hull.ends[1][k] = vsub(to[1 + k], to[0]);
    }
    Pose pose;
    if (!find_impact(&hull, &pose)) {
        return false;
    }
    *impact = (PercaleImpact){.time = pose.time, .normal = normal_of(&pose)};
    impact->weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        impact->weights[1 + k] = -pose.weights[k];
    }
    return true;
}

bool percale_edge_edge_impact_time(const Vec3 *from, const Vec3 *to, double separation, PercaleImpact *impact)
{
    Hull hull;
    hull.count = 4;
    hull.separation = separation;
    const Vec3 *ends[2] = {from, to};
    for (int i = 0; i < 2; i++) {
        const Vec3 *x = ends[i];
        hull.ends[i][0] = vsub(x[2], x[0]);
        hull.ends[i][1] = vsub(x[3], x[0]);
        hull.ends[i][2] = vsub(x[3], x[1]);
        hull.ends[i][3] = vsub(x[2], x[1]);
    }
    Pose pose;
    if (!find_impact(&hull, &pose)) {
        return false;
    }
    const double *w = pose.weights;
    *impact = (PercaleImpact){.time = pose.time, .normal = normal_of(&pose)};
    impact->weights[0] = w[0] + w[1];
    impact->weights[1] = w[2] + w[3];
    impact->weights[2] = -(w[0] + w[3]);
    impact->weights[3] = -(w[1] + w[2]);
    return true;
}

// ---- the public form ----

typedef bool ImpactTime(const Vec3 *from, const Vec3 *to, double separation, PercaleImpact *impact);

static bool impact_of(ImpactTime *impact_time, const double start[4][3], const double end[4][3],
                      double separation, double *time)
{
    Vec3 from[4];
    Vec3 to[4];
    for (int k = 0; k < 4; k++) {
        from[k] = vec3(start[k][0], start[k][1], start[k][2]);
        to[k] = vec3(end[k][0], end[k][1], end[k][2]);
    }
    PercaleImpact impact;
    if (!impact_time(from, to, separation, &impact)) {
        return false;
    }
    *time = impact.time;
    return true;
}

bool percale_vertex_face_approach(const double start[4][3], const double end[4][3], double separation,
                                  double *time)
{
    return impact_of(percale_vertex_face_impact_time, start, end, separation, time);
}

bool percale_edge_edge_approach(const double start[4][3], const double end[4][3], double separation,
                                double *time)
{
    return impact_of(percale_edge_edge_impact_time, start, end, separation, time);
}

bool percale_vertex_face_impact(const double start[4][3], const double end[4][3], double *time)
{
    return impact_of(percale_vertex_face_impact_time, start, end, 0.0, time);
}

bool percale_edge_edge_impact(const double start[4][3], const double end[4][3], double *time)
{
    return impact_of(percale_edge_edge_impact_time, start, end, 0.0, time);
}
