// The midpoint of an edge is made by the first triangle that asks for it and found again through the lists of
// neighbours that every vertex has.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/shapes.h"

#include <math.h>
#include <string.h>

enum { CORNERS = 12, FACES = 20, NEIGHBOURS = 6, NO_MIDPOINT = 0 };

// (0, +-1, +-golden) and its rotations.
static const int8_t corners[CORNERS][3] = {{-1, 2, 0}, {1, 2, 0}, {-1, -2, 0}, {1, -2, 0},
                                           {0, -1, 2}, {0, 1, 2}, {0, -1, -2}, {0, 1, -2},
                                           {2, 0, -1}, {2, 0, 1}, {-2, 0, -1}, {-2, 0, 1}};
static const uint8_t faces[FACES][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                        {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                        {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                        {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};

// Midpoints of the edges from a vertex to larger ones.
typedef struct Spokes {
    uint32_t to[NEIGHBOURS];
    uint32_t midpoint[NEIGHBOURS]; // NO_MIDPOINT: free
} Spokes;

typedef struct Sphere {
    double (*points)[3]; // on the unit sphere
    uint32_t point_count;
    uint32_t (*triangles)[3];
    uint32_t triangle_count;
    Spokes *spokes;
} Sphere;

static void normalise(double point[3])
{
    const double length = sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]);
    for (int axis = 0; axis < 3; ++axis) {
        point[axis] /= length;
    }
}

static void start(Sphere *sphere)
{
    const double golden = (1.0 + sqrt(5.0)) / 2.0;
    for (size_t corner = 0; corner < CORNERS; ++corner) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const double code = corners[corner][axis]; // 2 stands for the golden ratio
            sphere->points[corner][axis] = fabs(code) > 1.5 ? code / 2.0 * golden : code;
        }
        normalise(sphere->points[corner]);
    }
    for (size_t face = 0; face < FACES; ++face) {
        for (size_t k = 0; k < 3; ++k) {
            sphere->triangles[face][k] = faces[face][k];
        }
    }
    sphere->point_count = CORNERS;
    sphere->triangle_count = FACES;
}

static uint32_t midpoint(Sphere *sphere, uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b;
    const uint32_t high = a < b ? b : a;
    Spokes *spokes = &sphere->spokes[low];
    size_t slot = 0;
    while (spokes->midpoint[slot] != NO_MIDPOINT && spokes->to[slot] != high) {
        ++slot;
    }
    if (spokes->midpoint[slot] == NO_MIDPOINT) {
        double *point = sphere->points[sphere->point_count];
        for (int axis = 0; axis < 3; ++axis) {
            point[axis] = 0.5 * (sphere->points[low][axis] + sphere->points[high][axis]);
        }
        normalise(point);
        spokes->to[slot] = high;
        spokes->midpoint[slot] = sphere->point_count++;
    }
    return spokes->midpoint[slot];
}

// From the last triangle to the first, so that the four new ones fit in the place of the old.
static void subdivide(Sphere *sphere)
{
    memset(sphere->spokes, 0, sphere->point_count * sizeof *sphere->spokes);
    for (uint32_t face = sphere->triangle_count; face-- > 0;) {
        const uint32_t a = sphere->triangles[face][0];
        const uint32_t b = sphere->triangles[face][1];
        const uint32_t c = sphere->triangles[face][2];
        const uint32_t ab = midpoint(sphere, a, b);
        const uint32_t bc = midpoint(sphere, b, c);
        const uint32_t ca = midpoint(sphere, c, a);
        const uint32_t parts[4][3] = {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
        memcpy(sphere->triangles[4 * (size_t)face], parts, sizeof parts);
    }
    sphere->triangle_count *= 4;
}

static bool finish(const Sphere *sphere, double radius, const double centre[3], PercaleMesh *mesh)
{
    mesh->vertex_count = sphere->point_count;
    mesh->triangle_count = sphere->triangle_count;
    mesh->positions = percale_array_new(3 * (uint64_t)sphere->point_count, sizeof *mesh->positions);
    mesh->triangles = percale_array_new(3 * (uint64_t)sphere->triangle_count, sizeof *mesh->triangles);
    if (mesh->name == NULL || mesh->positions == NULL || mesh->triangles == NULL) {
        return false;
    }
    memcpy(mesh->triangles, sphere->triangles, sphere->triangle_count * sizeof *sphere->triangles);
    for (size_t k = 0; k < 3 * (size_t)sphere->point_count; ++k) {
        mesh->positions[k] = (float)(centre[k % 3] + radius * sphere->points[k / 3][k % 3]);
    }
    return true;
}

bool percale_icosphere_make(const char *name, int subdivisions, double radius, const double centre[3],
                            PercaleMesh *mesh, PercaleSceneError *error)
{
    const uint64_t triangle_count = (uint64_t)FACES << (2 * subdivisions);
    const uint64_t point_count = triangle_count / 2 + 2; // Euler
    Sphere sphere = {.points = percale_array_new(point_count, sizeof *sphere.points),
                     .triangles = percale_array_new(triangle_count, sizeof *sphere.triangles),
                     .spokes = percale_array_new(point_count, sizeof *sphere.spokes)};
    *mesh = (PercaleMesh){.name = strdup(name)};
    bool done = sphere.points != NULL && sphere.triangles != NULL && sphere.spokes != NULL;
    if (done) {
        start(&sphere);
        for (int level = 0; level < subdivisions; ++level) {
            subdivide(&sphere);
        }
        done = finish(&sphere, radius, centre, mesh);
    }
    free(sphere.points);
    free(sphere.triangles);
    free(sphere.spokes);
    if (!done) {
        percale_mesh_free(mesh);
        return percale_scene_out_of_memory(error);
    }
    return true;
}
