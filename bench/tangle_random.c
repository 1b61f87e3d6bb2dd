#include "tangle_random.h"

#include "bench_random.h"
#include "scene/shapes.h"
#include "tangle_sheet.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

static double between(uint64_t *seed, double low, double high)
{
    return low + (high - low) * bench_random(seed);
}

static bool add_sheet(TangleCase *tangle, const Pattern *pattern, uint64_t *seed)
{
    return tangle_sheet_make(pattern, seed, &tangle->cloths[tangle->cloth_count++]);
}

// ---- smooth random displacement ----

enum { WAVES = 12 };

/// A sum of waves.
typedef struct Waves {
    double amplitude[WAVES][3], u[WAVES], v[WAVES], phase[WAVES];
} Waves;

/// amplitude: of the sum, about, m; shortest: wavelength, m.
static Waves draw_waves(uint64_t *seed, double amplitude, double shortest)
{
    Waves waves;
    for (int i = 0; i < WAVES; i++) {
        double turn = between(seed, 0.0, 2.0 * PI);
        double number = 2.0 * PI / between(seed, shortest, 4.0 * shortest);
        waves.u[i] = number * cos(turn);
        waves.v[i] = number * sin(turn);
        waves.phase[i] = between(seed, 0.0, 2.0 * PI);
        for (int axis = 0; axis < 3; axis++) {
            waves.amplitude[i][axis] = amplitude * bench_random_signed(seed) * sqrt(6.0 / WAVES);
        }
    }
    return waves;
}

static void add_waves(const Waves *waves, double u, double v, Place *place)
{
    for (int i = 0; i < WAVES; i++) {
        double wave = sin(waves->u[i] * u + waves->v[i] * v + waves->phase[i]);
        place->x += waves->amplitude[i][0] * wave;
        place->y += waves->amplitude[i][1] * wave;
        place->z += waves->amplitude[i][2] * wave;
    }
}

// ---- a garment pushed into a body ----

/// A tube with a slit around an ellipsoid.
typedef struct Garment {
    double radius, height; // m, of the ellipsoid
    double clearance, squeeze, push[3];
    Waves folds;
} Garment;

static Place put_on(const void *context, double u, double v)
{
    const Garment *garment = context;
    double angle = u / garment->radius;
    double level = v / garment->height;
    double around = garment->squeeze * (garment->radius * sqrt(1.0 - level * level) + garment->clearance);
    Place place = {around * cos(angle) + garment->push[0], v + garment->push[1],
                   around * sin(angle) + garment->push[2]};
    add_waves(&garment->folds, u, v, &place);
    return place;
}

static bool make_body(TangleCase *tangle, uint64_t *seed)
{
    const double CENTRE[3] = {0.0, 0.0, 0.0};
    PercaleSceneError error = {""};
    Garment garment = {.radius = between(seed, 0.08, 0.14),
                       .height = between(seed, 0.25, 0.35),
                       .clearance = 0.006,
                       .squeeze = between(seed, 0.92, 1.02)};
    double push = between(seed, 0.002, 0.03);
    double turn = between(seed, 0.0, 2.0 * PI);
    garment.push[0] = push * cos(turn);
    garment.push[1] = between(seed, -0.02, 0.02);
    garment.push[2] = push * sin(turn);
    garment.folds = draw_waves(seed, between(seed, 0.0, 0.006), 0.08);
    tangle->edge = between(seed, 0.009, 0.016);
    tangle->extent = push + 0.08 * garment.radius;
    double round = PI * garment.radius;
    Pattern pattern = {"garment",
                       {-0.95 * round, 0.95 * round},
                       {-0.5 * garment.height, 0.5 * garment.height},
                       tangle->edge,
                       put_on,
                       &garment};
    if (!percale_icosphere_make("body", 4, 1.0, CENTRE, &tangle->body, &error)) {
        return false;
    }
    for (uint32_t i = 0; i < tangle->body.vertex_count; i++) {
        float *x = tangle->body.positions + 3 * (size_t)i;
        x[0] *= (float)garment.radius;
        x[1] *= (float)garment.height;
        x[2] *= (float)garment.radius;
    }
    return add_sheet(tangle, &pattern, seed);
}

// ---- two layers swapped over a part of their area ----

typedef struct Layer {
    double gap;      // m
    double sign;     // +1 lies above, but where they are swapped
    double radius;   // m, of a swapped disc; 0: a half plane
    double limit;    // m, of the half plane
    double softness; // m, over which they change sides
    Waves ground;    // the same for both
} Layer;

static Place lay(const void *context, double u, double v)
{
    const Layer *layer = context;
    double outside = layer->radius > 0.0 ? sqrt(u * u + v * v) - layer->radius : layer->limit - u;
    Place place = {u, 0.5 * layer->sign * layer->gap * tanh(outside / layer->softness), v};
    add_waves(&layer->ground, u, v, &place);
    return place;
}

static bool make_layers(TangleCase *tangle, uint64_t *seed)
{
    double fraction = between(seed, 0.1, 0.5);
    bool is_disc = bench_random(seed) < 0.6;
    tangle->edge = between(seed, 0.008, 0.016);
    Layer layer = {.gap = between(seed, 0.3, 2.0) * tangle->edge,
                   .radius = is_disc ? TANGLE_SIZE * sqrt(fraction / PI) : 0.0,
                   .limit = TANGLE_SIZE * (0.5 - fraction),
                   .softness = between(seed, 0.5, 3.0) * tangle->edge,
                   .ground = draw_waves(seed, between(seed, 0.0, 0.01), 0.15)};
    tangle->extent = layer.gap;
    bool is_ordered = bench_random(seed) < 0.5;
    double half = 0.5 * TANGLE_SIZE;
    bool complete = true;
    for (int i = 0; complete && i < 2; i++) {
        layer.sign = i == 0 ? 1.0 : -1.0;
        tangle->layers[i] = is_ordered ? i : 0; // sheets face down: the outer layer is the lower one
        Pattern pattern = {
            i == 0 ? "inner" : "outer", {-half, half}, {-half, half}, tangle->edge, lay, &layer};
        complete = add_sheet(tangle, &pattern, seed);
    }
    return complete;
}

// ---- a fold pushed through ----

typedef struct Fold {
    double radius;    // m, of the fold
    double flap;      // m, length of the upper part
    double depth;     // m, below the lower part
    double centre[2]; // m, of what is pushed through, on the lower part
    double width;     // m
    Waves ground;
} Fold;

static Place fold_over(const void *context, double u, double v)
{
    const Fold *fold = context;
    double arc = PI * fold->radius;
    Place place = {u, 0.0, v};
    if (u > 0.0 && u < arc) {
        place.x = fold->radius * sin(u / fold->radius);
        place.y = fold->radius * (1.0 - cos(u / fold->radius));
    } else if (u >= arc) {
        place.x = arc - u;
        double across = place.x - fold->centre[0];
        double along = v - fold->centre[1];
        double push = exp(-(across * across + along * along) / (fold->width * fold->width));
        place.y = 2.0 * fold->radius - (2.0 * fold->radius + fold->depth) * push;
    }
    add_waves(&fold->ground, place.x, v, &place);
    return place;
}

static bool make_fold(TangleCase *tangle, uint64_t *seed)
{
    double half = 0.5 * TANGLE_SIZE;
    tangle->edge = between(seed, 0.008, 0.016);
    Fold fold = {.radius = between(seed, 0.8, 2.5) * tangle->edge,
                 .flap = between(seed, 0.4, 0.8) * TANGLE_SIZE,
                 .depth = between(seed, 0.3, 2.5) * tangle->edge,
                 .width = between(seed, 0.08, 0.2) * TANGLE_SIZE,
                 .ground = draw_waves(seed, between(seed, 0.0, 0.006), 0.15)};
    double arc = PI * fold.radius;
    fold.centre[0] = -between(seed, 0.35, 1.0) * fold.flap; // from the middle of the flap to its rim
    fold.centre[1] = between(seed, -half, half);            // and to its corners
    tangle->extent = fold.depth + 2.0 * fold.radius;
    Pattern pattern = {"folded", {-TANGLE_SIZE, arc + fold.flap}, {-half, half}, tangle->edge, fold_over,
                       &fold};
    return add_sheet(tangle, &pattern, seed);
}

// ---- crumpled sheets put into each other ----

typedef struct Crumple {
    double offset[3];
    Waves waves;
} Crumple;

static Place crumple(const void *context, double u, double v)
{
    const Crumple *crumpled = context;
    Place place = {u + crumpled->offset[0], crumpled->offset[1], v + crumpled->offset[2]};
    add_waves(&crumpled->waves, u, v, &place);
    return place;
}

static bool make_crumpled(TangleCase *tangle, uint64_t *seed)
{
    double half = 0.5 * TANGLE_SIZE;
    double amplitude = between(seed, 0.004, 0.016);
    tangle->edge = between(seed, 0.009, 0.014);
    tangle->extent = 2.0 * amplitude;
    bool complete = true;
    for (int i = 0; complete && i < 2; i++) {
        Crumple crumpled = {.waves = draw_waves(seed, amplitude, 0.09)};
        for (int axis = 0; axis < 3; axis++) {
            double most = axis == 1 ? 1.5 * amplitude : 0.1;
            crumpled.offset[axis] = i == 1 ? most * bench_random_signed(seed) : 0.0;
        }
        Pattern pattern = {
            i == 0 ? "first" : "second", {-half, half}, {-half, half}, tangle->edge, crumple, &crumpled};
        complete = add_sheet(tangle, &pattern, seed);
    }
    return complete;
}

bool tangle_random_make(uint32_t seed, TangleCase *tangle)
{
    uint64_t state = hash_add(hash_add(hash_start(), (uint32_t)tangle->kind), seed);
    switch (tangle->kind) {
    case TANGLE_KIND_BODY:
        return make_body(tangle, &state);
    case TANGLE_KIND_LAYERS:
        return make_layers(tangle, &state);
    case TANGLE_KIND_FOLD:
        return make_fold(tangle, &state);
    case TANGLE_KIND_CRUMPLED:
        return make_crumpled(tangle, &state);
    case TANGLE_KIND_STANDARD:
    case TANGLE_KINDS:
        break;
    }
    return false;
}
