// Sums and random numbers, one kernel per question.
#include "compensated.h"
#include "context.h"
#include "random.h"

// Adds `count` samples to compensated sums, and to a plain one: their values are those of random4.x scaled to 0..high, with a bright
// one now and then. out: the sum, what it lost, the plain sum, three reals an item. exact: the sum of the integers behind the samples.
__kernel void add_samples(uint count, uint seed, __global real *out, __global ulong *exact)
{
    const uint i = (uint)get_global_id(0);
    real4 sum = (real4)(0), lost = (real4)(0);
    real plain = 0;
    ulong all = 0;
    for (uint k = 0; k < count; k++) {
        // 12 bits: exact in both precisions.
        uint bits = random_bits(i, k, 0, seed).x >> 20;
        if (bits % 1024 == 0) bits *= 1000;
        all += bits;
        const real sample = (real)bits * (real)(1.0 / 4096);
        add_compensated(&sum, &lost, (real4)(sample));
        plain += sample;
    }
    out[3 * i] = sum.y;
    out[3 * i + 1] = lost.y;
    out[3 * i + 2] = plain;
    exact[i] = all;
}

// A 64-bit counter that grows by n, `times` times.
__kernel void count_far(uint n, uint times, volatile __global uint *words)
{
    Context c;
    c.counters = words;
    for (uint k = 0; k < times; k++) add_to_count(&c, 0, n);
}

// random4 of this work-item's samples: out: how many numbers were not in [0,1); the largest and the least number; and their mean.
__kernel void random_range(uint first, uint turns, uint seed, volatile __global uint *out, __global real *least_most_mean)
{
    const uint i = (uint)get_global_id(0);
    real least = 2, most = -1, sum = 0;
    for (uint k = 0; k < turns; k++) {
        // Counters up to their last value, in each of the four places.
        const uint x = first + i * turns + k;
        const real4 u = k % 4 == 0 ? random4(x, 0, 0, seed) : k % 4 == 1 ? random4(0, x, 0, seed)
                      : k % 4 == 2 ? random4(0xffffffffu, 0xffffffffu, x, seed) : random4(0, 0xffffffffu - x, 0, 0xffffffffu);
        if (!(all(u >= (real4)(0)) && all(u < (real4)(1)))) atomic_inc(out);
        least = fmin(least, fmin(fmin(u.x, u.y), fmin(u.z, u.w)));
        most = fmax(most, fmax(fmax(u.x, u.y), fmax(u.z, u.w)));
        sum += (u.x + u.y + u.z + u.w) * (real)0.25;
    }
    least_most_mean[3 * i] = least;
    least_most_mean[3 * i + 1] = most;
    least_most_mean[3 * i + 2] = sum / turns;
}

// What random4 makes of given bits: of every value of the bits that it keeps.
__kernel void random_edges(volatile __global uint *out)
{
    const uint bits = (uint)get_global_id(0) << 8 | 255u;
    const real4 u = random_reals((uint4)(bits));
    if (!(u.x >= 0 && u.x < 1)) atomic_inc(out);
    if (u.x * (real)16777216 != (real)(bits >> 8)) atomic_inc(out + 1);
}
