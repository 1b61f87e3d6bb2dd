// exact.h: integers of any length, and polynomials over them, for oracles that may not round.
//
// Numbers live in one pool until exact_forget(). A polynomial is {degree, coefficients}; degree -1 is zero.

#ifndef PERCALE_TESTS_EXACT_H
#define PERCALE_TESTS_EXACT_H

#include <stdbool.h>
#include <stdint.h>

typedef struct Exact {
    int sign;              // -1, 0, 1
    int count;             // limbs; the highest is not 0
    const uint32_t *limbs; // lowest first
} Exact;

/// All numbers so far are gone.
void exact_forget(void);

/// value * 2^shift, which has to be an integer.
Exact exact_scaled(double value, int shift);
/// The shift with which a value becomes an odd integer; 0 for 0.
int exact_shift_of(double value);
Exact exact_add(Exact a, Exact b);
Exact exact_subtract(Exact a, Exact b);
Exact exact_multiply(Exact a, Exact b);
/// a * 2^bits, bits >= 0.
Exact exact_shifted(Exact a, int bits);
/// Off by less than 2^-50 of the value; below 2^1000.
double exact_to_double(Exact a);

enum { DEGREE_MOST = 8 };

typedef struct Polynomial {
    int degree;
    Exact c[DEGREE_MOST + 1];
} Polynomial;

Polynomial polynomial_linear(Exact constant, Exact slope);
Polynomial polynomial_add(const Polynomial *a, const Polynomial *b);
Polynomial polynomial_subtract(const Polynomial *a, const Polynomial *b);
Polynomial polynomial_multiply(const Polynomial *a, const Polynomial *b);
/// P / (t - root)^n for root 0 or 1 and the largest n; P not zero.
Polynomial polynomial_without_root(const Polynomial *p, int root);
int polynomial_sign(const Polynomial *p, double t);

/// Sturm's chain of P and P' g. At its ends P must not be 0.
typedef struct Chain {
    int count;
    Polynomial p[DEGREE_MOST + 4];
} Chain;

void chain_make(Chain *chain, const Polynomial *p, const Polynomial *g);
/// Sum of the signs of g at the distinct roots of P between a and b (Sturm, Tarski); with g = 1 their number.
int chain_sum(const Chain *chain, double a, double b);

/// The sign of P everywhere in [a, b], a >= 0, or 0 when doubles can't tell.
int polynomial_sign_between(const Polynomial *p, double a, double b);

#endif
