#include "cli/complaint.h"

#include <stdarg.h>
#include <stdio.h>

enum { COMPLAINT_SIZE = 1024 }; // bytes; longer file names are cut

int percale_complain(int code, const char *format, ...)
{
    char text[COMPLAINT_SIZE];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    for (char *character = text; *character; ++character)
        if ((unsigned char)*character < 0x20 || *character == 0x7f)
            *character = '?';
    (void)fprintf(stderr, "percale: %s\n", text);
    return code;
}
