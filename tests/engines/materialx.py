# SPDX-License-Identifier: MIT OR Apache-2.0
"""MaterialX writes its shaders, and the EXR files of brdf-baker become numbers that a page can read.

usage: materialx.py FOLDER NAME...

Writes materialx.json, which holds the GLSL ES of a vertex stage and of three pixel stages: a surface, MaterialX' own filter
of environments, its own table of albedos; and NAME.f32 for every NAME.exr: its parts one after the other, four values a
texel, the sizes of the parts under `sizes` of materialx.json.
"""

import json
import pathlib
import sys

import MaterialX as mx
import numpy as np
import OpenEXR
from MaterialX import PyMaterialXGenGlsl as glsl
from MaterialX import PyMaterialXGenShader as shader

# A Fresnel layer over Lambert's: a metal where the base is black, and what all surfaces of MaterialX are made of.
SURFACE = """<?xml version="1.0"?>
<materialx version="1.39">
  <generalized_schlick_bsdf name="top" type="BSDF" />
  <oren_nayar_diffuse_bsdf name="base" type="BSDF" />
  <layer name="both" type="BSDF">
    <input name="top" type="BSDF" nodename="top" />
    <input name="base" type="BSDF" nodename="base" />
  </layer>
  <surface name="surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="both" /></surface>
</materialx>
"""

# Where shaders take directional albedos from: hwDirectionalAlbedoMethod, an option that the bindings lack.
TABLE, MONTE_CARLO = 1, 2


def stages(document, albedo, **flags):
    """Vertex and pixel stage of the surface."""
    generator = glsl.EsslShaderGenerator.create()
    context = shader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    options = context.getOptions()
    options.hwSpecularEnvironmentMethod = shader.SPECULAR_ENVIRONMENT_PREFILTER
    options.hwMaxActiveLightSources = 0
    for name, value in flags.items():
        setattr(options, name, value)
    made = generator.generate("surface", document.getDescendant("surface"), context)
    pixel = made.getSourceCode(shader.PIXEL_STAGE)
    method = "#define DIRECTIONAL_ALBEDO_METHOD "
    assert pixel.count(method + "0") == 1, "MaterialX says otherwise which albedo it takes"
    sampler = "uniform sampler2D u_albedoTable;\n" if albedo == TABLE else ""
    pixel = pixel.replace(method + "0", sampler + method + str(albedo))
    ports = {}
    for block in made.getStage(shader.PIXEL_STAGE).getUniformBlocks().values():
        for i in range(len(block)):
            value = block[i].getValue()
            if value is not None:
                ports[block[i].getVariable()] = [block[i].getType().getName(), value.getValueString()]
    return made.getSourceCode(shader.VERTEX_STAGE), pixel, ports


def numbers(path):
    """The parts of an EXR file, from the largest one, as f32 and their sizes."""
    texels = []
    for part in OpenEXR.File(str(path), separate_channels=True).parts:
        red = part.channels["R"].pixels
        planes = [part.channels[name].pixels if name in part.channels else np.zeros_like(red) for name in "RGB"]
        texels.append(np.dstack([*planes, np.ones_like(red)]).astype("<f4"))
    return b"".join(t.tobytes() for t in texels), [[t.shape[1], t.shape[0]] for t in texels]


def main(folder, names):
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document = mx.createDocument()
    document.setDataLibrary(library)
    mx.readFromXmlString(document, SURFACE)
    valid, message = document.validate()
    assert valid, message

    vertex, surface, ports = stages(document, TABLE)
    _, table, _ = stages(document, MONTE_CARLO, hwWriteAlbedoTable=True)
    _, prefilter, _ = stages(document, MONTE_CARLO, hwWriteEnvPrefilter=True)
    # Where GLSL takes an integer for a float, GLSL ES does not.
    table = table.replace("gl_FragCoord.xy / u_albedoTableSize", "gl_FragCoord.xy / float(u_albedoTableSize)")
    prefilter = prefilter.replace("pow(2.0, u_envPrefilterMip)", "pow(2.0, float(u_envPrefilterMip))")
    sizes = {}
    for name in names:
        data, sizes[name] = numbers(folder / f"{name}.exr")
        (folder / f"{name}.f32").write_bytes(data)
    written = {
        "version": mx.getVersionString(), "vertex": vertex, "surface": surface, "ports": ports,
        "table": table, "prefilter": prefilter, "sizes": sizes,
    }
    (folder / "materialx.json").write_text(json.dumps(written, indent=1))


main(pathlib.Path(sys.argv[1]), sys.argv[2:])
