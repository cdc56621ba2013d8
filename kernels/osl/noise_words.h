// Noise that is a hash of one word per coordinate: the forms of cell and hash noise.
//
// In: words. Out: [0, 1]. A triple hashes one word more, 0, 1 and 2 for its components.
#ifndef OSLCL_OSL_NOISE_WORDS_H
#define OSLCL_OSL_NOISE_WORDS_H

#include "osl/noise.h"

static inline real noise_words_f_1(uint x) { return noise_unit(hash_1(x)); }
static inline real noise_words_f_2(uint x, uint y) { return noise_unit(hash_2(x, y)); }
static inline real noise_words_f_3(uint x, uint y, uint z) { return noise_unit(hash_3(x, y, z)); }
static inline real noise_words_f_4(uint x, uint y, uint z, uint w) { return noise_unit(hash_4(x, y, z, w)); }

static inline real3 noise_words_v_1(uint x) {
    return (real3)(noise_unit(hash_2(x, 0u)), noise_unit(hash_2(x, 1u)), noise_unit(hash_2(x, 2u)));
}

static inline real3 noise_words_v_2(uint x, uint y) {
    return (real3)(noise_unit(hash_3(x, y, 0u)), noise_unit(hash_3(x, y, 1u)), noise_unit(hash_3(x, y, 2u)));
}

static inline real3 noise_words_v_3(uint x, uint y, uint z) {
    return (real3)(noise_unit(hash_4(x, y, z, 0u)), noise_unit(hash_4(x, y, z, 1u)), noise_unit(hash_4(x, y, z, 2u)));
}

// lookup3 of five words.
static inline uint noise_words_hash_5(uint x, uint y, uint z, uint w, uint v) {
    uint a = HASH_SEED(5) + x, b = HASH_SEED(5) + y, c = HASH_SEED(5) + z;
    HASH_MIX(a, b, c);
    a += w;
    b += v;
    HASH_FINAL(a, b, c);
    return c;
}

static inline real3 noise_words_v_4(uint x, uint y, uint z, uint w) {
    return (real3)(noise_unit(noise_words_hash_5(x, y, z, w, 0u)), noise_unit(noise_words_hash_5(x, y, z, w, 1u)),
                   noise_unit(noise_words_hash_5(x, y, z, w, 2u)));
}

// osl_noise_KIND_R_* and osl_pnoise_KIND_R_* from the word of a coordinate, and of a coordinate under a period.
#define NOISE_OF_WORDS_RESULT(KIND, WORD, WRAP, R, TYPE)                                                               \
    static inline TYPE osl_noise_##KIND##_##R##_f(real x) { return noise_words_##R##_1(WORD(x)); }                     \
    static inline TYPE osl_noise_##KIND##_##R##_ff(real x, real y) { return noise_words_##R##_2(WORD(x), WORD(y)); }   \
    static inline TYPE osl_noise_##KIND##_##R##_v(real3 p) {                                                           \
        return noise_words_##R##_3(WORD(p.x), WORD(p.y), WORD(p.z));                                                   \
    }                                                                                                                  \
    static inline TYPE osl_noise_##KIND##_##R##_vf(real3 p, real t) {                                                  \
        return noise_words_##R##_4(WORD(p.x), WORD(p.y), WORD(p.z), WORD(t));                                          \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_##KIND##_##R##_ff(real x, real px) { return noise_words_##R##_1(WRAP(x, px)); }      \
    static inline TYPE osl_pnoise_##KIND##_##R##_ffff(real x, real y, real px, real py) {                              \
        return noise_words_##R##_2(WRAP(x, px), WRAP(y, py));                                                          \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_##KIND##_##R##_vv(real3 p, real3 pp) {                                               \
        return noise_words_##R##_3(WRAP(p.x, pp.x), WRAP(p.y, pp.y), WRAP(p.z, pp.z));                                 \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_##KIND##_##R##_vfvf(real3 p, real t, real3 pp, real pt) {                            \
        return noise_words_##R##_4(WRAP(p.x, pp.x), WRAP(p.y, pp.y), WRAP(p.z, pp.z), WRAP(t, pt));                    \
    }

#define NOISE_OF_WORDS(KIND, WORD, WRAP)                                                                               \
    NOISE_OF_WORDS_RESULT(KIND, WORD, WRAP, f, real)                                                                   \
    NOISE_OF_WORDS_RESULT(KIND, WORD, WRAP, v, real3)

#endif
