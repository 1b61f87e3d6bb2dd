// The filters are Shewchuk's (1997) with rounder bounds. Exact: a product of two floats fits a double, one of
// three is the sum of two doubles, and a sum of doubles grows as an expansion without rounding (his theorem
// 10); the largest component has the sign of the whole.

#include "audit/audit_exact.h"

#include <math.h>
#include <stddef.h>

#define TERMS_MAX 48 // the determinant has 24 triple products of two components each

static const double FILTER = 1e-15; // above Shewchuk's 3.3e-16 (2D) and 7.8e-16 (3D) of the permanent

typedef struct Expansion {
    double components[TERMS_MAX]; // grows in magnitude; they don't overlap
    size_t count;
} Expansion;

static void add_term(Expansion *sum, double term)
{
    size_t kept = 0;
    for (size_t i = 0; i < sum->count; i++) {
        double component = sum->components[i];
        double total = term + component;
        double virtual_component = total - term;
        double error = (term - (total - virtual_component)) + (component - virtual_component);
        if (error != 0.0)
            sum->components[kept++] = error;
        term = total;
    }
    if (term != 0.0)
        sum->components[kept++] = term;
    sum->count = kept;
}

static int sign_of(double value)
{
    return (value > 0.0) - (value < 0.0);
}

static int sign_of_sum(const Expansion *sum)
{
    return sum->count == 0 ? 0 : sign_of(sum->components[sum->count - 1]);
}

static void add_triple(Expansion *sum, float a, float b, float c, double sign)
{
    double pair = (double)a * (double)b;
    double triple = pair * (double)c;
    add_term(sum, sign * fma(pair, (double)c, -triple));
    add_term(sum, sign * triple);
}

static void add_determinant(Expansion *sum, const float a[3], const float b[3], const float c[3], double sign)
{
    for (size_t i = 0; i < 3; i++) {
        size_t j = (i + 1) % 3;
        size_t k = (i + 2) % 3;
        add_triple(sum, a[i], b[j], c[k], sign);
        add_triple(sum, a[i], b[k], c[j], -sign);
    }
}

static int orient_exactly(const float a[3], const float b[3], const float c[3], const float d[3])
{
    Expansion sum = {.count = 0};
    add_determinant(&sum, a, b, c, 1.0);
    add_determinant(&sum, a, b, d, -1.0);
    add_determinant(&sum, a, c, d, 1.0);
    add_determinant(&sum, b, c, d, -1.0);
    return sign_of_sum(&sum);
}

int percale_audit_orient(const float a[3], const float b[3], const float c[3], const float d[3])
{
    double row[3][3];
    for (size_t axis = 0; axis < 3; axis++) {
        row[0][axis] = (double)a[axis] - (double)d[axis];
        row[1][axis] = (double)b[axis] - (double)d[axis];
        row[2][axis] = (double)c[axis] - (double)d[axis];
    }
    double determinant = 0.0;
    double permanent = 0.0;
    for (size_t i = 0; i < 3; i++) {
        size_t j = (i + 1) % 3;
        size_t k = (i + 2) % 3;
        double plus = row[1][j] * row[2][k];
        double minus = row[1][k] * row[2][j];
        determinant += row[0][i] * (plus - minus);
        permanent += fabs(row[0][i]) * (fabs(plus) + fabs(minus));
    }
    if (fabs(determinant) > FILTER * permanent)
        return sign_of(determinant);
    // Differences of equal numbers are exactly 0: what lies flat in an axis plane ends here.
    if (permanent == 0.0)
        return 0;
    return orient_exactly(a, b, c, d);
}

static int orient_yz_exactly(const float a[3], const float b[3], const float c[3])
{
    Expansion sum = {.count = 0};
    const float *corners[3] = {a, b, c};
    for (size_t i = 0; i < 3; i++) {
        const float *from = corners[i];
        const float *to = corners[(i + 1) % 3];
        add_term(&sum, (double)from[1] * (double)to[2]);
        add_term(&sum, -((double)from[2] * (double)to[1]));
    }
    return sign_of_sum(&sum);
}

int percale_audit_orient_yz(const float a[3], const float b[3], const float c[3])
{
    double plus = ((double)a[1] - (double)c[1]) * ((double)b[2] - (double)c[2]);
    double minus = ((double)a[2] - (double)c[2]) * ((double)b[1] - (double)c[1]);
    double area = plus - minus;
    if (fabs(area) > FILTER * (fabs(plus) + fabs(minus)))
        return sign_of(area);
    return orient_yz_exactly(a, b, c);
}
