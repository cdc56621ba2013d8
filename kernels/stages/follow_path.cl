// In the place of select_bsdf and what comes behind it, where no light's shader has to be asked (ADR 0024): one program per material, its
// generated code in front, that takes paths on while they meet the same material.
// In: the material's queue. Out: another material's, QUEUE_environment or, behind the last turn, QUEUE_trace and QUEUE_done.
#include "stages/follow.h"
#include "stages/select_bsdf.h"
#ifdef QUEUE_scatter
#include "stages/sample_light.h"
#include "stages/sample_next.h"
#include "stages/trace_shadow.h"
#endif

// Most surfaces that a launch takes a path to: on CPUs so many that the host keeps hearing how far it is, on GPUs so few that lanes don't
// wait for each other for long.
#ifdef OSLCL_CPU
#define FOLLOW_TURNS 32
#else
#define FOLLOW_TURNS 2
#endif

// A surface, a light and the next direction.
static inline int follow_scatter(const Context *c, uint slot, Followed *f)
{
    int queue = stage_select_bsdf(c, slot);
#ifdef QUEUE_scatter
    if (queue != QUEUE_scatter) return queue;
    between_stages();
    if (stage_sample_light(c, slot) == QUEUE_shadow) {
        between_stages();
        stage_trace_shadow(c, slot);
        f->shadow_rays++;
    }
    between_stages();
    queue = stage_sample_next(c, slot);
#endif
    return queue;
}

LOBE_KERNEL void follow_path(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    __local uint counts[FOLLOW_COUNTS];
    follow_begin(counts);
    barrier(CLK_LOCAL_MEM_FENCE);
    const int own = QUEUE_MATERIALS + (int)launch;
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, own, &slot)) {
        Followed f;
        f.rays = f.shadow_rays = f.samples = 0;
        for (uint turn = 1;; turn++) {
            queue = follow_scatter(&c, slot, &f);
            if (turn == FOLLOW_TURNS) break;
            queue = follow_to_surface(&c, slot, queue, &f);
            if (queue != own) break;
            between_stages();
        }
        follow_count(counts, &f);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    follow_end(&c, counts);
    QUEUE_PUSH(&c, queue, slot);
}
