// Elementary functions of `precision = fast`: shorter polynomials and fewer special cases than maths.h has, whose names and reductions
// they share. Arguments that are no numbers, and infinite ones, give anything: relaxed arithmetic takes it that there are none.
//
// Largest error (tests/tests/maths.rs holds it; docs/accuracy.md):
//   sin cos 1.3e-6 . tan 3e-6 of 1 + tan^2 . atan 3e-6 . atan2 3.5e-6 . exp exp2 3.5e-6 + 1.2e-7 |log2 of the result| of the result
//   log log2 log10 3e-7 + 1.5e-6 of the result . powr(x, y) 4e-6 + 3e-7 |y| + 1.5e-6 |log2 of the result| of the result
// NVIDIA's devices have 2^x and log2 in hardware, with errors of 2 ulp and of 2^-22 (CUDA C++ Programming Guide, "Mathematical
// Functions"): there they are taken.
#ifndef OSLCL_MATHS_FAST_H
#define OSLCL_MATHS_FAST_H

// The nearest whole number, |x| < 2^22. By the bits of a sum that has no room for fractions: PoCL 3.1 builds rint from branches, and
// what is added and taken away again relaxed arithmetic leaves out.
static inline float m_nearest(float x, int *n) {
    *n = as_int(x + 12582912.0) - 0x4b400000;
    return (float)*n;
}

// ---- Trigonometry ---------------------------------------------------------------------------------------------------

// x = quadrant * pi/2 + result, |result| <= pi/4; pi/2 in two parts.
static inline float m_reduce(float x, int *quadrant) {
    if (!(fabs(x) < 1e5)) return m_reduce_large(x, quadrant);
    float n = m_nearest(x * 0.636619772, quadrant);
    return fma(-n, -4.371138829e-08, fma(-n, 1.570796371, x));
}

// Sine and cosine of |r| <= pi/4, then turned by quadrants.
static inline void m_sincos_reduced(float r, int quadrant, float *s, float *c) {
    float z = r * r;
    float ps = fma(r * z, fma(z, 8.152956143e-03, -1.666283160e-01), r);
    float pc = fma(z * z, fma(z, -1.365240314e-03, 4.166127741e-02), fma(z, -0.5, 1.0));
    float a = quadrant & 1 ? pc : ps;
    float b = quadrant & 1 ? ps : pc;
    *s = as_float(as_int(a) ^ ((quadrant & 2) << 30));
    *c = as_float(as_int(b) ^ (((quadrant + 1) & 2) << 30));
}

static inline void m_sincos(float x, float *s, float *c) {
    int quadrant;
    float r = m_reduce(x, &quadrant);
    m_sincos_reduced(r, quadrant, s, c);
}

static inline float m_sin(float x) {
    float s, c;
    m_sincos(x, &s, &c);
    return s;
}

static inline float m_cos(float x) {
    float s, c;
    m_sincos(x, &s, &c);
    return c;
}

static inline float m_tan(float x) {
    float s, c;
    m_sincos(x, &s, &c);
    return s / c;
}

// Arc tangent of 0 <= t <= 1.
static inline float m_atan_reduced(float t) {
    float z = t * t, zz = z * z;
    float p = fma(zz, fma(z, -1.280838624e-02, 5.580619350e-02), fma(z, -1.198189184e-01, 1.951828897e-01));
    return fma(t * z, fma(z, p, -3.329659700e-01), t);
}

// ---- Exponentials and logarithms ------------------------------------------------------------------------------------

#ifdef __NV_CL_C_VERSION
static inline float m_exp2(float x) { return native_exp2(clamp(x, -126.0f, 126.0f)); }
static inline float m_exp(float x) { return m_exp2(x * 1.442695041); }
static inline float m_log2(float x) { return native_log2(x); }
#else
// 2^(k + r), |r| <= 1/2, k within -126..126. By pairs: the chain of operations is what takes time.
static inline float m_exp2_split(int k, float r) {
    float z = r * r;
    float p = fma(z, fma(r, 9.582852945e-03, 5.590642616e-02), fma(r, 2.402409911e-01, 6.931241751e-01));
    return as_float(as_int(fma(r, p, 1.0)) + (k << 23));
}

// Beyond 2^-126 and 2^126 the result stays there.
static inline float m_exp2(float x) {
    x = x > 126 ? 126 : (x > -126 ? x : -126);
    int k;
    float r = x - m_nearest(x, &k);
    return m_exp2_split(k, r);
}

static inline float m_exp(float x) {
    x = x > 87.3365 ? 87.3365 : (x > -87.3365 ? x : -87.3365);
    int k;
    float r = fma(x, 1.442695041, -m_nearest(x * 1.442695041, &k));
    return m_exp2_split(k, r);
}

// x > 0 and not denormal: 2^k * (1 + f), 1 + f in [sqrt(1/2), sqrt(2)).
static inline float m_log2(float x) {
    int bits = as_int(x);
    int k = (bits - 0x3f3504f3) >> 23;
    float f = as_float(bits - (k << 23)) - 1;
    float z = f * f;
    float low = fma(f, -7.213636041e-01, 1.442696452), middle = fma(f, -3.593716323e-01, 4.806267619e-01);
    float high = fma(z, 1.716245711e-01, fma(f, -2.693202794e-01, 2.956995368e-01));
    return fma(f, fma(z, fma(z, high, middle), low), (float)k);
}
#endif

static inline float m_log2_edges(float x, float r) { return x > 0 ? r : (x == 0 ? -INFINITY : NAN); }
static inline float m_log(float x) { return m_log2_edges(x, m_log2(x) * 6.931471806e-01); }
static inline float m_log10(float x) { return m_log2_edges(x, m_log2(x) * 3.010299957e-01); }

static inline float m_powr(float x, float y) { return m_exp2(y * m_log2(x)); }

#endif
