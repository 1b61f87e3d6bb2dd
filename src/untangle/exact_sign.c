#include "untangle/exact_sign.h"

#include <stdbool.h>
#include <stddef.h>

// Share of the sum of absolute products below which rounding may have turned the sign: above Shewchuk's
// 7.8e-16 (1997).
static const double FILTER = 1e-15;

enum {
    POINTS = 4,
    ONE = 3, // the column of the matrix (x, y, z, 1) that holds no coordinate
    ORDERS = 24,
    MASKS = 1 << 12, // sets of infinitesimals, one for each coordinate of each point
    TERMS = 48       // 24 products of three floats are 48 doubles
};

/// The ways to take one column from each row; the sign is that of the permutation.
static const struct Order {
    uint8_t column[POINTS];
    int8_t sign;
} COLUMN_ORDERS[ORDERS] = {
    {{0, 1, 2, 3}, 1},  {{0, 1, 3, 2}, -1}, {{0, 2, 1, 3}, -1}, {{0, 2, 3, 1}, 1},  {{0, 3, 1, 2}, 1},
    {{0, 3, 2, 1}, -1}, {{1, 0, 2, 3}, -1}, {{1, 0, 3, 2}, 1},  {{1, 2, 0, 3}, 1},  {{1, 2, 3, 0}, -1},
    {{1, 3, 0, 2}, -1}, {{1, 3, 2, 0}, 1},  {{2, 0, 1, 3}, 1},  {{2, 0, 3, 1}, -1}, {{2, 1, 0, 3}, -1},
    {{2, 1, 3, 0}, 1},  {{2, 3, 0, 1}, 1},  {{2, 3, 1, 0}, -1}, {{3, 0, 1, 2}, -1}, {{3, 0, 2, 1}, 1},
    {{3, 1, 0, 2}, 1},  {{3, 1, 2, 0}, -1}, {{3, 2, 0, 1}, -1}, {{3, 2, 1, 0}, 1},
};

/// A sum without rounding: components grow in magnitude and don't overlap (Shewchuk 1997, theorem 10).
typedef struct Expansion {
    double components[TERMS];
    size_t count;
} Expansion;

static void add_term(Expansion *sum, double term)
{
    size_t kept = 0;
    for (size_t i = 0; i < sum->count; i++) {
        double component = sum->components[i];
        double total = term + component;
        double part = total - term;
        double error = (term - (total - part)) + (component - part);
        if (error != 0.0) {
            sum->components[kept++] = error;
        }
        term = total;
    }
    if (term != 0.0) {
        sum->components[kept++] = term;
    }
    sum->count = kept;
}

static int sign_of(double value)
{
    return (value > 0.0) - (value < 0.0);
}

/// The sign of the coefficient that the infinitesimals of the mask have in the determinant of the points;
/// mask 0: of the determinant itself. Bit 3 i + 2 - c stands for coordinate c of point i.
static int coefficient_sign(const Vec3 points[POINTS], uint32_t mask)
{
    Expansion sum = {.count = 0};
    for (int order = 0; order < ORDERS; order++) {
        double factors[3] = {1.0, 1.0, 1.0};
        uint32_t left = mask;
        uint32_t count = 0;
        for (uint32_t row = 0; row < POINTS; row++) {
            uint32_t column = COLUMN_ORDERS[order].column[row];
            uint32_t bit = column == ONE ? 0 : 1U << (3 * row + 2 - column);
            if ((mask & bit) != 0) {
                left &= ~bit;
            } else if (column != ONE) {
                const double coordinates[3] = {points[row].x, points[row].y, points[row].z};
                factors[count++] = coordinates[column];
            }
        }
        if (left == 0) {
            double pair = factors[0] * factors[1]; // two floats: exact
            double triple = pair * factors[2];
            add_term(&sum, COLUMN_ORDERS[order].sign * fma(pair, factors[2], -triple));
            add_term(&sum, COLUMN_ORDERS[order].sign * triple);
        }
    }
    return sum.count == 0 ? 0 : sign_of(sum.components[sum.count - 1]);
}

/// The sign by rounded arithmetic, 0 where it can't be told.
static int filtered_sign(const Vec3 points[POINTS])
{
    double row[3][3];
    for (int k = 0; k < 3; k++) {
        Vec3 difference = vsub(points[k + 1], points[0]);
        row[k][0] = difference.x;
        row[k][1] = difference.y;
        row[k][2] = difference.z;
    }
    double determinant = 0.0;
    double permanent = 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        double plus = row[1][j] * row[2][k];
        double minus = row[1][k] * row[2][j];
        determinant += row[0][i] * (plus - minus);
        permanent += fabs(row[0][i]) * (fabs(plus) + fabs(minus));
    }
    return fabs(determinant) > FILTER * permanent ? sign_of(determinant) : 0;
}

int percale_plane_side(const f32x4 *x, const uint32_t numbers[4])
{
    Vec3 points[POINTS];
    for (int k = 0; k < POINTS; k++) {
        points[k] = vec3_of(x[numbers[k]]);
    }
    int sign = filtered_sign(points);
    if (sign != 0) {
        return sign;
    }
    uint32_t sorted[POINTS] = {numbers[0], numbers[1], numbers[2], numbers[3]};
    int parity = -1; // the determinant of rows (x, y, z, 1) is that of the differences turned round
    for (int i = 1; i < POINTS; i++) {
        for (int k = i; k > 0 && sorted[k] < sorted[k - 1]; k--) {
            uint32_t smaller = sorted[k];
            sorted[k] = sorted[k - 1];
            sorted[k - 1] = smaller;
            parity = -parity;
        }
    }
    for (int k = 0; k < POINTS; k++) {
        points[k] = vec3_of(x[sorted[k]]);
    }
    for (uint32_t mask = 0; sign == 0 && mask < MASKS; mask++) {
        sign =
            coefficient_sign(points, mask); // ends at the latest where the three infinitesimals stand alone
    }
    return parity * sign;
}
