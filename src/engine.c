#include "engine.h"

extern const PercaleEngine PERCALE_ENGINE;

const PercaleEngine PERCALE_ENGINE = {PERCALE_ENGINE_ISA, percale_run_substeps, percale_sweep_run};
