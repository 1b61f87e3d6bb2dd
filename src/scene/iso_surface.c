#include "iso_surface.h"

#include "edge_flips.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t NO_VERTEX = UINT32_MAX;
static const int RELAXATIONS = 15;         // per round; enough for the shapes that the edges allow
static const int ROUNDS = 3;               // of flips and relaxations
static const double RELAXATION_STEP = 0.5; // share of the way to the neighbours' mean
static const int ATTEMPTS = 16;            // lattices tried, each shifted a little; the first few do
static const double SHIFTS[3] = {0.0, -1.0 / 24, -1.0 / 40}; // cells per attempt; x stays, for symmetry
static const int PROJECTIONS = 12;                           // Newton steps; two or three are the rule
static const double ROUGHLY = 1e-4; // m; near enough to the surface while vertices still slide
static const double EXACTLY = 1e-8; // m

typedef struct Lattice {
    PercaleField *field;
    double lower[3]; ///< m
    double cell;     ///< m
    uint32_t count[3];
    double *values;     ///< per lattice point, x fastest
    uint32_t *vertices; ///< per cell, named by its lowest corner: its vertex, or NO_VERTEX
} Lattice;

typedef struct Net {
    double *positions; ///< [3 * vertex_count] m
    uint32_t vertex_count;
    uint32_t vertex_capacity;
    uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
} Net;

bool percale_field_project(PercaleField *field, double tolerance, double point[3])
{
    for (int step = 0; step < PROJECTIONS; step++) {
        double gradient[3];
        const double value = field(point, gradient);
        if (fabs(value) <= tolerance) {
            return true;
        }
        const double square =
            gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
        if (!(square > 0.0)) {
            return false;
        }
        for (int k = 0; k < 3; k++) {
            point[k] -= value / square * gradient[k];
        }
    }
    return false;
}

static size_t lattice_index(const Lattice *lattice, uint32_t x, uint32_t y, uint32_t z)
{
    return x + (size_t)lattice->count[0] * (y + (size_t)lattice->count[1] * z);
}

static void lattice_point(const Lattice *lattice, uint32_t x, uint32_t y, uint32_t z, double point[3])
{
    point[0] = lattice->lower[0] + lattice->cell * x;
    point[1] = lattice->lower[1] + lattice->cell * y;
    point[2] = lattice->lower[2] + lattice->cell * z;
}

// The surface is at least |value| away from a point, so that far points tell the sign of the points after
// them; only ends of edges that the surface crosses need more than the sign.
static void sample_row(Lattice *lattice, uint32_t y, uint32_t z)
{
    double *row = lattice->values + lattice_index(lattice, 0, y, z);
    double clear = 0.0; // m along the row for which `value` has the right sign
    double value = 0.0;
    for (uint32_t x = 0; x < lattice->count[0]; x++) {
        clear -= lattice->cell;
        if (clear < lattice->cell) {
            double point[3];
            double gradient[3];
            lattice_point(lattice, x, y, z, point);
            value = lattice->field(point, gradient);
            clear = fabs(value);
        }
        row[x] = value;
    }
}

static void sample(Lattice *lattice)
{
    for (uint32_t z = 0; z < lattice->count[2]; z++) {
        for (uint32_t y = 0; y < lattice->count[1]; y++) {
            sample_row(lattice, y, z);
        }
    }
}

// The mean of the points where the surface crosses the cell's edges; false if it crosses none.
static bool cell_vertex(const Lattice *lattice, const uint32_t low[3], double vertex[3])
{
    double sum[3] = {0, 0, 0};
    int crossings = 0;
    for (uint32_t corner = 0; corner < 8; corner++) {
        for (uint32_t axis = 0; axis < 3; axis++) {
            if (corner >> axis & 1U) {
                continue;
            }
            const uint32_t c[3] = {low[0] + (corner & 1U), low[1] + (corner >> 1 & 1U),
                                   low[2] + (corner >> 2 & 1U)};
            const double from = lattice->values[lattice_index(lattice, c[0], c[1], c[2])];
            const double to = lattice->values[lattice_index(lattice, c[0] + (axis == 0), c[1] + (axis == 1),
                                                            c[2] + (axis == 2))];
            if ((from < 0) == (to < 0)) {
                continue;
            }
            double point[3];
            lattice_point(lattice, c[0], c[1], c[2], point);
            point[axis] += lattice->cell * from / (from - to);
            for (int k = 0; k < 3; k++) {
                sum[k] += point[k];
            }
            crossings++;
        }
    }
    for (int k = 0; k < 3; k++) {
        vertex[k] = crossings ? sum[k] / crossings : 0.0;
    }
    return crossings > 0;
}

static bool add_vertex(Net *net, const double vertex[3])
{
    if (net->vertex_count == net->vertex_capacity) {
        const uint32_t capacity = net->vertex_capacity ? 2 * net->vertex_capacity : 4096;
        double *grown = realloc(net->positions, 3 * (size_t)capacity * sizeof *grown);
        if (!grown) {
            return false;
        }
        net->positions = grown;
        net->vertex_capacity = capacity;
    }
    memcpy(net->positions + 3 * (size_t)net->vertex_count, vertex, 3 * sizeof *vertex);
    net->vertex_count++;
    return true;
}

static bool place_vertices(Lattice *lattice, Net *net)
{
    bool good = true;
    for (uint32_t z = 0; z + 1 < lattice->count[2]; z++) {
        for (uint32_t y = 0; y + 1 < lattice->count[1]; y++) {
            for (uint32_t x = 0; x + 1 < lattice->count[0]; x++) {
                double vertex[3];
                const bool crossed = cell_vertex(lattice, (const uint32_t[3]){x, y, z}, vertex);
                lattice->vertices[lattice_index(lattice, x, y, z)] = crossed ? net->vertex_count : NO_VERTEX;
                good = good && (!crossed || add_vertex(net, vertex));
            }
        }
    }
    return good && net->vertex_count > 0;
}

static double square_distance(const double *a, const double *b)
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

// Two triangles, split along the shorter diagonal.
static void add_quad(Net *net, const uint32_t quad[4])
{
    const double *p[4];
    for (int k = 0; k < 4; k++) {
        p[k] = net->positions + 3 * (size_t)quad[k];
    }
    const uint32_t turn = square_distance(p[1], p[3]) < square_distance(p[0], p[2]) ? 1 : 0;
    uint32_t *triangle = net->triangles + 3 * (size_t)net->triangle_count;
    const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    for (int k = 0; k < 6; k++) {
        triangle[k] = quad[(order[k] + turn) % 4];
    }
    net->triangle_count += 2;
}

// A quad around each of the lattice edges from point `here` upwards that the surface crosses. The box is
// larger than the surface, so that the four cells around such an edge exist.
static void place_quads_at(const Lattice *lattice, size_t here, Net *net)
{
    const size_t stride[3] = {1, lattice->count[0], (size_t)lattice->count[0] * lattice->count[1]};
    const uint32_t *cells = lattice->vertices;
    for (int axis = 0; axis < 3; axis++) {
        const double from = lattice->values[here];
        const double to = lattice->values[here + stride[axis]];
        if ((from < 0) == (to < 0)) {
            continue;
        }
        const size_t u = stride[(axis + 1) % 3];
        const size_t v = stride[(axis + 2) % 3];
        const uint32_t out[4] = {cells[here - u - v], cells[here - v], cells[here], cells[here - u]};
        const uint32_t in[4] = {out[3], out[2], out[1], out[0]};
        add_quad(net, from < 0 ? out : in);
    }
}

// A cell has 12 edges and a quad 4 cells: at most 3 quads per vertex.
static bool place_quads(const Lattice *lattice, Net *net)
{
    net->triangles = malloc(3 * sizeof *net->triangles * 6 * (size_t)net->vertex_count);
    if (!net->triangles) {
        return false;
    }
    for (uint32_t z = 1; z + 1 < lattice->count[2]; z++) {
        for (uint32_t y = 1; y + 1 < lattice->count[1]; y++) {
            for (uint32_t x = 1; x + 1 < lattice->count[0]; x++) {
                place_quads_at(lattice, lattice_index(lattice, x, y, z), net);
            }
        }
    }
    return true;
}

// Each vertex goes part of the way to the mean of its neighbours and back onto the surface. In a closed mesh
// each neighbour is met in two triangles, once in each direction.
static bool relax(PercaleField *field, double tolerance, Net *net)
{
    const size_t n = net->vertex_count;
    double *sums = malloc(3 * n * sizeof *sums);
    uint32_t *valences = calloc(n, sizeof *valences);
    bool good = sums && valences;
    for (size_t i = 0; good && i < 3 * (size_t)net->triangle_count; i++) {
        valences[net->triangles[i]]++;
    }
    for (int round = 0; good && round < RELAXATIONS; round++) {
        memset(sums, 0, 3 * n * sizeof *sums);
        for (size_t i = 0; i < 3 * (size_t)net->triangle_count; i++) {
            const size_t next = i % 3 == 2 ? i - 2 : i + 1;
            const double *to = net->positions + 3 * (size_t)net->triangles[next];
            double *sum = sums + 3 * (size_t)net->triangles[i];
            for (int k = 0; k < 3; k++) {
                sum[k] += to[k];
            }
        }
        for (size_t i = 0; good && i < n; i++) {
            double *p = net->positions + 3 * i;
            for (int k = 0; k < 3; k++) {
                p[k] += RELAXATION_STEP * (sums[3 * i + (size_t)k] / valences[i] - p[k]);
            }
            good = percale_field_project(field, tolerance, p);
        }
    }
    free(sums);
    free(valences);
    return good;
}

// Flat triangles with their corners on the surface lie inside where it bulges and outside where it is hollow.
// Corners that go half as far the other way put the triangles astride the surface.
static bool straddle(PercaleField *field, Net *net)
{
    double *depths = calloc(net->vertex_count, sizeof *depths);
    uint32_t *valences = calloc(net->vertex_count, sizeof *valences);
    const bool good = depths && valences;
    for (uint32_t t = 0; good && t < net->triangle_count; t++) {
        const uint32_t *v = net->triangles + 3 * (size_t)t;
        double middle[3];
        double gradient[3];
        for (size_t k = 0; k < 3; k++) {
            middle[k] = (net->positions[3 * (size_t)v[0] + k] + net->positions[3 * (size_t)v[1] + k] +
                         net->positions[3 * (size_t)v[2] + k]) /
                        3.0;
        }
        const double depth = field(middle, gradient);
        for (int k = 0; k < 3; k++) {
            depths[v[k]] += depth;
            valences[v[k]]++;
        }
    }
    for (size_t i = 0; good && i < net->vertex_count; i++) {
        double *p = net->positions + 3 * i;
        double gradient[3];
        (void)field(p, gradient);
        for (int k = 0; k < 3; k++) {
            p[k] -= 0.5 * depths[i] / valences[i] * gradient[k];
        }
    }
    free(depths);
    free(valences);
    return good;
}

// Re-connect and slide, twice, since better places ask for better edges. Fails at once on a bad lattice.
static bool even_out(PercaleField *field, Net *net)
{
    bool good = true;
    for (int round = 0; good && round < ROUNDS; round++) {
        good = percale_flip_edges(net->positions, net->vertex_count, net->triangles, net->triangle_count) &&
               relax(field, round + 1 < ROUNDS ? ROUGHLY : EXACTLY, net);
    }
    return good && straddle(field, net);
}

static bool net_to_mesh(const Net *net, PercaleMesh *mesh)
{
    memset(mesh, 0, sizeof *mesh);
    const size_t index_count = 3 * (size_t)net->triangle_count;
    mesh->positions = malloc(3 * (size_t)net->vertex_count * sizeof *mesh->positions);
    mesh->triangles = malloc(index_count * sizeof *mesh->triangles);
    if (!mesh->positions || !mesh->triangles) {
        free(mesh->positions);
        free(mesh->triangles);
        memset(mesh, 0, sizeof *mesh);
        return false;
    }
    mesh->vertex_count = net->vertex_count;
    mesh->triangle_count = net->triangle_count;
    for (size_t i = 0; i < 3 * (size_t)net->vertex_count; i++) {
        mesh->positions[i] = (float)net->positions[i];
    }
    memcpy(mesh->triangles, net->triangles, index_count * sizeof *mesh->triangles);
    return true;
}

// One try on one lattice; false also if two sheets of the surface share a cell, which makes an edge with four
// triangles.
static bool try_lattice(Lattice *lattice, PercaleMesh *mesh)
{
    Net net = {0};
    sample(lattice);
    const bool good = place_vertices(lattice, &net) && place_quads(lattice, &net) &&
                      even_out(lattice->field, &net) && net_to_mesh(&net, mesh);
    free(net.positions);
    free(net.triangles);
    return good;
}

bool percale_iso_surface(PercaleField *field, const double lower[3], const double upper[3], double cell,
                         PercaleMesh *mesh)
{
    Lattice lattice = {.field = field, .cell = cell};
    size_t point_count = 1;
    for (int k = 0; k < 3; k++) {
        lattice.count[k] = (uint32_t)ceil((upper[k] - lower[k]) / cell) + 2;
        point_count *= lattice.count[k];
    }
    lattice.values = malloc(point_count * sizeof *lattice.values);
    lattice.vertices = malloc(point_count * sizeof *lattice.vertices);
    bool good = false;
    for (int attempt = 0; lattice.values && lattice.vertices && !good && attempt < ATTEMPTS; attempt++) {
        for (int k = 0; k < 3; k++) {
            lattice.lower[k] = lower[k] + SHIFTS[k] * attempt * cell;
        }
        good = try_lattice(&lattice, mesh);
    }
    free(lattice.values);
    free(lattice.vertices);
    return good;
}
