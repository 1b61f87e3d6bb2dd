#include "render/color_scale.h"

#include <stddef.h>

// Every tenth of matplotlib's viridis (van der Walt and Smith 2015, CC0), sRGB.
static const uint32_t VIRIDIS[] = {0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c,
                                   0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725};
static const size_t VIRIDIS_LAST = sizeof VIRIDIS / sizeof VIRIDIS[0] - 1;

static float linear_of_srgb(uint32_t byte)
{
    float value = (float)byte / 255.0f;
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f); // IEC 61966-2-1
}

static uint8_t srgb_of_linear(float value)
{
    float clamped = fminf(fmaxf(value, 0.0f), 1.0f);
    float encoded = clamped <= 0.0031308f ? 12.92f * clamped : 1.055f * powf(clamped, 1.0f / 2.4f) - 0.055f;
    return (uint8_t)(encoded * 255.0f + 0.5f);
}

PercaleVec3 percale_color_from_srgb(uint32_t rgb)
{
    return vec3(linear_of_srgb(rgb >> 16 & 0xffu), linear_of_srgb(rgb >> 8 & 0xffu),
                linear_of_srgb(rgb & 0xffu));
}

void percale_color_to_srgb(PercaleVec3 linear, uint8_t rgb[3])
{
    rgb[0] = srgb_of_linear(linear.x);
    rgb[1] = srgb_of_linear(linear.y);
    rgb[2] = srgb_of_linear(linear.z);
}

PercaleVec3 percale_color_of_heat(float heat)
{
    float place = fminf(fmaxf(heat, 0.0f), 1.0f) * (float)VIRIDIS_LAST;
    size_t step = (size_t)place;
    if (step >= VIRIDIS_LAST)
        return percale_color_from_srgb(VIRIDIS[VIRIDIS_LAST]);
    return vec3_mix(percale_color_from_srgb(VIRIDIS[step]), percale_color_from_srgb(VIRIDIS[step + 1]),
                    place - (float)step);
}
