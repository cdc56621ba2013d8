#!/usr/bin/env python3
"""Writes the OSL that MaterialX generates for every renderable element of .mtlx files, as a collection for run.py.

    pip install materialx==1.39.5
    tests/corpora/materialx.py -o shaders/materialx MaterialX/resources/Materials/

What it writes includes headers of MaterialX, which lie in the package's libraries (the last line printed names the folder).
"""

import argparse
import pathlib
import re
import sys

import MaterialX as mx
import MaterialX.PyMaterialXGenOsl as gen_osl
import MaterialX.PyMaterialXGenShader as gen_shader

LIBRARIES = pathlib.Path(mx.__file__).parent / "libraries"


def standard_library():
    library = mx.createDocument()
    mx.loadLibraries(["libraries"], mx.FileSearchPath(str(LIBRARIES.parent)), library)
    return library


def generator_of(library):
    generator = gen_osl.OslShaderGenerator.create()
    context = gen_shader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(LIBRARIES.parent)))
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(LIBRARIES)))
    generator.registerTypeDefs(library)
    colors = gen_shader.DefaultColorManagementSystem.create(generator.getTarget())
    colors.loadLibrary(library)
    generator.setColorManagementSystem(colors)
    units = gen_shader.UnitSystem.create(generator.getTarget())
    units.loadLibrary(library)
    registry = mx.UnitConverterRegistry.create()
    for kind in ("distance", "angle"):
        definition = library.getUnitTypeDef(kind)
        registry.addUnitConverter(definition, mx.LinearUnitConverter.create(definition))
    units.setUnitConverterRegistry(registry)
    generator.setUnitSystem(units)
    options = context.getOptions()
    options.targetDistanceUnit = "meter"
    options.fileTextureVerticalFlip = False
    return generator, context


def shaders_of(path, library, generator, context):
    """The name and text of the shader of each renderable element of a document; a reason where one can't be generated."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path), mx.FileSearchPath(str(path.parent)))
    document.setDataLibrary(library)
    for element in gen_shader.findRenderableElements(document):
        name = re.sub(r"\W", "_", f"{path.stem}_{element.getNamePath()}")
        try:
            yield name, generator.generate(name, element, context).getSourceCode(gen_shader.PIXEL_STAGE), None
        except Exception as error:  # the package raises its own kinds, and LookupError
            yield name, None, str(error).splitlines()[0]


def main():
    parser = argparse.ArgumentParser(description="Generates OSL from MaterialX documents.")
    parser.add_argument("documents", nargs="+", type=pathlib.Path, help=".mtlx files, or folders that hold some")
    parser.add_argument("-o", dest="output", required=True, type=pathlib.Path, help="the folder for the shaders")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    library = standard_library()
    generator, context = generator_of(library)
    written = failed = 0
    for given in args.documents:
        for path in sorted(given.rglob("*.mtlx")) if given.is_dir() else [given]:
            try:
                for name, text, reason in shaders_of(path, library, generator, context):
                    if text is None:
                        failed += 1
                        print(f"{path}: {name}: {reason}", file=sys.stderr)
                    else:
                        written += 1
                        (args.output / f"{name}.osl").write_text(text)
            except Exception as error:  # a document that the package can't read
                failed += 1
                print(f"{path}: {error}", file=sys.stderr)
    print(f"{written} shaders in {args.output}, {failed} not generated; headers: -I {LIBRARIES / 'stdlib/genosl/include'}")


if __name__ == "__main__":
    main()
