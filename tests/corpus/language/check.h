// What the shaders of this folder share: they compute values that the specification of the language or the reference
// implementation gives, and count those that come out otherwise. tests/tests/language.rs runs them on the host and the device.
// `IS(x, y)` holds that x is y; `ROUGHLY(x, y, e)` that it is not further than e from it.
#pragma once

int near(float x, float y, float e) { return abs(x - y) <= e * max(1.0, abs(y)); }

int is_not(string what, int x, int y)
{
    if (x == y)
        return 0;
    printf("%s is %d, not %d", what, x, y);
    return 1;
}

int is_not(string what, float x, float y)
{
    if (near(x, y, 2e-6))
        return 0;
    printf("%s is %.9g, not %.9g", what, x, y);
    return 1;
}

int is_not(string what, string x, string y)
{
    if (x == y)
        return 0;
    printf("%s is <%s>, not <%s>", what, x, y);
    return 1;
}

int is_not(string what, matrix x, matrix y)
{
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            if (!near(x[row][column], y[row][column], 2e-6)) {
                printf("%s is %g, not %g", what, x, y);
                return 1;
            }
    return 0;
}

#define TRIPLE(T, NAME) \
    int NAME(string what, T x, T y, float e) \
    { \
        if (near(x[0], y[0], e) && near(x[1], y[1], e) && near(x[2], y[2], e)) \
            return 0; \
        printf("%s is %.9g, not %.9g", what, x, y); \
        return 1; \
    }
TRIPLE(color, triple_is_not)
TRIPLE(vector, triple_is_not)
TRIPLE(point, triple_is_not)
TRIPLE(normal, triple_is_not)

int is_not(string what, color x, color y) { return triple_is_not(what, x, y, 2e-6); }
int is_not(string what, vector x, vector y) { return triple_is_not(what, x, y, 2e-6); }
int is_not(string what, point x, point y) { return triple_is_not(what, x, y, 2e-6); }
int is_not(string what, normal x, normal y) { return triple_is_not(what, x, y, 2e-6); }

int is_far(string what, float x, float y, float e)
{
    if (near(x, y, e))
        return 0;
    printf("%s is %.9g, not %.9g", what, x, y);
    return 1;
}
int is_far(string what, color x, color y, float e) { return triple_is_not(what, x, y, e); }
int is_far(string what, vector x, vector y, float e) { return triple_is_not(what, x, y, e); }

#define IS(X, Y) { wrong += is_not(#X, X, Y); checks += 1; }
#define ROUGHLY(X, Y, E) { wrong += is_far(#X, X, Y, E); checks += 1; }

// Numbers that only a run tells: u is in 0..1.
#define NUMBERS float zero = u > 2 ? 1.0 : 0.0; float one = u > 2 ? 0.0 : 1.0; float two = one + one; int none = u > 2; int some = u <= 2;
