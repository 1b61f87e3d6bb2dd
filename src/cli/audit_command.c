// percale audit: judges meshes from files, without a simulation. Exit 0 whatever it finds.

#include "cli/commands.h"
#include "cli/complaint.h"
#include "cli/destination.h"
#include "cli/mesh_list.h"
#include "cli/report.h"
#include "cli/table.h"
#include "percale/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double THICKNESS_RANGE[2] = {0.0, 1.0}; // m
static const double THICKNESS_DEFAULT = 0.002;       // m; the built-in scenes'

static const PercaleOptionKind KINDS[] = {
    {"--cloth", PERCALE_OPTION_LIST},    {"--rest", PERCALE_OPTION_LIST},
    {"--obstacle", PERCALE_OPTION_LIST}, {"--thickness", PERCALE_OPTION_VALUE},
    {"--json", PERCALE_OPTION_VALUE},    {NULL, PERCALE_OPTION_SWITCH}};

typedef struct Judgement {
    PercaleMeshList cloths, rests, obstacles;
    PercaleAuditMesh *audit; // [cloths, then obstacles]
    float **rest_lengths;    // [cloths]
    double thickness;        // m
} Judgement;

static bool out_of_memory(PercaleSceneError *error)
{
    (void)snprintf(error->text, sizeof error->text, "audit: out of memory");
    return false;
}

static PercaleAuditMesh audit_mesh(const PercaleMesh *mesh, double thickness)
{
    return (PercaleAuditMesh){.positions = mesh->positions,
                              .vertex_count = mesh->vertex_count,
                              .triangles = mesh->triangles,
                              .triangle_count = mesh->triangle_count,
                              .thickness = (float)thickness,
                              .mask = UINT32_MAX};
}

/// Lengths of the rest mesh's edges, by the cloth's corners.
static void measure_rest(const PercaleMesh *cloth, const PercaleMesh *rest, float *lengths)
{
    for (size_t corner = 0; corner < 3 * (size_t)cloth->triangle_count; ++corner) {
        const float *x = rest->positions + 3 * (size_t)cloth->triangles[corner];
        const float *y =
            rest->positions + 3 * (size_t)cloth->triangles[corner - corner % 3 + (corner + 1) % 3];
        double difference[3];
        for (int k = 0; k < 3; ++k)
            difference[k] = (double)x[k] - (double)y[k];
        lengths[corner] = (float)sqrt(difference[0] * difference[0] + difference[1] * difference[1] +
                                      difference[2] * difference[2]);
    }
}

static bool take_rest(Judgement *judgement, size_t index, PercaleSceneError *error)
{
    const PercaleMesh *cloth = &judgement->cloths.meshes[index];
    const PercaleMesh *rest = &judgement->rests.meshes[index];
    if (rest->vertex_count != cloth->vertex_count) {
        (void)snprintf(error->text, sizeof error->text, "--rest: %s has %u vertices, its cloth %s has %u",
                       judgement->rests.paths[index], (unsigned)rest->vertex_count,
                       judgement->cloths.paths[index], (unsigned)cloth->vertex_count);
        return false;
    }
    float *lengths = malloc((3 * (size_t)cloth->triangle_count + 1) * sizeof *lengths);
    judgement->rest_lengths[index] = lengths;
    if (!lengths)
        return out_of_memory(error);
    measure_rest(cloth, rest, lengths);
    judgement->audit[index].rest_lengths = lengths;
    return true;
}

static bool read_meshes(const PercaleOptions *options, Judgement *judgement, PercaleSceneError *error)
{
    if (!percale_mesh_list_read(options, "--cloth", &judgement->cloths, error) ||
        !percale_mesh_list_read(options, "--rest", &judgement->rests, error) ||
        !percale_mesh_list_read(options, "--obstacle", &judgement->obstacles, error))
        return false;
    size_t cloth_count = judgement->cloths.count;
    size_t obstacle_count = judgement->obstacles.count;
    if (judgement->rests.count != 0 && judgement->rests.count != cloth_count) {
        (void)snprintf(error->text, sizeof error->text, "--rest: %zu rest meshes for %zu cloths",
                       judgement->rests.count, cloth_count);
        return false;
    }
    judgement->audit = calloc(cloth_count + obstacle_count + 1, sizeof *judgement->audit);
    judgement->rest_lengths = calloc(cloth_count + 1, sizeof(float *));
    if (!judgement->audit || !judgement->rest_lengths)
        return out_of_memory(error);
    for (size_t index = 0; index < cloth_count; ++index)
        judgement->audit[index] = audit_mesh(&judgement->cloths.meshes[index], judgement->thickness);
    for (size_t index = 0; index < obstacle_count; ++index)
        judgement->audit[cloth_count + index] =
            audit_mesh(&judgement->obstacles.meshes[index], judgement->thickness);
    for (size_t index = 0; index < judgement->rests.count; ++index)
        if (!take_rest(judgement, index, error))
            return false;
    return true;
}

/// Everything that the user can get wrong; writes nothing.
static bool prepare(const PercaleOptions *options, Judgement *judgement, PercaleSceneError *error)
{
    const PercaleOption *word = percale_options_find(options, NULL);
    if (word) {
        (void)snprintf(error->text, sizeof error->text, "audit: what is '%s'? --cloth, --rest or --obstacle",
                       word->value);
        return false;
    }
    if (!percale_options_find(options, "--cloth")) {
        (void)snprintf(error->text, sizeof error->text, "audit: --cloth is missing");
        return false;
    }
    judgement->thickness = THICKNESS_DEFAULT;
    const char *thickness = percale_options_value(options, "--thickness");
    return percale_option_number("--thickness", thickness, THICKNESS_RANGE, &judgement->thickness, error) &&
           percale_destination_file("--json", percale_options_value(options, "--json"), error) &&
           read_meshes(options, judgement, error);
}

static int judge(const Judgement *judgement, const char *json)
{
    PercaleAuditReport report = {.cloths = (uint32_t)judgement->cloths.count,
                                 .obstacles = (uint32_t)judgement->obstacles.count,
                                 .thickness = judgement->thickness};
    report.vertices = percale_mesh_list_vertices(&judgement->cloths);
    report.triangles = percale_mesh_list_triangles(&judgement->cloths);
    report.obstacle_triangles = percale_mesh_list_triangles(&judgement->obstacles);
    PercaleResult result = percale_audit(judgement->audit, report.cloths, judgement->audit + report.cloths,
                                         report.obstacles, &report.quality);
    if (result != PERCALE_OK)
        return percale_complain(PERCALE_EXIT_FAILED, "audit: %s", percale_result_string(result));
    PercaleSceneError error = {""};
    if (json && !percale_audit_report_write(&report, json, &error))
        return percale_complain(PERCALE_EXIT_FAILED, "%s", error.text);
    if (!json || strcmp(json, "-") != 0)
        percale_audit_table_print(&report);
    return PERCALE_EXIT_DONE;
}

int percale_command_audit(int argument_count, char **arguments)
{
    PercaleSceneError error = {""};
    PercaleOptions options;
    if (!percale_options_parse(argument_count, arguments, KINDS, &options, &error))
        return percale_complain(PERCALE_EXIT_USAGE, "audit: %s", error.text);
    Judgement judgement = {0};
    int code = prepare(&options, &judgement, &error)
                   ? judge(&judgement, percale_options_value(&options, "--json"))
                   : percale_complain(PERCALE_EXIT_USAGE, "%s", error.text);
    for (size_t index = 0; judgement.rest_lengths && index < judgement.cloths.count; ++index)
        free(judgement.rest_lengths[index]);
    free(judgement.rest_lengths);
    free(judgement.audit);
    percale_mesh_list_free(&judgement.cloths);
    percale_mesh_list_free(&judgement.rests);
    percale_mesh_list_free(&judgement.obstacles);
    percale_options_free(&options);
    return code;
}
