#!/usr/bin/env python3
"""Compiles public collections of shaders to OpenCL C, builds them on a device, and writes docs/reports/corpus.md.

Each argument is a folder with a collection, named in the report as its folder is; -I names folders with headers that the
collections need beside their own. The work is done by tests/src/bin/corpora.rs.

Example:
  tests/corpora/run.py -I ../MaterialX/libraries/stdlib/genosl/include ../shaders/*/
"""

import argparse
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def main():
    parser = argparse.ArgumentParser(description="Compiles collections of OSL shaders and builds them on a device.")
    parser.add_argument("folders", nargs="+", metavar="DIR", help="a collection")
    parser.add_argument("-I", dest="include", action="append", default=[], metavar="DIR", help="a folder of headers")
    parser.add_argument("--report", default=os.path.join(ROOT, "docs/reports/corpus.md"), help="where the report goes")
    parser.add_argument("--no-build", action="store_true", help="compile only")
    parser.add_argument("--dev", action="store_true", help="use the development profile")
    args = parser.parse_args()
    command = ["cargo", "run", "-q", "-p", "oslcl-tests", "--bin", "corpora"]
    command += [] if args.dev else ["--release"]
    command += ["--", "--report", os.path.abspath(args.report)]
    command += ["--no-build"] if args.no_build else []
    for folder in args.include:
        command += ["-I", os.path.abspath(folder)]
    for folder in args.folders:
        if not os.path.isdir(folder):
            sys.exit(f"corpora: {folder} is no folder")
        path = os.path.abspath(folder)
        command.append(f"{os.path.basename(path)}={path}")
    return subprocess.run(command, cwd=ROOT).returncode


if __name__ == "__main__":
    sys.exit(main())
