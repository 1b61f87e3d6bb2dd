// percale-tangles: takes the seeded set of tangles apart and says how many come apart. The judge is the
// audit, which shares no code with the untangling.

#include "cli/complaint.h"
#include "tangle_cases.h"

#include <stdlib.h>
#include <string.h>

static const char HELP[] =
    "percale-tangles [PREFIX] [--threads N]: one row for each tangle whose name begins with PREFIX, and a "
    "summary\n"
    "\n"
    "  pairs      of triangles that cross, before and after, as the audit counts them\n"
    "  rounds     of looking and moving\n"
    "  ms         without the audit\n"
    "  edges      farthest way of a vertex, in edge lengths\n"
    "  drift      |sum m dx| / sum m |dx|; a body takes what it pushes\n"
    "\n"
    "Exit codes: 0 done; 1 a tangle was made worse or holds what is no number; 2 bad arguments.\n";

/// What became of one tangle.
typedef struct Outcome {
    double before, after;
    bool nonfinite;
    PercaleUntangleReport work;
} Outcome;

typedef struct Sum {
    uint32_t count, apart, worse, nonfinite;
    double before, after, seconds, rounds;
} Sum;

static bool judge(PercaleSolver *solver, double *pairs, bool *nonfinite)
{
    PercaleQuality quality;
    if (percale_solver_quality(solver, &quality) != PERCALE_OK) {
        return false;
    }
    *pairs = quality.ef_cloth_cloth + quality.ef_cloth_obstacle;
    *nonfinite = quality.nonfinite > 0.0;
    return true;
}

static bool add(PercaleSolver *solver, const TangleCase *tangle)
{
    bool added = true;
    for (uint32_t i = 0; added && i < tangle->cloth_count; i++) {
        const PercaleMesh *mesh = &tangle->cloths[i];
        PercaleClothDef def = percale_cloth_def_default();
        PercaleCloth cloth;
        def.positions = mesh->positions;
        def.vertex_count = mesh->vertex_count;
        def.triangles = mesh->triangles;
        def.triangle_count = mesh->triangle_count;
        def.material.thickness = tangle->thickness;
        def.layer = tangle->layers[i];
        added = percale_cloth_add(solver, &def, &cloth) == PERCALE_OK;
    }
    if (added && tangle->body.vertex_count > 0) {
        PercaleObstacleDef def = percale_obstacle_def_default();
        PercaleObstacle body;
        def.positions = tangle->body.positions;
        def.vertex_count = tangle->body.vertex_count;
        def.triangles = tangle->body.triangles;
        def.triangle_count = tangle->body.triangle_count;
        def.thickness = tangle->thickness;
        added = percale_obstacle_add(solver, &def, &body) == PERCALE_OK;
    }
    return added;
}

static bool take_apart(const TangleCase *tangle, int thread_count, Outcome *outcome)
{
    PercaleSolverDef def = percale_solver_def_default();
    PercaleUntangleDef untangle = percale_untangle_def_default();
    PercaleSolver *solver = NULL;
    def.thread_count = thread_count;
    bool done = percale_solver_create(def, &solver) == PERCALE_OK && add(solver, tangle) &&
                judge(solver, &outcome->before, &outcome->nonfinite) &&
                percale_solver_untangle(solver, &untangle, &outcome->work) == PERCALE_OK &&
                judge(solver, &outcome->after, &outcome->nonfinite);
    if (!done) {
        (void)percale_complain(PERCALE_EXIT_FAILED, "%s: %s", tangle->name,
                               solver ? percale_solver_last_error(solver) : "out of memory");
    }
    percale_solver_destroy(solver);
    return done;
}

static void print_row(const TangleCase *tangle, const Outcome *outcome)
{
    (void)printf("%-28s %6.0f %6.0f %6d %9.1f %7.2f %9.1e%s\n", tangle->name, outcome->before, outcome->after,
                 outcome->work.iterations, 1e3 * outcome->work.seconds,
                 outcome->work.displacement_max / tangle->edge, outcome->work.momentum_drift,
                 outcome->after > 0.0 ? "  remains" : "");
}

static void add_up(Sum *sum, const Outcome *outcome)
{
    sum->count++;
    sum->apart += outcome->after == 0.0 && !outcome->nonfinite;
    sum->worse += outcome->after > outcome->before;
    sum->nonfinite += outcome->nonfinite;
    sum->before += outcome->before;
    sum->after += outcome->after;
    sum->seconds += outcome->work.seconds;
    sum->rounds += outcome->work.iterations;
}

static bool print_sums(const Sum sums[TANGLE_KINDS])
{
    bool good = true;
    (void)printf("\n%-28s %6s %6s %7s %9s %9s %9s %7s\n", "kind", "count", "apart", "", "pairs", "left",
                 "ms each", "rounds");
    for (int kind = 0; kind < TANGLE_KINDS; kind++) {
        const Sum *sum = &sums[kind];
        if (sum->count > 0) {
            (void)printf("%-28s %6u %6u %6.1f%% %9.0f %9.0f %9.1f %7.1f\n",
                         tangle_kind_name((TangleKind)kind), (unsigned)sum->count, (unsigned)sum->apart,
                         100.0 * sum->apart / sum->count, sum->before, sum->after,
                         1e3 * sum->seconds / sum->count, sum->rounds / sum->count);
        }
        good = good && sum->worse == 0 && sum->nonfinite == 0;
    }
    return good;
}

static int run(const char *prefix, int thread_count)
{
    Sum sums[TANGLE_KINDS] = {{0}};
    (void)printf("%-28s %6s %6s %6s %9s %7s %9s\n", "tangle", "pairs", "left", "rounds", "ms", "edges",
                 "drift");
    for (uint32_t i = 0; i < tangle_case_count(); i++) {
        TangleCase tangle;
        Outcome outcome = {0};
        bool made = tangle_case_make(i, &tangle);
        bool done = made && (strncmp(tangle.name, prefix, strlen(prefix)) != 0 ||
                             take_apart(&tangle, thread_count, &outcome));
        if (done && outcome.work.seconds > 0.0) {
            print_row(&tangle, &outcome);
            add_up(&sums[tangle.kind], &outcome);
        }
        tangle_case_free(&tangle);
        if (!done) {
            return PERCALE_EXIT_FAILED;
        }
    }
    return print_sums(sums) ? PERCALE_EXIT_DONE : PERCALE_EXIT_FAILED;
}

int main(int argument_count, char **arguments)
{
    const char *prefix = "";
    long thread_count = 1;
    for (int i = 1; i < argument_count; i++) {
        char *end = NULL;
        if (strcmp(arguments[i], "--help") == 0) {
            (void)fputs(HELP, stdout);
            return PERCALE_EXIT_DONE;
        }
        if (strcmp(arguments[i], "--threads") == 0 && i + 1 < argument_count) {
            thread_count = strtol(arguments[++i], &end, 10);
            if (*end != '\0' || thread_count < 1 || thread_count > PERCALE_MAX_THREADS) {
                return percale_complain(PERCALE_EXIT_USAGE, "--threads: '%s' is not within 1..%d",
                                        arguments[i], PERCALE_MAX_THREADS);
            }
        } else if (arguments[i][0] == '-') {
            return percale_complain(PERCALE_EXIT_USAGE, "what is '%s'? PREFIX, --threads or --help",
                                    arguments[i]);
        } else {
            prefix = arguments[i];
        }
    }
    return run(prefix, (int)thread_count);
}
