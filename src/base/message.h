// message.h: one line of text about what went wrong.

#ifndef PERCALE_MESSAGE_H
#define PERCALE_MESSAGE_H

#include "percale/types.h"

typedef struct PercaleMessage {
    char text[256];
} PercaleMessage;

/// Sets the text and returns `result`, so that a check reads `return percale_fail(message, ..., "...")`.
__attribute__((format(printf, 3, 4))) PercaleResult
percale_fail(PercaleMessage *message, PercaleResult result, const char *format, ...);
PercaleResult percale_fail_memory(PercaleMessage *message);

#endif
