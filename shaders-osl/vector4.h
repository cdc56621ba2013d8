// Four numbers with the operators and functions of vectors; homogeneous coordinates.
#pragma once
#define VECTOR4_H

struct vector4
{
    float x;
    float y;
    float z;
    float w;
};

// By component.
#define VECTOR4_1(f) vector4 f(vector4 v) { return vector4(f(v.x), f(v.y), f(v.z), f(v.w)); }
#define VECTOR4_2(f) vector4 f(vector4 v, vector4 w) { return vector4(f(v.x, w.x), f(v.y, w.y), f(v.z, w.z), f(v.w, w.w)); }
#define VECTOR4_2F(f) vector4 f(vector4 v, float w) { return f(v, vector4(w, w, w, w)); }
// An operator between two, and with a number on either side.
#define VECTOR4_OPERATOR(name, op) \
    vector4 name(vector4 v, vector4 w) { return vector4(v.x op w.x, v.y op w.y, v.z op w.z, v.w op w.w); } \
    vector4 name(vector4 v, int w) { return name(v, vector4(w, w, w, w)); } \
    vector4 name(vector4 v, float w) { return name(v, vector4(w, w, w, w)); } \
    vector4 name(int v, vector4 w) { return name(vector4(v, v, v, v), w); } \
    vector4 name(float v, vector4 w) { return name(vector4(v, v, v, v), w); }

vector4 __operator__neg__(vector4 v) { return vector4(-v.x, -v.y, -v.z, -v.w); }
VECTOR4_OPERATOR(__operator__add__, +)
VECTOR4_OPERATOR(__operator__sub__, -)
VECTOR4_OPERATOR(__operator__mul__, *)
VECTOR4_OPERATOR(__operator__div__, /)
int __operator__eq__(vector4 v, vector4 w) { return v.x == w.x && v.y == w.y && v.z == w.z && v.w == w.w; }
int __operator__neq__(vector4 v, vector4 w) { return v.x != w.x || v.y != w.y || v.z != w.z || v.w != w.w; }

VECTOR4_1(abs)
VECTOR4_1(ceil)
VECTOR4_1(floor)
VECTOR4_1(sqrt)
VECTOR4_1(exp)
VECTOR4_1(log)
VECTOR4_1(log2)
VECTOR4_1(sign)
VECTOR4_1(sin)
VECTOR4_1(cos)
VECTOR4_1(tan)
VECTOR4_1(asin)
VECTOR4_1(acos)
VECTOR4_2(max)
VECTOR4_2F(max)
VECTOR4_2(min)
VECTOR4_2F(min)
VECTOR4_2(fmod)
VECTOR4_2F(fmod)
VECTOR4_2(pow)
VECTOR4_2F(pow)
VECTOR4_2(atan2)
vector4 atan2(vector4 v, float f) { return vector4(atan2(v.x, f), atan2(v.y, f), atan2(v.z, f), atan2(v.w, f)); }
vector4 mix(vector4 v, vector4 w, float t) { return vector4(mix(v.x, w.x, t), mix(v.y, w.y, t), mix(v.z, w.z, t), mix(v.w, w.w, t)); }
vector4 smoothstep(vector4 low, vector4 high, vector4 v)
{
    return vector4(smoothstep(low.x, high.x, v.x), smoothstep(low.y, high.y, v.y), smoothstep(low.z, high.z, v.z), smoothstep(low.w, high.w, v.w));
}
vector4 smoothstep(float low, float high, vector4 v) { return smoothstep(vector4(low, low, low, low), vector4(high, high, high, high), v); }
vector4 clamp(vector4 v, vector4 low, vector4 high)
{
    return vector4(clamp(v.x, low.x, high.x), clamp(v.y, low.y, high.y), clamp(v.z, low.z, high.z), clamp(v.w, low.w, high.w));
}
vector4 clamp(vector4 v, float low, float high) { return clamp(v, vector4(low, low, low, low), vector4(high, high, high, high)); }
float dot(vector4 v, vector4 w) { return v.x * w.x + v.y * w.y + v.z * w.z + v.w * w.w; }
float length(vector4 v) { return sqrt(dot(v, v)); }
vector4 normalize(vector4 v) { return v / length(v); }
vector vec4ToVec3(vector4 v) { return vector(v.x, v.y, v.z) / v.w; }
// A row vector times a matrix, as everywhere in OSL.
vector4 transform(matrix M, vector4 v)
{
    float column(int c) { return v.x * M[0][c] + v.y * M[1][c] + v.z * M[2][c] + v.w * M[3][c]; }
    return vector4(column(0), column(1), column(2), column(3));
}
vector4 transform(string from, string to, vector4 v) { return transform(matrix(from, to), v); }

#undef VECTOR4_1
#undef VECTOR4_2
#undef VECTOR4_2F
#undef VECTOR4_OPERATOR
