"""Runs one directory of the reference implementation's suite with its own, unmodified runtest.py, and notes what it decided.

Usage: drive.py RUNTEST WORK_FOLDER BUILD_FOLDER RESULT

The suite's script reads its arguments from the command line and the environment (set by run.py), executes the directory's
run.py and every command of it; with OSL_TESTSUITE_SKIP_DIFF it leaves the comparison to us. RESULT becomes a JSON object:
`code` (its exit code), and the variables of the directory that say what to compare and how closely.
"""

import json
import sys

NAMES = (
    "command outputs failthresh hardfail failpercent failrelative allowfailures failureok filter_re idiff_program".split()
)


def main():
    runtest, work, build, result = sys.argv[1:5]
    sys.argv = [runtest, work, build]
    scope = {"__name__": "__main__", "__file__": runtest}
    code = 0
    try:
        with open(runtest) as file:
            exec(compile(file.read(), runtest, "exec"), scope)
    except SystemExit as end:
        code = end.code or 0
    found = {name: scope.get(name) for name in NAMES}
    found["code"] = code
    with open(result, "w") as file:
        json.dump(found, file)


main()
