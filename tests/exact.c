#include "exact.h"

#include "testing.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { POOL_LIMBS = 1 << 22, LIMB_BITS = 32 };

static uint32_t pool[POOL_LIMBS];
static size_t pool_used;

static const Exact ZERO = {0, 0, NULL};

void exact_forget(void)
{
    pool_used = 0;
}

static uint32_t *take(int count)
{
    if (pool_used + (size_t)count > POOL_LIMBS) { // each passing assertion would write a message
        ck_abort_msg("the pool of exact numbers is too small");
    }
    uint32_t *limbs = pool + pool_used;
    pool_used += (size_t)count;
    return limbs;
}

static Exact trimmed(int sign, const uint32_t *limbs, int count)
{
    while (count > 0 && limbs[count - 1] == 0) {
        count--;
    }
    return count > 0 ? (Exact){sign, count, limbs} : ZERO;
}

int exact_shift_of(double value)
{
    if (value == 0.0) {
        return 0;
    }
    int exponent;
    uint64_t digits = (uint64_t)ldexp(fabs(frexp(value, &exponent)), DBL_MANT_DIG);
    int shift = DBL_MANT_DIG - exponent;
    for (; digits % 2 == 0; digits /= 2) {
        shift--;
    }
    return shift;
}

Exact exact_scaled(double value, int shift)
{
    if (value == 0.0) {
        return ZERO;
    }
    int own = exact_shift_of(value);
    if (own > shift) {
        ck_abort_msg("%a has more digits than %d", value, shift);
    }
    uint64_t digits = (uint64_t)ldexp(fabs(value), own);
    uint32_t *limbs = take(2);
    limbs[0] = (uint32_t)digits;
    limbs[1] = (uint32_t)(digits >> LIMB_BITS);
    return exact_shifted(trimmed(value < 0.0 ? -1 : 1, limbs, 2), shift - own);
}

Exact exact_shifted(Exact a, int bits)
{
    if (a.sign == 0 || bits == 0) {
        return a;
    }
    int whole = bits / LIMB_BITS;
    int rest = bits % LIMB_BITS;
    int count = a.count + whole + 1;
    uint32_t *limbs = take(count);
    memset(limbs, 0, sizeof(*limbs) * (size_t)count);
    for (int i = 0; i < a.count; i++) {
        uint64_t both = (uint64_t)a.limbs[i] << rest;
        limbs[whole + i] |= (uint32_t)both;
        limbs[whole + i + 1] = (uint32_t)(both >> LIMB_BITS);
    }
    return trimmed(a.sign, limbs, count);
}

static int compare_sizes(Exact a, Exact b)
{
    if (a.count != b.count) {
        return a.count < b.count ? -1 : 1;
    }
    for (int i = a.count - 1; i >= 0; i--) {
        if (a.limbs[i] != b.limbs[i]) {
            return a.limbs[i] < b.limbs[i] ? -1 : 1;
        }
    }
    return 0;
}

/// |a| + |b| or |a| - |b|, where |a| >= |b|.
static Exact combine(int sign, Exact a, Exact b, bool minus)
{
    uint32_t *limbs = take(a.count + 1);
    uint64_t carry = 0;
    for (int i = 0; i < a.count; i++) {
        uint64_t other = (i < b.count ? b.limbs[i] : 0) + carry;
        uint64_t result = minus ? (uint64_t)a.limbs[i] - other : (uint64_t)a.limbs[i] + other;
        limbs[i] = (uint32_t)result;
        carry = (result >> LIMB_BITS) & 1;
    }
    limbs[a.count] = minus ? 0 : (uint32_t)carry;
    return trimmed(sign, limbs, a.count + 1);
}

Exact exact_add(Exact a, Exact b)
{
    if (a.sign == 0 || b.sign == 0) {
        return a.sign == 0 ? b : a;
    }
    if (a.sign != b.sign && compare_sizes(a, b) == 0) {
        return ZERO;
    }
    if (compare_sizes(a, b) < 0) {
        return combine(b.sign, b, a, a.sign != b.sign);
    }
    return combine(a.sign, a, b, a.sign != b.sign);
}

static Exact negative(Exact a)
{
    a.sign = -a.sign;
    return a;
}

Exact exact_subtract(Exact a, Exact b)
{
    return exact_add(a, negative(b));
}

Exact exact_multiply(Exact a, Exact b)
{
    if (a.sign == 0 || b.sign == 0) {
        return ZERO;
    }
    int count = a.count + b.count;
    uint32_t *limbs = take(count);
    memset(limbs, 0, sizeof(*limbs) * (size_t)count);
    for (int i = 0; i < a.count; i++) {
        uint64_t carry = 0;
        for (int j = 0; j < b.count; j++) {
            carry += (uint64_t)a.limbs[i] * b.limbs[j] + limbs[i + j];
            limbs[i + j] = (uint32_t)carry;
            carry >>= LIMB_BITS;
        }
        limbs[i + b.count] = (uint32_t)carry;
    }
    return trimmed(a.sign * b.sign, limbs, count);
}

double exact_to_double(Exact a)
{
    enum { LEADING = 3 };
    double value = 0.0;
    int first = a.count > LEADING ? a.count - LEADING : 0;
    for (int i = a.count - 1; i >= first; i--) {
        value = value * 0x1p32 + (double)a.limbs[i];
    }
    return (double)a.sign * ldexp(value, LIMB_BITS * first);
}

// ---- polynomials ----

static Polynomial shortened(Polynomial p)
{
    while (p.degree >= 0 && p.c[p.degree].sign == 0) {
        p.degree--;
    }
    return p;
}

Polynomial polynomial_linear(Exact constant, Exact slope)
{
    return shortened((Polynomial){.degree = 1, .c = {constant, slope}});
}

static Exact coefficient(const Polynomial *p, int i)
{
    return i <= p->degree ? p->c[i] : ZERO;
}

static Polynomial sum_of(const Polynomial *a, const Polynomial *b, bool minus)
{
    Polynomial sum = {.degree = a->degree > b->degree ? a->degree : b->degree};
    for (int i = 0; i <= sum.degree; i++) {
        Exact other = coefficient(b, i);
        sum.c[i] = exact_add(coefficient(a, i), minus ? negative(other) : other);
    }
    return shortened(sum);
}

Polynomial polynomial_add(const Polynomial *a, const Polynomial *b)
{
    return sum_of(a, b, false);
}

Polynomial polynomial_subtract(const Polynomial *a, const Polynomial *b)
{
    return sum_of(a, b, true);
}

Polynomial polynomial_multiply(const Polynomial *a, const Polynomial *b)
{
    if (a->degree < 0 || b->degree < 0) {
        return (Polynomial){.degree = -1};
    }
    Polynomial product = {.degree = a->degree + b->degree};
    if (product.degree > DEGREE_MOST) {
        ck_abort_msg("degree %d", product.degree);
    }
    for (int i = 0; i <= a->degree; i++) {
        for (int j = 0; j <= b->degree; j++) {
            product.c[i + j] = exact_add(product.c[i + j], exact_multiply(a->c[i], b->c[j]));
        }
    }
    return shortened(product);
}

Polynomial polynomial_without_root(const Polynomial *p, int root)
{
    Polynomial rest = *p;
    while (rest.degree > 0 && polynomial_sign(&rest, (double)root) == 0) {
        Polynomial quotient = {.degree = rest.degree - 1};
        Exact carried = ZERO; // Horner's scheme
        for (int i = rest.degree; i > 0; i--) {
            carried = root == 0 ? rest.c[i] : exact_add(carried, rest.c[i]);
            quotient.c[i - 1] = carried;
        }
        rest = quotient;
    }
    return rest;
}

int polynomial_sign(const Polynomial *p, double t)
{
    if (p->degree < 0) {
        return 0;
    }
    int shift = exact_shift_of(t);
    shift = shift > 0 ? shift : 0;
    Exact numerator = exact_scaled(t, shift);
    Exact value = p->c[p->degree];
    for (int i = p->degree - 1; i >= 0; i--) {
        value = exact_add(exact_multiply(value, numerator), exact_shifted(p->c[i], shift * (p->degree - i)));
    }
    return value.sign;
}

/// Divided by the power of two in all coefficients, so that numbers stay short.
static void shorten_numbers(Polynomial *p)
{
    int limbs = -1;
    for (int i = 0; i <= p->degree; i++) {
        int zero = 0;
        while (zero < p->c[i].count && p->c[i].limbs[zero] == 0) {
            zero++;
        }
        if (p->c[i].sign != 0 && (limbs < 0 || zero < limbs)) {
            limbs = zero;
        }
    }
    for (int i = 0; i <= p->degree && limbs > 0; i++) {
        if (p->c[i].sign != 0) {
            p->c[i].limbs += limbs;
            p->c[i].count -= limbs;
        }
    }
}

/// A positive multiple of -(a mod b).
static Polynomial negative_remainder(const Polynomial *a, const Polynomial *b)
{
    Polynomial rest = *a;
    Exact leading = b->c[b->degree];
    while (rest.degree >= b->degree) {
        Polynomial next = {.degree = rest.degree - 1};
        Exact top = rest.c[rest.degree];
        top.sign *= leading.sign;
        Exact factor = leading;
        factor.sign = 1;
        int offset = rest.degree - b->degree;
        for (int i = 0; i < rest.degree; i++) {
            Exact off = i >= offset ? exact_multiply(top, b->c[i - offset]) : ZERO;
            next.c[i] = exact_subtract(exact_multiply(factor, rest.c[i]), off);
        }
        rest = shortened(next);
    }
    for (int i = 0; i <= rest.degree; i++) {
        rest.c[i] = negative(rest.c[i]);
    }
    shorten_numbers(&rest);
    return rest;
}

static Polynomial derivative(const Polynomial *p)
{
    Polynomial d = {.degree = p->degree - 1};
    for (int i = 1; i <= p->degree; i++) {
        d.c[i - 1] = exact_multiply(p->c[i], exact_scaled((double)i, 0));
    }
    return d;
}

void chain_make(Chain *chain, const Polynomial *p, const Polynomial *g)
{
    Polynomial slope = derivative(p);
    chain->p[0] = *p;
    chain->p[1] = g ? polynomial_multiply(&slope, g) : slope;
    chain->count = 1;
    while (chain->p[chain->count].degree >= 0) {
        int last = chain->count++;
        if (chain->count >= DEGREE_MOST + 4) {
            ck_abort_msg("a chain of more than %d", chain->count);
        }
        chain->p[chain->count] = negative_remainder(&chain->p[last - 1], &chain->p[last]);
    }
}

static int variations(const Chain *chain, double t)
{
    int changes = 0;
    int before = 0;
    for (int i = 0; i < chain->count; i++) {
        int sign = polynomial_sign(&chain->p[i], t);
        changes += sign * before < 0;
        before = sign != 0 ? sign : before;
    }
    return changes;
}

int chain_sum(const Chain *chain, double a, double b)
{
    return variations(chain, a) - variations(chain, b);
}

int polynomial_sign_between(const Polynomial *p, double a, double b)
{
    const double ROUNDING = 0x1p-48; // of the sum of the terms' sizes, above that of all operations here
    double low = 0.0;
    double high = 0.0;
    double terms = 0.0;
    for (int i = p->degree; i >= 0; i--) {
        double c = exact_to_double(p->c[i]);
        low = c + fmin(low * a, low * b);
        high = c + fmax(high * a, high * b);
        terms = fabs(c) + terms * b;
    }
    return low > ROUNDING * terms ? 1 : high < -ROUNDING * terms ? -1 : 0;
}
