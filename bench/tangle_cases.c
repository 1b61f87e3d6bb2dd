#include "tangle_cases.h"

#include "tangle_random.h"
#include "tangle_sheet.h"

#include <math.h>
#include <string.h>

static const float THICKNESS = 0.002f; // m

// ---- the seven standard cases ----

/// What a case's maps know.
typedef struct Standard {
    double depth; // m
    double edge;  // m
} Standard;

static Place level(const void *context, double u, double v)
{
    (void)context;
    return (Place){u, 0.0, v};
}

static Place upright(const void *context, double u, double v)
{
    (void)context;
    return (Place){u, v, 0.013 * TANGLE_SIZE};
}

static Place upright_across(const void *context, double u, double v)
{
    (void)context;
    return (Place){0.017 * TANGLE_SIZE, v, u};
}

/// Whitney's umbrella: a folded sheet whose halves go through each other along a line from the fold to the
/// rim.
static Place umbrella(const void *context, double u, double v)
{
    (void)context;
    return (Place){u, 2.0 / TANGLE_SIZE * v * v + 0.15 * v, 1.5 / TANGLE_SIZE * u * v};
}

/// A dent in a layer above the level one.
static Place dent(const void *context, double u, double v)
{
    const Standard *standard = context;
    double gap = 0.05 * TANGLE_SIZE;
    double radius = 0.2 * TANGLE_SIZE;
    return (Place){u, gap - (gap + standard->depth) * exp(-(u * u + v * v) / (radius * radius)), v};
}

/// A curve that is bent into a bell and, where `loop` is above 1, goes through itself.
static Place bend(double v, double loop)
{
    double width = 0.15 * TANGLE_SIZE;
    double bell = exp(-v * v / (width * width));
    return (Place){0.0, 0.2 * TANGLE_SIZE * bell, v * (1.0 - loop * bell)};
}

/// How far the loop of a curve is closed when its crossing is so far from its middle, m.
static double loop_of(double reach)
{
    double width = 0.15 * TANGLE_SIZE;
    return exp(reach * reach / (width * width));
}

/// A ruffle that loops through itself in its middle.
static Place ruffle(const void *context, double u, double v)
{
    const Standard *standard = context;
    double half = 0.25 * TANGLE_SIZE;
    Place place = bend(v, 1.0 + (loop_of(standard->depth) - 1.0) * (1.0 - u * u / (half * half)));
    return (Place){u, place.y, place.z};
}

/// The lower rim of a hanging cloth, with a ruffle that loops through itself.
static Place ruffled_rim(const void *context, double u, double v)
{
    const double REACH = 2.0; // edges
    const Standard *standard = context;
    double half = 0.25 * TANGLE_SIZE;
    Place place = bend(v, 1.0 + (loop_of(REACH * standard->edge) - 1.0) * (1.0 - u * u / (half * half)));
    return (Place){place.z, u, place.y};
}

/// The patterns of a case; names are percale_contour_kind_name's.
static uint32_t list_standard(const char *name, const Standard *standard, Pattern patterns[TANGLE_CLOTHS_MAX])
{
    double d = standard->depth;
    double e = standard->edge;
    double half = 0.5 * TANGLE_SIZE;
    const Pattern ground = {"level", {-half, half}, {-half, half}, e, level, standard};
    patterns[0] = ground;
    if (strcmp(name, "BBII") == 0) {
        patterns[1] =
            (Pattern){"strip", {-0.22 * TANGLE_SIZE, 0.22 * TANGLE_SIZE}, {-d, half}, e, upright, standard};
    } else if (strcmp(name, "BIBI") == 0) {
        patterns[1] = (Pattern){"strip",
                                {half - d, half + 0.4 * TANGLE_SIZE},
                                {-0.25 * TANGLE_SIZE, 0.25 * TANGLE_SIZE},
                                e,
                                upright,
                                standard};
    } else if (strcmp(name, "Closed") == 0) {
        patterns[1] = (Pattern){"dent", {-half, half}, {-half, half}, e, dent, standard};
    } else if (strcmp(name, "Eight") == 0) {
        patterns[1] =
            (Pattern){"rim", {-d, half}, {-0.4 * TANGLE_SIZE, 0.4 * TANGLE_SIZE}, e, ruffled_rim, standard};
    } else if (strcmp(name, "Cross") == 0) {
        patterns[1] = (Pattern){
            "strip", {-0.2 * TANGLE_SIZE, 0.2 * TANGLE_SIZE}, {-d, 0.4 * TANGLE_SIZE}, e, upright, standard};
        patterns[2] = (Pattern){"across",
                                {0.013 * TANGLE_SIZE - d, 0.4 * TANGLE_SIZE},
                                {-0.7 * d, 0.35 * TANGLE_SIZE},
                                e,
                                upright_across,
                                standard};
        return 3;
    } else if (strcmp(name, "BLI") == 0) {
        patterns[0] = (Pattern){"umbrella", {-d, 0.7 * TANGLE_SIZE}, {-half, half}, e, umbrella, standard};
        return 1;
    } else {
        patterns[0] = (Pattern){"ruffle", {-half, half}, {-half, half}, e, ruffle, standard};
        return 1;
    }
    return 2;
}

const char *tangle_standard_name(uint32_t index)
{
    static const char *const NAMES[TANGLE_STANDARD] = {"BBII",  "BIBI",  "BLI", "Closed",
                                                       "Cross", "Eight", "LL"};
    return NAMES[index];
}

bool tangle_case_make_standard(const char *name, uint32_t depth, uint32_t resolution, TangleCase *tangle)
{
    static const double DEPTHS[TANGLE_DEPTHS] = {0.6, 1.6, 3.2}; // edges
    static const double RESOLUTIONS[TANGLE_RESOLUTIONS] = {20.0, 40.0};
    Standard standard = {.edge = TANGLE_SIZE / RESOLUTIONS[resolution]};
    standard.depth = DEPTHS[depth] * standard.edge;
    Pattern patterns[TANGLE_CLOTHS_MAX];
    uint64_t seed = 1 + depth + TANGLE_DEPTHS * resolution;
    *tangle = (TangleCase){.kind = TANGLE_KIND_STANDARD,
                           .thickness = THICKNESS,
                           .edge = standard.edge,
                           .extent = standard.depth};
    (void)snprintf(tangle->name, sizeof tangle->name, "standard/%s/depth:%.1f/%.0f", name, DEPTHS[depth],
                   RESOLUTIONS[resolution]);
    uint32_t count = list_standard(name, &standard, patterns);
    bool complete = true;
    while (complete && tangle->cloth_count < count) {
        complete =
            tangle_sheet_make(&patterns[tangle->cloth_count], &seed, &tangle->cloths[tangle->cloth_count]);
        tangle->cloth_count++;
    }
    return complete;
}

void tangle_case_free(TangleCase *tangle)
{
    for (uint32_t i = 0; i < tangle->cloth_count; i++) {
        percale_mesh_free(&tangle->cloths[i]);
    }
    percale_mesh_free(&tangle->body);
    *tangle = (TangleCase){.kind = TANGLE_KIND_STANDARD};
}

// ---- all ----

enum { STANDARD_COUNT = TANGLE_STANDARD * TANGLE_DEPTHS * TANGLE_RESOLUTIONS };

/// How many of each kind.
static const uint32_t COUNTS[TANGLE_KINDS] = {STANDARD_COUNT, 66, 66, 66, 66};

uint32_t tangle_case_count(void)
{
    uint32_t sum = 0;
    for (int kind = 0; kind < TANGLE_KINDS; kind++) {
        sum += COUNTS[kind];
    }
    return sum;
}

const char *tangle_kind_name(TangleKind kind)
{
    static const char *const NAMES[TANGLE_KINDS] = {"standard", "body", "layers", "fold", "crumpled"};
    return NAMES[kind];
}

bool tangle_case_make(uint32_t index, TangleCase *tangle)
{
    int kind = TANGLE_KIND_STANDARD;
    while (index >= COUNTS[kind]) {
        index -= COUNTS[kind++];
    }
    if (kind == TANGLE_KIND_STANDARD) {
        uint32_t depth = index / TANGLE_RESOLUTIONS % TANGLE_DEPTHS;
        uint32_t standard = index / (TANGLE_RESOLUTIONS * TANGLE_DEPTHS);
        return tangle_case_make_standard(tangle_standard_name(standard), depth, index % TANGLE_RESOLUTIONS,
                                         tangle);
    }
    *tangle = (TangleCase){.kind = (TangleKind)kind, .thickness = THICKNESS};
    (void)snprintf(tangle->name, sizeof tangle->name, "%s/%u", tangle_kind_name(tangle->kind), index);
    return tangle_random_make(index, tangle);
}
