// A 3x3 matrix, kept as the upper left part of a 4x4 one.
#pragma once
#define MATRIX33_H

struct matrix33
{
    matrix m;
};

// Whether the rest is that of the identity.
int isValidAs33(matrix m)
{
    return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1;
}

matrix matrix33To44(matrix33 a) { return a.m; }

matrix33 matrix44To33(matrix m)
{
    return matrix33(matrix(m[0][0], m[0][1], m[0][2], 0, m[1][0], m[1][1], m[1][2], 0, m[2][0], m[2][1], m[2][2], 0, 0, 0, 0, 1));
}

#define MATRIX33_OPERATOR(name, op) \
    matrix33 name(matrix33 a, matrix33 b) { return matrix33(a.m op b.m); } \
    matrix33 name(matrix33 a, int b) { return matrix33(a.m op b); } \
    matrix33 name(matrix33 a, float b) { return matrix33(a.m op b); } \
    matrix33 name(int a, matrix33 b) { return matrix33(a op b.m); } \
    matrix33 name(float a, matrix33 b) { return matrix33(a op b.m); }

matrix33 __operator__neg__(matrix33 a) { return matrix33(-a.m); }
MATRIX33_OPERATOR(__operator__mul__, *)
MATRIX33_OPERATOR(__operator__div__, /)
int __operator__eq__(matrix33 a, matrix33 b) { return a.m == b.m; }
int __operator__neq__(matrix33 a, matrix33 b) { return a.m != b.m; }
// The name that shaders know from the reference's header.
int __operator__ne__(matrix33 a, matrix33 b) { return a.m != b.m; }

float determinant(matrix33 a) { return determinant(a.m); }
matrix33 transpose(matrix33 a) { return matrix33(transpose(a.m)); }
point transform(matrix33 a, point p) { return transform(a.m, p); }
vector transform(matrix33 a, vector v) { return transform(a.m, v); }
normal transform(matrix33 a, normal n) { return transform(a.m, n); }

#undef MATRIX33_OPERATOR
