// Numbers the welded points of all cloths. Cloths without weld numbers are sewn to nothing, so each of their
// vertices is a point of its own.

#include "audit/audit.h"
#include "audit/audit_pairs.h"

#define HALF_BITS 16 // a weld number may be any 32-bit number, so it is sorted as two halves

static size_t list_welds(const PercaleAuditScene *scene, PercaleAuditPair *welds)
{
    size_t count = 0;
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        const PercaleAuditMesh *mesh = &scene->cloths[cloth];
        for (uint32_t vertex = 0; mesh->weld && vertex < mesh->vertex_count; vertex++) {
            uint32_t weld = mesh->weld[vertex];
            welds[count].first = weld >> HALF_BITS;
            welds[count].second = weld & ((1U << HALF_BITS) - 1U);
            welds[count++].item = (uint32_t)(scene->first_vertex[cloth] + vertex);
        }
    }
    return count;
}

static void number_welds(PercaleAuditScene *scene, const PercaleAuditPair *welds, size_t count)
{
    size_t end = 0;
    for (size_t begin = 0; begin < count; begin = end) {
        end = percale_audit_run_end(welds, count, begin);
        for (size_t i = begin; i < end; i++)
            scene->points[welds[i].item] = (uint32_t)scene->point_count;
        scene->is_sewn[scene->point_count++] = end - begin > 1;
    }
}

bool percale_audit_weld(PercaleAuditScene *scene)
{
    size_t vertex_count = scene->first_vertex[scene->cloth_count];
    scene->points = percale_audit_allocate(&scene->memory, vertex_count, sizeof *scene->points);
    scene->is_sewn = percale_audit_allocate(&scene->memory, vertex_count, sizeof *scene->is_sewn);
    PercaleAuditPair *welds = percale_audit_allocate(&scene->memory, vertex_count, sizeof *welds);
    bool has_memory = scene->points && scene->is_sewn && welds;
    if (has_memory) {
        size_t count = list_welds(scene, welds);
        has_memory = percale_audit_sort_pairs(&scene->memory, welds, count, (size_t)1 << HALF_BITS);
        if (has_memory)
            number_welds(scene, welds, count);
    }
    percale_audit_release(&scene->memory, welds);
    for (uint32_t cloth = 0; has_memory && cloth < scene->cloth_count; cloth++) {
        size_t first = scene->first_vertex[cloth];
        for (size_t i = 0; !scene->cloths[cloth].weld && i < scene->cloths[cloth].vertex_count; i++)
            scene->points[first + i] = (uint32_t)scene->point_count++;
    }
    return has_memory;
}
