#include "scene/number_text.h"

#include <math.h>
#include <stdint.h>

enum {
    MANTISSA_DIGITS = 19,    // that always fit into 64 bits; later ones can't matter
    EXPONENT_LIMIT = 100000, // beyond any double, far from overflow of an int
    EXACT_POWER = 22         // 10^22 is the largest power of ten that a double holds exactly
};

typedef struct Decimal {
    uint64_t mantissa;
    int digits;   // significant ones in mantissa
    int exponent; // value = mantissa * 10^exponent
    bool found;   // at least one digit seen
} Decimal;

static bool is_digit(const char *at, const char *end)
{
    return at < end && *at >= '0' && *at <= '9';
}

static const char *parse_digits(const char *at, const char *end, bool fraction, Decimal *decimal)
{
    for (; is_digit(at, end); ++at) {
        decimal->found = true;
        if (decimal->digits < MANTISSA_DIGITS) {
            decimal->mantissa = 10 * decimal->mantissa + (uint64_t)(*at - '0');
            decimal->digits += decimal->mantissa != 0;
            decimal->exponent -= fraction && decimal->exponent > -EXPONENT_LIMIT;
        } else if (!fraction && decimal->exponent < EXPONENT_LIMIT) {
            ++decimal->exponent;
        }
    }
    return at;
}

// An 'e' without digits behind it is not part of the number.
static const char *parse_exponent(const char *at, const char *end, Decimal *decimal)
{
    const char *digit = at + 1;
    if (at >= end || (*at != 'e' && *at != 'E')) {
        return at;
    }
    const bool negative = digit < end && *digit == '-';
    if (digit < end && (*digit == '-' || *digit == '+')) {
        ++digit;
    }
    if (!is_digit(digit, end)) {
        return at;
    }
    int exponent = 0;
    for (; is_digit(digit, end); ++digit) {
        exponent = exponent < EXPONENT_LIMIT ? 10 * exponent + (*digit - '0') : exponent;
    }
    decimal->exponent += negative ? -exponent : exponent;
    return digit;
}

// One rounding for a mantissa below 2^53 and a power that is exact; a few steps for the far ends of the
// range.
static double scale(uint64_t mantissa, int exponent)
{
    static const double powers[EXACT_POWER + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    double value = (double)mantissa;
    while (exponent > EXACT_POWER && value != 0.0 && isfinite(value)) {
        value *= powers[EXACT_POWER];
        exponent -= EXACT_POWER;
    }
    while (exponent < -EXACT_POWER && value != 0.0) {
        value /= powers[EXACT_POWER];
        exponent += EXACT_POWER;
    }
    if (value == 0.0 || !isfinite(value)) {
        return value;
    }
    return exponent < 0 ? value / powers[-exponent] : value * powers[exponent];
}

bool percale_number_parse(const char **at, const char *end, double *value)
{
    const char *cursor = *at;
    const bool negative = cursor < end && *cursor == '-';
    if (cursor < end && (*cursor == '-' || *cursor == '+')) {
        ++cursor;
    }
    Decimal decimal = {0};
    cursor = parse_digits(cursor, end, false, &decimal);
    if (cursor < end && *cursor == '.') {
        cursor = parse_digits(cursor + 1, end, true, &decimal);
    }
    if (!decimal.found) {
        return false;
    }
    cursor = parse_exponent(cursor, end, &decimal);
    const double magnitude = scale(decimal.mantissa, decimal.exponent);
    if (!isfinite(magnitude)) {
        return false;
    }
    *value = negative ? -magnitude : magnitude;
    *at = cursor;
    return true;
}

size_t percale_number_format(char text[PERCALE_NUMBER_TEXT_SIZE], double value)
{
    const int length = snprintf(text, PERCALE_NUMBER_TEXT_SIZE, "%.9g", value);
    size_t used = 0;
    for (int k = 0; k < length; ++k) {
        const bool plain =
            (text[k] >= '0' && text[k] <= '9') || text[k] == '-' || text[k] == '+' || text[k] == 'e';
        // Whatever else there is, is the host's decimal separator, of one byte or several.
        if (plain) {
            text[used++] = text[k];
        } else if (used == 0 || text[used - 1] != '.') {
            text[used++] = '.';
        }
    }
    text[used] = '\0';
    return used;
}
