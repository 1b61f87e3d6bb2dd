#include "detect/passage.h"

#include "detect/coplanar.h"

#include <string.h>

// Squared sine below which edges are parallel: their ends say all.
static const double PARALLEL = 1e-12;

// Share of a pair's size below which an edge's length or a triangle's height is rounding. At a time when two
// points meet, what is left between them points anywhere.
static const double NO_LENGTH = 1e-10;

bool percale_weigh_edges(const Vec3 *x, double slack, double weights[4])
{
    Vec3 a = vsub(x[1], x[0]);
    Vec3 b = vsub(x[3], x[2]);
    Vec3 c = vsub(x[0], x[2]);
    double aa = vdot(a, a);
    double bb = vdot(b, b);
    double ab = vdot(a, b);
    double ac = vdot(a, c);
    double bc = vdot(b, c);
    double sine2 = aa * bb - ab * ab;
    if (!(sine2 > PARALLEL * aa * bb)) {
        return false;
    }
    double s = (ab * bc - bb * ac) / sine2;
    double t = (aa * bc - ab * ac) / sine2;
    bool inside = s > -slack && s < 1.0 + slack && t > -slack && t < 1.0 + slack;
    s = fmin(fmax(s, 0.0), 1.0);
    t = fmin(fmax(t, 0.0), 1.0);
    weights[0] = 1.0 - s;
    weights[1] = s;
    weights[2] = t - 1.0;
    weights[3] = -t;
    return inside;
}

static Vec3 across_edges(const Vec3 *x)
{
    return vcross(vsub(x[1], x[0]), vsub(x[3], x[2]));
}

static double distance2(Vec3 a, Vec3 b)
{
    Vec3 between = vsub(a, b);
    return vdot(between, between);
}

/// Squared size of the longer edge.
static double edges_size2(const Vec3 *x)
{
    return fmax(distance2(x[0], x[1]), distance2(x[2], x[3]));
}

/// False, too, when one of the edges turns over end to end at that time: it has no inside then.
static bool weigh_edges(const Vec3 *x, double size2, double weights[4], Vec3 *across)
{
    double least2 = NO_LENGTH * NO_LENGTH * size2;
    *across = across_edges(x);
    return distance2(x[0], x[1]) > least2 && distance2(x[2], x[3]) > least2 &&
           percale_weigh_edges(x, SEAMLESS, weights);
}

/// Squared size of the triangle's longest side.
static double face_size2(const Vec3 *x)
{
    return fmax(fmax(distance2(x[1], x[2]), distance2(x[2], x[3])), distance2(x[3], x[1]));
}

/// The point x[0] and the triangle of the others. False when it isn't above its inside; a triangle that turns
/// over edge-on has none at that time.
static bool weigh_face(const Vec3 *x, double size2, double weights[4], Vec3 *across)
{
    Vec3 area = vcross(vsub(x[2], x[1]), vsub(x[3], x[1]));
    double scale = vdot(area, area);
    *across = area;
    if (!(scale > NO_LENGTH * NO_LENGTH * size2 * size2)) {
        return false;
    }
    bool inside = true;
    weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        Vec3 a = x[1 + (k + 1) % 3];
        Vec3 b = x[1 + (k + 2) % 3];
        double share = vdot(area, vcross(vsub(b, a), vsub(x[0], a))) / scale;
        weights[1 + k] = -share;
        inside = inside && share >= -SEAMLESS;
    }
    return inside;
}

/// Weights of the features' points where all four are in a plane, and the vector across it. False when they
/// don't meet there. `size2`: the features' squared size at one end of the way.
typedef bool Weigh(const Vec3 *x, double size2, double weights[4], Vec3 *across);

static bool find_passage(const Vec3 *from, const Vec3 *to, Weigh *weigh, double size2,
                         PercalePassage *passage)
{
    double times[3];
    int count = percale_coplanar_times(from, to, times);
    int meetings = 0;
    Vec3 across = {0.0, 0.0, 0.0};
    for (int i = 0; i < count; i++) {
        Vec3 x[4];
        double here[4];
        Vec3 plane;
        for (int k = 0; k < 4; k++) {
            x[k] = vadd(from[k], vscale(times[i], vsub(to[k], from[k])));
        }
        if (weigh(x, size2, here, &plane)) {
            memcpy(passage->weights, here, sizeof(here));
            passage->time = times[i];
            across = plane;
            meetings++;
        }
    }
    if (meetings % 2 == 0) {
        return false;
    }
    double came_from = vdot(across, weigh_points(from, passage->weights));
    passage->normal = vunit(came_from >= 0.0 ? across : vscale(-1.0, across));
    return true;
}

bool percale_vertex_passes(const Vec3 *from, const Vec3 *to, PercalePassage *passage)
{
    return find_passage(from, to, weigh_face, fmax(face_size2(from), face_size2(to)), passage);
}

bool percale_edges_pass(const Vec3 *from, const Vec3 *to, PercalePassage *passage)
{
    return find_passage(from, to, weigh_edges, fmax(edges_size2(from), edges_size2(to)), passage);
}
