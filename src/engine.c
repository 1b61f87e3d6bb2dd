#include "engine.h"

#include "step_untangle.h"

extern const PercaleEngine PERCALE_ENGINE;

const PercaleEngine PERCALE_ENGINE = {PERCALE_ENGINE_ISA, percale_run_substeps, percale_run_untangling,
                                      percale_sweep_run};
