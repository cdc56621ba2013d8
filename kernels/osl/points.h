// Point clouds: pointcloud_search, pointcloud_get (OSL specification ch. 7).
//
// In: ShaderGlobals.clouds, where runtime/src/points/pack.rs lays out the clouds, a file's id. Out: the nearest points of a place,
// and what is known of them. Without HAS_POINT_CLOUDS there are none. All offsets count 32-bit words from the start of the buffer:
//   buffer     number of clouds; for each its id and its offset
//   cloud      the words CLOUD_*, then for each attribute id, type (0 ints, 1 floats, 2 a triple, 3 a string), how many numbers a
//              point has, offset of the first
//   cells      x fastest; where the points of each begin in the list of points by cell, and where the last one's end
#ifndef OSLCL_OSL_POINTS_H
#define OSLCL_OSL_POINTS_H

#include "globals.h"

#define CLOUD_POINTS 0u
#define CLOUD_CELLS 1u     // along x, y, z
#define CLOUD_ORIGIN 4u    // three floats
#define CLOUD_SCALE 7u     // cells per unit of length, a float
#define CLOUD_STARTS 8u    // offsets
#define CLOUD_ORDER 9u
#define CLOUD_POSITIONS 10u
#define CLOUD_ATTRIBUTES 11u
#define CLOUD_WORDS 12u

#ifdef HAS_POINT_CLOUDS

// The cloud of a file; 0: there is none.
static inline __global const uint *cloud_of(const ShaderGlobals *sg, int file)
{
    for (uint i = 0; i < sg->clouds[0]; i++)
        if (sg->clouds[1 + 2 * i] == (uint)file) return sg->clouds + sg->clouds[2 + 2 * i];
    return 0;
}

// The cell nearest to a place, along one axis.
static inline uint cloud_cell(__global const uint *cloud, real x, uint axis)
{
    const real at = (x - as_float(cloud[CLOUD_ORIGIN + axis])) * as_float(cloud[CLOUD_SCALE]);
    return (uint)clamp(at, (real)0, (real)(cloud[CLOUD_CELLS + axis] - 1));
}

// The nearest points within the radius, sorted by distance, then by index; without arrays they are counted. Distances are squares
// until the end.
static inline int cloud_nearest(const ShaderGlobals *sg, int file, real3 center, real radius, int most, int *indices,
                                real *distances)
{
    __global const uint *cloud = cloud_of(sg, file);
    if (cloud == 0 || !(radius >= 0) || !is_finite_real(dot(center, (real3)(1)))) return 0;
    __global const uint *starts = sg->clouds + cloud[CLOUD_STARTS], *order = sg->clouds + cloud[CLOUD_ORDER];
    __global const float *positions = (__global const float *)(sg->clouds + cloud[CLOUD_POSITIONS]);
    const real scale = as_float(cloud[CLOUD_SCALE]);
    // A little more: rounding may put a point over the edge of its cell.
    const real slack = scale > 0 ? radius + (real)1e-3 / scale : radius;
    const uint x0 = cloud_cell(cloud, center.x - slack, 0), x1 = cloud_cell(cloud, center.x + slack, 0);
    const uint y0 = cloud_cell(cloud, center.y - slack, 1), y1 = cloud_cell(cloud, center.y + slack, 1);
    const uint z0 = cloud_cell(cloud, center.z - slack, 2), z1 = cloud_cell(cloud, center.z + slack, 2);
    int found = 0;
    for (uint z = z0; z <= z1; z++) {
        for (uint y = y0; y <= y1; y++) {
            const uint row = (z * cloud[CLOUD_CELLS + 1] + y) * cloud[CLOUD_CELLS];
            for (uint k = starts[row + x0]; k < starts[row + x1 + 1]; k++) {
                const int i = (int)order[k];
                const real3 d = center - convert_real3(vload3(i, positions));
                const real square = dot(d, d);
                if (!(square <= radius * radius)) continue;
                if (indices == 0) {
                    found = min(found + 1, max(most, 0));
                    continue;
                }
                // Where it belongs among those found so far.
                int at = found;
                while (at > 0 && (square < distances[at - 1] || (square == distances[at - 1] && i < indices[at - 1]))) at--;
                if (at >= most) continue;
                found = min(found + 1, most);
                for (int j = found - 1; j > at; j--) {
                    distances[j] = distances[j - 1];
                    indices[j] = indices[j - 1];
                }
                distances[at] = square;
                indices[at] = i;
            }
        }
    }
    for (int j = 0; j < found && distances != 0; j++) distances[j] = sqrt(distances[j]);
    return found;
}

// Where an attribute's numbers are, if all indices are points and the type is right: *each numbers a point.
static inline __global const uint *cloud_attribute(const ShaderGlobals *sg, int file, const int *indices, int count,
                                                   int name, uint type, uint *each)
{
    __global const uint *cloud = cloud_of(sg, file);
    if (cloud == 0) return 0;
    for (int k = 0; k < count; k++)
        if (indices[k] < 0 || (uint)indices[k] >= cloud[CLOUD_POINTS]) return 0;
    for (uint i = 0; i < cloud[CLOUD_ATTRIBUTES]; i++) {
        __global const uint *row = cloud + CLOUD_WORDS + 4 * i;
        if (row[0] != (uint)name || row[1] != type) continue;
        *each = row[2];
        return sg->clouds + row[3];
    }
    return 0;
}

// The body of a read: the type of the attribute, and how an element is made of the words `at`.
#define CLOUD_GET(TYPE, READ)                                                                                       \
    uint each = 1;                                                                                                     \
    count = min(count, index_count);                                                                                   \
    if (count <= 0) return 1;                                                                                          \
    __global const uint *values = cloud_attribute(sg, file, indices, count, name, TYPE, &each);                        \
    if (values == 0) return 0;                                                                                         \
    const int width = TYPE == 2u ? 1 : (int)each;                                                                      \
    /* Only whole points. */                                                                                           \
    count = min(count, data_count / width);                                                                            \
    for (int k = 0; k < count; k++)                                                                                    \
        for (int j = 0; j < width; j++) {                                                                              \
            __global const uint *at = values + (size_t)indices[k] * each + j;                                          \
            data[k * width + j] = READ;                                                                                \
        }                                                                                                              \
    return 1;

#else

#define CLOUD_GET(TYPE, READ) return min(count, index_count) <= 0;

#endif

static inline int osl_cloud_count_i_svfi(const ShaderGlobals *sg, int file, real3 center, real radius, int most)
{
#ifdef HAS_POINT_CLOUDS
    return cloud_nearest(sg, file, center, radius, most, 0, 0);
#else
    return 0;
#endif
}

static inline int osl_cloud_search_i_svfioaioaf(const ShaderGlobals *sg, int file, real3 center, real radius, int most,
                                                int *indices, int index_count, real *distances, int distance_count)
{
#ifdef HAS_POINT_CLOUDS
    return cloud_nearest(sg, file, center, radius, min(most, min(index_count, distance_count)), indices, distances);
#else
    return 0;
#endif
}

static inline int osl_cloud_get_i_saiisoai(const ShaderGlobals *sg, int file, const int *indices, int index_count,
                                           int count, int name, int *data, int data_count)
{
    CLOUD_GET(0u, (int)*at)
}

static inline int osl_cloud_get_i_saiisoas(const ShaderGlobals *sg, int file, const int *indices, int index_count,
                                           int count, int name, int *data, int data_count)
{
    CLOUD_GET(3u, (int)*at)
}

static inline int osl_cloud_get_i_saiisoaf(const ShaderGlobals *sg, int file, const int *indices, int index_count,
                                           int count, int name, real *data, int data_count)
{
    CLOUD_GET(1u, as_float(*at))
}

static inline int osl_cloud_get_i_saiisoav(const ShaderGlobals *sg, int file, const int *indices, int index_count,
                                           int count, int name, real3 *data, int data_count)
{
    CLOUD_GET(2u, (real3)(as_float(at[0]), as_float(at[1]), as_float(at[2])))
}

#endif
