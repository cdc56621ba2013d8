// Pairs of numbers with the operators and functions of vectors.
#pragma once
#define VECTOR2_H

struct vector2
{
    float x;
    float y;
};

// By component.
#define VECTOR2_1(f) vector2 f(vector2 v) { return vector2(f(v.x), f(v.y)); }
#define VECTOR2_2(f) vector2 f(vector2 v, vector2 w) { return vector2(f(v.x, w.x), f(v.y, w.y)); }
#define VECTOR2_2F(f) vector2 f(vector2 v, float w) { return f(v, vector2(w, w)); }
// An operator between two, and with a number on either side.
#define VECTOR2_OPERATOR(name, op) \
    vector2 name(vector2 v, vector2 w) { return vector2(v.x op w.x, v.y op w.y); } \
    vector2 name(vector2 v, int w) { return name(v, vector2(w, w)); } \
    vector2 name(vector2 v, float w) { return name(v, vector2(w, w)); } \
    vector2 name(int v, vector2 w) { return name(vector2(v, v), w); } \
    vector2 name(float v, vector2 w) { return name(vector2(v, v), w); }

vector2 __operator__neg__(vector2 v) { return vector2(-v.x, -v.y); }
VECTOR2_OPERATOR(__operator__add__, +)
VECTOR2_OPERATOR(__operator__sub__, -)
VECTOR2_OPERATOR(__operator__mul__, *)
VECTOR2_OPERATOR(__operator__div__, /)
int __operator__eq__(vector2 v, vector2 w) { return v.x == w.x && v.y == w.y; }
int __operator__neq__(vector2 v, vector2 w) { return v.x != w.x || v.y != w.y; }

VECTOR2_1(abs)
VECTOR2_1(ceil)
VECTOR2_1(floor)
VECTOR2_1(sqrt)
VECTOR2_1(exp)
VECTOR2_1(log)
VECTOR2_1(log2)
VECTOR2_1(sign)
VECTOR2_1(sin)
VECTOR2_1(cos)
VECTOR2_1(tan)
VECTOR2_1(asin)
VECTOR2_1(acos)
VECTOR2_2(max)
VECTOR2_2F(max)
VECTOR2_2(min)
VECTOR2_2F(min)
VECTOR2_2(fmod)
VECTOR2_2F(fmod)
VECTOR2_2(pow)
VECTOR2_2F(pow)
VECTOR2_2(atan2)
vector2 atan2(vector2 v, float f) { return vector2(atan2(v.x, f), atan2(v.y, f)); }
vector2 mix(vector2 v, vector2 w, float t) { return vector2(mix(v.x, w.x, t), mix(v.y, w.y, t)); }
vector2 smoothstep(vector2 low, vector2 high, vector2 v)
{
    return vector2(smoothstep(low.x, high.x, v.x), smoothstep(low.y, high.y, v.y));
}
vector2 smoothstep(float low, float high, vector2 v) { return smoothstep(vector2(low, low), vector2(high, high), v); }
vector2 clamp(vector2 v, vector2 low, vector2 high)
{
    return vector2(clamp(v.x, low.x, high.x), clamp(v.y, low.y, high.y));
}
vector2 clamp(vector2 v, float low, float high) { return clamp(v, vector2(low, low), vector2(high, high)); }
float dot(vector2 v, vector2 w) { return v.x * w.x + v.y * w.y; }
float length(vector2 v) { return sqrt(dot(v, v)); }
vector2 normalize(vector2 v) { return v / length(v); }
vector2 mod(vector2 v, vector2 w) { return v - w * floor(v / w); }

#undef VECTOR2_1
#undef VECTOR2_2
#undef VECTOR2_2F
#undef VECTOR2_OPERATOR
