// png_file.h: writes an 8-bit RGB picture as PNG.
//
//   in   an open stream, pixels, a text for the file's description
//   out  the PNG's bytes on the stream

#ifndef PERCALE_PNG_FILE_H
#define PERCALE_PNG_FILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct PercalePixels {
    uint8_t *rgb; ///< [3 * width * height], rows from top to bottom
    uint32_t width, height;
} PercalePixels;

/// `description` goes into a tEXt chunk; NULL: none. False when libpng reports an error or the stream fails.
bool percale_png_write(FILE *stream, const PercalePixels *pixels, const char *description);

#endif
