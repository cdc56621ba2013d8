// The lobe in hand as path state: only the fields that some lobe type of the scene uses.
#ifndef OSLCL_LOBE_STATE_H
#define OSLCL_LOBE_STATE_H

#include "context.h"
#include "lobe.h"

static inline void store_lobe(const Context *c, uint slot, const Lobe *l)
{
    path_set_uint(c, PATHU_lobe, slot, (uint)l->type | (uint)l->flags << 8);
    path_set3(c, PATH_lobe_N, slot, l->N);
#ifdef PATH_lobe_T
    path_set3(c, PATH_lobe_T, slot, l->T);
#endif
#ifdef PATH_lobe_ax
    path_set(c, PATH_lobe_ax, slot, l->ax);
#endif
#ifdef PATH_lobe_ay
    path_set(c, PATH_lobe_ay, slot, l->ay);
#endif
#ifdef PATH_lobe_eta
    path_set(c, PATH_lobe_eta, slot, l->eta);
#endif
#ifdef PATH_lobe_c0
    path_set3(c, PATH_lobe_c0, slot, l->c0);
    path_set3(c, PATH_lobe_c1, slot, l->c1);
#endif
#if defined(PATH_lobe_c2) && (defined(HAS_LOBE_GENERALIZED_SCHLICK) || defined(HAS_LOBE_CHIANG_HAIR))
    path_set3(c, PATH_lobe_c2, slot, l->c2);
    path_set3(c, PATH_lobe_c3, slot, l->c3);
#endif
#if defined(PATH_lobe_exponent) && defined(HAS_LOBE_GENERALIZED_SCHLICK)
    path_set(c, PATH_lobe_exponent, slot, l->exponent);
#endif
#if defined(PATH_lobe_c4) && defined(HAS_LOBE_CHIANG_HAIR)
    path_set3(c, PATH_lobe_c4, slot, l->c4);
    path_set3(c, PATH_lobe_c5, slot, l->c5);
#endif
#ifdef PATH_lobe_film
#ifdef HAS_LOBE_THIN_FILM
    path_set(c, PATH_lobe_film, slot, l->film);
    path_set(c, PATH_lobe_film_ior, slot, l->film_ior);
#else
    // This material has no films, others of the scene have.
    path_set(c, PATH_lobe_film, slot, 0);
#endif
#endif
}

// The weight is not stored: it went into the path's throughput.
static inline Lobe load_lobe(const Context *c, uint slot)
{
    Lobe l = {0};
    uint kind = path_get_uint(c, PATHU_lobe, slot);
    l.type = kind & 255u;
    l.flags = kind >> 8;
    l.N = path_get3(c, PATH_lobe_N, slot);
#ifdef PATH_lobe_T
    l.T = path_get3(c, PATH_lobe_T, slot);
#endif
#ifdef PATH_lobe_ax
    l.ax = path_get(c, PATH_lobe_ax, slot);
    l.ay = l.ax;
#endif
#ifdef PATH_lobe_ay
    l.ay = path_get(c, PATH_lobe_ay, slot);
#endif
#ifdef PATH_lobe_eta
    l.eta = path_get(c, PATH_lobe_eta, slot);
#endif
#ifdef PATH_lobe_c0
    l.c0 = path_get3(c, PATH_lobe_c0, slot);
    l.c1 = path_get3(c, PATH_lobe_c1, slot);
#endif
#if defined(PATH_lobe_c2) && (defined(HAS_LOBE_GENERALIZED_SCHLICK) || defined(HAS_LOBE_CHIANG_HAIR))
    l.c2 = path_get3(c, PATH_lobe_c2, slot);
    l.c3 = path_get3(c, PATH_lobe_c3, slot);
#endif
#if defined(PATH_lobe_exponent) && defined(HAS_LOBE_GENERALIZED_SCHLICK)
    l.exponent = path_get(c, PATH_lobe_exponent, slot);
#endif
#if defined(PATH_lobe_c4) && defined(HAS_LOBE_CHIANG_HAIR)
    l.c4 = path_get3(c, PATH_lobe_c4, slot);
    l.c5 = path_get3(c, PATH_lobe_c5, slot);
#endif
#if defined(PATH_lobe_film) && defined(HAS_LOBE_THIN_FILM)
    l.film = path_get(c, PATH_lobe_film, slot);
    l.film_ior = path_get(c, PATH_lobe_film_ior, slot);
#endif
    return l;
}

#endif
