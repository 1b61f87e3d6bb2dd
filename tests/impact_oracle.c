#include "impact_oracle.h"

#include "testing.h"

#include <math.h>
#include <string.h>

enum { CORNERS = 4 };

static const double FINE = 0x1p-40;   // to which a root is enclosed before its exact sign is taken
static const double FINEST = 0x1p-48; // interval in which roots are not parted any more

/// The differences of the features' points, in cyclic order: zero is in their hull when the features touch.
typedef struct Hull {
    int count;
    Polynomial r[CORNERS][3];
    Polynomial normal[3];
    Polynomial normal2;
    Polynomial plane;          // normal . r: 0 where all is in a plane with zero
    Polynomial sides[CORNERS]; // normal . (r_k x r_k+1): not below 0 where zero is inside side k
} Hull;

static void cross_of(const Polynomial a[3], const Polynomial b[3], Polynomial result[3])
{
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3;
        int e = (c + 2) % 3;
        Polynomial plus = polynomial_multiply(&a[d], &b[e]);
        Polynomial minus = polynomial_multiply(&a[e], &b[d]);
        result[c] = polynomial_subtract(&plus, &minus);
    }
}

static Polynomial dot_of(const Polynomial a[3], const Polynomial b[3])
{
    Polynomial sum = {.degree = -1};
    for (int c = 0; c < 3; c++) {
        Polynomial product = polynomial_multiply(&a[c], &b[c]);
        sum = polynomial_add(&sum, &product);
    }
    return sum;
}

static void from_to(const Polynomial a[3], const Polynomial b[3], Polynomial result[3])
{
    for (int c = 0; c < 3; c++) {
        result[c] = polynomial_subtract(&b[c], &a[c]);
    }
}

/// Which points each corner of the hull leads from and to.
static const int FACE_PAIRS[CORNERS][2] = {{0, 1}, {0, 2}, {0, 3}, {0, 0}};
static const int EDGE_PAIRS[CORNERS][2] = {{0, 2}, {0, 3}, {1, 3}, {1, 2}};

/// By what the coordinates become integers.
static int shift_of(const ImpactQuery *query)
{
    int shift = 0;
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            int a = exact_shift_of(query->start[k][c]);
            int b = exact_shift_of(query->end[k][c]);
            shift = a > shift ? a : shift;
            shift = b > shift ? b : shift;
        }
    }
    return shift;
}

static void make_corners(const ImpactQuery *query, int shift, Hull *hull)
{
    Polynomial x[4][3];
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            Exact from = exact_scaled(query->start[k][c], shift);
            Exact to = exact_scaled(query->end[k][c], shift);
            x[k][c] = polynomial_linear(from, exact_subtract(to, from));
        }
    }
    hull->count = query->edges ? 4 : 3;
    for (int k = 0; k < hull->count; k++) {
        const int *pair = query->edges ? EDGE_PAIRS[k] : FACE_PAIRS[k];
        from_to(x[pair[0]], x[pair[1]], hull->r[k]);
    }
}

static void make_tests(Hull *hull)
{
    Polynomial u[3];
    Polynomial v[3];
    from_to(hull->r[0], hull->r[1], u);
    from_to(hull->r[0], hull->r[hull->count - 1], v);
    cross_of(u, v, hull->normal);
    hull->normal2 = dot_of(hull->normal, hull->normal);
    hull->plane = dot_of(hull->normal, hull->r[0]);
    for (int k = 0; k < hull->count; k++) {
        Polynomial area[3];
        cross_of(hull->r[k], hull->r[(k + 1) % hull->count], area);
        hull->sides[k] = dot_of(hull->normal, area);
    }
}

// ---- signs at a time ----

/// Halves the interval until it is no wider.
static void refine(ExactTime *time, double width)
{
    const Polynomial *p = &time->chain.p[0];
    while (time->high - time->low > width) {
        double middle = 0.5 * (time->low + time->high);
        int there = polynomial_sign(p, middle);
        if (there == 0) {
            time->low = time->high = middle;
            return;
        }
        int before = polynomial_sign(p, time->low);
        bool simple = before * polynomial_sign(p, time->high) < 0;
        if (simple ? before * there < 0 : chain_sum(&time->chain, time->low, middle) == 1) {
            time->high = middle;
        } else {
            time->low = middle;
        }
    }
}

static int sign_at(ExactTime *time, const Polynomial *g)
{
    if (g->degree < 0) {
        return 0;
    }
    const double WIDTHS[] = {0x1p-8, 0x1p-24, FINE};
    for (size_t i = 0; i < sizeof(WIDTHS) / sizeof(WIDTHS[0]) && time->low < time->high; i++) {
        refine(time, WIDTHS[i]);
        int sign = polynomial_sign_between(g, time->low, time->high);
        if (sign != 0) {
            return sign;
        }
    }
    if (time->low >= time->high) {
        return polynomial_sign(g, time->low);
    }
    Chain chain;
    chain_make(&chain, &time->chain.p[0], g);
    return chain_sum(&chain, time->low, time->high);
}

/// Whether all corners and zero are on one line there, with zero between two of them.
static bool zero_between(const Hull *hull, ExactTime *time)
{
    for (int i = 0; i < hull->count; i++) {
        for (int j = i + 1; j < hull->count; j++) {
            Polynomial area[3];
            cross_of(hull->r[i], hull->r[j], area);
            Polynomial product = dot_of(hull->r[i], hull->r[j]);
            if (sign_at(time, &area[0]) == 0 && sign_at(time, &area[1]) == 0 &&
                sign_at(time, &area[2]) == 0 && sign_at(time, &product) <= 0) {
                return true;
            }
        }
    }
    return false;
}

static bool touch_at(const Hull *hull, ExactTime *time)
{
    for (int k = 0; k < hull->count; k++) {
        if (sign_at(time, &hull->sides[k]) < 0) {
            return false;
        }
    }
    if (sign_at(time, &hull->plane) != 0) {
        return false;
    }
    return sign_at(time, &hull->normal2) > 0 || zero_between(hull, time);
}

// ---- events ----

static void add_time(ImpactTruth *truth, const ExactTime *time)
{
    if (truth->count >= EVENTS_MOST) {
        ck_abort_msg("%d events", truth->count);
    }
    truth->times[truth->count++] = *time;
}

/// A place in between where P is not 0.
static double part_at(const Polynomial *p, double low, double high)
{
    static const double PLACES[] = {0.5, 0.375, 0.625, 0.4375, 0.5625, 0.40625, 0.59375, 0.25, 0.75};
    for (size_t i = 0; i < sizeof(PLACES) / sizeof(PLACES[0]); i++) {
        double place = low + PLACES[i] * (high - low);
        if (polynomial_sign(p, place) != 0) {
            return place;
        }
    }
    ck_abort_msg("more roots than the degree");
    return low;
}

/// The first root between low and high at which they touch, if any. True when one is found.
static bool search_roots(const Hull *hull, const Chain *chain, double low, double high, ImpactTruth *truth)
{
    int count = chain_sum(chain, low, high);
    if (count == 0) {
        return false;
    }
    if (count == 1) {
        ExactTime time = {low, high, *chain};
        if (!touch_at(hull, &time)) {
            return false;
        }
        add_time(truth, &time);
        return true;
    }
    if (high - low < FINEST) {
        truth->undecided = true;
        return false;
    }
    double middle = part_at(&chain->p[0], low, high);
    return search_roots(hull, chain, low, middle, truth) || search_roots(hull, chain, middle, high, truth);
}

static void search_event(const Hull *hull, const Polynomial *event, ImpactTruth *truth)
{
    if (event->degree <= 0) {
        return;
    }
    Polynomial p = polynomial_without_root(event, 0);
    p = polynomial_without_root(&p, 1);
    if (p.degree <= 0) {
        return;
    }
    Chain chain;
    chain_make(&chain, &p, NULL);
    (void)search_roots(hull, &chain, 0.0, 1.0, truth);
}

static void search_line_events(const Hull *hull, ImpactTruth *truth)
{
    for (int i = 0; i < hull->count; i++) {
        for (int j = i + 1; j < hull->count; j++) {
            Polynomial area[3];
            cross_of(hull->r[i], hull->r[j], area);
            Polynomial product = dot_of(hull->r[i], hull->r[j]);
            for (int c = 0; c < 3; c++) {
                search_event(hull, &area[c], truth);
            }
            search_event(hull, &product, truth);
        }
    }
}

void impact_truth(const ImpactQuery *query, ImpactTruth *truth)
{
    Hull hull;
    make_corners(query, shift_of(query), &hull);
    make_tests(&hull);
    truth->count = 0;
    truth->undecided = false;
    ExactTime begin = {0.0, 0.0, {.count = 0}};
    if (touch_at(&hull, &begin)) {
        add_time(truth, &begin);
        return;
    }
    if (hull.plane.degree >= 0) {
        search_event(&hull, &hull.plane, truth);
    } else if (hull.normal2.degree >= 0) {
        search_event(&hull, &hull.normal2, truth);
        for (int k = 0; k < hull.count; k++) {
            search_event(&hull, &hull.sides[k], truth);
        }
    } else {
        search_line_events(&hull, truth);
    }
    ExactTime finish = {1.0, 1.0, {.count = 0}};
    if (truth->count == 0 && touch_at(&hull, &finish)) {
        add_time(truth, &finish);
    }
}

static int order_of(const ExactTime *exact, double time)
{
    if (time <= exact->low || time >= exact->high) {
        return exact->low >= exact->high && time == exact->low ? 0 : time <= exact->low ? 1 : -1;
    }
    if (polynomial_sign(&exact->chain.p[0], time) == 0) {
        return 0;
    }
    return chain_sum(&exact->chain, exact->low, time) == 1 ? -1 : 1;
}

int impact_truth_order(const ImpactTruth *truth, double time)
{
    int least = 1;
    for (int i = 0; i < truth->count; i++) {
        int order = order_of(&truth->times[i], time);
        least = order < least ? order : least;
    }
    return least;
}

double impact_truth_time(ImpactTruth *truth)
{
    double first = 1.0;
    for (int i = 0; i < truth->count; i++) {
        refine(&truth->times[i], FINE);
        first = fmin(first, truth->times[i].low);
    }
    return first;
}

// ---- distances ----

/// Polynomials of degree 0: the hull at a moment, all scaled by one power of two, whose exponent is returned.
static int freeze(const ImpactQuery *query, double time, Hull *hull)
{
    Hull moving;
    int shift = shift_of(query);
    make_corners(query, shift, &moving);
    int digits = exact_shift_of(time);
    digits = digits > 0 ? digits : 0;
    Exact t = exact_scaled(time, digits);
    hull->count = moving.count;
    for (int k = 0; k < moving.count; k++) {
        for (int c = 0; c < 3; c++) {
            const Polynomial *p = &moving.r[k][c];
            Exact constant = p->degree >= 0 ? exact_shifted(p->c[0], digits) : exact_scaled(0.0, 0);
            Exact slope = p->degree >= 1 ? exact_multiply(p->c[1], t) : exact_scaled(0.0, 0);
            hull->r[k][c] = polynomial_linear(exact_add(constant, slope), exact_scaled(0.0, 0));
        }
    }
    make_tests(hull);
    return shift + digits;
}

static int sign_of_constant(const Polynomial *p)
{
    return p->degree < 0 ? 0 : p->c[0].sign;
}

/// a <= b
static bool at_most(const Polynomial *a, const Polynomial *b)
{
    Polynomial rest = polynomial_subtract(b, a);
    return sign_of_constant(&rest) >= 0;
}

static bool side_within(const Hull *hull, int k, const Polynomial *separation2)
{
    const Polynomial *r = hull->r[k];
    Polynomial side[3];
    Polynomial area[3];
    from_to(r, hull->r[(k + 1) % hull->count], side);
    cross_of(r, side, area);
    Polynomial area2 = dot_of(area, area);
    Polynomial length2 = dot_of(side, side);
    Polynomial most = polynomial_multiply(separation2, &length2);
    Polynomial along = dot_of(r, side); // the foot is at -along / length2
    Polynomial rest = polynomial_add(&along, &length2);
    return sign_of_constant(&length2) > 0 && sign_of_constant(&along) <= 0 && sign_of_constant(&rest) >= 0 &&
           at_most(&area2, &most);
}

static bool inside_within(const Hull *hull, const Polynomial *separation2)
{
    for (int k = 0; k < hull->count; k++) {
        if (sign_of_constant(&hull->sides[k]) < 0) {
            return false;
        }
    }
    Polynomial plane2 = polynomial_multiply(&hull->plane, &hull->plane);
    Polynomial most = polynomial_multiply(separation2, &hull->normal2);
    return sign_of_constant(&hull->normal2) > 0 && at_most(&plane2, &most);
}

bool impact_within(const ImpactQuery *query, double separation, double time)
{
    Hull hull;
    int shift = freeze(query, time, &hull);
    int own = exact_shift_of(separation);
    // a separation finer than the coordinates is scaled up with them
    int more = own > shift ? own - shift : 0;
    for (int k = 0; k < hull.count; k++) {
        for (int c = 0; c < 3; c++) {
            hull.r[k][c].c[0] = exact_shifted(hull.r[k][c].c[0], more);
        }
    }
    make_tests(&hull);
    Exact s = exact_scaled(separation, shift + more);
    Polynomial separation2 = polynomial_linear(exact_multiply(s, s), exact_scaled(0.0, 0));
    for (int k = 0; k < hull.count; k++) {
        Polynomial length2 = dot_of(hull.r[k], hull.r[k]);
        if (at_most(&length2, &separation2) || side_within(&hull, k, &separation2)) {
            return true;
        }
    }
    return inside_within(&hull, &separation2);
}

typedef struct LongVec {
    long double x[3];
} LongVec;

static long double long_dot(LongVec a, LongVec b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static LongVec long_along(LongVec a, long double t, LongVec b) // a + t b
{
    for (int c = 0; c < 3; c++) {
        a.x[c] += t * b.x[c];
    }
    return a;
}

static LongVec long_cross(LongVec a, LongVec b)
{
    LongVec result;
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3;
        int e = (c + 2) % 3;
        result.x[c] = a.x[d] * b.x[e] - a.x[e] * b.x[d];
    }
    return result;
}

static LongVec corner_at(const ImpactQuery *query, int k, double time)
{
    const int *pair = query->edges ? EDGE_PAIRS[k] : FACE_PAIRS[k];
    long double t = (long double)time;
    LongVec r;
    for (int c = 0; c < 3; c++) {
        long double from = (long double)query->start[pair[1]][c] - (long double)query->start[pair[0]][c];
        long double to = (long double)query->end[pair[1]][c] - (long double)query->end[pair[0]][c];
        r.x[c] = (1.0L - t) * from + t * to;
    }
    return r;
}

long double impact_distance(const ImpactQuery *query, double time)
{
    int count = query->edges ? 4 : 3;
    LongVec r[CORNERS];
    long double best2 = HUGE_VALL;
    for (int k = 0; k < count; k++) {
        r[k] = corner_at(query, k, time);
    }
    for (int k = 0; k < count; k++) {
        LongVec side = long_along(r[(k + 1) % count], -1.0L, r[k]);
        long double length2 = long_dot(side, side);
        long double t = length2 > 0.0L ? -long_dot(r[k], side) / length2 : 0.0L;
        LongVec nearest = long_along(r[k], fminl(1.0L, fmaxl(0.0L, t)), side);
        best2 = fminl(best2, long_dot(nearest, nearest));
    }
    LongVec normal = long_cross(long_along(r[1], -1.0L, r[0]), long_along(r[count - 1], -1.0L, r[0]));
    long double normal2 = long_dot(normal, normal);
    bool inside = normal2 > 0.0L;
    for (int k = 0; k < count; k++) {
        inside = inside && long_dot(normal, long_cross(r[k], r[(k + 1) % count])) >= 0.0L;
    }
    long double plane = inside ? fabsl(long_dot(normal, r[0])) / sqrtl(normal2) : HUGE_VALL;
    return fminl(plane, sqrtl(best2));
}

/// Golden section around a sample that is lower than its neighbours; returns the time.
static double lowest_between(const ImpactQuery *query, double low, double high)
{
    const double GOLDEN = 0.6180339887498949;
    const int ROUNDS = 70;
    double inner[2] = {high - GOLDEN * (high - low), low + GOLDEN * (high - low)};
    long double value[2] = {impact_distance(query, inner[0]), impact_distance(query, inner[1])};
    for (int round = 0; round < ROUNDS; round++) {
        if (value[0] < value[1]) {
            high = inner[1];
            inner[1] = inner[0];
            value[1] = value[0];
            inner[0] = high - GOLDEN * (high - low);
            value[0] = impact_distance(query, inner[0]);
        } else {
            low = inner[0];
            inner[0] = inner[1];
            value[0] = value[1];
            inner[1] = low + GOLDEN * (high - low);
            value[1] = impact_distance(query, inner[1]);
        }
    }
    return value[0] < value[1] ? inner[0] : inner[1];
}

static void keep_lower(const ImpactQuery *query, double time, long double *least, double *best)
{
    long double distance = impact_distance(query, time);
    if (distance < *least) {
        *least = distance;
        *best = time;
    }
}

double impact_least_distance(const ImpactQuery *query, double *time)
{
    enum { SAMPLES = 24 };
    long double samples[SAMPLES + 1];
    long double least = HUGE_VALL;
    for (int i = 0; i <= SAMPLES; i++) {
        samples[i] = impact_distance(query, (double)i / SAMPLES);
        keep_lower(query, (double)i / SAMPLES, &least, time);
    }
    for (int i = 0; i <= SAMPLES; i++) {
        bool lower =
            (i == 0 || samples[i] <= samples[i - 1]) && (i == SAMPLES || samples[i] <= samples[i + 1]);
        if (lower) {
            double low = i > 0 ? (double)(i - 1) / SAMPLES : 0.0;
            double high = i < SAMPLES ? (double)(i + 1) / SAMPLES : 1.0;
            keep_lower(query, lowest_between(query, low, high), &least, time);
        }
    }
    return (double)least;
}

double impact_size(const ImpactQuery *query)
{
    double size = 0.0;
    for (int k = 0; k < (query->edges ? 4 : 3); k++) {
        LongVec from = corner_at(query, k, 0.0);
        LongVec to = corner_at(query, k, 1.0);
        for (int c = 0; c < 3; c++) {
            size = fmax(size, (double)fmaxl(fabsl(from.x[c]), fabsl(to.x[c])));
        }
    }
    return size;
}

double impact_way(const ImpactQuery *query)
{
    double way = 0.0;
    for (int k = 0; k < (query->edges ? 4 : 3); k++) {
        LongVec from = corner_at(query, k, 0.0);
        LongVec to = corner_at(query, k, 1.0);
        for (int c = 0; c < 3; c++) {
            way = fmax(way, (double)fabsl(to.x[c] - from.x[c]));
        }
    }
    return way;
}
