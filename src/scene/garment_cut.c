#include "garment_cut.h"

// Knee-length, with short sleeves.
const PercaleGarmentCut percale_dress_cut = {
    .name = "dress",
    .smallest = 1000,
    .smooth = 5000,
    .grid = {.side = 4, .face = 24, .below = 42, .hole = 10, .yoke = 5, .sleeve = 12},
    .hem = 0.52,
    .flare = 0.19,
    .fold_depth = 0.060,
    .cuff = 0.160};

// To the hip, over the folds that the dress has there, 8 mm deep at the jacket's hem.
const PercaleGarmentCut percale_jacket_cut = {
    .name = "jacket",
    .smallest = 750,
    .smooth = 4100,
    .grid = {.side = 4, .face = 24, .below = 26, .hole = 10, .yoke = 5, .sleeve = 15},
    .hem = 0.80,
    .flare = 0.26,
    .fold_depth = 0.0,
    .cuff = 0.200};

// To the knee, outside the crests of the dress's folds: 60 mm more radius than it at its hem.
const PercaleGarmentCut percale_coat_cut = {
    .name = "coat",
    .smallest = 1100,
    .smooth = 5700,
    .grid = {.side = 4, .face = 24, .below = 45, .hole = 10, .yoke = 5, .sleeve = 18},
    .hem = 0.48,
    .flare = 0.34,
    .fold_depth = 0.025,
    .cuff = 0.235};
