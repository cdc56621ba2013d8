"""The BSDFs of Mitsuba 3 around their singularities, by the measures of tests/tests/hard_cases_bsdf.rs, through sample, eval and pdf.

In: families of BSDFs and directions. Out: of each family the worst number of a kind, and what Mitsuba refused. Lobes that one of the two
renderers lacks are left out: rough glass, rough conductors, mirrors, smooth glass and diffuse stand for ours.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from on_mitsuba import ARRAYS, GOLD

ROUGHNESS = [0.0, 1e-7, 1e-5, 1e-4, 2e-4, 1e-3, 1e-2, 0.1, 1.0]


def angle(cosine):
    return 90 - np.degrees(np.arcsin(cosine))


def glass(a, b, ior, distribution):
    if a == 0 and b == 0:
        return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    return {"type": "roughdielectric", "alpha_u": a, "alpha_v": b, "int_ior": ior, "ext_ior": 1.0, "distribution": distribution}


def conductor(a, b, distribution, eta=None, k=None):
    ior = GOLD if eta is None else {"eta": {"type": "uniform", "value": eta}, "k": {"type": "uniform", "value": k}}
    if a == 0 and b == 0:
        return {"type": "conductor", **ior}
    return {"type": "roughconductor", "alpha_u": a, "alpha_v": b, "distribution": distribution, **ior}


def facets(a, b, ior, degrees):
    """As glass and as gold, in both distributions."""
    kinds = [glass(a, b, ior, d) for d in ("ggx", "beckmann")] + [conductor(a, b, d) for d in ("ggx", "beckmann")]
    return [(bsdf, degrees) for bsdf in kinds]


def families():
    diffuse = {"type": "diffuse", "reflectance": 1.0}
    cosines = [angle(c) for c in (1e-2, 1e-4, 1e-6, 1e-8)]
    critical = np.degrees(np.arcsin(1 / 1.5))
    around = [critical + d for d in (-1e-2, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-2)]
    flat = lambda lists: [x for l in lists for x in l]
    metals = [
        (conductor(a, a, "ggx", n, k), degrees)
        for n in (1e-3, 1.0, 1e3)
        for k in (0.0, 1.0, 1e3)
        for a, degrees in [(0.0, 30.0), (0.1, 0.0), (0.1, 60.0), (0.1, 85.0), (1e-3, 30.0)]
    ]
    near = (1 - 1e-7, 1 - 1e-6, 1.0, 1 + 1e-7, 1 + 1e-6)
    return {
        "roughness 0, 1e-7 .. 1": flat(facets(a, a, 1.5, d) for a in ROUGHNESS for d in (0.0, 60.0, 85.0)),
        "roughness 1e-4 : 1": flat(facets(1e-4, 1.0, 1.5, d) + facets(1.0, 1e-4, 1.5, d) for d in (0.0, 60.0, 85.0)),
        "cosines to 1e-8": flat(facets(0.1, 0.1, 1.5, d) + [(diffuse, d)] for d in cosines),
        "cosines to 1e-8, mirrors": flat(facets(0.0, 0.0, 1.5, d) for d in cosines),
        "ior 1 +- 1e-7": flat(
            facets(0.0, 0.0, e, 50.0) + facets(0.1, 0.1, e, 50.0) + facets(0.0, 0.0, e, angle(1e-4)) for e in near
        ),
        "the edge of total reflection": flat(facets(0.0, 0.0, 1 / 1.5, d) + facets(0.05, 0.05, 1 / 1.5, d) for d in around),
        "ior 1e-3 and 1e3": flat(facets(a, a, e, d) for e in (1e-3, 1e3) for d in (0.0, 60.0, 85.0) for a in (0.0, 0.2)),
        "conductors, n 1e-3 .. 1e3, k 0 .. 1e3": metals,
    }


def apart(a, b):
    return np.abs(a - b) > 0.05 * np.maximum(np.abs(a), np.abs(b)) + 1e-9


def share(which, of):
    return float((which & of).sum() / of.sum()) if of.any() else 0.0


def examine(bsdf, degrees, count, seed):
    """The numbers of one BSDF seen at an angle."""
    draw = np.random.default_rng(seed).random
    wo = np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))]).astype(np.float32)
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(wo.tolist())
    si.t, si.n, si.sh_frame = 1.0, mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    context = mi.BSDFContext()
    numbers = [draw(count).astype(np.float32) for _ in range(3)]
    sample, weight = bsdf.sample(context, si, mi.Float(numbers[0]), mi.Point2f(numbers[1], numbers[2]))
    f, pdf_of = bsdf.eval(context, si, sample.wo), bsdf.pdf(context, si, sample.wo)
    swapped = dr.copy(si)
    swapped.wi = sample.wo
    back = bsdf.eval(context, swapped, mi.Vector3f(wo.tolist()))
    array = lambda x: np.array(x).astype(float)
    many = lambda x: np.broadcast_to(array(x).reshape(3, -1), (3, count)).T
    one = lambda x: np.broadcast_to(array(x).ravel(), (count,))
    wi, value, f, back = many(sample.wo), many(weight), many(f), many(back)
    pdf, pdf_of, eta = one(sample.pdf), one(pdf_of), one(sample.eta)
    kind = np.broadcast_to(np.array(sample.sampled_type).ravel(), (count,)).astype(np.int64)
    # A sample that the BSDF rejects (a reflection below the surface) may come with the density that it was drawn with, and no value.
    drawn = ~(pdf == 0) & (~(value == 0) | ~(f == 0)).any(1)
    finite = lambda x: np.isfinite(x).all(1) if x.ndim == 2 else np.isfinite(x)
    fine = (
        finite(value) & finite(f) & finite(back) & finite(pdf) & finite(pdf_of) & (value >= 0).all(1) & (pdf >= 0) & (pdf_of >= 0)
    )
    fine &= ~drawn | (finite(wi) & (np.abs((wi * wi).sum(1) - 1) < 1e-4))
    # Radiance is scaled by the square of the ior across an interface; light itself is not.
    light = np.where(drawn, value.max(1) * np.where(kind & int(mi.BSDFFlags.Transmission) != 0, eta * eta, 1), 0)
    energy = light.mean() - 4.5 * light.std() / np.sqrt(count)
    rough = drawn & (kind & int(mi.BSDFFlags.Delta) == 0)
    both = rough & (kind & int(mi.BSDFFlags.Reflection) != 0) & (wi[:, 2] > 1e-2) & (wo[2] > 1e-2)
    return {
        "broken": int((~fine).sum()),
        "energy": energy,
        "pdf": share(apart(pdf, pdf_of), rough),
        "value": share(apart(value[:, 0], f[:, 0] / np.maximum(pdf_of, np.finfo(float).tiny)), rough),
        "reciprocity": share(apart(f[:, 0] * wo[2], back[:, 0] * wi[:, 2]), both),
    }


def measure(family, count):
    """The worst over a family, and the messages of refused ones."""
    mi.set_variant(ARRAYS)
    worst, refused, where = {}, [], {}
    for k, (description, degrees) in enumerate(families()[family]):
        try:
            bsdf = mi.load_dict(description)
        except Exception as e:
            refused.append(" ".join(str(e).split()))
            continue
        with np.errstate(all="ignore"):
            found = examine(bsdf, degrees, count, 1 + k)
        for name, x in found.items():
            if name == "broken":
                worst[name] = worst.get(name, 0) + x
                if x:
                    where[name] = f"{description} at {degrees} degrees"
            elif name not in worst or not x <= worst[name]:
                worst[name] = x
                where[name] = f"{description} at {degrees} degrees"
    return worst, refused, where


def random_numbers(count):
    """How many numbers of the independent sampler are outside [0, 1), and how far their mean is from 1/2."""
    mi.set_variant(ARRAYS)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, count)
    x = np.array(sampler.next_1d()).astype(float)
    return int(((x < 0) | (x >= 1)).sum()), abs(x.mean() - 0.5)
