// Built-in functions that are no operations of the .oso format, in terms of those that are. Included before shaders that are
// compiled to .oso only; for kernels, kernels/osl/ has them. Formulas as there.

#define EACH_TRIPLE(F) F(color) F(point) F(vector) F(normal)
#define EACH_TYPE(F) F(float) EACH_TRIPLE(F)

float hypot(float a, float b) { return sqrt(a * a + b * b); }
float hypot(float a, float b, float c) { return sqrt(a * a + b * b + c * c); }

int mod(int a, int b) { return b == 0 ? a : a % b; }
#define MOD(T) T mod(T a, T b) { return a - b * floor(a / b); }
EACH_TYPE(MOD)
#define MOD_FLOAT(T) T mod(T a, float b) { return a - b * floor(a / b); }
EACH_TRIPLE(MOD_FLOAT)

float linearstep(float low, float high, float x)
{
    return low == high ? step(low, x) : clamp((x - low) / (high - low), 0.0, 1.0);
}
float smooth_linearstep(float low, float high, float x, float eps)
{
    float result;
    if (low == high) {
        result = step(low, x);
    } else {
        float scale = 1 / (high - low);
        float t = (x - low) * scale;
        float e = eps * scale;
        float k = 0.25 / e;
        if (t <= -e)
            result = 0;
        else if (t >= e && t <= 1 - e)
            result = t;
        else if (t >= 1 + e)
            result = 1;
        else if (t < e)
            result = k * (t + e) * (t + e);
        else
            result = 1 - k * (1 + e - t) * (1 + e - t);
    }
    return result;
}
#define STEPS(T) \
T linearstep(T low, T high, T x) \
{ \
    return T(linearstep(low[0], high[0], x[0]), linearstep(low[1], high[1], x[1]), linearstep(low[2], high[2], x[2])); \
} \
T linearstep(float low, float high, T x) \
{ \
    return T(linearstep(low, high, x[0]), linearstep(low, high, x[1]), linearstep(low, high, x[2])); \
} \
T smooth_linearstep(T low, T high, T x, T eps) \
{ \
    return T(smooth_linearstep(low[0], high[0], x[0], eps[0]), smooth_linearstep(low[1], high[1], x[1], eps[1]), \
             smooth_linearstep(low[2], high[2], x[2], eps[2])); \
} \
T smooth_linearstep(float low, float high, T x, float eps) \
{ \
    return T(smooth_linearstep(low, high, x[0], eps), smooth_linearstep(low, high, x[1], eps), \
             smooth_linearstep(low, high, x[2], eps)); \
} \
T step(float edge, T x) { return step(T(edge), x); } \
T smoothstep(float low, float high, T x) { return smoothstep(T(low), T(high), x); }
EACH_TRIPLE(STEPS)

vector faceforward(vector N, vector I, vector reference) { return dot(I, reference) > 0 ? -N : N; }
vector faceforward(vector N, vector I) { return dot(I, Ng) > 0 ? -N : N; }
vector reflect(vector I, vector N) { return I - 2 * dot(N, I) * N; }
// Snell's law in vector form; 0 beyond the critical angle.
vector refract(vector I, vector N, float eta)
{
    float c = dot(I, N);
    float k = 1 - eta * eta * (1 - c * c);
    return k < 0 ? vector(0) : (eta * I - (eta * c + sqrt(k)) * N);
}
// Unpolarised reflectance of a dielectric (Cook and Torrance 1982).
void fresnel(vector I, normal N, float eta, output float Kr, output float Kt, output vector R, output vector T)
{
    float c = abs(dot(I, N));
    float g = 1 / (eta * eta) - 1 + c * c;
    R = reflect(I, N);
    if (g >= 0) {
        g = sqrt(g);
        float s = (g - c) / (g + c);
        float p = (c * (g + c) - 1) / (c * (g - c) + 1);
        Kr = 0.5 * s * s * (1 + p * p);
        Kt = (1 - Kr) * eta * eta;
        T = refract(I, N, eta);
    } else {
        Kr = 1;
        Kt = 0;
        T = vector(0);
    }
}
void fresnel(vector I, normal N, float eta, output float Kr, output float Kt)
{
    vector R, T;
    fresnel(I, N, eta, Kr, Kt, R, T);
}
// About the line through a and b, right-handed (Rodrigues' formula).
point rotate(point Q, float angle, point a, point b)
{
    vector axis = normalize(b - a);
    vector v = Q - a;
    float s, c;
    sincos(angle, s, c);
    return a + (c * v + s * cross(axis, v) + dot(axis, v) * (1 - c) * axis);
}
point rotate(point Q, float angle, vector axis) { return rotate(Q, angle, point(0), point(axis)); }
float distance(point a, point b, point q)
{
    vector d = b - a;
    float t = clamp(dot(q - a, d) / dot(d, d), 0.0, 1.0);
    return distance(q, a + t * d);
}

int getmatrix(string from, output matrix M) { return getmatrix(from, "common", M); }
closure color mix(closure color x, closure color y, float a) { return x * (1 - a) + y * a; }
closure color mix(closure color x, closure color y, color a) { return x * (1 - a) + y * a; }
int iscameraray() { return raytype("camera"); }
int isshadowray() { return raytype("shadow"); }
int isdiffuseray() { return raytype("diffuse"); }
int isglossyray() { return raytype("glossy"); }

#define PERIODIC(T) \
T pcellnoise(float x, float px) { return pnoise("cell", x, px); } \
T pcellnoise(float x, float y, float px, float py) { return pnoise("cell", x, y, px, py); } \
T pcellnoise(point x, point px) { return pnoise("cell", x, px); } \
T pcellnoise(point x, float y, point px, float py) { return pnoise("cell", x, y, px, py); } \
T phashnoise(float x, float px) { return pnoise("hash", x, px); } \
T phashnoise(float x, float y, float px, float py) { return pnoise("hash", x, y, px, py); } \
T phashnoise(point x, point px) { return pnoise("hash", x, px); } \
T phashnoise(point x, float y, point px, float py) { return pnoise("hash", x, y, px, py); }
EACH_TYPE(PERIODIC)

#undef EACH_TRIPLE
#undef EACH_TYPE
#undef MOD
#undef MOD_FLOAT
#undef STEPS
#undef PERIODIC
