#include "cli/machine.h"

#include "percale/types.h"

#include <unistd.h>

uint64_t percale_machine_threads(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    if (count < 1)
        return 1;
    return count > PERCALE_MAX_THREADS ? PERCALE_MAX_THREADS : (uint64_t)count;
}
