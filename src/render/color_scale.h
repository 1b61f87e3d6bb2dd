// color_scale.h: colours of the renderer: the heat scale, and between linear light and what a screen shows.
//
//   in   a heat 0..1, or a linear RGB colour
//   out  a linear RGB colour, or its sRGB bytes

#ifndef PERCALE_COLOR_SCALE_H
#define PERCALE_COLOR_SCALE_H

#include "render/vec3.h"

#include <stdint.h>

/// Viridis: even steps of heat look even, also in grey and to the colour-blind. Outside 0..1 is clamped.
PercaleVec3 percale_color_of_heat(float heat);

/// Linear RGB of an sRGB colour written as 0xRRGGBB.
PercaleVec3 percale_color_from_srgb(uint32_t rgb);

/// sRGB bytes of a linear colour; outside 0..1 is clamped.
void percale_color_to_srgb(PercaleVec3 linear, uint8_t rgb[3]);

#endif
