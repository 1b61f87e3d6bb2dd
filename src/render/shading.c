#include "render/shading.h"

#include "render/color_scale.h"

enum {
    SKY_RAYS = 4, // per sample; nine samples see the sky in 36 directions
    KEY_RAYS = 2  // per sample
};

static const float TAU = 6.28318531f;
static const float KEY_RADIUS = 0.06f;      // rad; half the light's apparent size: shadows with a soft edge
static const float KEY_STRENGTH = 1.05f;    // of a white surface that faces the light
static const float SKY_STRENGTH = 0.68f;    // of a white surface under the open sky
static const float BOUNCE = 0.16f;          // light that comes back from a surface in the way
static const float SHEEN = 0.10f;           // of cloth at grazing angles: fibres that stand out
static const float HEAT_BRIGHTNESS = 0.75f; // of the scale: its yellow in full light still has shape
static const float BEHIND = 0.72f;          // a cloth's wrong side is a little darker
static const float OFFSET = 2e-4f; // of the radius; above the rounding of a hit, below 2 mm for a body
static const float FLOOR_FADE_START = 1.1f; // radii from the middle, where shadows begin to fade
static const float FLOOR_FADE_END = 3.2f;

// sRGB. Clear of each other and of the clay, also to the colour-blind.
static const uint32_t CLOTH_COLORS[] = {0x4c739c, 0xc27c4e, 0x6b9170, 0x8d6a94, 0xc7aa5c, 0x565a6e};
static const uint32_t CLAY_COLORS[] = {0xc8ada0, 0xb5aea6, 0xa7b0b8};
static const uint32_t BACKGROUND_TOP = 0xc3cad2;
static const uint32_t BACKGROUND_BOTTOM = 0xf1efec;
static const uint32_t KEY_COLOR = 0xfff6e8;
static const uint32_t ZENITH_COLOR = 0xe4eefc;
static const uint32_t GROUND_COLOR = 0xb7afa8;

/// Two numbers in [0, 1), spread evenly over the samples of a pixel and differently rotated from pixel to
/// pixel.
typedef struct Spread {
    float u, v;
} Spread;

static uint32_t hash(uint32_t value) // Wellons 2018, "lowbias32"
{
    value ^= value >> 16;
    value *= 0x7feb352du;
    value ^= value >> 15;
    value *= 0x846ca68bu;
    return value ^ value >> 16;
}

static float unit_float(uint32_t bits)
{
    return (float)(bits >> 8) * 0x1p-24f;
}

/// The R2 sequence (Roberts 2018) shifted per pixel.
static Spread spread_sample(const PercaleSample *sample, uint32_t place, uint32_t salt)
{
    uint32_t rotation = hash(sample->pixel * 2u + salt);
    uint32_t u = place * 3242174889u + rotation;       // 2^32 / 1.3247
    uint32_t v = place * 2447445414u + hash(rotation); // 2^32 / 1.3247^2
    return (Spread){unit_float(u), unit_float(v)};
}

PercaleStudio percale_studio_create(const PercaleRayScene *scene, PercaleVec3 right, PercaleVec3 forward)
{
    PercaleRayBounds bounds = percale_ray_scene_bounds(scene);
    PercaleStudio studio = {.scene = scene};
    studio.center = vec3_scale(vec3_add(bounds.low, bounds.high), 0.5f);
    studio.center.y = bounds.low.y;
    studio.radius = fmaxf(0.5f * vec3_length(vec3_subtract(bounds.high, bounds.low)), 1e-3f);
    studio.offset = OFFSET * studio.radius;
    PercaleVec3 back = vec3_normalize(vec3(-forward.x, 0.0f, -forward.z), vec3(0.0f, 0.0f, 1.0f));
    PercaleVec3 key =
        vec3_add(vec3_scale(right, -0.75f), vec3_add(vec3_scale(back, 0.75f), vec3(0.0f, 1.8f, 0.0f)));
    studio.key_light = vec3_normalize(key, vec3(0.0f, 1.0f, 0.0f));
    studio.key_right = vec3_normalize(vec3_cross(vec3(0.0f, 1.0f, 0.0f), studio.key_light), right);
    studio.key_up = vec3_cross(studio.key_light, studio.key_right);
    return studio;
}

/// Share of the key light that is seen from a point.
static float see_key_light(const PercaleStudio *studio, const PercaleSample *sample, PercaleVec3 point)
{
    float seen = 0.0f;
    for (uint32_t ray = 0; ray < KEY_RAYS; ++ray) {
        Spread spread = spread_sample(sample, sample->index * KEY_RAYS + ray, 0u);
        float radius = KEY_RADIUS * sqrtf(spread.u);
        PercaleVec3 aside = vec3_scale(studio->key_right, radius * cosf(TAU * spread.v));
        PercaleVec3 above = vec3_scale(studio->key_up, radius * sinf(TAU * spread.v));
        PercaleVec3 direction = vec3_add(studio->key_light, vec3_add(aside, above));
        seen += percale_ray_scene_occluded(studio->scene, point, direction) ? 0.0f : 1.0f;
    }
    return seen / KEY_RAYS;
}

/// Light of the sky, or of the floor below, from a direction.
static PercaleVec3 sky_color(PercaleVec3 direction)
{
    float t = fminf(fmaxf(0.5f + 0.5f * direction.y, 0.0f), 1.0f);
    return vec3_mix(percale_color_from_srgb(GROUND_COLOR), percale_color_from_srgb(ZENITH_COLOR), t);
}

/// Mean light of the sky on a surface with this normal: cosine-weighted directions, each with a shadow ray.
static PercaleVec3 gather_sky(const PercaleStudio *studio, const PercaleSample *sample, PercaleVec3 point,
                              PercaleVec3 normal)
{
    PercaleVec3 helper = fabsf(normal.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    PercaleVec3 tangent = vec3_normalize(vec3_cross(helper, normal), helper);
    PercaleVec3 bitangent = vec3_cross(normal, tangent);
    PercaleVec3 sum = vec3(0.0f, 0.0f, 0.0f);
    for (uint32_t ray = 0; ray < SKY_RAYS; ++ray) {
        Spread spread = spread_sample(sample, sample->index * SKY_RAYS + ray, 1u);
        float radius = sqrtf(spread.u);
        PercaleVec3 direction = vec3_scale(normal, sqrtf(1.0f - spread.u));
        direction = vec3_add(direction, vec3_scale(tangent, radius * cosf(TAU * spread.v)));
        direction = vec3_add(direction, vec3_scale(bitangent, radius * sinf(TAU * spread.v)));
        float seen = percale_ray_scene_occluded(studio->scene, point, direction) ? BOUNCE : 1.0f;
        sum = vec3_add(sum, vec3_scale(sky_color(direction), seen));
    }
    return vec3_scale(sum, SKY_STRENGTH / SKY_RAYS);
}

static PercaleVec3 base_color(const PercaleRayHit *hit)
{
    enum {
        CLOTH_COLOR_COUNT = sizeof CLOTH_COLORS / sizeof CLOTH_COLORS[0],
        CLAY_COLOR_COUNT = sizeof CLAY_COLORS / sizeof CLAY_COLORS[0]
    };
    if (hit->mesh->heat)
        return vec3_scale(percale_color_of_heat(hit->heat), HEAT_BRIGHTNESS);
    if (!hit->mesh->cloth)
        return percale_color_from_srgb(CLAY_COLORS[hit->mesh->index % CLAY_COLOR_COUNT]);
    PercaleVec3 color = percale_color_from_srgb(CLOTH_COLORS[hit->mesh->index % CLOTH_COLOR_COUNT]);
    return hit->from_behind ? vec3_scale(color, BEHIND) : color;
}

static PercaleVec3 shade_surface(const PercaleStudio *studio, const PercaleSample *sample,
                                 const PercaleRayHit *hit)
{
    PercaleVec3 point = vec3_add(hit->point, vec3_scale(hit->facet, studio->offset));
    PercaleVec3 light = gather_sky(studio, sample, point, hit->normal);
    float facing = vec3_dot(hit->normal, studio->key_light);
    if (facing > 0.0f && vec3_dot(hit->facet, studio->key_light) > 0.0f) {
        float key = KEY_STRENGTH * facing * see_key_light(studio, sample, point);
        light = vec3_add(light, vec3_scale(percale_color_from_srgb(KEY_COLOR), key));
    }
    PercaleVec3 color = vec3_multiply(base_color(hit), light);
    if (hit->mesh->cloth) {
        float grazing = 1.0f - fabsf(vec3_dot(hit->normal, sample->direction));
        color = vec3_add(color, vec3_scale(light, SHEEN * grazing * grazing * grazing * grazing));
    }
    return color;
}

/// Share of the open floor's light that arrives at a point of the floor.
static float light_on_floor(const PercaleStudio *studio, const PercaleSample *sample, PercaleVec3 point)
{
    const PercaleVec3 up = {0.0f, 1.0f, 0.0f};
    point.y += studio->offset;
    float key = KEY_STRENGTH * studio->key_light.y;
    float open_sky = SKY_STRENGTH * sky_color(vec3(0.0f, 0.6f, 0.0f)).y; // 0.6: mean height of the directions
    float seen = key * see_key_light(studio, sample, point) + gather_sky(studio, sample, point, up).y;
    return fminf(seen / (key + open_sky), 1.0f);
}

static PercaleVec3 shade_background(const PercaleStudio *studio, const PercaleSample *sample)
{
    PercaleVec3 color = vec3_mix(percale_color_from_srgb(BACKGROUND_BOTTOM),
                                 percale_color_from_srgb(BACKGROUND_TOP), sample->height);
    float drop = sample->start.y - studio->center.y;
    if (sample->direction.y >= 0.0f || drop <= 0.0f)
        return color;
    PercaleVec3 point = vec3_add(sample->start, vec3_scale(sample->direction, -drop / sample->direction.y));
    float away = vec3_length(vec3_subtract(point, studio->center)) / studio->radius;
    float fade = (FLOOR_FADE_END - away) / (FLOOR_FADE_END - FLOOR_FADE_START);
    if (!(fade > 0.0f))
        return color;
    point.y = studio->center.y;
    fade = fminf(fade, 1.0f);
    float light = light_on_floor(studio, sample, point);
    return vec3_scale(color, 1.0f + fade * (light - 1.0f));
}

PercaleVec3 percale_studio_shade(const PercaleStudio *studio, const PercaleSample *sample)
{
    PercaleRayHit hit;
    if (percale_ray_scene_hit(studio->scene, sample->start, sample->direction, &hit))
        return shade_surface(studio, sample, &hit);
    return shade_background(studio, sample);
}
