#include "cli/table.h"

#include <inttypes.h>
#include <stdio.h>

static const double MEGABYTE = 1e6; // bytes

static void print_quality_row(const char *name, double worst, double last)
{
    (void)printf("  %-26s %14.6g %14.6g\n", name, worst, last);
}

static void print_quality(const PercaleQuality *worst, const PercaleQuality *last)
{
    (void)printf("%-28s %14s %14s\n", "quality", "worst", "last frame");
#define ROW(name) print_quality_row(#name, worst->name, last->name);
    PERCALE_QUALITIES(ROW)
#undef ROW
}

void percale_table_print(const PercaleReport *report)
{
    (void)printf("%s: %" PRIu64 " vertices, %" PRIu64 " triangles, %" PRIu64 " obstacle triangles\n",
                 report->scene, report->vertices, report->triangles, report->obstacle_triangles);
    (void)printf("%u frames, preset %s, %d threads, %s\n\n", (unsigned)report->frames, report->preset,
                 report->threads, percale_isa_name(report->isa));
    (void)printf("%-28s %14s %14s %14s\n", "ms per frame", "median", "p90", "last 60");
    (void)printf("  %-26s %14.3f %14.3f %14.3f\n", "step", report->ms_per_frame_median,
                 report->ms_per_frame_p90, report->ms_per_frame_last60);
    (void)printf("%-28s %14s\n", "stages", "mean");
    for (int stage = 0; stage < PERCALE_STAGE_COUNT; ++stage)
        (void)printf("  %-26s %14.3f\n", percale_stage_name((PercaleStage)stage), report->stage_ms[stage]);
    print_quality(&report->quality, &report->quality_last);
    if (report->crossing[0] != '\0')
        (void)printf("%s\n", report->crossing);
    (void)printf("\n%-28s %14.1f MB, %.0f bytes per cloth vertex\n", "peak memory",
                 (double)report->peak_bytes / MEGABYTE,
                 (double)report->peak_bytes / (double)report->vertices);
    PercaleBytes bytes = report->bytes;
    uint64_t held = bytes.model + bytes.detect + bytes.color + bytes.solve + bytes.arena;
    (void)printf("%-28s %14.1f MB, %.0f bytes per cloth vertex\n", "held by the solver",
                 (double)held / MEGABYTE, (double)held / (double)report->vertices);
    (void)printf("%-26s %016" PRIx64 "\n", "state hash", report->state_hash);
}

void percale_audit_table_print(const PercaleAuditReport *report)
{
    (void)printf("%u cloths: %" PRIu64 " vertices, %" PRIu64 " triangles; %u obstacles: %" PRIu64
                 " triangles; thickness %g m\n",
                 (unsigned)report->cloths, report->vertices, report->triangles, (unsigned)report->obstacles,
                 report->obstacle_triangles, report->thickness);
#define ROW(name) (void)printf("  %-26s %14.6g\n", #name, report->quality.name);
    PERCALE_QUALITIES(ROW)
#undef ROW
}

void percale_untangle_table_print(const PercaleUntangleCommandReport *report)
{
    (void)printf("%u cloths: %" PRIu64 " vertices, %" PRIu64 " triangles; %u obstacles: %" PRIu64
                 " triangles; thickness %g m\n",
                 (unsigned)report->cloths, report->vertices, report->triangles, (unsigned)report->obstacles,
                 report->obstacle_triangles, report->settings.thickness);
    (void)printf("  %-26s %14.0f %14.0f\n", "pairs before, after", report->ef_before, report->ef_after);
    (void)printf("  %-26s %14" PRIu64 " %14" PRIu64 "\n", "contours before, after",
                 report->work.contours_before, report->work.contours_after);
    (void)printf("  %-26s %14d\n", "iterations", report->work.iterations);
    (void)printf("  %-26s %14.6g\n", "displacement_max_mm", 1e3 * report->work.displacement_max);
    (void)printf("  %-26s %14.6g\n", "momentum_drift", report->work.momentum_drift);
    (void)printf("  %-26s %14.6g\n", "ms", 1e3 * report->work.seconds);
}
