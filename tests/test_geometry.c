// The closest-point functions against slow twins in long double, on random and degenerate configurations.

#include "testing.h"

#include "base/simd.h"
#include "percale/geometry.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { TRIALS = 3000 };               // per kind of configuration and size
static const double ROUNDING = 1e-13; // of the largest coordinate: some hundred units in the last place
static const double THIN_ROUNDING =
    1.2e-7; // the same for what counts as flat: what float32 positions resolve

typedef double ClosestFunction(const double x[4][3], double weight[4]);

// ---- slow twins ----

typedef struct LongVec {
    long double x, y, z;
} LongVec;

static LongVec load(const double x[3])
{
    return (LongVec){(long double)x[0], (long double)x[1], (long double)x[2]};
}

static LongVec along(LongVec a, long double t, LongVec b) // a + t b
{
    return (LongVec){a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}

static LongVec from_to(LongVec a, LongVec b)
{
    return along(b, -1.0L, a);
}

static long double dot(LongVec a, LongVec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static LongVec cross(LongVec a, LongVec b)
{
    return (LongVec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static long double distance2(LongVec a, LongVec b)
{
    LongVec d = from_to(a, b);
    return dot(d, d);
}

static long double point_segment2(LongVec p, LongVec a, LongVec b)
{
    LongVec d = from_to(a, b);
    long double length2 = dot(d, d);
    long double t = length2 > 0.0L ? dot(from_to(a, p), d) / length2 : 0.0L;
    return distance2(p, along(a, fminl(1.0L, fmaxl(0.0L, t)), d));
}

/// The nearest of the three sides and, when it lies inside, the foot of the perpendicular.
static double vertex_face_twin(const double x[4][3])
{
    LongVec q = load(x[0]);
    LongVec a = load(x[1]);
    LongVec b = load(x[2]);
    LongVec c = load(x[3]);
    long double best =
        fminl(point_segment2(q, a, b), fminl(point_segment2(q, b, c), point_segment2(q, c, a)));
    LongVec u = from_to(a, b);
    LongVec v = from_to(a, c);
    LongVec w = from_to(a, q);
    LongVec n = cross(u, v);
    if (dot(n, n) > 0.0L) {
        long double s = dot(n, cross(w, v)) / dot(n, n);
        long double t = dot(n, cross(u, w)) / dot(n, n);
        if (s >= 0.0L && t >= 0.0L && s + t <= 1.0L) {
            best = fminl(best, distance2(q, along(along(a, s, u), t, v)));
        }
    }
    return (double)sqrtl(best);
}

/// The nearest of the four ends and, when it lies inside both, the common perpendicular.
static double edge_edge_twin(const double x[4][3])
{
    LongVec a = load(x[0]);
    LongVec b = load(x[1]);
    LongVec c = load(x[2]);
    LongVec d = load(x[3]);
    long double best = fminl(fminl(point_segment2(a, c, d), point_segment2(b, c, d)),
                             fminl(point_segment2(c, a, b), point_segment2(d, a, b)));
    LongVec u = from_to(a, b);
    LongVec v = from_to(c, d);
    LongVec w = from_to(a, c);
    LongVec n = cross(u, v);
    if (dot(n, n) > 0.0L) {
        long double s = dot(n, cross(w, v)) / dot(n, n);
        long double t = dot(n, cross(w, u)) / dot(n, n);
        if (s >= 0.0L && s <= 1.0L && t >= 0.0L && t <= 1.0L) {
            best = fminl(best, distance2(along(a, s, u), along(c, t, v)));
        }
    }
    return (double)sqrtl(best);
}

// ---- configurations ----

/// How the four points lie.
typedef enum Kind {
    GENERIC = 0,
    ONE_POINT,     // all of a feature's points coincide
    TWO_COINCIDE,  // two of a triangle's corners, or the ends of one edge
    COLLINEAR,     // the triangle's corners; the edges are parallel
    ON_ONE_LINE,   // all four points
    TOUCHING,      // the distance is 0
    THIN,          // collinear up to 1e-3 .. 1e-9 of the size
    THIN_AND_NEAR, // the same, with the closest points inside
    KIND_COUNT
} Kind;

static void set(double x[3], Vec3 value)
{
    x[0] = value.x;
    x[1] = value.y;
    x[2] = value.z;
}

static Vec3 get(const double x[3])
{
    return vec3(x[0], x[1], x[2]);
}

static Vec3 random_vector(uint64_t *seed, double size)
{
    double x = size * (2.0 * percale_test_random(seed) - 1.0);
    double y = size * (2.0 * percale_test_random(seed) - 1.0);
    return vec3(x, y, size * (2.0 * percale_test_random(seed) - 1.0));
}

static void make_vertex_face(Kind kind, uint64_t *seed, double size, double x[4][3])
{
    Vec3 corner[3];
    for (int k = 0; k < 3; k++) {
        corner[k] = random_vector(seed, size);
    }
    Vec3 q = random_vector(seed, 1.5 * size);
    Vec3 line = vsub(corner[1], corner[0]);
    double t = 3.0 * percale_test_random(seed) - 1.0;
    if (kind == ONE_POINT) {
        corner[1] = corner[2] = corner[0];
    } else if (kind == TWO_COINCIDE) {
        uint32_t k = (uint32_t)(3.0 * percale_test_random(seed));
        corner[k] = corner[(k + 1) % 3];
    } else if (kind == COLLINEAR || kind == ON_ONE_LINE) {
        corner[2] = vadd(corner[0], vscale(t, line));
        q = kind == COLLINEAR ? q : vadd(corner[0], vscale(2.0 * t - 1.0, line));
    } else if (kind == TOUCHING) { // at a corner, on a side or inside
        double u = percale_test_random(seed) < 0.3 ? 0.0 : percale_test_random(seed);
        double v = percale_test_random(seed) < 0.3 ? 0.0 : (1.0 - u) * percale_test_random(seed);
        q = vadd(corner[0], vadd(vscale(u, line), vscale(v, vsub(corner[2], corner[0]))));
    } else if (kind == THIN || kind == THIN_AND_NEAR) {
        double thin = size * pow(10.0, -3.0 - 6.0 * percale_test_random(seed));
        corner[2] = vadd(vadd(corner[0], vscale(t, line)), random_vector(seed, thin));
        if (kind == THIN_AND_NEAR) {
            double u = percale_test_random(seed);
            double v = (1.0 - u) * percale_test_random(seed);
            q = vadd(corner[0], vadd(vscale(u, line), vscale(v, vsub(corner[2], corner[0]))));
            q = vadd(q, random_vector(seed, thin));
        }
    }
    set(x[0], q);
    for (int k = 0; k < 3; k++) {
        set(x[k + 1], corner[k]);
    }
}

static void make_edge_edge(Kind kind, uint64_t *seed, double size, double x[4][3])
{
    Vec3 p[4];
    for (int k = 0; k < 4; k++) {
        p[k] = random_vector(seed, size);
    }
    Vec3 line = vsub(p[1], p[0]);
    double t = 4.0 * percale_test_random(seed) - 2.0; // along, against, longer, shorter
    if (kind == ONE_POINT) {
        p[1] = p[0];
        p[3] = p[2];
    } else if (kind == TWO_COINCIDE) {
        uint32_t edge = percale_test_random(seed) < 0.5 ? 0 : 2;
        p[edge + 1] = p[edge];
    } else if (kind == COLLINEAR) {
        p[3] = vadd(p[2], vscale(t, line));
    } else if (kind == ON_ONE_LINE) {
        p[2] = vadd(p[0], vscale(2.0 * percale_test_random(seed) - 0.5, line));
        p[3] = vadd(p[2], vscale(t, line));
    } else if (kind == TOUCHING) { // crossing inside, or at the end of the first edge
        double s = percale_test_random(seed) < 0.3 ? 0.0 : percale_test_random(seed);
        Vec3 meeting = vadd(p[0], vscale(s, line));
        Vec3 half = random_vector(seed, size);
        p[2] = vsub(meeting, half);
        p[3] = vadd(meeting, half);
    } else if (kind == THIN) {
        double thin = size * pow(10.0, -3.0 - 6.0 * percale_test_random(seed));
        p[3] = vadd(vadd(p[2], vscale(t, line)), random_vector(seed, thin));
    } else if (kind == THIN_AND_NEAR) {
        double thin = size * pow(10.0, -3.0 - 6.0 * percale_test_random(seed));
        Vec3 half = vadd(vscale(t, line), random_vector(seed, thin));
        Vec3 meeting = vadd(vadd(p[0], vscale(percale_test_random(seed), line)), random_vector(seed, thin));
        p[2] = vsub(meeting, half);
        p[3] = vadd(meeting, half);
    }
    for (int k = 0; k < 4; k++) {
        set(x[k], p[k]);
    }
}

typedef struct Subject {
    ClosestFunction *closest;
    double (*twin)(const double x[4][3]);
    void (*make)(Kind kind, uint64_t *seed, double size, double x[4][3]);
    int first_count;     // points of the first feature: their weights sum to 1
    int swap_count;      // rows of swaps
    int swaps[5][4];     // where each point goes
    int is_negated_from; // from this row on the two features change roles
} Subject;

static const Subject VERTEX_FACE = {percale_vertex_face_closest,
                                    vertex_face_twin,
                                    make_vertex_face,
                                    1,
                                    5,
                                    {{0, 1, 3, 2}, {0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 3, 2, 1}},
                                    5};
static const Subject EDGE_EDGE = {percale_edge_edge_closest,
                                  edge_edge_twin,
                                  make_edge_edge,
                                  2,
                                  5,
                                  {{1, 0, 2, 3}, {0, 1, 3, 2}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}},
                                  3};

static double largest(const double x[4][3])
{
    double most = 0.0;
    for (int k = 0; k < 4; k++) {
        for (int axis = 0; axis < 3; axis++) {
            most = fmax(most, fabs(x[k][axis]));
        }
    }
    return most;
}

/// sum weight[k] x[k] by way of differences, as the weights sum to 0: far from the origin it keeps its
/// digits.
static Vec3 offset_of(const double x[4][3], const double weight[4])
{
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 1; k < 4; k++) {
        sum = vadd(sum, vscale(weight[k], vsub(get(x[k]), get(x[0]))));
    }
    return sum;
}

// ---- laws ----

/// Error that is allowed in a distance, m.
static double tolerance_of(Kind kind, const double x[4][3])
{
    return largest(x) * (kind == THIN || kind == THIN_AND_NEAR ? THIN_ROUNDING : ROUNDING);
}

static void expect_weights(const Subject *subject, Kind kind, const double x[4][3], double distance,
                           const double weight[4])
{
    const double UNIT = 1e-15;
    double first = 0.0;
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        double share = k < subject->first_count ? weight[k] : -weight[k];
        first += k < subject->first_count ? weight[k] : 0.0;
        sum += weight[k];
        if (!(share >= -UNIT && share <= 1.0 + UNIT)) {
            ck_abort_msg("kind %d: weight %d is %.17g", (int)kind, k, weight[k]);
        }
    }
    if (!(fabs(sum) <= UNIT && fabs(first - 1.0) <= UNIT)) {
        ck_abort_msg("kind %d: the weights sum to %.3g, the first feature's to %.17g", (int)kind, sum, first);
    }
    double length = vlength(offset_of(x, weight));
    if (!(fabs(length - distance) <= ROUNDING * largest(x))) {
        ck_abort_msg("kind %d: distance %.17g, but |sum w x| = %.17g", (int)kind, distance, length);
    }
}

/// Runs `judge` on all kinds, on features of 2 m, 2 cm and 20 km, the smaller ones also 10 km away.
static void for_all(const Subject *subject,
                    void (*judge)(const Subject *subject, Kind kind, const double x[4][3]))
{
    static const double SIZES[] = {1.0, 0.01, 1e4};
    uint64_t seed = 20;
    for (int kind = 0; kind < KIND_COUNT; kind++) {
        for (int i = 0; i < TRIALS; i++) {
            double x[4][3];
            double size = SIZES[i % 3];
            subject->make((Kind)kind, &seed, size, x);
            bool is_far = i % 2 == 1 && size < 1e4;
            for (int k = 0; is_far && k < 4; k++) {
                x[k][0] += 1e4;
                x[k][2] -= 9e3;
            }
            judge(subject, (Kind)kind, (const double(*)[3])x);
        }
    }
}

static void judge_distance(const Subject *subject, Kind kind, const double x[4][3])
{
    double weight[4];
    double distance = subject->closest(x, weight);
    double expected = subject->twin(x);
    if (!(fabs(distance - expected) <= tolerance_of(kind, x))) {
        ck_abort_msg("kind %d: distance %.17g, the twin says %.17g (coordinates up to %g)", (int)kind,
                     distance, expected, largest(x));
    }
    expect_weights(subject, kind, x, distance, weight);
}

/// The closest points' difference is unique, even where the points are not. Its error is the root of that of
/// the distance: |d - d*|^2 <= |d|^2 - |d*|^2.
static void judge_swaps(const Subject *subject, Kind kind, const double x[4][3])
{
    double weight[4];
    double distance = subject->closest(x, weight);
    Vec3 offset = offset_of(x, weight);
    double error = tolerance_of(kind, x);
    double tolerance = 2.0 * sqrt(2.0 * distance * error + error * error);
    for (int row = 0; row < subject->swap_count; row++) {
        double swapped[4][3];
        double swapped_weight[4];
        for (int k = 0; k < 4; k++) {
            memcpy(swapped[k], x[subject->swaps[row][k]], sizeof(swapped[k]));
        }
        double swapped_distance = subject->closest((const double(*)[3])swapped, swapped_weight);
        Vec3 swapped_offset = offset_of((const double(*)[3])swapped, swapped_weight);
        double sign = row >= subject->is_negated_from ? -1.0 : 1.0;
        double gap = vlength(vsub(offset, vscale(sign, swapped_offset)));
        if (!(fabs(distance - swapped_distance) <= error && gap <= tolerance)) {
            ck_abort_msg("kind %d, swap %d: distance %.17g and %.17g, %.3g apart", (int)kind, row, distance,
                         swapped_distance, gap);
        }
    }
}

START_TEST(vertex_face_distance_equals_the_twin)
{
    for_all(&VERTEX_FACE, judge_distance);
}
END_TEST

START_TEST(edge_edge_distance_equals_the_twin)
{
    for_all(&EDGE_EDGE, judge_distance);
}
END_TEST

START_TEST(vertex_face_ignores_the_order_of_the_corners)
{
    for_all(&VERTEX_FACE, judge_swaps);
}
END_TEST

START_TEST(edge_edge_ignores_the_order_of_ends_and_edges)
{
    for_all(&EDGE_EDGE, judge_swaps);
}
END_TEST

// No sampled pair of points is nearer than the distance, and the best of a fine grid is nearly as near.
START_TEST(no_sample_is_nearer)
{
    enum { GRID = 60 };
    uint64_t seed = 4;
    for (int trial = 0; trial < 400; trial++) {
        double x[2][4][3];
        Kind kind = (Kind)(trial % KIND_COUNT);
        make_vertex_face(kind, &seed, 1.0, x[0]);
        make_edge_edge(kind, &seed, 1.0, x[1]);
        double best[2] = {HUGE_VAL, HUGE_VAL};
        for (int i = 0; i <= GRID; i++) {
            for (int j = 0; j <= GRID; j++) {
                double s = (double)i / GRID;
                double t = (double)j / GRID;
                const double edge[4] = {1.0 - s, s, t - 1.0, -t};
                best[1] = fmin(best[1], vlength(offset_of((const double(*)[3])x[1], edge)));
                const double face[4] = {1.0, -(1.0 - s), -s * (1.0 - t), -s * t};
                best[0] = fmin(best[0], vlength(offset_of((const double(*)[3])x[0], face)));
            }
        }
        for (int which = 0; which < 2; which++) {
            double weight[4];
            double distance = (which == 0 ? percale_vertex_face_closest
                                          : percale_edge_edge_closest)((const double(*)[3])x[which], weight);
            ck_assert_double_le(distance, best[which] + 1e-12);
            ck_assert_double_le(best[which],
                                distance + 8.0 / GRID); // a cell of the grid is at most that wide
        }
    }
}
END_TEST

// The seven regions of a triangle, with numbers that are exact in binary.
START_TEST(each_region_has_its_weights)
{
    static const struct {
        double q[3];
        double distance, weights[3];
    } CASES[] = {
        {{1.0, 1.0, 5.0}, 5.0, {0.5, 0.25, 0.25}}, {{2.0, -3.0, 4.0}, 5.0, {0.5, 0.5, 0.0}},
        {{4.0, 4.0, 1.0}, 3.0, {0.0, 0.5, 0.5}},   {{-3.0, 1.0, -4.0}, 5.0, {0.75, 0.0, 0.25}},
        {{-3.0, -4.0, 0.0}, 5.0, {1.0, 0.0, 0.0}}, {{7.0, -4.0, 0.0}, 5.0, {0.0, 1.0, 0.0}},
        {{-4.0, 7.0, 0.0}, 5.0, {0.0, 0.0, 1.0}},
    };
    for (size_t i = 0; i < sizeof(CASES) / sizeof(CASES[0]); i++) {
        double x[4][3] = {{0.0}, {0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, {0.0, 4.0, 0.0}};
        double weight[4];
        memcpy(x[0], CASES[i].q, sizeof(x[0]));
        double distance = percale_vertex_face_closest((const double(*)[3])x, weight);
        ck_assert_double_eq_tol(distance, CASES[i].distance, DBL_EPSILON);
        for (int k = 0; k < 3; k++) {
            ck_assert_double_eq_tol(-weight[k + 1], CASES[i].weights[k], DBL_EPSILON);
        }
    }
}
END_TEST

// Where a whole stretch of two parallel edges is nearest, the pair of smallest index is named.
START_TEST(parallel_edges_name_the_smallest_index)
{
    static const double X[4][3] = {{0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, {-1.0, 3.0, 4.0}, {3.0, 3.0, 4.0}};
    double weight[4];
    ck_assert_double_eq_tol(percale_edge_edge_closest(X, weight), 5.0, DBL_EPSILON);
    static const double EXPECTED[4] = {1.0, 0.0, -0.75, -0.25};
    for (int k = 0; k < 4; k++) {
        ck_assert_double_eq_tol(weight[k], EXPECTED[k], DBL_EPSILON);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("geometry");
    TCase *twins = tcase_create("twins");
    tcase_add_test(twins, vertex_face_distance_equals_the_twin);
    tcase_add_test(twins, edge_edge_distance_equals_the_twin);
    tcase_add_test(twins, vertex_face_ignores_the_order_of_the_corners);
    tcase_add_test(twins, edge_edge_ignores_the_order_of_ends_and_edges);
    tcase_add_test(twins, no_sample_is_nearer);
    suite_add_tcase(suite, twins);
    TCase *exact = tcase_create("exact");
    tcase_add_test(exact, each_region_has_its_weights);
    tcase_add_test(exact, parallel_edges_name_the_smallest_index);
    suite_add_tcase(suite, exact);
    return percale_test_run(suite);
}
