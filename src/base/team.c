#include "base/team.h"

#include "base/parallel.h"
#include "base/timer.h"
#include "percale/types.h"

#include <omp.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>

static const double MUCH_WAITING = 0.15; // share of a region's time that its leader has waited for others

enum {
    LONGEST_PAUSE = 15, // openings
    PATIENCE =
        100,      // spins before chunks are taken from a thread that is late: it has the points in its cache
    SPINS = 2000, // some microseconds: longer than a small phase, far shorter than a scheduler's slice
    CACHE_LINE = 64
};

/// A thread's share of the running phase's chunks: chunks left, counted down. On a cache line of its own.
typedef struct Share {
    _Alignas(CACHE_LINE) atomic_uint left;
} Share;

/// The running phase. Written by the thread that opens it, while nobody holds a chunk; a chunk's owner may
/// read it.
typedef struct Running {
    PercalePhase phase;
    uint32_t chunk_count;
} Running;

struct PercaleTeam {
    int size;
    Running running;
    const PercalePhase *next, *end;              // phases of the job that are not open yet
    _Alignas(CACHE_LINE) atomic_uint unfinished; // chunks of the running phase
    _Alignas(CACHE_LINE) atomic_uint turn;       // changes when a phase opens, a job ends and the team closes
    atomic_bool job_done, closed;
    double leader_waited; // s; for others, beyond the spins
    Share shares[PERCALE_MAX_THREADS];
};

static PercaleTeam ALONE = {.size = 1};

PercaleTeam *percale_team_alone(void)
{
    return &ALONE; // never written: its only thread runs every phase in place
}

int percale_team_size(const PercaleTeam *team)
{
    return team->size;
}

static uint32_t chunks_of(const PercalePhase *phase)
{
    return phase->end > phase->first ? (phase->end - phase->first - 1) / phase->grain + 1 : 0;
}

/// First chunk of a thread's share.
static uint32_t share_first(const PercaleTeam *team, uint32_t chunk_count, int thread)
{
    return (uint32_t)((uint64_t)chunk_count * (uint64_t)thread / (uint64_t)team->size);
}

// ---- chunks ----

/// Takes one chunk of a share and runs it. False when none is left.
static bool run_chunk(PercaleTeam *team, int share)
{
    atomic_uint *counter = &team->shares[share].left;
    uint32_t left = atomic_load_explicit(counter, memory_order_acquire);
    do {
        if (left == 0) {
            return false;
        }
    } while (!atomic_compare_exchange_weak_explicit(counter, &left, left - 1, memory_order_acquire,
                                                    memory_order_acquire));
    const Running *running = &team->running;
    uint32_t chunk = share_first(team, running->chunk_count, share + 1) - left;
    uint32_t first = running->phase.first + chunk * running->phase.grain;
    uint32_t rest = running->phase.end - first;
    running->phase.run(running->phase.context, first,
                       rest > running->phase.grain ? first + running->phase.grain : running->phase.end);
    return true;
}

/// Runs what is left of the own share. Returns the number of chunks.
static uint32_t run_own_chunks(PercaleTeam *team, int thread)
{
    uint32_t done = 0;
    while (run_chunk(team, thread)) {
        done++;
    }
    return done;
}

/// Runs what is left of all other shares: their owners are late. Returns the number of chunks.
static uint32_t run_other_chunks(PercaleTeam *team, int thread)
{
    uint32_t done = 0;
    for (int i = 1; i < team->size; i++) {
        while (run_chunk(team, (thread + i) % team->size)) {
            done++;
        }
    }
    return done;
}

// ---- phases ----

static void next_turn(PercaleTeam *team)
{
    atomic_fetch_add_explicit(&team->turn, 1, memory_order_release);
}

/// Runs phases of one chunk in place, up to one that is worth sharing. False when the job has no more.
static bool find_shared_phase(PercaleTeam *team)
{
    while (team->next < team->end && chunks_of(team->next) <= 1) {
        const PercalePhase *phase = team->next++;
        if (phase->end > phase->first) {
            phase->run(phase->context, phase->first, phase->end);
        }
    }
    return team->next < team->end;
}

/// Opens the job's next phase, or ends the job. For the thread that has finished the phase before.
static void open_next(PercaleTeam *team)
{
    if (!find_shared_phase(team)) {
        atomic_store_explicit(&team->job_done, true, memory_order_release);
        next_turn(team);
        return;
    }
    uint32_t chunk_count = chunks_of(team->next);
    team->running = (Running){*team->next++, chunk_count};
    atomic_store_explicit(&team->unfinished, chunk_count, memory_order_relaxed);
    for (int t = 0; t < team->size; t++) {
        uint32_t left = share_first(team, chunk_count, t + 1) - share_first(team, chunk_count, t);
        atomic_store_explicit(&team->shares[t].left, left, memory_order_release);
    }
    next_turn(team);
}

/// Spins until the turn is another one; false when that takes too long.
static bool spin_turn(PercaleTeam *team, uint32_t turn, int spins)
{
    for (int spin = 0; spin < spins; spin++) {
        if (atomic_load_explicit(&team->turn, memory_order_acquire) != turn) {
            return true;
        }
#if defined(__SSE2__)
        __builtin_ia32_pause();
#endif
    }
    return false;
}

/// Waits until the turn is another one. Returns how long it took beyond the spins, s.
static double wait_turn(PercaleTeam *team, uint32_t turn)
{
    if (spin_turn(team, turn, SPINS)) {
        return 0.0;
    }
    double since = percale_seconds();
    while (atomic_load_explicit(&team->turn, memory_order_acquire) == turn) {
        sched_yield();
    }
    return percale_seconds() - since;
}

static void finish_chunks(PercaleTeam *team, uint32_t done)
{
    if (atomic_fetch_sub_explicit(&team->unfinished, done, memory_order_acq_rel) == done) {
        open_next(team);
    }
}

/// Runs chunks as they come, until `stop` is set. Returns how long it has waited beyond the spins, s.
static double work_until(PercaleTeam *team, int thread, const atomic_bool *stop)
{
    double waited = 0.0;
    while (!atomic_load_explicit(stop, memory_order_acquire)) {
        uint32_t turn = atomic_load_explicit(&team->turn, memory_order_acquire);
        uint32_t done = run_own_chunks(team, thread);
        if (done > 0) {
            finish_chunks(team, done);
        } else if (!spin_turn(team, turn, PATIENCE)) {
            done = run_other_chunks(team, thread);
            if (done > 0) {
                finish_chunks(team, done);
            } else if (!atomic_load_explicit(stop, memory_order_acquire)) {
                waited += wait_turn(team, turn);
            }
        }
    }
    return waited;
}

// ---- jobs ----

void percale_team_run(PercaleTeam *team, const PercalePhase *phases, size_t phase_count)
{
    if (team->size == 1) {
        for (size_t i = 0; i < phase_count; i++) {
            if (phases[i].end > phases[i].first) {
                phases[i].run(phases[i].context, phases[i].first, phases[i].end);
            }
        }
        return;
    }
    team->next = phases;
    team->end = phases + phase_count;
    atomic_store_explicit(&team->job_done, false, memory_order_relaxed);
    open_next(team);
    team->leader_waited += work_until(team, 0, &team->job_done);
}

void percale_team_for(PercaleTeam *team, uint32_t count, uint32_t grain, PercaleRange *run, void *context)
{
    PercalePhase phase = {run, context, 0, count, grain};
    percale_team_run(team, &phase, 1);
}

static void open_region(int thread_count, PercaleTeam *team, PercaleLead *lead, void *context)
{
    double opened = percale_seconds();
    double led = 0.0;
#pragma omp parallel default(none) shared(team, lead, context, opened, led) num_threads(thread_count)
    {
        uint32_t mode = float_mode_enter();
        int thread = omp_get_thread_num();
        if (thread == 0) {
            team->leader_waited = percale_seconds() - opened;
            team->size = omp_get_num_threads();
            next_turn(team); // the others may come as late as they like
            lead(team, context);
            led = percale_seconds();
            atomic_store_explicit(&team->closed, true, memory_order_release);
            next_turn(team);
        } else {
            (void)wait_turn(team, 0);
            (void)work_until(team, thread, &team->closed);
        }
        float_mode_leave(mode);
    }
    team->leader_waited += percale_seconds() - led;
}

void percale_team_open(int thread_count, PercaleCrowding *crowding, PercaleLead *lead, void *context)
{
    PercaleTeam team = {.size = 1};
    if (thread_count == 1 || crowding->alone > 0) {
        crowding->alone -= crowding->alone > 0;
        open_region(1, &team, lead, context);
        return;
    }
    double began = percale_seconds();
    open_region(thread_count, &team, lead, context);
    if (team.leader_waited > MUCH_WAITING * (percale_seconds() - began)) {
        crowding->pause = crowding->pause < LONGEST_PAUSE ? 2 * crowding->pause + 1 : LONGEST_PAUSE;
        crowding->alone = crowding->pause;
    } else {
        crowding->pause = 0;
    }
}
