// A colour and alpha.
#pragma once
#define COLOR4_H

struct color4
{
    color rgb;
    float a;
};

// By component.
#define COLOR4_1(f) color4 f(color4 v) { return color4(f(v.rgb), f(v.a)); }
#define COLOR4_2(f) color4 f(color4 v, color4 w) { return color4(f(v.rgb, w.rgb), f(v.a, w.a)); }
#define COLOR4_2F(f) color4 f(color4 v, float w) { return f(v, color4(color(w), w)); }
// An operator between two, and with a number on either side.
#define COLOR4_OPERATOR(name, op) \
    color4 name(color4 v, color4 w) { return color4(v.rgb op w.rgb, v.a op w.a); } \
    color4 name(color4 v, int w) { return name(v, color4(color(w), w)); } \
    color4 name(color4 v, float w) { return name(v, color4(color(w), w)); } \
    color4 name(int v, color4 w) { return name(color4(color(v), v), w); } \
    color4 name(float v, color4 w) { return name(color4(color(v), v), w); }

color4 __operator__neg__(color4 v) { return color4(-v.rgb, -v.a); }
COLOR4_OPERATOR(__operator__add__, +)
COLOR4_OPERATOR(__operator__sub__, -)
COLOR4_OPERATOR(__operator__mul__, *)
COLOR4_OPERATOR(__operator__div__, /)
int __operator__eq__(color4 v, color4 w) { return v.rgb == w.rgb && v.a == w.a; }
int __operator__neq__(color4 v, color4 w) { return v.rgb != w.rgb || v.a != w.a; }

COLOR4_1(abs)
COLOR4_1(ceil)
COLOR4_1(floor)
COLOR4_1(sqrt)
COLOR4_1(exp)
COLOR4_1(log)
COLOR4_1(log2)
COLOR4_1(sign)
COLOR4_1(sin)
COLOR4_1(cos)
COLOR4_1(tan)
COLOR4_1(asin)
COLOR4_1(acos)
COLOR4_2(max)
COLOR4_2F(max)
COLOR4_2(min)
COLOR4_2F(min)
COLOR4_2(fmod)
COLOR4_2F(fmod)
COLOR4_2(pow)
COLOR4_2F(pow)
COLOR4_2(atan2)
color4 atan2(color4 v, float f) { return color4(atan2(v.rgb, color(f)), atan2(v.a, f)); }
color4 fmod(color4 v, int w) { return fmod(v, color4(color(w), w)); }
color4 mix(color4 v, color4 w, float t) { return color4(mix(v.rgb, w.rgb, t), mix(v.a, w.a, t)); }
color4 smoothstep(color4 low, color4 high, color4 v)
{
    return color4(smoothstep(low.rgb, high.rgb, v.rgb), smoothstep(low.a, high.a, v.a));
}
color4 smoothstep(float low, float high, color4 v) { return smoothstep(color4(color(low), low), color4(color(high), high), v); }
color4 clamp(color4 v, color4 low, color4 high)
{
    return color4(clamp(v.rgb, low.rgb, high.rgb), clamp(v.a, low.a, high.a));
}
color4 clamp(color4 v, float low, float high) { return clamp(v, color4(color(low), low), color4(color(high), high)); }
// Alpha knows no colour space.
color4 transformc(string from, string to, color4 c) { return color4(transformc(from, to, c.rgb), c.a); }

#undef COLOR4_1
#undef COLOR4_2
#undef COLOR4_2F
#undef COLOR4_OPERATOR
