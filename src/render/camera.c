// A point with camera coordinates (r, u, f) is in the picture of an eye at (cx, cy, -d) when
// |r - cx| <= t (d + f), and the same for u. So r - t f <= t d + cx and -r - t f <= t d - cx: with A and B
// the largest left sides over all points, the nearest eye has d = (A + B) / (2 t) and cx = (A - B) / 2.

#include "render/camera.h"

static const float AZIMUTH = 0.48f;       // rad; 3/4 view
static const float ELEVATION = 0.16f;     // rad; enough to see the floor
static const float HALF_HEIGHT = 0.2309f; // tangent of 13 degrees: a portrait lens, little distortion
static const float MARGIN = 0.86f;        // share of the picture's width and height that the scene fills
static const float DISTANCE_MIN = 1e-4f;  // m; a scene of a single point still has a distance

PercaleCamera percale_camera_start(uint32_t width, uint32_t height)
{
    PercaleCamera camera = {0};
    float aspect = (float)width / (float)height;
    camera.forward =
        vec3(-sinf(AZIMUTH) * cosf(ELEVATION), -sinf(ELEVATION), -cosf(AZIMUTH) * cosf(ELEVATION));
    camera.right = vec3(cosf(AZIMUTH), 0.0f, -sinf(AZIMUTH));
    camera.up = vec3_cross(camera.right, camera.forward);
    camera.tangent_up = aspect < 1.0f ? HALF_HEIGHT : HALF_HEIGHT / aspect;
    camera.tangent_right = aspect * camera.tangent_up;
    camera.extent_right = camera.extent_left = -INFINITY;
    camera.extent_up = camera.extent_down = -INFINITY;
    camera.nearest = INFINITY;
    return camera;
}

void percale_camera_include(PercaleCamera *camera, PercaleVec3 point)
{
    float r = vec3_dot(point, camera->right);
    float u = vec3_dot(point, camera->up);
    float f = vec3_dot(point, camera->forward);
    float t_right = MARGIN * camera->tangent_right;
    float t_up = MARGIN * camera->tangent_up;
    camera->extent_right = fmaxf(camera->extent_right, r - t_right * f);
    camera->extent_left = fmaxf(camera->extent_left, -r - t_right * f);
    camera->extent_up = fmaxf(camera->extent_up, u - t_up * f);
    camera->extent_down = fmaxf(camera->extent_down, -u - t_up * f);
    camera->nearest = fminf(camera->nearest, f);
}

void percale_camera_frame(PercaleCamera *camera)
{
    float t_right = MARGIN * camera->tangent_right;
    float t_up = MARGIN * camera->tangent_up;
    float distance = fmaxf((camera->extent_right + camera->extent_left) / (2.0f * t_right),
                           (camera->extent_up + camera->extent_down) / (2.0f * t_up));
    distance = fmaxf(distance, DISTANCE_MIN - camera->nearest);
    float r = 0.5f * (camera->extent_right - camera->extent_left);
    float u = 0.5f * (camera->extent_up - camera->extent_down);
    camera->eye = vec3_add(vec3_add(vec3_scale(camera->right, r), vec3_scale(camera->up, u)),
                           vec3_scale(camera->forward, -distance));
}

PercaleVec3 percale_camera_direction(const PercaleCamera *camera, float x, float y)
{
    PercaleVec3 aside = vec3_scale(camera->right, x * camera->tangent_right);
    PercaleVec3 above = vec3_scale(camera->up, y * camera->tangent_up);
    return vec3_normalize(vec3_add(camera->forward, vec3_add(aside, above)), camera->forward);
}
