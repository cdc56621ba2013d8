"""What each directory of the suite is about, and which ones cannot say anything about us."""

import re

# The first pattern that fits the directory's name decides.
CLASSES = [
    ("diagnostics", r"oslc-err|oslc-warn|error-|struct-err|allowconnect-err|function-redef|Werror|oslc-comma|opt-warnings"
                    r"|missing-shader|unknown-instruction|bug-param-duplicate|pragma-nowarn|oslc-pragma"),
    ("query", r"oslinfo|python-oslquery"),
    ("texture", r"texture|gettextureinfo|osl-imageio"),
    ("render", r"render-"),
    ("noise", r"noise|pnoise|cellnoise|hashnoise"),
    ("strings", r"string|printf|fprintf|format|test-fmt|regex|split|hash|draw_string"),
    ("groups", r"layers|connect|group|userdata|reparam|vararray|initops|mergeinstances|lockgeom|isconnected|lazy"
               r"|entry|globals-needed|closure-|struct-layers|bug-|paramval|isconstant|const-array-params|testshade-expr"),
    ("host", r"getattribute|message|xml|pointcloud|trace|raytype|camera|oslc-|compile-buffer|debug|getsymbol|compstats|exit"
             r"|shaderglobals|ocio"),
    ("other", r"example-|backend-cpp|testoptix"),
    ("language", r"."),
]

# Directories that ask for something that is no part of the language or of these tools.
NOT_APPLICABLE = {
    "python-oslquery": "tests the reference implementation's Python module",
    "example-batched-deformer": "builds a C++ program against the reference implementation's library",
    "example-cuda": "builds a C++ program against the reference implementation's library",
    "example-deformer": "builds a C++ program against the reference implementation's library",
    "backend-cpp": "tests the reference implementation's C++ back end",
    "testoptix": "tests the reference implementation's OptiX back end",
    "testoptix-noise": "tests the reference implementation's OptiX back end",
    "testoptix-reparam": "tests the reference implementation's OptiX back end",
    "osl-imageio": "tests a plug-in of OpenImageIO that runs OSL",
    "compstats": "prints compile statistics of the reference implementation's optimiser",
    "lazyglobals": "not among the tests that the suite registers",
    "oslc-empty": "not among the tests that the suite registers: dumps the reference compiler's own tables",
    "oslc-err-initlist": "not among the tests that the suite registers",
    "spline-nonuniformknots": "not among the tests that the suite registers",
    "groupdata-opt": "prints sizes of the reference implementation's internal group data",
}


def class_of(name):
    return next(kind for kind, pattern in CLASSES if re.match(pattern, name))
