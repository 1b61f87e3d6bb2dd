// machine.h: what the machine offers.

#ifndef PERCALE_MACHINE_H
#define PERCALE_MACHINE_H

#include <stdint.h>

/// Processors, 1 .. PERCALE_MAX_THREADS.
uint64_t percale_machine_threads(void);

#endif
