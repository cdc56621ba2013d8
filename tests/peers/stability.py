#!/usr/bin/env python3
"""Measures the hard cases of docs/numerics.md in other renderers beside oslcl, and writes a report.

Each case is rendered or shot from the same meshes, with the same number of samples or the same rays, in

- oslcl: the binary, 32-bit floats unless --precision says otherwise; rays are shot by trace() of a shader. What only our own tests can
  measure is taken from docs/reports/stability.md, in a column of its own.
- Mitsuba 3 (`pip install mitsuba`): pictures in scalar_rgb, rays and BSDFs in llvm_ad_rgb, which needs LLVM 16 or newer, on new
  processors 19: name its library by DRJIT_LIBLLVM_PATH if an older one is found first. Once with the default ray test, once with
  Embree's robust mode.
- Cycles, as Blender's Python module (`pip install bpy`, which wants the Python version of its wheel). Rays are shot by a camera of
  its own, an OSL shader.

Everything stays at its default but what would trade light for noise on purpose (see on_*.py): Russian roulette, adaptive sampling,
denoising, clamping and the like are off, filters are a box of one pixel, and clipping planes scale with the scene.
A renderer that is not installed is left out with a note. Each runs in a process of its own; a case that ends it is a row, too.
Also needed: numpy, OpenEXR.

Examples:
  tests/peers/stability.py                                             all cases in all renderers that are installed
  tests/peers/stability.py --only 'geometry|lights' --in cycles        some cases in one renderer, as text
  tests/peers/stability.py --report docs/reports/stability-peers.md    the report of the repository
"""

import argparse
import importlib
import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
OURS = os.path.join(ROOT, "docs/reports/stability.md")
RENDERERS = {
    "oslcl": ("on_oslcl", "oslcl"),
    "mitsuba": ("on_mitsuba", "Mitsuba 3"),
    "robust": ("on_mitsuba", "Mitsuba 3, robust"),
    "cycles": ("on_cycles", "Cycles"),
}
NEEDS = {"mitsuba": "mitsuba", "robust": "mitsuba", "cycles": "bpy"}
# Embree's robust mode changes rays, not lobes or numbers.
ROBUST_GROUPS = ("geometry", "scenes")
TIMEOUT = 300  # seconds without a result


def arguments():
    parser = argparse.ArgumentParser(description="Measures the hard cases in other renderers beside oslcl.")
    parser.add_argument("--only", default="", help="cases whose group and name this regular expression finds; default: all")
    parser.add_argument("--in", dest="renderers", nargs="*", choices=list(RENDERERS), default=list(RENDERERS), help="renderers")
    parser.add_argument("--oslcl", default=os.path.join(ROOT, "target/release/oslcl"), help="our binary")
    parser.add_argument("--precision", default="standard", choices=["standard", "fast", "reference"], help="of oslcl")
    parser.add_argument("--report", help="write the report to this file")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    parser.add_argument("--skip", type=int, default=0, help=argparse.SUPPRESS)
    return parser.parse_args()


def chosen(args):
    from cases import all_cases

    cases = [c for c in all_cases() if re.search(args.only, f"{c.group}: {c.name}")]
    if not cases:
        sys.exit(f"stability: no case is found by {args.only!r}")
    return cases


def main():
    args = arguments()
    if args.child:
        return child(args)
    for name in ("numpy", "OpenEXR"):
        if importlib.util.find_spec(name) is None:
            sys.exit(f"stability: the Python package {name} is needed")
    cases = chosen(args)
    versions, found = {}, {}
    for name in args.renderers:
        if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None:
            print(f"stability: skipped: {RENDERERS[name][1]}: the Python package {NEEDS[name]} is not installed")
            continue
        start = time.time()
        versions[name], found[name] = measure(args, name, cases)
        print(f"{RENDERERS[name][1]}: {time.time() - start:.0f} s", flush=True)
    text = report(cases, versions, found, args)
    if args.report:
        with open(args.report, "w") as file:
            file.write(text)
    else:
        print(text)
    return 0


def applies(case, name):
    return name in case.only and (name != "robust" or case.group in ROBUST_GROUPS)


def measure(args, name, cases):
    """Runs all cases in a process; begins anew behind a case that ended it. The version, and by index a number or a text."""
    version, results, skip = "", {}, 0
    with tempfile.TemporaryDirectory(prefix="oslcl-peers-") as folder:
        while skip < len(cases):
            command = [sys.executable, "-W", "ignore", __file__, "--child", name, "--skip", str(skip)]
            command += ["--only", args.only, "--oslcl", args.oslcl, "--precision", args.precision]
            log = open(os.path.join(folder, "log"), "w+")
            process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=log, text=True)
            current = skip
            for line in process.stdout:
                # Renderers print lines of their own.
                if not line.startswith("{"):
                    continue
                said = json.loads(line)
                if "version" in said:
                    version = said["version"]
                elif "begin" in said:
                    current = said["begin"]
                else:
                    results[said["index"]] = said["value"]
                    print(f"{name:8} {cases[said['index']].group}: {cases[said['index']].name}: {show(said['value'])}", flush=True)
            if process.wait() == 0:
                return version, results
            log.seek(0)
            lines = log.read().strip().splitlines()
            if not version:
                sys.exit(f"stability: {RENDERERS[name][1]} does not start: {lines[-1] if lines else process.returncode}")
            results[current] = f"ends the process (code {process.returncode})"
            print(f"{name:8} {cases[current].name}: {results[current]}: {' '.join(lines[-3:])}", flush=True)
            skip = current + 1
    return version, results


def child(args):
    """Runs the cases of one renderer; says a line for each."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what the renderer prints is no result
    say = lambda **line: print(json.dumps(line), file=out, flush=True)
    renderer = importlib.import_module(RENDERERS[args.child][0])
    if args.child == "oslcl":
        renderer.BINARY, renderer.PRECISION = os.path.abspath(args.oslcl), args.precision
    if args.child == "robust":
        renderer.ROBUST = True
    say(version=renderer.version())
    for index, case in enumerate(chosen(args)):
        if index < args.skip or not applies(case, args.child):
            continue
        say(begin=index)
        try:
            value = case.measure(renderer, os.getcwd())
        except NotImplementedError as e:
            value = f"- ({e})"
        except Exception as e:
            # The last of nested messages says what is wrong.
            words = re.split(r"\[\w+\.\w+:\d+\] ", " ".join(str(e).split()))[-1]
            value = f"- (refused: {words[:160]})"
        say(index=index, value=value)
    return 0


def show(x):
    """A number with as many digits as say something."""
    if isinstance(x, str):
        return x
    if isinstance(x, list):
        return show(x[0])
    if x != x or x in (float("inf"), float("-inf")):
        return str(x)
    if x == int(x) and abs(x) < 1e6:
        return f"{x:.0f}"
    if abs(x - 1) < 1e-3:
        return short(f"1 {'+' if x > 1 else '-'} {abs(x - 1):.1e}")
    return f"{x:.4g}" if 1e-3 <= abs(x) < 1e4 else short(f"{x:.2e}")


def short(text):
    """Exponents without zeros in front."""
    return re.sub(r"e([-+])0*(\d)", lambda m: f"e{m[1].replace('+', '')}{m[2]}", text)


def beyond(case, value):
    """Whether a number is beyond the bound and its noise. Texts that begin with a number count by it."""
    if isinstance(value, str):
        number = re.match(r"[\d.]+(e[-+]?\d+)?", value)
        return bool(number) and float(number[0]) > case.bound or value.startswith("ends")
    if isinstance(value, list):
        return not value[0] <= case.bound + value[1]
    return not value <= case.bound


def own_rows():
    """The rows of our own report's first device: by name the number in 32-bit floats, and the device."""
    rows, device = {}, None
    with open(OURS) as file:
        for line in file:
            if line.startswith("## "):
                if device:
                    break
                device = line[3:].strip()
            cells = [c.strip() for c in line.strip().strip("|").split(" | ")]
            if len(cells) == 6 and cells[0] not in ("group", "---"):
                rows[cells[1]] = cells[3]
    return rows, device


def cell(case, name, results, index):
    if not applies(case, name):
        return f"- ({case.why})" if case.why and name != "oslcl" else "-"
    value = results.get(index)
    if value is None:
        return "-"
    text = show(value).replace("|", "\\|").replace("<", "&lt;")
    if isinstance(value, list) and not value[0] <= case.bound:
        text += f" (noise {show(value[1])})"
    return f"**{text}**" if beyond(case, value) else text


def report(cases, versions, found, args):
    rows, device = own_rows()
    names = [n for n in RENDERERS if n in found]
    parts = ["# The hard cases in other renderers\n"]
    parts.append(
        "Written by `tests/peers/stability.py`; do not edit. Each row is one measured number, beside the bound that our own tests hold it to "
        "([stability.md](stability.md), [numerics.md](../numerics.md)): smaller is better, **bold** is beyond the bound. The same meshes, "
        "the same rays or numbers of samples, and the same measure in each renderer.\n"
    )
    said = [f"{versions[n]}" for n in names if n != "robust"]
    parts.append(
        "Versions: "
        + ", ".join(said)
        + f' (oslcl in `--precision {args.precision}`). Column "our own test": from stability.md, on {device}.\n'
    )
    parts.append(NOTES)
    parts.append(summary(cases, names, found))
    parts.append(worse(cases, names, found))
    group = None
    for index, case in enumerate(cases):
        if case.group != group:
            group = case.group
            here = [n for n in names if n != "robust" or group in ROBUST_GROUPS]
            titles = " | ".join(RENDERERS[n][1] for n in here)
            parts.append(f"\n## {group}\n\n| case | bound | our own test | {titles} |\n|---|--:|--:|" + "--:|" * len(here))
        cells = [cell(case, n, found[n], index) for n in here]
        parts.append(f"| {case.name} | {show(case.bound)} | {rows.get(case.own or case.name, '-')} | " + " | ".join(cells) + " |")
    parts.append("\n## Rows of our own report without another renderer\n\n| row | why |\n|---|---|")
    used = {c.own or c.name for c in cases}
    for reason, names in grouped(n for n in rows if n not in used):
        parts.append(f"| {'; '.join(names[:3])}{f'; and {len(names) - 3} more' if len(names) > 3 else ''} | {reason} |")
    return "\n".join(parts) + "\n"


def worse(cases, names, found):
    """Rows of errors, leaks and shares in which oslcl's number is more than twice the smallest of the others."""
    lines = ["\nWhere oslcl's number is more than twice the smallest of the others' (of small errors of means, much is chance):\n"]
    lines.append("| row | bound | oslcl | smallest |\n|---|--:|--:|--:|")
    first = lambda value: value[0] if isinstance(value, list) else value
    for index, case in enumerate(cases):
        numbers = {n: first(found[n][index]) for n in names if isinstance(found[n].get(index), (int, float, list))}
        if "oslcl" not in numbers or len(numbers) < 2 or case.name.endswith((": mean", "white room")) or "noise at" in case.name:
            continue
        ours, best = numbers.pop("oslcl"), min(numbers, key=numbers.get)
        if ours > max(2 * numbers[best], 1e-6):
            row = [f"{case.group}: {case.name}", show(case.bound), show(ours), f"{RENDERERS[best][1]}: {show(numbers[best])}"]
            lines.append(f"| {' | '.join(row)} |")
    return "\n".join(lines) if len(lines) > 2 else "\nIn no row is oslcl's number more than twice the smallest of the others'."


def grouped(names):
    """Names by the reason why they stand alone."""
    out = {}
    for name in names:
        reason = next((why for part, why in NOT_ELSEWHERE if part in name), "not asked for by --only")
        out.setdefault(reason, []).append(name)
    return out.items()


def summary(cases, names, found):
    """How many rows of a group are within their bounds, of those that a renderer can say."""
    from cases import SIDE

    lines = ["Rows within their bounds, of those that were measured:\n"]
    lines.append("| group | " + " | ".join(RENDERERS[n][1] for n in names) + " |\n|---|" + "--:|" * len(names))
    for group in dict.fromkeys(c.group for c in cases):
        counts = []
        for n in names:
            mine = [(c, found[n][i]) for i, c in enumerate(cases) if c.group == group and i in found[n]]
            mine = [(c, v) for c, v in mine if not (isinstance(v, str) and v.startswith("- ("))]
            counts.append(f"{sum(not beyond(c, v) for c, v in mine)} of {len(mine)}" if mine else "-")
        lines.append(f"| {group} | " + " | ".join(counts) + " |")
    leaks = [i for i, c in enumerate(cases) if "leaks through" in c.name and "1e7 away" not in c.name]
    count = lambda value: int(str(value).split()[0]) if str(value)[:1].isdigit() else 0
    if leaks:
        total = [str(sum(count(found[n].get(i)) for i in leaks)) for n in names]
        rays = len(leaks) * SIDE * SIDE
        lines.append(f"| leaks through edges and vertices in {rays:,} rays, those 1e7 away left out | " + " | ".join(total) + " |")
    return "\n".join(lines)


NOTES = """What to know before comparing:

- "Mitsuba 3, robust": its scene setting `embree_use_robust_intersections`, off by default. It does not reach into groups that instances
  share.
- Corners and rays are 32-bit floats in world space. oslcl holds a mesh relative to the camera instead, but a shader's rays, by which this
  script shoots, start in world space, too: where all is 1e7 away, no renderer here can be told rays that are exact to a unit, and only
  our own test, whose rays are relative to the camera, says something of oslcl.
- Where chance counts, 4.5 sigma of the mean (by the pixels' scatter) or of a pixel (by the same scene without what is hard) are allowed
  beside the bound, and stand as "noise". oslcl samples constant skies by the lobe alone, so that white rooms have none.
- The cases are ours: they were chosen for what oslcl had to be made to hold. Other renderers make other promises, for scenes of ordinary
  sizes.
- Rows with nothing in the column of our own test are measured here only. Their bound is that of a like row.
- A bound from above does not tell a picture that came out black: a brightest pixel of 0 is one.
- Mirrors with smooth normals lose light at their rims in oslcl, which absorbs what would be reflected below the surface; the others do not.
"""

# Why a row of our own report has no other renderer beside it: by what its name contains, the first that fits.
NOT_ELSEWHERE = [
    ("samples repaired", "held in each picture: what is wrong with a film stands in the place of its number"),
    ("intersection=", "tests against triangles that oslcl offers as a choice"),
    ("leaks of all of these", "the sum of the rows above; see the head of this report"),
    ("1e7 away with its camera", "a case of rays relative to the camera"),
    ("relative error of the sum", "the sum of a film can't be called; see the sky of 0.1"),
    ("without compensation", "the sum of a film can't be called; see the sky of 0.1"),
    ("one pixel of 2^24 samples", "a sky by an expression; see the sky of 0.1"),
    ("past 2^32", "no such function: counters can't be set"),
    ("what paths lose or gain", "where paths also sample the sky, each brings a part of its light"),
    ("random number", "no such function: random numbers can't be made from given bits"),
    ("counters from", "no such function: a generator's counter can't be set"),
    ("too much for f32", "a counter of oslcl's render summary"),
]

if __name__ == "__main__":
    sys.exit(main())
