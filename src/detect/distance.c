#include "detect/distance.h"

#include "percale/geometry.h"

// sin^2 of the angle below which two edges, or two sides of a triangle, count as parallel: beyond it the
// cross product of float32 data has no digits left
static const double PARALLEL = 1e-14;

// squared distances to the features of a triangle without area that differ by less than this share of its
// squared size are the same
static const double ALIKE = 1e-12;

static PercaleClosest closest(double u, double v, double w, PercaleRegion region)
{
    return (PercaleClosest){0.0, {u, v, w}, region};
}

static double distance2_at(Vec3 point, Vec3 a, Vec3 b, Vec3 c, const double weights[3])
{
    Vec3 foot = vadd(vadd(vscale(weights[0], a), vscale(weights[1], b)), vscale(weights[2], c));
    Vec3 d = vsub(point, foot);
    return vdot(d, d);
}

/// Nearest parameter in [0, 1] on the segment from a to b.
static double nearest_parameter(Vec3 point, Vec3 a, Vec3 b)
{
    Vec3 along = vsub(b, a);
    double length2 = vdot(along, along);
    double t = length2 > 0.0 ? vdot(vsub(point, a), along) / length2 : 0.0;
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

/// Closest point of side k of a triangle.
static PercaleClosest closest_on_side(Vec3 point, const Vec3 corners[3], int k)
{
    int next = k == 2 ? 0 : k + 1;
    double t = nearest_parameter(point, corners[k], corners[next]);
    PercaleClosest side = {0.0, {0.0, 0.0, 0.0}, (PercaleRegion)(REGION_SIDE_0 + k)};
    side.weights[k] = 1.0 - t;
    side.weights[next] = t;
    if (t <= 0.0 || t >= 1.0) {
        side.region = (PercaleRegion)(REGION_CORNER_0 + (t <= 0.0 ? k : next));
    }
    side.distance2 = distance2_at(point, corners[0], corners[1], corners[2], side.weights);
    return side;
}

/// A triangle without area counts as its three sides.
static PercaleClosest closest_on_sides(Vec3 point, const Vec3 corners[3])
{
    PercaleClosest best = {HUGE_VAL, {1.0, 0.0, 0.0}, REGION_CORNER_0};
    for (int k = 0; k < 3; k++) {
        PercaleClosest side = closest_on_side(point, corners, k);
        if (side.distance2 < best.distance2) {
            best = side;
        }
    }
    return best;
}

/// A thin triangle: the nearest of its sides, or the foot of the perpendicular where that lies inside.
static PercaleClosest closest_on_thin(Vec3 point, const Vec3 corners[3], Vec3 normal)
{
    PercaleClosest best = closest_on_sides(point, corners);
    double scale = 1.0 / vdot(normal, normal);
    Vec3 from_0 = vsub(point, corners[0]);
    Vec3 from_1 = vsub(point, corners[1]);
    double u = scale * vdot(normal, vcross(vsub(corners[2], corners[1]), from_1));
    double v = scale * vdot(normal, vcross(vsub(corners[0], corners[2]), from_0));
    double w = 1.0 - u - v;
    if (u > 0.0 && v > 0.0 && w > 0.0) {
        PercaleClosest inside = closest(u, v, w, REGION_FACE);
        inside.distance2 = distance2_at(point, corners[0], corners[1], corners[2], inside.weights);
        return inside.distance2 < best.distance2 ? inside : best;
    }
    return best;
}

/// Voronoi regions of a triangle (Ericson 2005, section 5.1.5), for a triangle with area.
static PercaleClosest closest_by_region(Vec3 point, Vec3 a, Vec3 b, Vec3 c)
{
    Vec3 ab = vsub(b, a);
    Vec3 ac = vsub(c, a);
    Vec3 ap = vsub(point, a);
    double d1 = vdot(ab, ap);
    double d2 = vdot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) {
        return closest(1.0, 0.0, 0.0, REGION_CORNER_0);
    }
    Vec3 bp = vsub(point, b);
    double d3 = vdot(ab, bp);
    double d4 = vdot(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) {
        return closest(0.0, 1.0, 0.0, REGION_CORNER_1);
    }
    double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        double t = d1 / (d1 - d3);
        return closest(1.0 - t, t, 0.0, REGION_SIDE_0);
    }
    Vec3 cp = vsub(point, c);
    double d5 = vdot(ab, cp);
    double d6 = vdot(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) {
        return closest(0.0, 0.0, 1.0, REGION_CORNER_2);
    }
    double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        double t = d2 / (d2 - d6);
        return closest(1.0 - t, 0.0, t, REGION_SIDE_2);
    }
    double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return closest(0.0, 1.0 - t, t, REGION_SIDE_1);
    }
    double scale = 1.0 / (va + vb + vc);
    return closest(1.0 - vb * scale - vc * scale, vb * scale, vc * scale, REGION_FACE);
}

PercaleClosest percale_closest_on_triangle(Vec3 point, Vec3 a, Vec3 b, Vec3 c)
{
    Vec3 ab = vsub(b, a);
    Vec3 ac = vsub(c, a);
    Vec3 normal = vcross(ab, ac);
    double sides4 = vdot(ab, ab) * vdot(ac, ac);
    if (vdot(normal, normal) <= THIN * sides4) {
        const Vec3 corners[3] = {a, b, c};
        return vdot(normal, normal) <= PARALLEL * sides4 ? closest_on_sides(point, corners)
                                                         : closest_on_thin(point, corners, normal);
    }
    PercaleClosest result = closest_by_region(point, a, b, c);
    result.distance2 = distance2_at(point, a, b, c, result.weights);
    return result;
}

static PercaleClosest closest_on_corner(Vec3 point, const Vec3 corners[3], int k)
{
    PercaleClosest corner = {0.0, {0.0, 0.0, 0.0}, (PercaleRegion)(REGION_CORNER_0 + k)};
    corner.weights[k] = 1.0;
    corner.distance2 = distance2_at(point, corners[0], corners[1], corners[2], corner.weights);
    return corner;
}

int percale_closest_features(Vec3 point, Vec3 a, Vec3 b, Vec3 c, PercaleClosest closest[CLOSEST_MOST])
{
    Vec3 ab = vsub(b, a);
    Vec3 ac = vsub(c, a);
    Vec3 normal = vcross(ab, ac);
    if (vdot(normal, normal) > PARALLEL * vdot(ab, ab) * vdot(ac, ac)) {
        return 1;
    }
    const Vec3 corners[3] = {a, b, c};
    double most = closest[0].distance2 + ALIKE * (vdot(ab, ab) + vdot(ac, ac));
    int count = 0;
    for (int k = 0; k < 3; k++) {
        PercaleClosest corner = closest_on_corner(point, corners, k);
        PercaleClosest side = closest_on_side(point, corners, k);
        if (corner.distance2 <= most) {
            closest[count++] = corner;
        }
        if (side.distance2 <= most && side.region < REGION_CORNER_0) {
            closest[count++] = side;
        }
    }
    return count;
}

static Vec3 load(const double x[3])
{
    return vec3(x[0], x[1], x[2]);
}

double percale_vertex_face_closest(const double x[4][3], double weight[4])
{
    PercaleClosest result = percale_closest_on_triangle(load(x[0]), load(x[1]), load(x[2]), load(x[3]));
    weight[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        weight[1 + k] = -result.weights[k];
    }
    return sqrt(result.distance2);
}

static double clamp01(double t)
{
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

/// Distance of the points at s on edge a and t on edge b; keeps them when nearer than the best so far.
static void keep_nearer(const Vec3 x[4], double s, double t, double *best2, double weight[4])
{
    Vec3 on_a = vadd(vscale(1.0 - s, x[0]), vscale(s, x[1]));
    Vec3 on_b = vadd(vscale(1.0 - t, x[2]), vscale(t, x[3]));
    Vec3 d = vsub(on_a, on_b);
    double distance2 = vdot(d, d);
    if (distance2 < *best2) {
        *best2 = distance2;
        weight[0] = 1.0 - s;
        weight[1] = s;
        weight[2] = -(1.0 - t);
        weight[3] = -t;
    }
}

double percale_edge_edge_closest(const double x[4][3], double weight[4])
{
    Vec3 p[4] = {load(x[0]), load(x[1]), load(x[2]), load(x[3])};
    Vec3 a = vsub(p[1], p[0]);
    Vec3 b = vsub(p[3], p[2]);
    Vec3 between = vsub(p[0], p[2]);
    double aa = vdot(a, a);
    double bb = vdot(b, b);
    double ab = vdot(a, b);
    double best2 = HUGE_VAL;
    // the four ends against the other edge, then the inner pair: every closest pair is one of these
    keep_nearer(p, 0.0, nearest_parameter(p[0], p[2], p[3]), &best2, weight);
    keep_nearer(p, 1.0, nearest_parameter(p[1], p[2], p[3]), &best2, weight);
    keep_nearer(p, nearest_parameter(p[2], p[0], p[1]), 0.0, &best2, weight);
    keep_nearer(p, nearest_parameter(p[3], p[0], p[1]), 1.0, &best2, weight);
    Vec3 normal = vcross(a, b);
    double sine2 = vdot(normal, normal);
    if (sine2 > PARALLEL * aa * bb) {
        double s = clamp01((ab * vdot(b, between) - bb * vdot(a, between)) / sine2);
        double t = clamp01((ab * s + vdot(b, between)) / bb);
        keep_nearer(p, s, t, &best2, weight);
    }
    return sqrt(best2);
}
