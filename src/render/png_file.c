#include "render/png_file.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

static void ignore_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void leave_on_error(png_structp png, png_const_charp text)
{
    (void)text;
    png_longjmp(png, 1);
}

static void add_text(png_structp png, png_infop info, char *key, char *text)
{
    png_text entry = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = text};
    png_set_text(png, info, &entry, 1); // copies both
}

/// Everything that libpng leaves by a jump when it fails; `description` may be NULL.
static bool write_guarded(png_structp png, png_infop info, FILE *stream, const PercalePixels *pixels,
                          char *description)
{
    char software_key[] = "Software";
    char software[] = "percale";
    char description_key[] = "Description";
    if (setjmp(png_jmpbuf(png)) != 0)
        return false;
    png_init_io(png, stream);
    png_set_IHDR(png, info, pixels->width, pixels->height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    add_text(png, info, software_key, software);
    if (description)
        add_text(png, info, description_key, description);
    png_write_info(png, info);
    for (uint32_t row = 0; row < pixels->height; ++row)
        png_write_row(png, pixels->rgb + 3 * (size_t)pixels->width * row);
    png_write_end(png, NULL);
    return true;
}

bool percale_png_write(FILE *stream, const PercalePixels *pixels, const char *description)
{
    char *text = description ? strdup(description) : NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, leave_on_error, ignore_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool written = info && (text || !description) && write_guarded(png, info, stream, pixels, text);
    png_destroy_write_struct(&png, &info);
    free(text);
    return written && fflush(stream) == 0;
}
