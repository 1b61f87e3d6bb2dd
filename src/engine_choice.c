#include "engine.h"

extern const PercaleEngine percale_engine_sse2; // on other architectures: what they all have
#if defined(PERCALE_WIDE_ENGINES)
extern const PercaleEngine percale_engine_avx2, percale_engine_avx512;
#endif

const PercaleEngine *percale_engine_for(PercaleIsa isa)
{
    const PercaleEngine *engines[PERCALE_ISA_AVX512 + 1] = {NULL};
    engines[PERCALE_ISA_SSE2] = &percale_engine_sse2;
#if defined(PERCALE_WIDE_ENGINES)
    if (__builtin_cpu_supports("avx2")) {
        engines[PERCALE_ISA_AVX2] = &percale_engine_avx2;
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq")) {
        engines[PERCALE_ISA_AVX512] = &percale_engine_avx512;
    }
#endif
    if (isa != PERCALE_ISA_AUTO) {
        return engines[isa];
    }
    int widest = PERCALE_ISA_AVX512;
    while (engines[widest] == NULL) {
        widest--;
    }
    return engines[widest];
}
