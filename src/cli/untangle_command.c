// percale untangle: takes cloth from files apart and writes it back. Exit 0 when nothing is left that
// crosses, 1 when something is.

#include "cli/commands.h"
#include "cli/complaint.h"
#include "cli/destination.h"
#include "cli/machine.h"
#include "cli/mesh_list.h"
#include "cli/report.h"
#include "cli/seam_file.h"
#include "cli/table.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const PercaleOptionKind KINDS[] = {
    {"--obstacle", PERCALE_OPTION_LIST}, {"--seams", PERCALE_OPTION_VALUE},
    {"--out", PERCALE_OPTION_VALUE},     {"--json", PERCALE_OPTION_VALUE},
    {"--set", PERCALE_OPTION_VALUE},     {"--threads", PERCALE_OPTION_VALUE},
    {"--quiet", PERCALE_OPTION_SWITCH},  {NULL, PERCALE_OPTION_SWITCH}};

static const uint64_t THREADS_RANGE[2] = {1, PERCALE_MAX_THREADS};

typedef struct Untangling {
    PercaleMeshList cloths, obstacles;
    PercaleSeamPairs seams;
    PercaleSolver *solver;
    PercaleCloth *handles; // [cloths]
    PercaleUntangleDef def;
    PercaleUntangleSettings settings;
    uint64_t threads;
    const char *folder, *json;
    bool quiet;
} Untangling;

// ---- settings ----

static bool set(PercaleUntangleSettings *settings, const char *text, PercaleSceneError *error)
{
    const struct {
        const char *name;
        double range[2];
        double *value;
    } NUMBERS[] = {{"thickness", {0.0, 1.0}, &settings->thickness},
                   {"layers", {0.0, 1.0}, &settings->layers},
                   {"rounds", {1.0, 1000.0}, &settings->rounds},
                   {"sweeps", {1.0, 1000.0}, &settings->sweeps},
                   {"patience", {1.0, 100.0}, &settings->patience}};
    const char *value = strchr(text, '=');
    size_t length = value ? (size_t)(value - text) : strlen(text);
    for (size_t k = 0; value && k < sizeof NUMBERS / sizeof NUMBERS[0]; ++k) {
        if (strlen(NUMBERS[k].name) != length || strncmp(NUMBERS[k].name, text, length) != 0)
            continue;
        const char *number = strcmp(value + 1, "on") == 0    ? "1"
                             : strcmp(value + 1, "off") == 0 ? "0"
                                                             : value + 1;
        return percale_option_number(NUMBERS[k].name, number, NUMBERS[k].range, NUMBERS[k].value, error);
    }
    (void)snprintf(error->text, sizeof error->text,
                   "--set: '%s' is none of thickness=m, layers=on|off, rounds=n, sweeps=n, patience=n", text);
    return false;
}

static bool read_settings(const PercaleOptions *options, Untangling *untangling, PercaleSceneError *error)
{
    const double THICKNESS_DEFAULT = 0.002; // m; the built-in scenes'
    PercaleUntangleSettings *settings = &untangling->settings;
    untangling->def = percale_untangle_def_default();
    *settings = (PercaleUntangleSettings){.thickness = THICKNESS_DEFAULT,
                                          .rounds = untangling->def.rounds,
                                          .sweeps = untangling->def.sweeps,
                                          .patience = untangling->def.patience};
    for (size_t k = 0; k < options->count; ++k) {
        const PercaleOption *option = &options->items[k];
        if (option->name && strcmp(option->name, "--set") == 0 && !set(settings, option->value, error))
            return false;
    }
    untangling->def.rounds = (int)settings->rounds;
    untangling->def.sweeps = (int)settings->sweeps;
    untangling->def.patience = (int)settings->patience;
    return true;
}

// ---- the scene ----

static bool check_names(const PercaleMeshList *cloths, PercaleSceneError *error)
{
    for (size_t index = 0; index < cloths->count; ++index) {
        for (size_t other = 0; other < index; ++other) {
            if (strcmp(cloths->meshes[index].name, cloths->meshes[other].name) == 0) {
                (void)snprintf(error->text, sizeof error->text, "--out: two cloths are named '%s'",
                               cloths->meshes[index].name);
                return false;
            }
        }
    }
    return true;
}

static bool take_error(const Untangling *untangling, PercaleSceneError *error)
{
    (void)snprintf(error->text, sizeof error->text, "%s",
                   untangling->solver ? percale_solver_last_error(untangling->solver) : "out of memory");
    return false;
}

static bool add_meshes(Untangling *untangling)
{
    float thickness = (float)untangling->settings.thickness;
    bool added = true;
    for (size_t index = 0; added && index < untangling->cloths.count; ++index) {
        const PercaleMesh *mesh = &untangling->cloths.meshes[index];
        PercaleClothDef def = percale_cloth_def_default();
        def.name = mesh->name;
        def.positions = mesh->positions;
        def.vertex_count = mesh->vertex_count;
        def.triangles = mesh->triangles;
        def.triangle_count = mesh->triangle_count;
        def.material.thickness = thickness;
        def.layer = untangling->settings.layers > 0.0 ? (int32_t)index : 0;
        added = percale_cloth_add(untangling->solver, &def, &untangling->handles[index]) == PERCALE_OK;
    }
    for (size_t index = 0; added && index < untangling->obstacles.count; ++index) {
        const PercaleMesh *mesh = &untangling->obstacles.meshes[index];
        PercaleObstacleDef def = percale_obstacle_def_default();
        PercaleObstacle obstacle;
        def.name = mesh->name;
        def.positions = mesh->positions;
        def.vertex_count = mesh->vertex_count;
        def.triangles = mesh->triangles;
        def.triangle_count = mesh->triangle_count;
        def.thickness = thickness;
        added = percale_obstacle_add(untangling->solver, &def, &obstacle) == PERCALE_OK;
    }
    return added;
}

static bool sew(Untangling *untangling)
{
    bool sewn = true;
    for (size_t index = 0; sewn && index < untangling->seams.count; ++index) {
        const PercaleSeamPair *pair = &untangling->seams.items[index];
        PercaleSeamDef def = percale_seam_def_default();
        PercaleSeam seam;
        def.cloth_a = untangling->handles[pair->cloth[0]];
        def.cloth_b = untangling->handles[pair->cloth[1]];
        def.vertices_a = &pair->vertex[0];
        def.vertices_b = &pair->vertex[1];
        def.pair_count = 1;
        sewn = percale_seam_add(untangling->solver, &def, &seam) == PERCALE_OK;
    }
    return sewn;
}

static bool build(Untangling *untangling, PercaleSceneError *error)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.thread_count = (int)untangling->threads;
    untangling->handles = calloc(untangling->cloths.count + 1, sizeof *untangling->handles);
    bool built = untangling->handles && percale_solver_create(def, &untangling->solver) == PERCALE_OK &&
                 add_meshes(untangling) && sew(untangling);
    return built || take_error(untangling, error);
}

/// Everything that the user can get wrong; writes nothing.
static bool prepare(const PercaleOptions *options, Untangling *untangling, PercaleSceneError *error)
{
    untangling->threads = percale_machine_threads();
    untangling->folder = percale_options_value(options, "--out");
    untangling->json = percale_options_value(options, "--json");
    untangling->quiet = percale_options_find(options, "--quiet") != NULL;
    const char *seams = percale_options_value(options, "--seams");
    if (!percale_options_find(options, NULL) || !untangling->folder) {
        (void)snprintf(error->text, sizeof error->text, "untangle: %s",
                       untangling->folder ? "no cloth" : "--out is missing");
        return false;
    }
    bool good = percale_option_whole("--threads", percale_options_value(options, "--threads"), THREADS_RANGE,
                                     &untangling->threads, error) &&
                read_settings(options, untangling, error) &&
                percale_destination_folder("--out", untangling->folder, error) &&
                percale_destination_file("--json", untangling->json, error) &&
                percale_mesh_list_read(options, NULL, &untangling->cloths, error) &&
                percale_mesh_list_read(options, "--obstacle", &untangling->obstacles, error) &&
                check_names(&untangling->cloths, error) &&
                (!seams || percale_seam_file_read(seams, untangling->cloths.meshes, untangling->cloths.count,
                                                  &untangling->seams, error));
    for (uint32_t index = 0; good && index < untangling->cloths.count; ++index)
        if (!percale_seam_pairs_add_coincident(&untangling->cloths.meshes[index], index, &untangling->seams))
            good = take_error(untangling, error);
    return good && build(untangling, error);
}

// ---- results ----

static bool write_cloths(const Untangling *untangling, PercaleSceneError *error)
{
    bool written = percale_destination_make(untangling->folder, error);
    for (size_t index = 0; written && index < untangling->cloths.count; ++index) {
        const PercaleMesh *mesh = &untangling->cloths.meshes[index];
        size_t size = strlen(mesh->name) + sizeof ".obj";
        char *file = malloc(size);
        if (file)
            (void)snprintf(file, size, "%s.obj", mesh->name);
        char *path = file ? percale_destination_join(untangling->folder, file) : NULL;
        written = path && (percale_cloth_get_positions(untangling->solver, untangling->handles[index],
                                                       mesh->positions, 0) == PERCALE_OK ||
                           take_error(untangling, error));
        if (written)
            written = percale_obj_write(path, mesh->positions, mesh->vertex_count, mesh->triangles,
                                        mesh->triangle_count, NULL, error);
        else if (!path)
            (void)snprintf(error->text, sizeof error->text, "out of memory");
        free(path);
        free(file);
    }
    return written;
}

static double crossing_pairs(const PercaleQuality *quality)
{
    return quality->ef_cloth_cloth + quality->ef_cloth_obstacle;
}

static bool run(Untangling *untangling, PercaleUntangleCommandReport *report, PercaleSceneError *error)
{
    PercaleSolver *solver = untangling->solver;
    *report = (PercaleUntangleCommandReport){.threads = (int)untangling->threads,
                                             .isa = percale_solver_isa(solver),
                                             .cloths = (uint32_t)untangling->cloths.count,
                                             .obstacles = (uint32_t)untangling->obstacles.count,
                                             .vertices = percale_mesh_list_vertices(&untangling->cloths),
                                             .triangles = percale_mesh_list_triangles(&untangling->cloths),
                                             .obstacle_triangles =
                                                 percale_mesh_list_triangles(&untangling->obstacles),
                                             .settings = untangling->settings};
    if (percale_solver_quality(solver, &report->quality_before) != PERCALE_OK ||
        percale_solver_untangle(solver, &untangling->def, &report->work) != PERCALE_OK ||
        percale_solver_quality(solver, &report->quality) != PERCALE_OK)
        return take_error(untangling, error);
    report->ef_before = crossing_pairs(&report->quality_before);
    report->ef_after = crossing_pairs(&report->quality);
    report->state_hash = percale_solver_hash(solver);
    return write_cloths(untangling, error) &&
           (!untangling->json || percale_untangle_report_write(report, untangling->json, error));
}

static int untangle(Untangling *untangling)
{
    PercaleSceneError error = {""};
    PercaleUntangleCommandReport report;
    if (!run(untangling, &report, &error))
        return percale_complain(PERCALE_EXIT_FAILED, "%s", error.text);
    if (!untangling->quiet && (!untangling->json || strcmp(untangling->json, "-") != 0))
        percale_untangle_table_print(&report);
    if (report.ef_after > 0.0)
        return percale_complain(PERCALE_EXIT_FAILED, "untangle: %.0f of %.0f pairs of triangles still cross",
                                report.ef_after, report.ef_before);
    return PERCALE_EXIT_DONE;
}

int percale_command_untangle(int argument_count, char **arguments)
{
    PercaleSceneError error = {""};
    PercaleOptions options;
    if (!percale_options_parse(argument_count, arguments, KINDS, &options, &error))
        return percale_complain(PERCALE_EXIT_USAGE, "untangle: %s", error.text);
    Untangling untangling = {.quiet = false};
    int code = prepare(&options, &untangling, &error)
                   ? untangle(&untangling)
                   : percale_complain(PERCALE_EXIT_USAGE, "%s", error.text);
    percale_solver_destroy(untangling.solver);
    free(untangling.handles);
    free(untangling.seams.items);
    percale_mesh_list_free(&untangling.cloths);
    percale_mesh_list_free(&untangling.obstacles);
    percale_options_free(&options);
    return code;
}
