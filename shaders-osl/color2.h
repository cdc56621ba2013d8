// A grey value and alpha.
#pragma once
#define COLOR2_H

struct color2
{
    float r;
    float a;
};

// By component.
#define COLOR2_1(f) color2 f(color2 v) { return color2(f(v.r), f(v.a)); }
#define COLOR2_2(f) color2 f(color2 v, color2 w) { return color2(f(v.r, w.r), f(v.a, w.a)); }
#define COLOR2_2F(f) color2 f(color2 v, float w) { return f(v, color2(w, w)); }
// An operator between two, and with a number on either side.
#define COLOR2_OPERATOR(name, op) \
    color2 name(color2 v, color2 w) { return color2(v.r op w.r, v.a op w.a); } \
    color2 name(color2 v, int w) { return name(v, color2(w, w)); } \
    color2 name(color2 v, float w) { return name(v, color2(w, w)); } \
    color2 name(int v, color2 w) { return name(color2(v, v), w); } \
    color2 name(float v, color2 w) { return name(color2(v, v), w); }

color2 __operator__neg__(color2 v) { return color2(-v.r, -v.a); }
COLOR2_OPERATOR(__operator__add__, +)
COLOR2_OPERATOR(__operator__sub__, -)
COLOR2_OPERATOR(__operator__mul__, *)
COLOR2_OPERATOR(__operator__div__, /)
int __operator__eq__(color2 v, color2 w) { return v.r == w.r && v.a == w.a; }
int __operator__neq__(color2 v, color2 w) { return v.r != w.r || v.a != w.a; }

COLOR2_1(abs)
COLOR2_1(ceil)
COLOR2_1(floor)
COLOR2_1(sqrt)
COLOR2_1(exp)
COLOR2_1(log)
COLOR2_1(log2)
COLOR2_1(sign)
COLOR2_1(sin)
COLOR2_1(cos)
COLOR2_1(tan)
COLOR2_1(asin)
COLOR2_1(acos)
COLOR2_2(max)
COLOR2_2F(max)
COLOR2_2(min)
COLOR2_2F(min)
COLOR2_2(fmod)
COLOR2_2F(fmod)
COLOR2_2(pow)
COLOR2_2F(pow)
COLOR2_2(atan2)
color2 atan2(color2 v, float f) { return color2(atan2(v.r, f), atan2(v.a, f)); }
color2 fmod(color2 v, int w) { return fmod(v, color2(w, w)); }
color2 mix(color2 v, color2 w, float t) { return color2(mix(v.r, w.r, t), mix(v.a, w.a, t)); }
color2 smoothstep(color2 low, color2 high, color2 v)
{
    return color2(smoothstep(low.r, high.r, v.r), smoothstep(low.a, high.a, v.a));
}
color2 smoothstep(float low, float high, color2 v) { return smoothstep(color2(low, low), color2(high, high), v); }
color2 clamp(color2 v, color2 low, color2 high)
{
    return color2(clamp(v.r, low.r, high.r), clamp(v.a, low.a, high.a));
}
color2 clamp(color2 v, float low, float high) { return clamp(v, color2(low, low), color2(high, high)); }

#undef COLOR2_1
#undef COLOR2_2
#undef COLOR2_2F
#undef COLOR2_OPERATOR
