#include "impact_queries.h"

#include "testing.h"

#include "base/simd.h"

#include <math.h>
#include <string.h>

const char *impact_family_name(ImpactFamily family)
{
    static const char *const NAMES[FAMILY_COUNT] = {
        "random points", "grazing", "in a plane",  "through features", "parallel meeting",
        "degenerate",    "far off", "grid",        "sizes of motion",  "at rest",
        "noise",         "turning", "nearly exact"};
    return NAMES[family];
}

// ---- random numbers ----

static double between(uint64_t *seed, double low, double high)
{
    return low + (high - low) * percale_test_random(seed);
}

static double power_between(uint64_t *seed, double low, double high)
{
    return pow(10.0, between(seed, low, high));
}

/// 0 .. count - 1
static int pick(uint64_t *seed, int count)
{
    return (int)((double)count * percale_test_random(seed));
}

static Vec3 in_box(uint64_t *seed, double size)
{
    double x = between(seed, -size, size);
    double y = between(seed, -size, size);
    return vec3(x, y, between(seed, -size, size));
}

static Vec3 integers(uint64_t *seed, int most)
{
    double x = (double)(pick(seed, 2 * most + 1) - most);
    double y = (double)(pick(seed, 2 * most + 1) - most);
    return vec3(x, y, (double)(pick(seed, 2 * most + 1) - most));
}

// ---- from vectors to queries ----

static void put(double to[3], Vec3 x)
{
    to[0] = x.x;
    to[1] = x.y;
    to[2] = x.z;
}

static ImpactQuery query_of(bool edges, const Vec3 start[4], const Vec3 end[4])
{
    ImpactQuery query = {.edges = edges};
    for (int k = 0; k < 4; k++) {
        put(query.start[k], start[k]);
        put(query.end[k], end[k]);
    }
    return query;
}

static double largest_coordinate(const ImpactQuery *query)
{
    double largest = 0.0;
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            largest = fmax(largest, fmax(fabs(query->start[k][c]), fabs(query->end[k][c])));
        }
    }
    return largest;
}

/// Rounds all coordinates to multiples of 2^-60 of the power of two above the largest.
static void snap(ImpactQuery *query)
{
    const int DIGITS = 60;
    int exponent;
    (void)frexp(largest_coordinate(query), &exponent);
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            double *x[2] = {&query->start[k][c], &query->end[k][c]};
            *x[0] = ldexp(nearbyint(ldexp(*x[0], DIGITS - exponent)), exponent - DIGITS);
            *x[1] = ldexp(nearbyint(ldexp(*x[1], DIGITS - exponent)), exponent - DIGITS);
        }
    }
}

/// Points x at the time, moving by v.
static ImpactQuery moving(bool edges, const Vec3 x[4], const Vec3 v[4], double time)
{
    Vec3 start[4];
    Vec3 end[4];
    for (int k = 0; k < 4; k++) {
        start[k] = vadd(x[k], vscale(-time, v[k]));
        end[k] = vadd(x[k], vscale(1.0 - time, v[k]));
    }
    ImpactQuery query = query_of(edges, start, end);
    snap(&query);
    return query;
}

/// Integer points, all in units of a power of two, around an integer origin: exact in doubles.
static ImpactQuery in_units(bool edges, const Vec3 start[4], const Vec3 end[4], uint64_t *seed)
{
    Vec3 origin = pick(seed, 3) > 0 ? vec3(0.0, 0.0, 0.0) : integers(seed, 1 << 20);
    Vec3 x[2][4];
    for (int k = 0; k < 4; k++) {
        x[0][k] = vadd(start[k], origin);
        x[1][k] = vadd(end[k], origin);
    }
    ImpactQuery query = query_of(edges, x[0], x[1]);
    int exponent;
    (void)frexp(largest_coordinate(&query), &exponent);
    double unit = ldexp(1.0, 13 - exponent - pick(seed, 14)); // the largest coordinate is 2^-1 to 2^13
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            query.start[k][c] *= unit;
            query.end[k][c] *= unit;
        }
    }
    return query;
}

// ---- where features touch ----

/// Weights of a point of a triangle or a place on an edge: inside, on the border, at a corner. In quarters,
/// so that they are exact, or any.
static void weigh(uint64_t *seed, int count, bool exact, double weights[3])
{
    int left = 4;
    double rest = 1.0;
    memset(weights, 0, 3 * sizeof(weights[0]));
    int used = 1 + pick(seed, count); // corners that have weight, at most
    int first = pick(seed, count);
    for (int i = 0; i < used; i++) {
        int quarters = i + 1 == used ? left : pick(seed, left + 1);
        double share = i + 1 == used ? rest : rest * percale_test_random(seed);
        weights[(first + i) % count] = exact ? 0.25 * (double)quarters : share;
        left -= quarters;
        rest -= share;
    }
}

/// The sum of weighted points is zero: the features touch.
static void touching(uint64_t *seed, bool edges, double size, Vec3 x[4], double weights[4])
{
    double w[3];
    for (int k = 0; k < 4; k++) {
        x[k] = in_box(seed, size);
    }
    if (edges) {
        weigh(seed, 2, false, w);
        Vec3 meeting = vadd(vscale(w[0], x[0]), vscale(w[1], x[1]));
        weights[0] = w[0];
        weights[1] = w[1];
        weigh(seed, 2, false, w);
        Vec3 along = x[3];
        x[2] = vadd(meeting, vscale(-w[1], along));
        x[3] = vadd(meeting, vscale(w[0], along));
        weights[2] = -w[0];
        weights[3] = -w[1];
        return;
    }
    weigh(seed, 3, false, w);
    x[0] = vec3(0.0, 0.0, 0.0);
    weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        x[0] = vadd(x[0], vscale(w[k], x[1 + k]));
        weights[1 + k] = -w[k];
    }
}

/// Across both features, or any.
static Vec3 direction_apart(uint64_t *seed, bool edges, const Vec3 x[4])
{
    Vec3 across =
        edges ? vcross(vsub(x[1], x[0]), vsub(x[3], x[2])) : vcross(vsub(x[2], x[1]), vsub(x[3], x[1]));
    return vunit(pick(seed, 3) > 0 ? across : in_box(seed, 1.0));
}

static void move_first(bool edges, Vec3 x[4], Vec3 by)
{
    x[0] = vadd(x[0], by);
    x[1] = edges ? vadd(x[1], by) : x[1];
}

/// Apart by a gap along n, with motions of size `speed`, without closing speed when they graze.
static ImpactQuery meeting(uint64_t *seed, bool edges, double size, double speed, double gap, bool graze)
{
    Vec3 x[4];
    Vec3 v[4];
    double weights[4];
    touching(seed, edges, size, x, weights);
    Vec3 n = direction_apart(seed, edges, x);
    move_first(edges, x, vscale(gap, n));
    Vec3 closing = vec3(0.0, 0.0, 0.0);
    for (int k = 0; k < 4; k++) {
        v[k] = in_box(seed, speed);
        closing = vadd(closing, vscale(weights[k], v[k]));
    }
    if (graze) {
        move_first(edges, v, vscale(-vdot(n, closing), n));
    }
    return moving(edges, x, v, percale_test_random(seed));
}

// ---- families ----

typedef ImpactQuery Maker(bool edges, uint64_t *seed);

static ImpactQuery random_points(bool edges, uint64_t *seed)
{
    double size = power_between(seed, -3.0, 4.0);
    Vec3 start[4];
    Vec3 end[4];
    for (int k = 0; k < 4; k++) {
        start[k] = in_box(seed, size);
        end[k] = in_box(seed, size);
    }
    ImpactQuery query = query_of(edges, start, end);
    snap(&query);
    return query;
}

static ImpactQuery grazing(bool edges, uint64_t *seed)
{
    double size = power_between(seed, -3.0, 3.0);
    double gap = size * power_between(seed, -12.0, -3.0);
    return meeting(seed, edges, size, size * power_between(seed, -2.0, 0.5), gap, true);
}

static ImpactQuery in_a_plane(bool edges, uint64_t *seed)
{
    static const int SIZES[] = {2, 16, 1000, 30000};
    int size = SIZES[pick(seed, 4)];
    Vec3 axes[2] = {integers(seed, size), integers(seed, size)};
    int most = SIZES[pick(seed, 3)];
    Vec3 x[8];
    for (int k = 0; k < 8; k++) {
        Vec3 place = integers(seed, most);
        x[k] = vadd(vscale(place.x, axes[0]), vscale(place.y, axes[1]));
    }
    return in_units(edges, x, x + 4, seed);
}

static Vec3 weighted(const double w[3], int count, const Vec3 *x)
{
    Vec3 sum = vec3(0.0, 0.0, 0.0);
    for (int k = 0; k < count; k++) {
        sum = vadd(sum, vscale(w[k], x[k]));
    }
    return sum;
}

/// Moves integer points so that they are at x at the time 2^-halvings.
static ImpactQuery meeting_exactly(bool edges, const Vec3 x[4], int most, uint64_t *seed)
{
    double whole = ldexp(1.0, pick(seed, 4));
    Vec3 start[4];
    Vec3 end[4];
    bool still = pick(seed, 3) == 0; // the second feature
    for (int k = 0; k < 4; k++) {
        bool second = k >= (edges ? 2 : 1);
        start[k] = second && still ? x[k] : integers(seed, most);
        end[k] = vadd(start[k], vscale(whole, vsub(x[k], start[k])));
    }
    return in_units(edges, start, end, seed);
}

static ImpactQuery through_features(bool edges, uint64_t *seed)
{
    static const int SIZES[] = {3, 100, 1 << 16, 1 << 24};
    int most = SIZES[pick(seed, 4)];
    double w[3];
    Vec3 x[4];
    for (int k = 0; k < 4; k++) {
        x[k] = vscale(4.0, integers(seed, most));
    }
    if (edges) {
        weigh(seed, 2, true, w);
        Vec3 meeting_point = weighted(w, 2, x);
        weigh(seed, 2, true, w);
        Vec3 along = x[3];
        x[2] = vadd(meeting_point, vscale(-w[1], along));
        x[3] = vadd(meeting_point, vscale(w[0], along));
    } else {
        weigh(seed, 3, true, w);
        x[0] = weighted(w, 3, x + 1);
    }
    return meeting_exactly(edges, x, 4 * most, seed);
}

/// On one line, or one point off it, exactly.
static void place_on_line(bool edges, uint64_t *seed, int most, Vec3 x[4])
{
    Vec3 from = integers(seed, most);
    Vec3 along = integers(seed, most);
    for (int k = 0; k < 4; k++) {
        x[k] = vadd(from, vscale((double)pick(seed, 6), along));
    }
    if (pick(seed, 2) == 0) {
        move_first(edges, x, integers(seed, 1));
    }
}

static ImpactQuery parallel_meeting(bool edges, uint64_t *seed)
{
    static const int SIZES[] = {2, 100, 1 << 20};
    int most = SIZES[pick(seed, 3)];
    Vec3 x[4];
    place_on_line(edges, seed, most, x);
    return meeting_exactly(edges, x, most, seed);
}

/// A line or a point at the start and the end, in the same shares; the first feature goes through it, or
/// near.
static ImpactQuery degenerate(bool edges, uint64_t *seed)
{
    static const int SIZES[] = {2, 100, 1 << 20};
    int most = SIZES[pick(seed, 3)];
    int first = edges ? 2 : 1; // of the second feature
    Vec3 x[2][4];
    Vec3 from[2] = {integers(seed, most), integers(seed, most)};
    Vec3 along[2] = {integers(seed, most), integers(seed, most)};
    int places = 1 + pick(seed, 3); // 1: a point
    for (int k = 0; k < 4; k++) {
        double place = (double)pick(seed, places);
        for (int i = 0; i < 2; i++) {
            x[i][k] = k < first ? integers(seed, most) : vadd(from[i], vscale(2.0 * place, along[i]));
        }
    }
    if (pick(seed, 3) > 0) { // at half time a point of the first is on the second
        Vec3 middle =
            vadd(vadd(from[0], from[1]), vscale((double)pick(seed, places), vadd(along[0], along[1])));
        x[1][0] = vsub(middle, x[0][0]);
    }
    return in_units(edges, x[0], x[1], seed);
}

static ImpactQuery far_off(bool edges, uint64_t *seed)
{
    const double FAR = 1e4;
    double size = power_between(seed, -2.0, 1.0);
    double speed = size * power_between(seed, -4.0, 0.5);
    double gap = pick(seed, 2) == 0 ? 0.0 : size * power_between(seed, -9.0, -1.0);
    ImpactQuery query = meeting(seed, edges, size, speed, gap, pick(seed, 2) == 0);
    double offset[3];
    put(offset, in_box(seed, FAR));
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            query.start[k][c] += offset[c];
            query.end[k][c] += offset[c];
        }
    }
    snap(&query);
    return query;
}

static ImpactQuery grid(bool edges, uint64_t *seed)
{
    int most = 2 + pick(seed, 3);
    ImpactQuery query = {.edges = edges};
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            query.start[k][c] = (double)pick(seed, most);
            query.end[k][c] = (double)pick(seed, most);
        }
    }
    return query;
}

static ImpactQuery sizes_of_motion(bool edges, uint64_t *seed)
{
    const double LARGEST = 1e4;
    double relative = power_between(seed, -8.0, 4.0);
    double size = fmin(1.0, 1.0 / relative) * power_between(seed, -2.0, 3.0);
    double speed = fmin(size * relative, LARGEST);
    double gap = pick(seed, 3) > 0 ? 0.0 : fmin(size, speed) * power_between(seed, -6.0, 0.0);
    return meeting(seed, edges, size, speed, gap, false);
}

static ImpactQuery at_rest(bool edges, uint64_t *seed)
{
    double size = power_between(seed, -3.0, 3.0);
    double gap = pick(seed, 3) == 0 ? 0.0 : size * power_between(seed, -17.0, -1.0);
    ImpactQuery query = meeting(seed, edges, size, 0.0, gap, false);
    double shift[3];
    put(shift, in_box(seed, pick(seed, 2) == 0 ? 0.0 : size));
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            query.end[k][c] = query.start[k][c] + shift[c];
        }
    }
    snap(&query);
    return query;
}

static ImpactQuery noise(bool edges, uint64_t *seed)
{
    double size = power_between(seed, -3.0, 3.0);
    double gap = pick(seed, 2) == 0 ? 0.0 : size * power_between(seed, -17.0, -13.0);
    return meeting(seed, edges, size, size * power_between(seed, -3.0, 1.0), gap, pick(seed, 2) == 0);
}

static Vec3 turned(Vec3 x, Vec3 axis, double angle)
{
    Vec3 along = vscale(vdot(axis, x), axis);
    Vec3 square = vsub(x, along);
    return vadd(along, vadd(vscale(cos(angle), square), vscale(sin(angle), vcross(axis, x))));
}

static ImpactQuery turning(bool edges, uint64_t *seed)
{
    double size = power_between(seed, -3.0, 3.0);
    Vec3 x[4];
    Vec3 end[4];
    double weights[4];
    touching(seed, edges, size, x, weights);
    Vec3 across =
        edges ? vcross(vsub(x[1], x[0]), vsub(x[3], x[2])) : vcross(vsub(x[2], x[1]), vsub(x[3], x[1]));
    move_first(edges, x, vscale(size * power_between(seed, -9.0, -3.0), vunit(across)));
    Vec3 axis = vunit(in_box(seed, 1.0));
    double angle = between(seed, -1.0, 1.0);
    for (int k = 0; k < 4; k++) {
        end[k] = turned(x[k], axis, angle);
    }
    ImpactQuery query = query_of(edges, x, end);
    snap(&query);
    return query;
}

static ImpactQuery nearly_exact(bool edges, uint64_t *seed)
{
    static Maker *const MAKERS[] = {in_a_plane, through_features, parallel_meeting, degenerate, grid};
    ImpactQuery query = MAKERS[pick(seed, 5)](edges, seed);
    double off = impact_size(&query) * power_between(seed, -16.0, -3.0);
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            query.start[k][c] += between(seed, -off, off);
            query.end[k][c] += between(seed, -off, off);
        }
    }
    snap(&query);
    return query;
}

ImpactQuery impact_query(ImpactFamily family, bool edges, uint64_t *seed)
{
    static Maker *const MAKERS[FAMILY_COUNT] = {
        random_points,   grazing, in_a_plane, through_features, parallel_meeting, degenerate, far_off, grid,
        sizes_of_motion, at_rest, noise,      turning,          nearly_exact};
    return MAKERS[family](edges, seed);
}
