// The choice of one lobe among those that a material offers: a weighted reservoir of size one.
// In: lobes one after the other, and one uniform number. Out: the chosen lobe, its weight divided by the probability of
// the choice, so that the mean over the choices is the sum of all. It knows nothing of where the lobes come from.
#ifndef OSLCL_BSDF_PICK_H
#define OSLCL_BSDF_PICK_H

#include "bsdf/bsdf.h"
#include "bsdf/numeric.h"
#include "lobe.h"

// Whether a lobe of this weight counts: not 0 in all channels, and finite in each (fmax would pass over NaN). A lobe that
// does not is dropped.
static inline int lobe_counts(real3 weight)
{
    real3 size = fabs(weight);
    real sum = size.x + size.y + size.z;
    return sum > 0 && sum <= REAL_MAX;
}

// Offers a lobe. Its importance is the largest |weight| of the channels times its albedo; a lobe of importance 0 is not
// taken. The part of the random number that was not used for this decision is stretched for the next one.
static inline void lobe_offer(ShadeResult *out, LobeChoice *choice, const Lobe *lobe, real3 weight, real3 wo)
{
    if (!lobe_counts(weight)) return;
#ifdef WITHOUT_LOBES
    // A bit per type that the scene is rendered without.
    if ((WITHOUT_LOBES >> lobe->type) & 1u) return;
#endif
    real importance = max_component(fabs(weight)) * bsdf_albedo(lobe, wo);
    real total = choice->total + importance;
    if (!is_finite_positive(importance) || !(total <= REAL_MAX)) return;
#ifdef HAS_SPLIT_LOBES
    if (choice->u >= 1) {
        choice->total += 1;
        if (choice->total == choice->u) {
            out->lobe = *lobe;
            out->lobe.weight = weight;
        }
        return;
    }
#endif
    real p = importance / total;
    if (choice->total == 0 || choice->u < p) {
        out->lobe = *lobe;
        out->lobe.weight = weight;
        choice->chosen = importance;
        choice->u = choice->u / p;
    } else {
        choice->u = (choice->u - p) / (1 - p);
    }
    choice->u = clamp(choice->u, (real)0, (real)ONE_MINUS_EPSILON);
    choice->total = total;
}

// After the last offer.
static inline void lobe_finish(ShadeResult *out, const LobeChoice *choice)
{
#ifdef HAS_SPLIT_LOBES
    if (choice->u >= 1) {
        out->offered = (uint)choice->total;
        return;
    }
#endif
    if (choice->chosen > 0) out->lobe.weight *= choice->total / choice->chosen;
#ifdef HAS_SHARED_CUBES
    out->rest = choice->u;
#endif
}

#endif
