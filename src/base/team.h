// team.h: the threads of one parallel region and the phases that they run.
//
// A step opens one region. The thread that called is the leader: it runs the step's serial code and posts
// jobs, which are lists of phases; the others wait for them. A phase is a range of items, cut into chunks
// that don't depend on each other; the next phase begins when every chunk of this one is done:
//
//     phase -> chunk -> range
//
// Each thread has its own contiguous share of the chunks, so that from phase to phase it finds the same
// points in its cache; when its own are done and a moment later others are left, it takes those. So nobody
// waits for a thread that is not running, unless that thread holds a chunk; waiting is a short spin and then
// yields. libgomp's own barrier spins away whole scheduler slices when another process is busy on the
// machine.
//
// Which thread runs a chunk must not matter: the ranges, not the team, decide what is computed.

#ifndef PERCALE_TEAM_H
#define PERCALE_TEAM_H

#include <stddef.h>
#include <stdint.h>

typedef struct PercaleTeam PercaleTeam;

/// Works on the items [first, end).
typedef void PercaleRange(void *context, uint32_t first, uint32_t end);

typedef struct PercalePhase {
    PercaleRange *run;
    void *context; // what the items are; may be shared by all chunks
    uint32_t first, end;
    uint32_t grain; // items per chunk; a multiple of it begins each chunk
} PercalePhase;

/// What the leader does with its team.
typedef void PercaleLead(PercaleTeam *team, void *context);

/// Remembers from one region to the next whether there was room for a team. When the leader has waited long
/// for threads that got no processor, it works alone for a while, then tries again. Starts zeroed.
typedef struct PercaleCrowding {
    uint32_t alone; // openings still to be done alone
    uint32_t pause; // how many it was last time
} PercaleCrowding;

/// Opens a region of at most thread_count threads (fewer when the host's OpenMP grants fewer, or when it is
/// crowded) and runs `lead` on the calling one. Every thread flushes denormals inside.
void percale_team_open(int thread_count, PercaleCrowding *crowding, PercaleLead *lead, void *context);

/// Threads of the team, the leader included.
int percale_team_size(const PercaleTeam *team);

/// Runs the phases one after the other; for the leader only. Phases of one chunk cost no more than a call.
void percale_team_run(PercaleTeam *team, const PercalePhase *phases, size_t phase_count);

/// One phase over `count` items.
void percale_team_for(PercaleTeam *team, uint32_t count, uint32_t grain, PercaleRange *run, void *context);

/// A team of the calling thread alone: for what is done outside of a step.
PercaleTeam *percale_team_alone(void);

#endif
