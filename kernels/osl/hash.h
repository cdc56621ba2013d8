// OSL's integer hash of numbers (specification ch. 7.6, `hash`); cell and hash noise and Perlin's lattice use it too.
//
// In: 32-bit words: integers, or the bits of 32-bit floats (in f64 the argument is rounded to float first, so that both
// precisions hash alike). Out: 32 bits. The hash is Bob Jenkins' lookup3 (2006, public domain) of one to five words.
#ifndef OSLCL_OSL_HASH_H
#define OSLCL_OSL_HASH_H

#include "real.h"

#define HASH_ROTATE(x, k) (((x) << (k)) | ((x) >> (32 - (k))))

// Statements on three uint or uint-vector variables.
#define HASH_MIX(a, b, c)                                                                                              \
    a -= c, a ^= HASH_ROTATE(c, 4), c += b;                                                                            \
    b -= a, b ^= HASH_ROTATE(a, 6), a += c;                                                                            \
    c -= b, c ^= HASH_ROTATE(b, 8), b += a;                                                                            \
    a -= c, a ^= HASH_ROTATE(c, 16), c += b;                                                                           \
    b -= a, b ^= HASH_ROTATE(a, 19), a += c;                                                                           \
    c -= b, c ^= HASH_ROTATE(b, 4), b += a
#define HASH_FINAL(a, b, c)                                                                                            \
    c ^= b, c -= HASH_ROTATE(b, 14);                                                                                   \
    a ^= c, a -= HASH_ROTATE(c, 11);                                                                                   \
    b ^= a, b -= HASH_ROTATE(a, 25);                                                                                   \
    c ^= b, c -= HASH_ROTATE(b, 16);                                                                                   \
    a ^= c, a -= HASH_ROTATE(c, 4);                                                                                    \
    b ^= a, b -= HASH_ROTATE(a, 14);                                                                                   \
    c ^= b, c -= HASH_ROTATE(b, 24)

// Start value for n words.
#define HASH_SEED(n) (0xdeadbeefu + 4u * (n) + 13u)

static inline uint hash_1(uint x) {
    uint a = HASH_SEED(1) + x, b = HASH_SEED(1), c = HASH_SEED(1);
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint hash_2(uint x, uint y) {
    uint a = HASH_SEED(2) + x, b = HASH_SEED(2) + y, c = HASH_SEED(2);
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint hash_3(uint x, uint y, uint z) {
    uint a = HASH_SEED(3) + x, b = HASH_SEED(3) + y, c = HASH_SEED(3) + z;
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint hash_4(uint x, uint y, uint z, uint w) {
    uint a = HASH_SEED(4) + x, b = HASH_SEED(4) + y, c = HASH_SEED(4) + z;
    HASH_MIX(a, b, c);
    a += w;
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint hash_bits(real x) { return as_uint((float)x); }

static inline int osl_hash_value_i_i(int x) { return (int)hash_1((uint)x); }
static inline int osl_hash_value_i_f(real x) { return (int)hash_1(hash_bits(x)); }
static inline int osl_hash_value_i_ff(real x, real y) { return (int)hash_2(hash_bits(x), hash_bits(y)); }

static inline int osl_hash_value_i_v(real3 p) {
    return (int)hash_3(hash_bits(p.x), hash_bits(p.y), hash_bits(p.z));
}

static inline int osl_hash_value_i_vf(real3 p, real t) {
    return (int)hash_4(hash_bits(p.x), hash_bits(p.y), hash_bits(p.z), hash_bits(t));
}

#endif
