// complaint.h: how the command line says what went wrong: one line on stderr, and an exit code.

#ifndef PERCALE_COMPLAINT_H
#define PERCALE_COMPLAINT_H

enum {
    PERCALE_EXIT_DONE = 0,
    PERCALE_EXIT_FAILED = 1, ///< the simulation, or the writing of its results, failed
    PERCALE_EXIT_USAGE = 2   ///< bad arguments or bad input; nothing has been written
};

/// Prints "percale: ..." and returns `code`. Line breaks and other control characters become '?'.
int percale_complain(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
