// What the stages share: buffers, path state, queues. The plan writes layout.h: the list of buffers (STAGE_ARGS, Context,
// STAGE_CONTEXT), the fields of path state (PATH_*, PATHU_*), queues (QUEUE_*), settings (SETTING_*), constants (CONSTANT_*)
// and counters (COUNTER_*), each only if the scene calls for it.
//
// In, out: global memory. Slots are paths in flight; a slot belongs to one pixel, so each value has one writer.
#ifndef OSLCL_CONTEXT_H
#define OSLCL_CONTEXT_H

#include "real.h"
#include "layout.h"

#define QUEUE_NONE (-1)

static inline uint setting(const Context *c, uint which) { return c->settings[which]; }
static inline real constant_real(const Context *c, uint which) { return c->constants[which]; }
static inline real3 constant_real3(const Context *c, uint which) { return vload3(0, c->constants + which); }

// ---- Path state: a record per slot (ADR 0022) -----------------------------------------------------------------------

// PATH_* and PATHU_* are places in the records of reals and of uints. Triples of reals lie at multiples of four, so that each is
// read and written at once. Some fields may be of 16 bits, behind the reals of the same record: their places have the bit FIELD_HALF and
// count halves, so that what a name stands for is known when the kernel is built; triples of them lie at multiples of four as well.
static inline __global real *path_real(const Context *c, uint field, uint slot)
{
    return c->path + (size_t)slot * REALS_PER_PATH + field;
}
#ifdef FIELD_HALF
static inline __global half *path_half(const Context *c, uint field, uint slot)
{
    return (__global half *)path_real(c, HALVES_FIRST, slot) + (field & ~FIELD_HALF);
}
static inline float path_clamp(const Context *c, real v)
{
    // What is no number stays none, for `accumulate` to count.
    if (fabs(v) > 65504) {
        v = copysign((real)65504, v);
        atomic_inc(&c->counters[COUNTER_clamped]);
    }
    return (float)v;
}
#endif
static inline real path_get(const Context *c, uint field, uint slot)
{
#ifdef FIELD_HALF
    if (field & FIELD_HALF) return vload_half(0, path_half(c, field, slot));
#endif
    return *path_real(c, field, slot);
}
static inline void path_set(const Context *c, uint field, uint slot, real v)
{
#ifdef FIELD_HALF
    if (field & FIELD_HALF) {
        vstore_half_rte(path_clamp(c, v), 0, path_half(c, field, slot));
        return;
    }
#endif
    *path_real(c, field, slot) = v;
}
static inline real3 path_get3(const Context *c, uint field, uint slot)
{
#ifdef FIELD_HALF
    if (field & FIELD_HALF) {
        const float4 v = vloada_half4(0, path_half(c, field, slot));
        return (real3)(v.x, v.y, v.z);
    }
#endif
    return ((__global real4 *)path_real(c, field, slot))->xyz;
}
static inline void path_set3(const Context *c, uint field, uint slot, real3 v)
{
#ifdef FIELD_HALF
    if (field & FIELD_HALF) {
        const float4 narrow = (float4)(path_clamp(c, v.x), path_clamp(c, v.y), path_clamp(c, v.z), 0);
        vstorea_half4_rte(narrow, 0, path_half(c, field, slot));
        return;
    }
#endif
    *(__global real4 *)path_real(c, field, slot) = (real4)(v, 0);
}
static inline uint path_get_uint(const Context *c, uint field, uint slot)
{
    return c->path_uint[(size_t)slot * UINTS_PER_PATH + field];
}
static inline void path_set_uint(const Context *c, uint field, uint slot, uint v)
{
    c->path_uint[(size_t)slot * UINTS_PER_PATH + field] = v;
}

// The pixel of a slot: its number in the picture, row by row.
static inline uint path_pixel(const Context *c, uint slot)
{
    const uint place = setting(c, SETTING_pixel_first) + slot / setting(c, SETTING_slots_per_pixel);
#ifdef HAS_ADAPTIVE
    // Those that go on.
    return c->pixels[place];
#else
    return place;
#endif
}

#ifdef PATHU_turn
// Where paths split, a slot follows the lobes of a sample's first hit one after the other, in turns: which, and of how many.
static inline uint path_turn(const Context *c, uint slot) { return path_get_uint(c, PATHU_turn, slot) & 0xffffu; }
static inline uint path_turns(const Context *c, uint slot) { return path_get_uint(c, PATHU_turn, slot) >> 16; }
static inline void path_set_turn(const Context *c, uint slot, uint turn, uint turns)
{
    path_set_uint(c, PATHU_turn, slot, turn | turns << 16);
}
#endif

// Between stages that one kernel runs for a slot: what was stored is read back as it was rounded. NVIDIA's compiler (580) rounds
// otherwise without it, by units in the last place. CPUs' compilers don't, and PoCL 3.1 has no such function on the SPIR-V road.
static inline void between_stages(void)
{
#ifndef OSLCL_CPU
    mem_fence(CLK_GLOBAL_MEM_FENCE);
#endif
}

// ---- Queues --------------------------------------------------------------------------------------------------------

// This work-item's place in a queue. Drivers for CPUs hand each core a run of groups, and only the first groups of a launch find
// something in a short queue: there neighbours take groups of the queue that are a stripe apart.
static inline uint queue_place(const Context *c)
{
    const uint bits = setting(c, SETTING_stripe_bits), group = get_group_id(0);
    const uint stripe = group & ((1u << bits) - 1);
    return (stripe * ((uint)get_num_groups(0) >> bits) + (group >> bits)) * (uint)get_local_size(0) + (uint)get_local_id(0);
}

// The slot at this work-item's place in a queue; 0 when the queue is shorter.
static inline int queue_slot(const Context *c, uint queue, uint *slot)
{
    const uint i = queue_place(c);
    if (i >= c->counters[queue]) return 0;
    *slot = c->queues[(size_t)queue * setting(c, SETTING_paths) + i];
    return 1;
}

static inline void queue_store(const Context *c, int queue, uint at, uint slot)
{
    const uint paths = setting(c, SETTING_paths);
    if (at < paths) c->queues[(size_t)queue * paths + at] = slot;
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

// Adds to a 64-bit count in two words, whoever else does.
static inline void add_to_count(const Context *c, uint counter, uint n)
{
    const uint before = atomic_add(&c->counters[counter], n);
    if (before + n < before) atomic_inc(&c->counters[counter + 1]);
}

#endif
