// What shaders ask of the renderer's state (specification ch. 7.10): reads of ShaderGlobals only.
//
// In: the point being shaded. It must not know where its fields come from.
#ifndef OSLCL_OSL_STATE_H
#define OSLCL_OSL_STATE_H

#include "globals.h"
#include "osl/matrix.h"

static inline real osl_surfacearea_f_(const ShaderGlobals *sg) { return sg->surfacearea; }
static inline int osl_backfacing_i_(const ShaderGlobals *sg) { return sg->backfacing; }
#ifdef HAS_DERIVATIVES
static inline int osl_flip_handedness_i_(const ShaderGlobals *sg) { return sg->flip_handedness; }
#endif
static inline int osl_raytype_bit_i_i(const ShaderGlobals *sg, int bit) { return (sg->raytype & bit) != 0; }

// Spaces as `lower` numbers them: 0 common and world, 1 object, 2 shader, 3 camera, from 4 on the others of ShaderGlobals.
static inline mat4 osl_state_space(const ShaderGlobals *sg, int space, int inverse) {
    __global const real *m = space == 1   ? sg->object_space
                             : space == 2 ? sg->shader_space
                             : space == 3 ? sg->camera_space
                                          : sg->other_spaces;
    if (space > 4 && m != 0) m += 32 * (space - 4);
    mat4 r = op_matrix_f(1);
    if (space != 0 && m != 0) {
        for (int i = 0; i < 16; ++i) r.m[i] = m[16 * inverse + i];
    }
    return r;
}

// To common space.
static inline mat4 osl_space_matrix_m_i(const ShaderGlobals *sg, int space) { return osl_state_space(sg, space, 0); }

// From common space.
static inline mat4 osl_space_matrix_inverse_m_i(const ShaderGlobals *sg, int space) {
    return osl_state_space(sg, space, 1);
}

#endif
