// The contact kernel: its stencils against central differences of the distance, its projection, its friction.

#include "kernel_testing.h"

#include "detect/carry.h"
#include "detect/contacts.h"
#include "percale/geometry.h"
#include "solve/solve_arrays.h"

#include <math.h>

enum { TRIALS = 300 };

typedef struct Contact {
    PercaleModelSurface obstacle;
    uint32_t triangles[3];
    PercaleSurface surface;
    f32x4 x[POINTS]; // vertex, then the face
    PercaleClosest closest;
    int side;
    PercaleStencil stencil;
} Contact;

/// A vertex over or under the place of a triangle with the barycentric coordinates b, and the stencil that
/// detection makes of it.
static void open_contact(Contact *contact, uint64_t *seed, const double b[3], double height)
{
    *contact = (Contact){.obstacle = {.vertex_count = 3, .triangle_count = 1, .thickness = 0.002f},
                         .triangles = {1, 2, 3}};
    contact->obstacle.triangles = contact->triangles;
    contact->surface = (PercaleSurface){&contact->obstacle, NULL, contact->x, NULL};
    Vec3 corner[3];
    Vec3 normal;
    do {
        random_points(seed, contact->x);
        for (int k = 0; k < 3; k++) {
            corner[k] = vec3_of(contact->x[1 + k]);
        }
        normal = vcross(vsub(corner[1], corner[0]), vsub(corner[2], corner[0]));
    } while (vlength(normal) < 0.5);
    Vec3 place = vadd(vadd(vscale(b[0], corner[0]), vscale(b[1], corner[1])), vscale(b[2], corner[2]));
    contact->x[0] = f32x4_of(vadd(place, vscale(height, vunit(normal))), contact->x[0][3]);
    Vec3 point = vec3_of(contact->x[0]);
    contact->side = height > 0.0 ? 1 : -1;
    contact->closest = percale_closest_on_triangle(point, corner[0], corner[1], corner[2]);
    Vec3 direction = percale_contact_normal(&contact->surface, point, 0, &contact->closest, contact->side);
    contact->stencil =
        (PercaleStencil){.points = {0, 1, 2, 3}, .weights = {1.0f}, .normal = f32x4_of(direction, 0.0f)};
    float weights[3];
    quantize_weights(contact->closest.weights, weights);
    for (int k = 0; k < 3; k++) {
        contact->stencil.weights[1 + k] = -weights[k];
    }
}

static double signed_distance(const Vec3 x[POINTS], const void *side)
{
    double points[POINTS][3];
    double weights[POINTS];
    for (int k = 0; k < POINTS; k++) {
        points[k][0] = x[k].x;
        points[k][1] = x[k].y;
        points[k][2] = x[k].z;
    }
    return (double)*(const int *)side * percale_vertex_face_closest((const double(*)[3])points, weights);
}

/// A place in the middle of each kind of region: face, the three sides, the three corners.
static const double REGIONS[7][3] = {{0.3, 0.3, 0.4},   {0.6, 0.7, -0.3},  {-0.3, 0.5, 0.8}, {0.5, -0.3, 0.8},
                                     {2.2, -0.6, -0.6}, {-0.6, 2.2, -0.6}, {-0.6, -0.6, 2.2}};

START_TEST(contact_stencils_are_the_gradient_of_the_distance)
{
    uint64_t seed = 5;
    int met[REGION_CORNER_2 + 1] = {0};
    for (int trial = 0; trial < 2 * TRIALS; trial++) {
        Contact contact;
        Vec3 points[POINTS];
        Vec3 gradient[POINTS];
        double height = trial % 2 == 0 ? 0.2 : -0.2;
        open_contact(&contact, &seed, REGIONS[trial / 2 % 7], height);
        load_points(contact.x, points);
        differentiate(signed_distance, &contact.side, points, 1e-4, gradient);
        met[contact.closest.region]++;
        for (int k = 0; k < POINTS; k++) { // the weights were rounded to 2^-24, the normal to float32
            Vec3 stencil = vscale((double)contact.stencil.weights[k], vec3_of(contact.stencil.normal));
            ck_assert_double_lt(vlength(vsub(stencil, gradient[k])), 5e-7);
        }
    }
    for (int region = 0; region <= REGION_CORNER_2; region++) {
        ck_assert_int_gt(met[region], TRIALS / 10);
    }
}
END_TEST

static PercaleSolveArrays contact_arrays(Contact *contact, f32x4 x[POINTS], const f32x4 start[POINTS])
{
    static const uint32_t ORDER = 0;
    return (PercaleSolveArrays){
        .x = x, .start = start, .dt = 1e-3f, .stencils = &contact->stencil, .stencil_order = &ORDER};
}

/// The mobility that would move the point with the longest lever by four times the violation.
static double longest_lever(const f32x4 x[POINTS], const Vec3 gradient[POINTS])
{
    double longest = 0.0;
    for (int k = 0; k < POINTS; k++) {
        longest = fmax(longest, 0.25 * (double)x[k][3] * vlength(gradient[k]));
    }
    return longest;
}

START_TEST(contact_moves_along_its_gradient_onto_its_distance)
{
    uint64_t seed = 6;
    for (int trial = 0; trial < TRIALS; trial++) {
        Contact contact;
        f32x4 x[POINTS];
        Vec3 gradient[POINTS];
        open_contact(&contact, &seed, REGIONS[trial % 7], trial % 2 == 0 ? 0.02 : -0.02);
        double distance = (double)contact.side * sqrt(contact.closest.distance2);
        double target = distance + 0.05;
        contact.stencil.normal[3] = (float)target;
        for (int k = 0; k < POINTS; k++) {
            gradient[k] = vscale((double)contact.stencil.weights[k], vec3_of(contact.stencil.normal));
        }
        memcpy(x, contact.x, sizeof(x));
        PercaleSolveArrays arrays = contact_arrays(&contact, x, contact.x);
        percale_solve_contact(&arrays, 0, 1);
        double stiffness = fmax(mobility(contact.x, gradient), longest_lever(contact.x, gradient));
        expect_moved_along((const f32x4 *)contact.x, (const f32x4 *)x, (const Vec3 *)gradient,
                           stiffness > 0.0 ? 0.05 / stiffness : 0.0);
    }
}
END_TEST

/// sum m dx and sum m x cross dx, in relation to sum m |dx|.
static void momenta(const f32x4 before[POINTS], const f32x4 after[POINTS], double *linear, double *angular)
{
    Vec3 sum = {0.0, 0.0, 0.0};
    Vec3 turn = {0.0, 0.0, 0.0};
    double size = 0.0;
    for (int k = 0; k < POINTS; k++) {
        double mass = 1.0 / (double)before[k][3];
        Vec3 moved = vscale(mass, vsub(vec3_of(after[k]), vec3_of(before[k])));
        sum = vadd(sum, moved);
        turn = vadd(turn, vcross(vec3_of(before[k]), moved));
        size += vlength(moved);
    }
    *linear = vlength(sum) / size;
    *angular = vlength(turn) / size;
}

START_TEST(contact_keeps_momentum)
{
    uint64_t seed = 7;
    for (int trial = 0; trial < TRIALS; trial++) {
        Contact contact;
        f32x4 x[POINTS];
        open_contact(&contact, &seed, REGIONS[trial % 7], trial % 2 == 0 ? 0.2 : -0.2);
        for (int k = 0; k < POINTS; k++) {
            contact.x[k][3] = random_float(&seed, 0.1, 10.0);
        }
        double distance = (double)contact.side * sqrt(contact.closest.distance2);
        contact.stencil.normal[3] = (float)(distance + 0.1);
        memcpy(x, contact.x, sizeof(x));
        PercaleSolveArrays arrays = contact_arrays(&contact, x, contact.x);
        percale_solve_contact(&arrays, 0, 1);
        double linear;
        double angular;
        momenta((const f32x4 *)contact.x, (const f32x4 *)x, &linear, &angular);
        ck_assert_double_lt(linear, 5e-5);  // what float32 leaves of a heavy point's short way
        ck_assert_double_lt(angular, 5e-5); // the closest points' difference is parallel to the normal
    }
}
END_TEST

START_TEST(a_contact_that_keeps_its_distance_does_nothing)
{
    uint64_t seed = 8;
    for (int trial = 0; trial < TRIALS; trial++) {
        Contact contact;
        f32x4 x[POINTS];
        open_contact(&contact, &seed, REGIONS[trial % 7], 0.2);
        contact.stencil.friction = 0.5f;
        contact.stencil.normal[3] = (float)sqrt(contact.closest.distance2) - 1e-3f;
        memcpy(x, contact.x, sizeof(x));
        f32x4 start[POINTS] = {{0}}; // a long way: friction would show
        PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
        percale_solve_contact(&arrays, 0, 1);
        ck_assert_mem_eq(contact.x, x, sizeof(x));
    }
}
END_TEST

START_TEST(a_contact_that_nobody_can_yield_to_does_nothing)
{
    uint64_t seed = 9;
    Contact contact;
    f32x4 x[POINTS];
    open_contact(&contact, &seed, REGIONS[0], -0.2);
    for (int k = 0; k < POINTS; k++) {
        contact.x[k][3] = 0.0f;
    }
    memcpy(x, contact.x, sizeof(x));
    PercaleSolveArrays arrays = contact_arrays(&contact, x, contact.x);
    percale_solve_contact(&arrays, 0, 1);
    ck_assert_mem_eq(contact.x, x, sizeof(x));
    ck_assert_mem_eq(&contact.stencil.multiplier, &(f32x4){0}, sizeof(f32x4));
}
END_TEST

// ---- friction ----

static f32x4 random_shift(uint64_t *seed, double size)
{
    return (f32x4){random_float(seed, -size, size), random_float(seed, -size, size),
                   random_float(seed, -size, size), 0.0f};
}

START_TEST(friction_stays_inside_the_cone)
{
    uint64_t seed = 10;
    int sliding_count = 0;
    int sticking_count = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        Contact contact;
        f32x4 x[POINTS];
        f32x4 start[POINTS];
        open_contact(&contact, &seed, REGIONS[trial % 7], -0.05);
        contact.stencil.friction = random_float(&seed, 0.0, 1.5);
        memcpy(x, contact.x, sizeof(x));
        memcpy(start, contact.x, sizeof(start));
        PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
        for (int sweep = 0; sweep < 10; sweep++) { // other constraints pull at the points between sweeps
            for (int k = 0; k < POINTS; k++) {
                x[k] += x[k][3] > 0.0f ? random_shift(&seed, 0.02) : (f32x4){0};
            }
            percale_solve_contact(&arrays, 0, 1);
            f32x4 total = contact.stencil.multiplier;
            float normal = total[3];
            float tangential = length3(total);
            ck_assert(normal >= 0.0f);
            ck_assert(tangential <= contact.stencil.friction * normal * (1.0f + 1e-5f));
            ck_assert(fabsf(dot3(total, contact.stencil.normal)) <= 1e-5f * (tangential + normal));
            bool slides = tangential >= contact.stencil.friction * normal * (1.0f - 1e-5f);
            sliding_count += normal > 0.0f && slides;
            sticking_count += normal > 0.0f && !slides;
        }
    }
    ck_assert_int_gt(sliding_count, TRIALS);
    ck_assert_int_gt(sticking_count, TRIALS);
}
END_TEST

static void expect_near(float value, float expected)
{
    ck_assert_double_eq_tol((double)value, (double)expected, 2e-8);
}

/// A vertex of 0.5 kg above a fixed floor that keeps 2 mm: it has gone `slip` along x and stands `depth` too
/// low. Returns where it is afterwards.
static f32x4 press(float depth, float slip, float friction, int sweeps)
{
    Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                   .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                                   .normal = {0.0f, 0.0f, 1.0f, 0.002f},
                                   .friction = friction}};
    f32x4 start[POINTS] = {{0.0f, 0.0f, 0.002f, 2.0f},
                           {-1.0f, -1.0f, 0.0f, 0.0f},
                           {2.0f, 0.0f, 0.0f, 0.0f},
                           {0.0f, 2.0f, 0.0f, 0.0f}};
    f32x4 x[POINTS];
    memcpy(x, start, sizeof(x));
    x[0] += (f32x4){slip, 0.0f, -depth, 0.0f};
    PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
    for (int sweep = 0; sweep < sweeps; sweep++) {
        percale_solve_contact(&arrays, 0, 1);
    }
    return x[0];
}

// What slides is braked by mu times the depth, what holds doesn't move at all; more sweeps change nothing.
START_TEST(friction_brakes_as_coulomb_says)
{
    for (int sweeps = 1; sweeps < 5; sweeps++) {
        for (int i = 0; i < 10; i++) {
            float slip = 1e-5f * (float)(1 << i);
            f32x4 end = press(1e-3f, slip, 0.4f, sweeps);
            float left = slip > 0.4e-3f ? slip - 0.4e-3f : 0.0f;
            expect_near(end[0], left);
            expect_near(end[1], 0.0f);
            expect_near(end[2], 0.002f);
        }
    }
}
END_TEST

START_TEST(friction_lets_go_with_the_contact)
{
    Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                   .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                                   .normal = {0.0f, 0.0f, 1.0f, 0.002f},
                                   .friction = 1.0f}};
    f32x4 start[POINTS] = {{0.0f, 0.0f, 0.002f, 2.0f},
                           {-1.0f, -1.0f, 0.0f, 0.0f},
                           {2.0f, 0.0f, 0.0f, 0.0f},
                           {0.0f, 2.0f, 0.0f, 0.0f}};
    f32x4 x[POINTS];
    memcpy(x, start, sizeof(x));
    x[0] += (f32x4){5e-4f, 0.0f, -1e-3f, 0.0f};
    PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
    percale_solve_contact(&arrays, 0, 1);
    expect_near(x[0][0], 0.0f); // held
    x[0][2] += 0.01f;           // torn off by something else
    percale_solve_contact(&arrays, 0, 1);
    expect_near(x[0][0], 5e-4f); // as if it had never been touched
    expect_near(x[0][2], 0.011f);
    expect_near(contact.stencil.multiplier[3], 0.0f);
}
END_TEST

/// A vertex that is pressed 1 mm into a floor and owes a slip along x; friction may undo 0.4 mm of it. Others
/// then move it by `pull` along x.
static PercaleStencil owe(float owed, float pull, f32x4 *end)
{
    Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                   .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                                   .normal = {0.0f, 0.0f, 1.0f, 0.002f},
                                   .owed = {owed, 0.0f, 0.0f, 0.0f},
                                   .friction = 0.4f}};
    f32x4 start[POINTS] = {{0.0f, 0.0f, 0.002f, 2.0f},
                           {-1.0f, -1.0f, 0.0f, 0.0f},
                           {2.0f, 0.0f, 0.0f, 0.0f},
                           {0.0f, 2.0f, 0.0f, 0.0f}};
    f32x4 x[POINTS];
    memcpy(x, start, sizeof(x));
    x[0][2] -= 1e-3f;
    PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
    percale_solve_contact(&arrays, 0, 1);
    x[0][0] += pull;
    (void)percale_solve_contact_slips(&arrays, 0, 1);
    *end = x[0];
    return contact.stencil;
}

START_TEST(friction_undoes_what_it_owes)
{
    f32x4 end;
    PercaleStencil stencil = owe(3e-4f, 0.0f, &end);
    expect_near(end[0], -3e-4f);
    expect_near(stencil.owed[0], 0.0f);
    stencil = owe(3e-4f, 5e-5f, &end); // what comes after its turn is owed
    expect_near(stencil.owed[0], 5e-5f);
    expect_near(stencil.owed[2], 0.0f);
}
END_TEST

START_TEST(an_anchor_is_dragged_by_what_the_cone_refuses)
{
    f32x4 end;
    PercaleStencil stencil = owe(3e-3f, 0.0f, &end);
    expect_near(end[0], -4e-4f);
    expect_near(stencil.owed[0], 0.0f);
    stencil = owe(3e-3f, 5e-5f, &end);
    expect_near(stencil.owed[0], 5e-5f);
}
END_TEST

START_TEST(what_does_not_touch_owes_nothing)
{
    Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                   .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                                   .normal = {0.0f, 0.0f, 1.0f, 0.002f},
                                   .owed = {1e-4f, 0.0f, 0.0f, 0.0f},
                                   .friction = 0.4f}};
    f32x4 x[POINTS] = {{0.0f, 0.0f, 0.003f, 2.0f},
                       {-1.0f, -1.0f, 0.0f, 0.0f},
                       {2.0f, 0.0f, 0.0f, 0.0f},
                       {0.0f, 2.0f, 0.0f, 0.0f}};
    f32x4 start[POINTS];
    memcpy(start, x, sizeof(start));
    PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
    percale_solve_contact(&arrays, 0, 1);
    ck_assert(!percale_solve_contact_slips(&arrays, 0, 1));
    expect_near(x[0][0], 0.0f);
    ck_assert_mem_eq(&contact.stencil.owed, &(f32x4){0}, sizeof(f32x4));
}
END_TEST

// ---- what is handed on ----

/// A stencil of one vertex, of this face and this normal.
static PercaleStencil stencil_of(uint64_t source, uint32_t face, float nx, float nz)
{
    return (PercaleStencil){.points = {1, 10 * face, 10 * face + 1, 10 * face + 2},
                            .normal = {nx, 0.0f, nz, 0.002f},
                            .source = source};
}

START_TEST(anchors_pass_to_the_same_points_else_to_the_same_surface)
{
    PercaleStencil known[3] = {stencil_of(4, 1, 0.0f, 1.0f), stencil_of(7, 2, 0.0f, 1.0f),
                               stencil_of(7, 3, 0.0f, -1.0f)};
    for (int i = 0; i < 3; i++) {
        known[i].owed = (f32x4){1e-3f * (float)(i + 1), 0.0f, 0.0f, 0.0f};
        known[i].multiplier = (f32x4){0.5f, 0.0f, 0.0f, 2.0f + (float)i};
    }
    for (int same_substep = 0; same_substep < 2; same_substep++) {
        PercaleStencil found[5] = {stencil_of(4, 1, 0.0f, 1.0f),  // the same
                                   stencil_of(5, 1, 0.0f, 1.0f),  // the same points, another source
                                   stencil_of(7, 2, 0.6f, 0.8f),  // the same, turned
                                   stencil_of(7, 9, 0.0f, -1.0f), // a neighbour of the third
                                   stencil_of(7, 8, 1.0f, 0.0f)}; // no neighbour
        PercaleStencilList known_list = {known, 3, 3};
        PercaleStencilList found_list = {found, 5, 5};
        PercaleCarryStage stage = {&known_list, &found_list, same_substep == 1, percale_team_alone()};
        percale_carry_run(&stage);
        expect_near(found[0].owed[0], 1e-3f);
        expect_near(found[1].owed[0], 0.0f);
        expect_near(found[2].owed[0], 2e-3f * 0.64f); // along the turned surface
        expect_near(found[2].owed[2], -2e-3f * 0.48f);
        expect_near(found[3].owed[0], 3e-3f);
        expect_near(found[4].owed[0], 0.0f);
        expect_near(found[0].multiplier[3], same_substep == 1 ? 2.0f : 0.0f);
        expect_near(found[0].multiplier[0], same_substep == 1 ? 0.5f : 0.0f);
        expect_near(found[2].multiplier[3], same_substep == 1 ? 3.0f : 0.0f);
        expect_near(found[3].multiplier[3], 0.0f); // the push was another pair's
    }
}
END_TEST

/// A vertex that is held lies 1 mm too deep below a face of which only one corner is free, and that hardly
/// counts.
START_TEST(a_contact_far_from_what_can_move_is_no_lever)
{
    const float WEIGHTS[] = {0.5f, 0.25f, 0.125f, 0x1p-10f, 0x1p-24f};
    for (size_t i = 0; i < sizeof(WEIGHTS) / sizeof(WEIGHTS[0]); i++) {
        float weight = WEIGHTS[i];
        Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                       .weights = {1.0f, weight - 1.0f, -weight, 0.0f},
                                       .normal = {0.0f, 0.0f, 1.0f, 0.002f}}};
        f32x4 start[POINTS] = {{0.0f, 0.0f, 0.001f, 0.0f},
                               {0.0f, 0.0f, 0.0f, 0.0f},
                               {1.0f, 0.0f, 0.0f, 3.0f},
                               {0.0f, 1.0f, 0.0f, 0.0f}};
        f32x4 x[POINTS];
        memcpy(x, start, sizeof(x));
        PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
        percale_solve_contact(&arrays, 0, 1);
        expect_near(x[2][2], weight >= 0.25f ? -0.001f / weight : -0.004f);
    }
}
END_TEST

// ---- what undoes an overlap ----

/// A vertex that was `overlap` too low and rises at `speed` once it has been lifted; it rose at `before`
/// earlier. Returns the speed that is left to it.
static float leave(float overlap, float speed, float before)
{
    Contact contact = {.stencil = {.points = {0, 1, 2, 3},
                                   .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                                   .normal = {0.0f, 0.0f, 1.0f, 0.002f},
                                   .multiplier = {0.0f, 0.0f, 0.0f, 1.0f}}};
    f32x4 start[POINTS] = {{0.0f, 0.0f, 0.002f - overlap, 2.0f},
                           {-1.0f, -1.0f, 0.0f, 0.0f},
                           {2.0f, 0.0f, 0.0f, 0.0f},
                           {0.0f, 2.0f, 0.0f, 0.0f}};
    f32x4 x[POINTS];
    memcpy(x, start, sizeof(x));
    f32x4 velocity = {0.3f, 0.0f, speed, 0.0f};
    f32x4 earlier = {0.3f, 0.0f, before, 0.0f};
    PercaleModel model = {.slot_count = 1, .velocity = &earlier};
    PercaleSolveArrays arrays = contact_arrays(&contact, x, start);
    arrays.model = &model;
    arrays.velocity = &velocity;
    percale_solve_contact_exit(&arrays, 0, 1);
    expect_near(velocity[0], 0.3f);
    return velocity[2];
}

static void expect_speed(float value, float expected)
{
    ck_assert_double_eq_tol((double)value, (double)expected, 1e-6);
}

START_TEST(a_correction_gives_no_velocity_and_takes_none)
{
    expect_speed(leave(1e-3f, 0.5f, 0.0f), 0.0f);
    expect_speed(leave(1e-3f, 0.5f, -2.0f), 0.0f);   // it came in
    expect_speed(leave(1e-3f, 0.5f, 0.2f), 0.2f);    // it was on its way out
    expect_speed(leave(1e-4f, 0.5f, 0.0f), 0.4f);    // 0.1 mm in a millisecond was the correction's
    expect_speed(leave(0.0f, 0.5f, 0.0f), 0.5f);     // nothing was to be undone
    expect_speed(leave(1e-3f, -0.5f, -0.5f), -0.5f); // it doesn't leave
}
END_TEST

START_TEST(quantized_weights_sum_to_exactly_one)
{
    uint64_t seed = 11;
    for (int trial = 0; trial < 100 * TRIALS; trial++) {
        double u = percale_test_random(&seed);
        double v = (1.0 - u) * percale_test_random(&seed);
        const double weights[3] = {u, v, 1.0 - u - v};
        float rounded[3];
        quantize_weights(weights, rounded);
        ck_assert(1.0f - rounded[0] - rounded[1] - rounded[2] == 0.0f);
        ck_assert((double)rounded[0] + (double)rounded[1] + (double)rounded[2] == 1.0);
        for (int k = 0; k < 3; k++) {
            ck_assert(fabs((double)rounded[k] - weights[k]) <= 6.1e-8);
        }
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("contact kernel");
    TCase *contact = tcase_create("contact");
    tcase_add_test(contact, contact_stencils_are_the_gradient_of_the_distance);
    tcase_add_test(contact, contact_moves_along_its_gradient_onto_its_distance);
    tcase_add_test(contact, a_contact_far_from_what_can_move_is_no_lever);
    tcase_add_test(contact, contact_keeps_momentum);
    tcase_add_test(contact, a_contact_that_keeps_its_distance_does_nothing);
    tcase_add_test(contact, a_contact_that_nobody_can_yield_to_does_nothing);
    tcase_add_test(contact, friction_stays_inside_the_cone);
    tcase_add_test(contact, friction_brakes_as_coulomb_says);
    tcase_add_test(contact, friction_lets_go_with_the_contact);
    tcase_add_test(contact, friction_undoes_what_it_owes);
    tcase_add_test(contact, an_anchor_is_dragged_by_what_the_cone_refuses);
    tcase_add_test(contact, what_does_not_touch_owes_nothing);
    tcase_add_test(contact, anchors_pass_to_the_same_points_else_to_the_same_surface);
    tcase_add_test(contact, a_correction_gives_no_velocity_and_takes_none);
    tcase_add_test(contact, quantized_weights_sum_to_exactly_one);
    suite_add_tcase(suite, contact);
    return percale_test_run(suite);
}
