#!/usr/bin/env python3
"""Runs the test suite of the reference implementation of OSL with our tools, and writes a report.

The suite is a checkout of AcademySoftwareFoundation/OpenShadingLanguage whose folder OSL_SUITE_DIR names. Each directory's own
run.py is executed by the suite's own, unmodified runtest.py (see drive.py), with `oslc`, `oslinfo`, `testshade` and
`testrender` being ours. Then its outputs are compared with the stored references:

- text, line by line, after the directory's own filter. Lines that differ only in numbers, and by no more than 1e-5 relative
  or absolute or by one unit of the last digit that the reference prints, count as equal; the report says so ("numbers").
- pictures, by `oslcl compare` with the directory's own thresholds.
- directories about diagnostics: whether each file has errors and warnings on the lines of the reference's; wording is ours. In
  the text of other directories, such findings are compared in the same way, and all other lines as they are.

Examples:
  OSL_SUITE_DIR=../OpenShadingLanguage tests/osl-suite/run.py                    the whole suite
  OSL_SUITE_DIR=../OpenShadingLanguage tests/osl-suite/run.py 'noise-*' string   some directories, with what differs
"""

import argparse
import concurrent.futures
import difflib
import fnmatch
import glob
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from causes import CAUSES
from classes import CLASSES, NOT_APPLICABLE, class_of

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
TOOLS = ["oslc", "oslinfo", "testshade", "testrender"]
PICTURES = (".tif", ".exr", ".png")
TIMEOUT = 600  # seconds for a directory
NUMBERS_MAY_DIFFER = 1e-5
NOISE_OF_MEANS = 1  # percent of a picture's mean


def arguments():
    parser = argparse.ArgumentParser(description="Runs the reference implementation's test suite with our tools.")
    parser.add_argument("patterns", nargs="*", help="directories, also as patterns; default: all")
    parser.add_argument("--oslcl", default=os.path.join(ROOT, "target/release/oslcl"), help="our binary")
    parser.add_argument("--work", help="folder to run in; kept. Default: a temporary one")
    parser.add_argument("--report", help="write the report to this file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="directories at a time")
    parser.add_argument("-q", "--quiet", action="store_true", help="do not show what differs")
    return parser.parse_args()


def main():
    args = arguments()
    checkout = os.environ.get("OSL_SUITE_DIR")
    if not checkout:
        print("osl-suite: skipped: OSL_SUITE_DIR does not name a checkout of OpenShadingLanguage")
        return 0
    suite = os.path.abspath(os.path.join(checkout, "testsuite"))
    if not os.path.exists(os.path.join(suite, "runtest.py")):
        sys.exit(f"osl-suite: {checkout}: there is no testsuite/runtest.py")
    names = sorted(n for n in os.listdir(suite) if os.path.exists(os.path.join(suite, n, "run.py")))
    chosen = [n for n in names if not args.patterns or any(fnmatch.fnmatch(n, p) for p in args.patterns)]
    if not chosen:
        sys.exit(f"osl-suite: no directory is called {' or '.join(args.patterns)}")
    work = os.path.abspath(args.work or tempfile.mkdtemp(prefix="osl-suite-"))
    build = prepare(work, suite, os.path.abspath(args.oslcl))
    results = []
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        jobs = [pool.submit(directory, name, suite, work, build) for name in chosen]
        for job in concurrent.futures.as_completed(jobs):
            result = job.result()
            results.append(result)
            print(f"{result['outcome']:16} {result['name']:36} {result['seconds']:6.1f} s  {result['cause']}", flush=True)
            if not args.quiet and result["outcome"] == "fail":
                print(result["detail"])
    results.sort(key=lambda r: r["name"])
    print(summary(results))
    if args.report:
        with open(args.report, "w") as file:
            file.write(report(results, checkout))
    if not args.work:
        shutil.rmtree(work)
    return 0


def prepare(work, suite, oslcl):
    """A folder as the suite's build makes one: bin/ with the tools, testsuite/ with a folder per directory."""
    binaries = os.path.join(work, "bin")
    os.makedirs(binaries, exist_ok=True)
    for tool in TOOLS:
        link = os.path.join(binaries, tool)
        if os.path.lexists(link):
            os.remove(link)
        os.symlink(oslcl, link)
    folder = os.path.join(work, "testsuite")
    os.makedirs(folder, exist_ok=True)
    common = os.path.join(folder, "common")
    if not os.path.lexists(common):
        os.symlink(os.path.join(suite, "common"), common)
    return work


def directory(name, suite, work, build):
    """Runs one directory: name, class, outcome (pass, fail, not applicable, no reference), cause, detail, seconds."""
    start = time.time()
    outcome, cause, detail = judge(name, suite, work, build)
    return {
        "name": name,
        "class": class_of(name),
        "outcome": outcome,
        "cause": cause,
        "detail": detail,
        "seconds": time.time() - start,
    }


def judge(name, suite, work, build):
    source = os.path.join(suite, name)
    if name in NOT_APPLICABLE:
        return "not applicable", NOT_APPLICABLE[name], ""
    if not os.path.isdir(os.path.join(source, "ref")):
        return "no reference", "the suite compares two of its own back ends here", ""
    folder = os.path.join(work, "testsuite", name)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    found, said = execute(name, suite, folder, build)
    if found is None:
        return "fail", said.strip().splitlines()[-1] if said.strip() else "did not run", said
    out = read(os.path.join(folder, "out.txt"))
    if re.search(r"(oiiotool|maketx|idiff): (command )?not found", out):
        return "not applicable", "needs OpenImageIO's command line tools", out
    refs = os.path.join(source, "ref")
    if class_of(name) == "diagnostics":
        return diagnostics(out, refs, found)
    if found["code"] != 0:
        return "fail", first_error(out), out
    outputs = list(found["outputs"])
    # As runtest.py: these are compared whenever a reference is there.
    outputs += [o for o in ("out.exr", "out.tif") if o not in outputs and os.path.exists(os.path.join(refs, o))]
    notes, details = [], []
    for output in outputs:
        good, note, detail = compare(output, folder, refs, found, os.path.join(build, "bin", "oslc"))
        if not good:
            details.append(f"{output}: {detail}")
        if note:
            notes.append(note)
    if details and class_of(name) == "render" and "of the means" in details[0]:
        return "fail", render_cause(details[0]), "\n".join(details)
    if details:
        return "fail", new_error(out, refs) or details[0].split("\n")[0], "\n".join(details)
    return "pass", ", ".join(sorted(set(notes))), ""


def execute(name, suite, folder, build):
    """Runs the directory through the suite's script. What it decided (None if it did not end well), and what it said."""
    result = os.path.join(folder, ".result.json")
    environment = dict(
        os.environ,
        OSL_BUILD_DIR=build,
        OSL_SOURCE_DIR=os.path.dirname(suite),
        OSL_TESTSUITE_ROOT=suite,
        OSL_TESTSUITE_SRC=os.path.join(suite, name),
        OSL_TESTSUITE_CUR=folder,
        OSL_TESTSUITE_SKIP_DIFF="1",
    )
    command = [sys.executable, os.path.join(HERE, "drive.py"), os.path.join(suite, "runtest.py"), folder, build, result]
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        said = process.communicate(timeout=TIMEOUT)[0].decode(errors="replace")
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None, f"ran longer than {TIMEOUT} s"
    if not os.path.exists(result):
        return None, said
    with open(result) as file:
        return json.load(file), said


def compare(output, folder, refs, found, oslcl):
    """Compares an output with every reference that may stand for it: good or not, a note, what differs."""
    extension = os.path.splitext(output)[1]
    path = os.path.join(folder, output)
    if not os.path.exists(path):
        return False, "", "was not written"
    candidates = [os.path.join(refs, output)]
    candidates += [c for c in sorted(glob.glob(os.path.join(refs, "*" + extension))) if c not in candidates]
    candidates = [c for c in candidates if os.path.exists(c)]
    if not candidates:
        return False, "", "has no stored reference"
    first = None
    for candidate in candidates:
        if extension in PICTURES:
            good, note, detail = compare_pictures(path, candidate, found, oslcl)
        elif extension == ".txt":
            good, note, detail = compare_texts(path, candidate, found["filter_re"])
        else:
            good, note, detail = read(path) == read(candidate), "", "differs"
        if good:
            return True, note, ""
        first = first or detail
    return False, "", first


def compare_pictures(path, reference, found, oslcl):
    # oslcl behind one of its links: called by its own name for `compare`.
    command = [os.path.realpath(oslcl), "compare", path, reference]
    command += ["--fail", str(found["failthresh"]), "--hard-fail", str(found["hardfail"])]
    command += ["--fail-percent", str(found["failpercent"])]
    if found["idiff_program"] == "idiff":
        # runtest.py hands these on to idiff only.
        command += ["--fail-relative", str(found["failrelative"]), "--allow-failures", str(found["allowfailures"])]
    done = subprocess.run(command, capture_output=True, text=True)
    words = " ".join((done.stdout + done.stderr).split())
    return done.returncode == 0, "", words


def compare_texts(path, reference, pattern):
    ours, theirs = lines(path, pattern), lines(reference, pattern)
    if ours == theirs:
        return True, "", ""
    if len(ours) == len(theirs) and all(same_but_numbers(a, b) for a, b in zip(ours, theirs)):
        return True, "numbers", ""
    (ours_rest, ours_found), (theirs_rest, theirs_found) = without_findings(ours), without_findings(theirs)
    if theirs_found and ours_found == theirs_found and len(ours_rest) == len(theirs_rest):
        if all(same_but_numbers(a, b) for a, b in zip(ours_rest, theirs_rest)):
            return True, "wording of findings", ""
    difference = list(difflib.unified_diff(theirs, ours, "reference", "ours", n=0, lineterm=""))[2:]
    changed = [d for d in difference if not d.startswith("@@")]
    head = changed[0] if changed else "differs"
    partner = next((d for d in changed if d.startswith("+")), "")
    return False, "", f"{len(changed)} lines differ: {head} {partner if partner != head else ''}\n" + "\n".join(changed[:12])


NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:inf|nan)\b")


def same_but_numbers(a, b):
    if a == b:
        return True
    if NUMBER.split(a) != NUMBER.split(b):
        return False
    for x, y in zip(NUMBER.findall(a), NUMBER.findall(b)):
        if x == y:
            continue
        # Whole numbers are results, not roundings.
        if re.fullmatch(r"[-+]?\d+", x) and re.fullmatch(r"[-+]?\d+", y):
            return False
        p, q = float(x), float(y)
        if not abs(p - q) <= max(NUMBERS_MAY_DIFFER * max(1.0, abs(p), abs(q)), 1.01 * last_digit(y)):
            return False
    return True


def last_digit(number):
    """One unit of the last digit that is printed behind the point; 0 for whole numbers."""
    mantissa, _, exponent = number.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - digits) if digits else 0.0


def lines(path, pattern):
    keep = re.compile(pattern) if pattern else None
    return [l for l in read(path).splitlines() if keep is None or keep.match(l)]


FINDING = re.compile(r"^(?P<file>[^\s:]+):(?P<line>\d+): (?P<kind>error|warning):", re.MULTILINE)


# Words that stand for a failure; a warning may say "probably an error".
FAILURE = re.compile(r"\berror[:\[]|\bERROR\b|FAILED")


def without_findings(text_lines):
    """Lines that belong to no finding, and the places of the findings. What tells more of a finding is indented below it."""
    rest, places, inside = [], [], False
    for line in text_lines:
        found = FINDING.match(line)
        if found:
            places.append((found["file"], int(found["line"]), found["kind"]))
            inside = True
        elif not (inside and line[:1].isspace()):
            rest.append(line)
            inside = False
    return rest, sorted(places)


def findings(text):
    return {(m["file"], int(m["line"]), m["kind"]) for m in FINDING.finditer(text)}


def diagnostics(out, refs, found):
    """Errors and warnings on the same lines of the same files; where the reference names no line, an error where it has one."""
    ours = findings(out)
    first = None
    for candidate in sorted(glob.glob(os.path.join(refs, "out*.txt"))):
        text = read(candidate)
        theirs = findings(text)
        wanted = {(f, l) for f, l, kind in theirs if kind == "error"}
        got = {(f, l) for f, l, kind in ours if kind == "error"}
        missing, extra = sorted(wanted - got), sorted(got - wanted)
        warned = {(f, l) for f, l, kind in theirs if kind == "warning"}
        missing_warnings = sorted(warned - {(f, l) for f, l, kind in ours})
        said, we_said = bool(FAILURE.search(text)), bool(FAILURE.search(out))
        wrong = []
        for what, places in (("no error at", missing), ("an error at", extra), ("no warning at", missing_warnings)):
            if places:
                wrong.append(f"{what} " + ", ".join(f"{f}:{l}" for f, l in places[:6]))
        if not wrong and said != we_said:
            wrong.append("the reference reports an error" if said else "the reference reports no error")
        # Beside its findings, what a directory prints has to agree, unless it is the text of findings.
        if not wrong and not theirs and not said and text != out:
            same, _, wrong_text = compare_texts_of(out, text)
            if not same:
                wrong.append(wrong_text)
        if not wrong:
            return "pass", "", ""
        first = first or "; ".join(wrong)
    return "fail", (first or "no stored text").split("\n")[0], (first or "") + "\n" + out


def compare_texts_of(ours, theirs):
    a, b = ours.splitlines(), theirs.splitlines()
    if len(a) == len(b) and all(same_but_numbers(x, y) for x, y in zip(a, b)):
        return True, "", ""
    difference = [d for d in difflib.unified_diff(b, a, n=0, lineterm="") if not d.startswith(("@@", "---", "+++"))]
    return False, "", "\n".join(difference[:12])


def render_cause(detail):
    """Whether a picture is off as a whole, or only in its noise, which two renderers with other random numbers cannot share."""
    means = [abs(float(m)) for m in re.findall(r"([-+][\d.]+) %", detail.split("of the means")[1])]
    pixels = re.search(r"failing pixels \d+ \(([\d.]+) %\)", detail)
    if max(means, default=100) > NOISE_OF_MEANS:
        kind = "the means differ"
    elif pixels and float(pixels[1]) <= 1:
        # Sampler and random numbers are the same: a path turns elsewhere where rounding decides.
        kind = "the means agree: single paths that rounding turned elsewhere"
    else:
        kind = "the means agree: noise of other ways to sample"
    return f"{kind}; {detail.removeprefix('out.exr: ')}".split(" error:")[0]


def new_error(out, refs):
    """The first error that the reference does not report as well."""
    known = "".join(read(r) for r in glob.glob(os.path.join(refs, "out*.txt")))
    return next((l.strip()[:200] for l in out.splitlines() if FAILURE.search(l) and l.strip() not in known), None)


def first_error(out):
    wrong = [l for l in out.splitlines() if re.search(r"(?i)error|not supported|panicked", l)]
    return wrong[0].strip()[:200] if wrong else "a command failed"


def read(path):
    with open(path, errors="replace") as file:
        return file.read()


OUTCOMES = ["pass", "fail", "not applicable", "no reference"]


def table(results):
    rows = ["| class | directories | pass | fail | not applicable | no stored reference | pass of those that can |",
            "|---|--:|--:|--:|--:|--:|--:|"]
    kinds = [kind for kind, _ in sorted(CLASSES)] + ["all"]
    for kind in kinds:
        mine = [r for r in results if kind in ("all", r["class"])]
        if not mine:
            continue
        count = {o: sum(r["outcome"] == o for r in mine) for o in OUTCOMES}
        can = count["pass"] + count["fail"]
        part = f"{100 * count['pass'] / can:.1f} %" if can else "-"
        rows.append(f"| {kind} | {len(mine)} | " + " | ".join(str(count[o]) for o in OUTCOMES) + f" | {part} |")
    return "\n".join(rows)


def summary(results):
    return table(results)


def report(results, checkout):
    version = subprocess.run(["git", "-C", checkout, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    escape = lambda text: text.replace("|", "\\|").replace("<", "&lt;")
    parts = [
        "# The reference implementation's test suite\n",
        "Written by `make osl-suite` (tests/osl-suite/run.py), which runs each directory of the suite of "
        "AcademySoftwareFoundation/OpenShadingLanguage, at commit "
        f"{version.stdout.strip() or 'unknown'}, through the suite's own unmodified scripts with our `oslc`, `oslinfo`, "
        "`testshade` and `testrender`.\n",
        "Text must be the same line by line; `numbers`: lines differ in the last digits of numbers only, by no more than 1e-5 or one unit of the last digit. "
        "Pictures must be within the directory's own thresholds. Of diagnostics the wording is ours: each error must stand on "
        "the reference's line, and none elsewhere; a warning of the reference must have a finding on its line. The causes of failures were "
        "found by hand (tests/osl-suite/causes.py).\n",
        table(results) + "\n",
    ]
    for title, outcome in (("Fails", "fail"), ("Not applicable", "not applicable"), ("Passes", "pass"),
                           ("No stored reference", "no reference")):
        mine = [r for r in results if r["outcome"] == outcome]
        if not mine:
            continue
        parts.append(f"## {title}\n")
        if outcome == "no reference":
            parts.append(", ".join(r["name"] for r in mine) + "\n")
            continue
        heads = {"fail": ["cause", "what differs"], "pass": ["note"]}.get(outcome, ["cause"])
        table_row = lambda cells: "| " + " | ".join(cells) + " |"
        parts.append(table_row(["directory", "class", *heads]) + "\n|" + "---|" * (2 + len(heads)))
        known = lambda r: [CAUSES.get(r["name"], "not known")] if outcome == "fail" else []
        cells = lambda r: [r["name"], r["class"], *map(escape, known(r) + [r["cause"]])]
        parts.append("\n".join(table_row(cells(r)) for r in mine) + "\n")
    return "\n".join(parts)


if __name__ == "__main__":
    sys.exit(main())
