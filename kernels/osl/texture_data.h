// Texture files as the host lays them out in one buffer: descriptors, and texels in the format of the file.
//
// In: ShaderGlobals.textures, a file's id. Out: texels. runtime/src/textures/pack.rs writes what stands here. All numbers are
// 32-bit words, and so are offsets, from the start of the buffer:
//   buffer    number of files; for each file, in order of ids: id, offset of its node
//   node      TEXTURE_NONE, id of the message
//             TEXTURE_FILE, number of subimages, offset of each, id of the message for another one
//             TEXTURE_TILES, columns, rows, offset of each tile's node, row by row; 0 where there is none; id of the message
//   subimage  the words SUB_*, then for each level of detail the words LEVEL_*
//   texels    row by row, channels of a texel together; each level starts at a whole word
#ifndef OSLCL_OSL_TEXTURE_DATA_H
#define OSLCL_OSL_TEXTURE_DATA_H

#include "globals.h"

#ifndef HAS_TEXTURES
#error a shader looks textures up, but HAS_TEXTURES is not defined
#endif

#define TEXTURE_NONE 0u
#define TEXTURE_FILE 1u
#define TEXTURE_TILES 2u

#define SUB_NAME 0u      // id
#define SUB_CHANNELS 1u
#define SUB_FORMAT 2u    // FORMAT_*
#define SUB_SWRAP 3u     // the file's own wrap modes
#define SUB_TWRAP 4u
#define SUB_FLAGS 5u
#define SUB_LEVELS 6u    // at least 1
#define SUB_SSCALE 7u    // from the full picture's s to that of the part in the file: a factor, as a float, and
#define SUB_SOFFSET 8u   // an offset, as a float
#define SUB_TSCALE 9u
#define SUB_TOFFSET 10u
#define SUB_FULL 11u     // the larger side of the full picture, in texels
#define SUB_WORDS 12u

#define SUB_Y_UP 1u      // environments: y is up, else z
#define SUB_BORDER 2u    // the outermost texels lie on the border itself

#define LEVEL_WIDTH 0u
#define LEVEL_HEIGHT 1u
#define LEVEL_TEXELS 2u  // offset
#define LEVEL_POLES 3u   // environments: offset of floats, the colours of the first and the last row; 0: none
#define LEVEL_WORDS 4u

#define FORMAT_U8 0u
#define FORMAT_U16 1u
#define FORMAT_F16 2u
#define FORMAT_F32 3u

// Codes of wrap modes and interpolations: their places in compiler/src/textures.rs, which also has the mode's bits.
#define WRAP_DEFAULT 0
#define WRAP_CLAMP 2
#define WRAP_PERIODIC 3
#define WRAP_MIRROR 4
#define WRAP_PERIODIC_POW2 5
#define WRAP_SHARED_BORDER 6
#define INTERP_SMART 0
#define INTERP_CUBIC 1
#define INTERP_LINEAR 2
#define INTERP_CLOSEST 3
#define MODE_SWRAP(mode) ((mode) & 7)
#define MODE_TWRAP(mode) ((mode) >> 3 & 7)
#define MODE_RWRAP(mode) ((mode) >> 6 & 7)
#define MODE_INTERP(mode) ((mode) >> 9 & 3)
#define MODE_HAS_MISSING(mode) ((mode) >> 11 & 1)

// Larger texel coordinates are not told apart.
#define TEXEL_FAR 1000000000

// What a lookup reads from.
typedef struct {
    __global const uint *data;
    uint sub;         // offset of the subimage's descriptor
    int first;        // channel that the result starts with
    int channels;     // of the result
    int actual;       // how many of those the file has
    int swrap, twrap; // never WRAP_DEFAULT
} Texture;

// The texture coordinates that a set of tiles maps to its tile, and the node of that tile; 0 where there is none.
static inline uint texture_tile(__global const uint *data, uint node, real *s, real *t)
{
    const int u = max(convert_int_sat_rtz(*s), 0), v = max(convert_int_sat_rtz(*t), 0);
    const int inside = u < (int)data[node + 1] && v < (int)data[node + 2];
    *s -= floor(*s);
    *t -= floor(*t);
    return inside ? data[node + 3 + (uint)v * data[node + 1] + (uint)u] : 0;
}

// The node of a file; 0 for one that is not in the buffer, which the host does not let happen.
static inline uint texture_node(__global const uint *data, int file)
{
#ifdef WITHOUT_TEXTURES
    return 0;
#endif
    uint low = 0, high = data[0];
    while (low < high) {
        const uint middle = (low + high) / 2;
        if (data[1 + 2 * middle] < (uint)file) low = middle + 1;
        else high = middle;
    }
    return low < data[0] && data[1 + 2 * low] == (uint)file ? data[2 + 2 * low] : 0;
}

// The descriptor of a subimage, by number or, where the name is not "", by name; 0 when file or subimage are missing.
static inline uint texture_subimage(__global const uint *data, uint node, int number, int name)
{
    if (node == 0 || data[node] != TEXTURE_FILE) return 0;
    const uint count = data[node + 1];
    if (name == 0) return number >= 0 && (uint)number < count ? data[node + 2 + (uint)number] : 0;
    for (uint i = 0; i < count; i++)
        if (data[data[node + 2 + i] + SUB_NAME] == (uint)name) return data[node + 2 + i];
    return 0;
}

// Finds what a lookup reads from, and makes s and t those of the tile. 0: nothing is there.
static inline int texture_open(Texture *x, __global const uint *data, int file, real *s, real *t, int subimage, int name)
{
    uint node = texture_node(data, file);
    if (node != 0 && data[node] == TEXTURE_TILES) node = texture_tile(data, node, s, t);
    x->data = data;
    x->sub = texture_subimage(data, node, subimage, name);
    return x->sub != 0;
}

// `first`, `channels`, and the wrap modes of the call, which default to the file's.
static inline void texture_options(Texture *x, int first, int channels, int swrap, int twrap)
{
    x->first = max(first, 0);
    x->channels = channels;
    x->actual = clamp((int)x->data[x->sub + SUB_CHANNELS] - x->first, 0, channels);
    x->swrap = swrap == WRAP_DEFAULT ? (int)x->data[x->sub + SUB_SWRAP] : swrap;
    x->twrap = twrap == WRAP_DEFAULT ? (int)x->data[x->sub + SUB_TWRAP] : twrap;
}

static inline uint texture_flags(const Texture *x) { return x->data[x->sub + SUB_FLAGS]; }
static inline int texture_levels(const Texture *x) { return (int)x->data[x->sub + SUB_LEVELS]; }
static inline uint texture_level(const Texture *x, int level) { return x->sub + SUB_WORDS + LEVEL_WORDS * (uint)level; }
static inline int texture_width(const Texture *x, int level) { return (int)x->data[texture_level(x, level) + LEVEL_WIDTH]; }
static inline int texture_height(const Texture *x, int level) { return (int)x->data[texture_level(x, level) + LEVEL_HEIGHT]; }

// Moves a texel coordinate into 0 .. size - 1. 0: black lies there.
static inline int texture_wrap(int mode, int *coordinate, int size)
{
    int i = *coordinate;
    switch (mode) {
    case WRAP_CLAMP: *coordinate = clamp(i, 0, size - 1); return 1;
    case WRAP_PERIODIC:
    case WRAP_PERIODIC_POW2:
        i %= size;
        *coordinate = i < 0 ? i + size : i;
        return 1;
    case WRAP_MIRROR:
        i = i < 0 ? -i - 1 : i;
        *coordinate = (i / size) & 1 ? size - 1 - i % size : i % size;
        return 1;
    case WRAP_SHARED_BORDER:
        // The last texel is the first one of the next period.
        i %= max(size - 1, 1);
        *coordinate = i < 0 ? i + max(size - 1, 1) : i;
        return 1;
    default: return i >= 0 && i < size;
    }
}

static inline real texture_number(__global const uint *texels, uint format, size_t i)
{
    switch (format) {
    case FORMAT_U8: return (real)((__global const uchar *)texels)[i] / (real)255;
    case FORMAT_U16: return (real)((__global const ushort *)texels)[i] / (real)65535;
    case FORMAT_F16: return (real)vload_half(i, (__global const half *)texels);
    default: return (real)((__global const float *)texels)[i];
    }
}

// The channels of a texel, which must lie inside its level; those that the file lacks are 0.
static inline real3 texture_texel(const Texture *x, uint level, int column, int row)
{
    const size_t texel = (size_t)row * x->data[level + LEVEL_WIDTH] + (size_t)column;
    const size_t at = texel * x->data[x->sub + SUB_CHANNELS] + (size_t)x->first;
    const uint format = x->data[x->sub + SUB_FORMAT];
    __global const uint *texels = x->data + x->data[level + LEVEL_TEXELS];
    real3 c = (real3)(0);
    if (x->actual > 0) c.x = texture_number(texels, format, at);
    if (x->actual > 1) c.y = texture_number(texels, format, at + 1);
    if (x->actual > 2) c.z = texture_number(texels, format, at + 2);
    return c;
}

// From a coordinate in texels to the texel before it, and how far it lies behind that one.
static inline int texture_floor(real x, real *rest)
{
    const real whole = floor(x);
    const real r = x - whole;
    *rest = r >= 0 && r <= 1 ? r : 0;
    return convert_int_sat_rtz(clamp(whole, (real)-TEXEL_FAR, (real)TEXEL_FAR));
}

#endif
