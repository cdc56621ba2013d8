// What the stages share: buffers, path state, queues. The plan writes layout.h: the list of buffers (STAGE_ARGS, Context,
// STAGE_CONTEXT), the planes of path state (PATH_*, PATHU_*), queues (QUEUE_*), settings (SETTING_*), constants (CONSTANT_*)
// and counters (COUNTER_*), each only if the scene calls for it.
//
// In, out: global memory. Slots are paths in flight; a slot belongs to one pixel, so each value has one writer.
#ifndef OSLCL_CONTEXT_H
#define OSLCL_CONTEXT_H

#include "real.h"
#include "layout.h"

// Kernels that sample or evaluate lobes. Intel's compiler for CPUs spoils other lanes of its vectors where Beckmann's distribution
// stands in a branch (seen with 2026.22: values of 1e30 that differ from run to run): there they run lane by lane.
#ifdef OSLCL_LANE_BY_LANE
#define LOBE_KERNEL __attribute__((intel_vec_len_hint(1))) __kernel
#else
#define LOBE_KERNEL __kernel
#endif

#define QUEUE_NONE (-1)

// Bit of a launch's argument: this launch empties the queues that the stages before it have read.
#define LAUNCH_CLEARS 0x80000000u
#define LAUNCH_INDEX(launch) ((launch) & 0x7fffffffu)

static inline uint setting(const Context *c, uint which) { return c->settings[which]; }
static inline real constant_real(const Context *c, uint which) { return c->constants[which]; }
static inline real3 constant_real3(const Context *c, uint which) { return vload3(0, c->constants + which); }

// ---- Path state: planes of one number per slot ---------------------------------------------------------------------

static inline size_t path_at(const Context *c, uint plane, uint slot) { return (size_t)plane * PATHS + slot; }
// Some planes may be of 16 bits: the names of these have the bit PLANE_HALF, so that what a name stands for is known when the
// kernel is built.
static inline real path_get(const Context *c, uint plane, uint slot)
{
#ifdef PLANE_HALF
    if (plane & PLANE_HALF) return vload_half(path_at(c, plane & ~PLANE_HALF, slot), c->path_half);
#endif
    return c->path[path_at(c, plane, slot)];
}
static inline void path_set(const Context *c, uint plane, uint slot, real v)
{
#ifdef PLANE_HALF
    if (plane & PLANE_HALF) {
        // What is no number stays none, for `accumulate` to count.
        if (fabs(v) > 65504) {
            v = copysign((real)65504, v);
            atomic_inc(&c->counters[COUNTER_clamped]);
        }
        vstore_half_rte((float)v, path_at(c, plane & ~PLANE_HALF, slot), c->path_half);
        return;
    }
#endif
    c->path[path_at(c, plane, slot)] = v;
}
static inline real3 path_get3(const Context *c, uint plane, uint slot)
{
    return (real3)(path_get(c, plane, slot), path_get(c, plane + 1, slot), path_get(c, plane + 2, slot));
}
static inline void path_set3(const Context *c, uint plane, uint slot, real3 v)
{
    path_set(c, plane, slot, v.x);
    path_set(c, plane + 1, slot, v.y);
    path_set(c, plane + 2, slot, v.z);
}
static inline uint path_get_uint(const Context *c, uint plane, uint slot) { return c->path_uint[path_at(c, plane, slot)]; }
static inline void path_set_uint(const Context *c, uint plane, uint slot, uint v)
{
    c->path_uint[path_at(c, plane, slot)] = v;
}

// The pixel of a slot: its number in the picture, row by row.
static inline uint path_pixel(const Context *c, uint slot)
{
    return setting(c, SETTING_pixel_first) + slot / setting(c, SETTING_slots_per_pixel);
}

// ---- Queues --------------------------------------------------------------------------------------------------------

// The slot at this work-item's place in a queue; 0 when the queue is shorter.
static inline int queue_slot(const Context *c, uint queue, uint *slot)
{
    uint i = get_global_id(0);
    if (i >= c->counters[queue]) return 0;
    *slot = c->queues[(size_t)queue * PATHS + i];
    return 1;
}

static inline void queue_store(const Context *c, int queue, uint at, uint slot)
{
    if (at < PATHS) c->queues[(size_t)queue * PATHS + at] = slot;
    else atomic_inc(&c->counters[COUNTER_dropped]);
}

// QUEUE_PUSH(c, queue, slot): every work-item of the group calls it once, at the end of its kernel, with a queue or QUEUE_NONE.
// No kernel may return before it, not even a whole group: PoCL 3.1 builds code that crashes.
// Counts in local memory, then one global atomic per queue and group: on a CPU of two cores, too, an atomic per path takes half
// of the time of a short stage.
#define QUEUE_PUSH(c, queue, slot)                                                                                     \
    __local uint push_count[QUEUE_COUNT];                                                                              \
    __local uint push_base[QUEUE_COUNT];                                                                               \
    for (uint q = get_local_id(0); q < QUEUE_COUNT; q += get_local_size(0)) push_count[q] = 0;                         \
    barrier(CLK_LOCAL_MEM_FENCE);                                                                                      \
    uint push_rank = (queue) >= 0 ? atomic_inc(&push_count[queue]) : 0;                                                \
    barrier(CLK_LOCAL_MEM_FENCE);                                                                                      \
    for (uint q = get_local_id(0); q < QUEUE_COUNT; q += get_local_size(0))                                            \
        if (push_count[q] > 0) push_base[q] = atomic_add(&(c)->counters[q], push_count[q]);                            \
    barrier(CLK_LOCAL_MEM_FENCE);                                                                                      \
    if ((queue) >= 0) queue_store(c, queue, push_base[queue] + push_rank, slot);

// A 64-bit count in two words; only one work-item of a launch adds to it.
static inline void count_add(const Context *c, uint counter, uint n)
{
    uint low = c->counters[counter];
    c->counters[counter] = low + n;
    if (low + n < low) c->counters[counter + 1] += 1;
}

#endif
