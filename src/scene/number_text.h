// number_text.h: numbers from and to text, the same under every locale of the host.

#ifndef PERCALE_NUMBER_TEXT_H
#define PERCALE_NUMBER_TEXT_H

#include "percale/scene.h"

enum { PERCALE_NUMBER_TEXT_SIZE = 32 }; ///< bytes that percale_number_format needs

/// Reads a decimal number ("-1.5e3", ".5", "5.") that begins at *at and moves *at behind it. Exact to the
/// last bit up to 15 digits, else within one unit in the last place. False, *at unmoved: not a number, or too
/// large for a double. NaN and infinity are not numbers.
bool percale_number_parse(const char **at, const char *end, double *value);

/// Writes 9 significant digits: enough to give back every float. Returns the length.
size_t percale_number_format(char text[PERCALE_NUMBER_TEXT_SIZE], double value);

#endif
