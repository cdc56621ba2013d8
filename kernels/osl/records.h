// What a shader says to the host: one record per call, decoded there with the artifact's table of sites. It needs
// HAS_MESSAGES, which gives ShaderGlobals the buffer `records` (0: nobody listens) and the number `point` of the point.
//
// The buffer: [0] words asked for so far, [1] words that there are; from [2] on records, one behind the other: words of the
// record, point, site, then the values. A record that does not fit is not written; the host sees that [0] exceeds [1].
#ifndef OSLCL_RECORDS_H
#define OSLCL_RECORDS_H

#include "globals.h"
#include "osl/matrix.h"

// Once so many words were asked for, no more are counted: the count must not wrap.
#define RECORDS_MOST 0x80000000u

// Where the next value goes; `at` is 0 when the record has no place.
typedef struct {
    __global uint *at;
    uint left;
} Record;

// Begins a record of so many words of values.
static inline Record record_open(const ShaderGlobals *sg, uint site, uint words)
{
    Record record = {0, 0};
    __global uint *records = sg->records;
    if (records == 0 || *(volatile __global uint *)records >= RECORDS_MOST) return record;
    const uint size = words + 3;
    const uint place = atomic_add(records, size);
    const uint room = records[1];
    if (size < words || place > room || size > room - place) return record;
    __global uint *at = records + 2 + place;
    at[0] = size;
    at[1] = sg->point;
    at[2] = site;
    record.at = at + 3;
    record.left = words;
    return record;
}

static inline void record_word(Record *record, uint word)
{
    if (record->left == 0) return;
    *record->at = word;
    record->at++;
    record->left--;
}

// An int, or the id of a string.
static inline void record_i(Record *record, int x)
{
    record_word(record, (uint)x);
}

// As a 32-bit float, as OSL's are.
static inline void record_f(Record *record, real x)
{
    record_word(record, as_uint((float)x));
}

static inline void record_v(Record *record, real3 v)
{
    record_f(record, v.x);
    record_f(record, v.y);
    record_f(record, v.z);
}

static inline void record_m(Record *record, mat4 m)
{
    for (int k = 0; k < 16; k++) record_f(record, m.m[k]);
}

#endif
