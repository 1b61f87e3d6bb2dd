// report.h: what a run or an audit found, and its JSON.
//
//   in   a filled PercaleReport
//   out  strict JSON with the keys of the command line's contract, in its order, every key always there
//
// A number that is not finite is written as 0: JSON has no other way to say it.

#ifndef PERCALE_REPORT_H
#define PERCALE_REPORT_H

#include "percale/scene.h"

typedef struct PercaleReport {
    const char *scene; ///< as the user named it
    const char *preset;
    int threads;
    PercaleIsa isa;
    uint32_t frames; ///< that were stepped without an error
    uint64_t vertices, triangles, obstacle_triangles;
    const PercaleSetting *settings;
    uint32_t setting_count;
    double ms_per_frame_median, ms_per_frame_p90, ms_per_frame_last60;
    double stage_ms[PERCALE_STAGE_COUNT]; ///< mean per frame
    PercaleCounters work;
    PercaleQuality quality;      ///< worst over the audited frames
    PercaleQuality quality_last; ///< of the last frame
    char crossing[512]; ///< where triangles cross, at the frame with most of that; "" where none does
    PercaleBytes bytes;
    uint64_t peak_bytes; ///< of the whole process, audits included
    uint64_t state_hash;
} PercaleReport;

typedef struct PercaleAuditReport {
    uint32_t cloths, obstacles;
    uint64_t vertices, triangles, obstacle_triangles;
    double thickness; ///< m
    PercaleQuality quality;
} PercaleAuditReport;

/// What `percale untangle --set` takes.
typedef struct PercaleUntangleSettings {
    double thickness; ///< m
    double layers;    ///< 1: the cloths are layers, the first innermost; 0: not
    double rounds, sweeps, patience;
} PercaleUntangleSettings;

typedef struct PercaleUntangleCommandReport {
    int threads;
    PercaleIsa isa;
    uint32_t cloths, obstacles;
    uint64_t vertices, triangles, obstacle_triangles;
    PercaleUntangleSettings settings;
    double ef_before, ef_after; ///< pairs of triangles that cross, as the audit counts them
    PercaleUntangleReport work;
    PercaleQuality quality_before, quality;
    uint64_t state_hash;
} PercaleUntangleCommandReport;

/// "sse2", "avx2", "avx512"
const char *percale_isa_name(PercaleIsa isa);

/// Median and 90th percentile (nearest rank) of the frames' times; fills the three ms_per_frame fields.
/// `milliseconds` is sorted in place.
void percale_report_times(PercaleReport *report, double *milliseconds, uint32_t count);

/// Takes into `worst` whatever is worse in `quality`.
void percale_quality_worsen(PercaleQuality *worst, const PercaleQuality *quality);

/// `path` "-" is standard output; a file is written under a temporary name and renamed.
bool percale_report_write(const PercaleReport *report, const char *path, PercaleSceneError *error);
bool percale_audit_report_write(const PercaleAuditReport *report, const char *path, PercaleSceneError *error);
bool percale_untangle_report_write(const PercaleUntangleCommandReport *report, const char *path,
                                   PercaleSceneError *error);

#endif
