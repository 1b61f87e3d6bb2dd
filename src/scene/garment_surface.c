#include "garment_surface.h"

#include "body_field.h"

#include <math.h>
#include <string.h>

// m, in the body's coordinates.
static const double SKIRT_Y = 0.955;      // above it the skirt narrows quickly into the waist
static const double SKIRT_RADIUS = 0.113; // there
static const double SKIRT_FLAT = 0.060;   // half of the straight part of the oval in front and behind
static const double WAIST_FLARE = 1.20;   // radius gained per metre downwards above SKIRT_Y
static const double FLARE_BLEND = 0.04;   // half the height over which one flare becomes the other
static const double SKIRT_BLEND = 0.025;  // smooth union of skirt and bodice
static const double BODICE_END = 0.70;    // below it the trunk is out of reach

static const double SLEEVE_EASE = 0.024; // more radius at the elbow than the arm has
static const double ARM_BLEND = 0.070;   // wider than the body's: room under the arm

// Folds: they open from FOLD_TOP to the hem, and stand outside the plain skirt everywhere.
static const double FOLD_TOP = 0.93; // m
static const double TURN = 6.283185307179586;

static const int PROJECTIONS = 16; // Newton steps; two or three are the rule
static const double MARCH = 0.004; // m; steps in search of the surface
static const double REACH = 2.0;   // m; no ray of a wearable garment is so long

// Radius of the skirt's oval at a height, and how it changes with it: two straight lines and a parabola.
static double skirt_radius(const PercaleGarmentCut *cut, double y, double *slope)
{
    const double up = y - SKIRT_Y;
    const double bend = (WAIST_FLARE - cut->flare) / (4.0 * FLARE_BLEND);
    const double into = fmin(fmax(up + FLARE_BLEND, 0.0), 2.0 * FLARE_BLEND);
    const double beyond = fmax(up - FLARE_BLEND, 0.0);
    *slope = -cut->flare - 2.0 * bend * into;
    return SKIRT_RADIUS - cut->flare * up - bend * into * into - (WAIST_FLARE - cut->flare) * beyond;
}

static double skirt_field(const PercaleGarmentCut *cut, const double point[3], double gradient[3])
{
    const double over = fmax(fabs(point[0]) - SKIRT_FLAT, 0.0);
    const double x = copysign(over, point[0]);
    const double z = point[2] - PERCALE_GARMENT_AXIS_Z;
    const double off = sqrt(x * x + z * z);
    double slope;
    const double radius = skirt_radius(cut, point[1], &slope);
    const double steep = sqrt(1.0 + slope * slope);
    gradient[0] = off > 0.0 ? x / off / steep : 0.0;
    gradient[1] = -slope / steep;
    gradient[2] = off > 0.0 ? z / off / steep : 0.0;
    return (off - radius) / steep;
}

// Zero on the garment, without its folds.
static double garment_field(const PercaleGarmentSurface *surface, const double point[3], double gradient[3])
{
    double value = skirt_field(surface->cut, point, gradient);
    if (point[1] > BODICE_END) {
        double bodice_gradient[3];
        const double bodice =
            percale_bodice_field(point, SLEEVE_EASE, ARM_BLEND, bodice_gradient) - surface->clearance;
        percale_smooth_union(&value, gradient, bodice, bodice_gradient, SKIRT_BLEND);
    }
    return value - surface->outwards;
}

void percale_garment_settle(const PercaleGarmentSurface *surface, double tolerance, double point[3])
{
    for (int step = 0; step < PROJECTIONS; step++) {
        double gradient[3];
        const double value = garment_field(surface, point, gradient);
        const double square =
            gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
        if (fabs(value) <= tolerance || !(square > 0.0)) {
            return;
        }
        for (int k = 0; k < 3; k++) {
            point[k] -= value / square * gradient[k];
        }
    }
}

void percale_garment_march_out(const PercaleGarmentSurface *surface, const double origin[3],
                               const double direction[3], double point[3])
{
    const double length =
        sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    double gradient[3];
    double inside = 0.0;
    double outside = 0.0;
    double step = MARCH;
    memcpy(point, origin, 3 * sizeof *point);
    while (step > PERCALE_GARMENT_EXACTLY && inside < REACH) {
        const double t = inside + step;
        for (int k = 0; k < 3; k++) {
            point[k] = origin[k] + t * direction[k] / length;
        }
        if (garment_field(surface, point, gradient) < 0.0) {
            inside = t;
        } else {
            outside = t;
        }
        if (outside > 0.0) {
            step = 0.5 * (outside - inside);
        }
    }
}

// Crests of different width, so that no two folds are alike.
void percale_garment_add_folds(const PercaleGarmentCut *cut, double round, double point[3])
{
    const double down = fmin(fmax((FOLD_TOP - point[1]) / (FOLD_TOP - cut->hem), 0.0), 1.0);
    if (down <= 0.0) {
        return;
    }
    const double angle = TURN * round;
    const double crest = 0.5 + 0.34 * cos(11.0 * angle + 0.4) + 0.16 * cos(7.0 * angle + 2.0);
    const double depth = cut->fold_depth * down * down * (1.5 - 0.5 * down) * crest;
    double gradient[3];
    (void)skirt_field(cut, point, gradient);
    const double flat = sqrt(gradient[0] * gradient[0] + gradient[2] * gradient[2]);
    point[0] += depth * gradient[0] / flat;
    point[2] += depth * gradient[2] / flat;
}
