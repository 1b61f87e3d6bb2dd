#include "detect/coplanar.h"

#include <stdbool.h>

// Share of the product of three lengths that their triple product may be off by: a few roundings.
static const double ROUNDING = 1e-14;

static double triple(Vec3 a, Vec3 b, Vec3 c)
{
    return vdot(a, vcross(b, c));
}

/// c[0] + c[1] t + c[2] t^2 + c[3] t^3.
static double cubic_at(const double c[4], double t)
{
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/// -1 or 1; 0: zero, as far as rounding lets one see.
static int sign_of(double value, double rounding)
{
    return (value > rounding) - (value < -rounding);
}

/// The root between two ends where the cubic has different signs, by bisection: it never leaves the interval.
static double root_between(const double c[4], double low, double high)
{
    const int HALVINGS = 60;
    bool low_positive = cubic_at(c, low) >= 0.0;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (low + high);
        if ((cubic_at(c, middle) >= 0.0) == low_positive) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

/// The root where the cubic turns in the plane without leaving it: three in one, which rounding hides from
/// bisection in a millionth of the way, while the turning points' mean is exact.
static double middle_of(const double *turns, int first, int last)
{
    return 0.5 * (turns[first] + turns[last]);
}

/// Where the cubic turns inside (0, 1), ascending.
static int turning_points(const double c[4], double turns[2])
{
    double a = 3.0 * c[3];
    double b = 2.0 * c[2];
    double discriminant = b * b - 4.0 * a * c[1];
    if (!(discriminant > 0.0)) {
        if (a == 0.0 && b == 0.0) {
            return 0;
        }
        discriminant = 0.0;
    }
    double q = -0.5 * (b + copysign(sqrt(discriminant), b));
    double found[2] = {a != 0.0 ? q / a : HUGE_VAL, q != 0.0 ? c[1] / q : HUGE_VAL};
    int count = 0;
    for (int i = 0; i < 2; i++) {
        if (found[i] > 0.0 && found[i] < 1.0) {
            turns[count++] = found[i];
        }
    }
    if (count == 2 && turns[0] > turns[1]) {
        double first = turns[1];
        turns[1] = turns[0];
        turns[0] = first;
    }
    return count;
}

int percale_coplanar_times(const Vec3 *from, const Vec3 *to, double times[3])
{
    Vec3 x[3];
    Vec3 v[3];
    for (int k = 0; k < 3; k++) {
        x[k] = vsub(from[k + 1], from[0]);
        v[k] = vsub(vsub(to[k + 1], to[0]), x[k]);
    }
    const double c[4] = {triple(x[0], x[1], x[2]),
                         triple(v[0], x[1], x[2]) + triple(x[0], v[1], x[2]) + triple(x[0], x[1], v[2]),
                         triple(x[0], v[1], v[2]) + triple(v[0], x[1], v[2]) + triple(v[0], v[1], x[2]),
                         triple(v[0], v[1], v[2])};
    double rounding = ROUNDING;
    for (int k = 0; k < 3; k++) {
        rounding *= vlength(x[k]) + vlength(v[k]);
    }
    double ends[4] = {0.0, 1.0, 1.0, 1.0};
    int pieces = turning_points(c, ends + 1) + 1;
    ends[pieces] = 1.0;
    int count = 0;
    int last = 0; // the last end that is not in the plane
    for (int i = 1; i <= pieces; i++) {
        int before = sign_of(cubic_at(c, ends[last]), rounding);
        int here = sign_of(cubic_at(c, ends[i]), rounding);
        if (before * here < 0) {
            times[count++] =
                last + 1 < i ? middle_of(ends, last + 1, i - 1) : root_between(c, ends[last], ends[i]);
        }
        last = here != 0 ? i : last;
    }
    return count;
}
