#include "base/message.h"

#include <stdarg.h>
#include <stdio.h>

PercaleResult percale_fail(PercaleMessage *message, PercaleResult result, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(message->text, sizeof(message->text), format, arguments);
    va_end(arguments);
    return result;
}

PercaleResult percale_fail_memory(PercaleMessage *message)
{
    return percale_fail(message, PERCALE_OUT_OF_MEMORY, "out of memory");
}
