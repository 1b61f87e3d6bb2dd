#include "solve/coarse_sweep.h"

enum {
    GRAIN_POINTS = 1024,
    GRAIN_LINKS = 256 // per chunk
};

/// A level in a sweep.
typedef struct Level {
    const PercaleCoarseLevel *level;
    const struct Level *above; // NULL: the coarsest
    const PercaleBatches *links;
    f32x4 *x;     // predicted points of the cloth
    f32x4 *nodes; // [node_count] where they are, and inverse masses; at the end how far they have moved
} Level;

/// What a follower takes over of its leaders' moves.
static inline f32x4 followed(const Level *level, uint32_t follower)
{
    const uint32_t *leaders = level->level->leaders[follower];
    const f32x4 *moves = level->nodes;
    f32x4 shares = level->level->shares[follower];
    f32x4 near = shares[0] * moves[leaders[0]] + shares[1] * moves[leaders[1]];
    return near + (shares[2] * moves[leaders[2]] + shares[3] * moves[leaders[3]]);
}

static void place_nodes(void *context, uint32_t first, uint32_t end)
{
    const Level *level = context;
    for (uint32_t node = first; node < end; node++) {
        f32x4 x = level->x[level->level->slots[node]];
        float inverse_mass = level->level->inverse_masses[node];
        if (level->above != NULL && inverse_mass > 0.0f) {
            x += followed(level->above, node);
        }
        level->nodes[node] = with_w(x, inverse_mass);
    }
}

static void pull_links(void *context, uint32_t first, uint32_t end)
{
    const Level *level = context;
    for (uint32_t i = first; i < end; i++) {
        const uint32_t *link = level->level->links[i];
        f32x4 *a = (f32x4 *)(void *)((char *)level->nodes + link[0]);
        f32x4 *b = (f32x4 *)(void *)((char *)level->nodes + link[1]);
        f32x4 d = *b - *a;
        float limit = level->level->link_lengths[i];
        float length2 = dot3(d, d);
        if (length2 > limit * limit) {
            float length = sqrtf(length2);
            float pull = (length - limit) / (length * ((*a)[3] + (*b)[3])); // two pins have no link
            *a = with_w(*a + d * ((*a)[3] * pull), (*a)[3]);
            *b = with_w(*b - d * ((*b)[3] * pull), (*b)[3]);
        }
    }
}

/// Whole runs, one after the other.
static void pull_runs(void *context, uint32_t first, uint32_t end)
{
    const Level *level = context;
    for (uint32_t run = first; run < end; run++) {
        pull_links(context, level->links->run_first[run], level->links->run_first[run + 1]);
    }
}

static void find_moves(void *context, uint32_t first, uint32_t end)
{
    const Level *level = context;
    for (uint32_t node = first; node < end; node++) {
        level->nodes[node] -= level->x[level->level->slots[node]];
    }
}

static void move_vertices(void *context, uint32_t first, uint32_t end)
{
    const Level *level = context;
    for (uint32_t slot = first; slot < end; slot++) {
        f32x4 x = level->x[slot];
        if (x[3] > 0.0f) {
            level->x[slot] = with_w(x + followed(level, slot), x[3]);
        }
    }
}

/// Runs of some length one by one, short ones in a row as one chunk.
static size_t add_runs(PercalePhase *phases, Level *level)
{
    const PercaleBatches *links = level->links;
    size_t count = 0;
    for (uint32_t run = 0; run < links->run_count;) {
        uint32_t end = run;
        while (end < links->run_count && links->run_first[end + 1] - links->run_first[end] <= GRAIN_LINKS) {
            end++;
        }
        if (end > run) {
            phases[count++] = (PercalePhase){pull_runs, level, run, end, end - run};
            run = end;
        } else {
            phases[count++] = (PercalePhase){pull_links, level, links->run_first[run],
                                             links->run_first[run + 1], GRAIN_LINKS};
            run++;
        }
    }
    return count;
}

bool percale_coarse_sweep(const PercaleCoarse *coarse, const PercaleBatches *links, f32x4 *x,
                          PercaleTeam *team, PercaleArena *arena)
{
    Level levels[COARSE_LEVELS_MAX];
    size_t most = 1;
    for (uint32_t i = 0; i < coarse->level_count; i++) {
        most += 2 + links[i].run_count;
    }
    PercalePhase *phases = percale_arena_new(arena, most, sizeof(phases[0]));
    size_t count = 0;
    if (phases == NULL) {
        return false;
    }
    for (uint32_t i = coarse->level_count; i-- > 0;) {
        Level *above = i + 1 < coarse->level_count ? &levels[i + 1] : NULL;
        uint32_t node_count = coarse->levels[i].node_count;
        levels[i] = (Level){&coarse->levels[i], above, &links[i], x,
                            percale_arena_new(arena, node_count, sizeof(f32x4))};
        if (levels[i].nodes == NULL) {
            return false;
        }
        phases[count++] = (PercalePhase){place_nodes, &levels[i], 0, node_count, GRAIN_POINTS};
        count += add_runs(phases + count, &levels[i]);
        phases[count++] = (PercalePhase){find_moves, &levels[i], 0, node_count, GRAIN_POINTS};
    }
    phases[count++] =
        (PercalePhase){move_vertices, &levels[0], 0, coarse->levels[0].follower_count, GRAIN_POINTS};
    percale_team_run(team, phases, count);
    return true;
}
