# SPDX-License-Identifier: MIT OR Apache-2.0
"""Blender (Cycles) as a Python module: six lights in a panorama of brdf-baker, on spheres and behind them.

blender.py FOLDER: reads lights.json and blender.exr, writes blender-lights.f32 and blender-background.f32.
"""

import array
import json
import math
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

folder = Path(sys.argv[1]).resolve()
layout = json.loads((folder / "lights.json").read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene

# The panorama behind everything, as a user sets it.
world = bpy.data.worlds.new("World")
scene.world = world
texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
texture.image = bpy.data.images.load(str(folder / "blender.exr"))
background = world.node_tree.nodes["Background"]
world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
assert texture.image.colorspace_settings.name == "Linear Rec.709", texture.image.colorspace_settings.name

# The picture's right, up and viewer are Blender's +X, +Z and -Y: its front view.
FRONT = Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))

spheres = []
for sphere in layout["spheres"]:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=layout["radius"])
    thing = bpy.context.object
    thing.location = FRONT @ Vector((*sphere["centre"], 0))
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new("material")
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*sphere["colour"], 1)
    surface.inputs["Metallic"].default_value = sphere["metallic"]
    surface.inputs["Roughness"].default_value = sphere["roughness"]
    thing.data.materials.append(material)
    # Spheres do not see each other: each shows the panorama only.
    thing.visible_diffuse = thing.visible_glossy = thing.visible_shadow = False
    spheres.append(thing)

scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 32
scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type = "BOX"
scene.cycles.filter_width = 0.01
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.color_mode = "RGBA"


def render(camera, width, height):
    """Radiance, rows from the top, four values a pixel."""
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = width, height
    path = folder / "blender-render.exr"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = array.array("f", image.pixels[:])
    bpy.data.images.remove(image)
    row = 4 * width
    rows = [pixels[at : at + row] for at in range(0, len(pixels), row)]
    return [value for row in reversed(rows) for value in row]


def camera(towards, up, **settings):
    """A camera that looks along a direction of the picture's frame."""
    data = bpy.data.cameras.new("camera")
    for name, value in settings.items():
        setattr(data, name, value)
    thing = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(thing)
    z = -Vector(towards).normalized()
    y = Vector(up)
    x = y.cross(z)
    thing.matrix_world = (FRONT @ Matrix((x, y, z)).transposed()).to_4x4()
    return thing


columns, rows = layout["tiles"]
width, height = layout["size_px"]
front = camera((0, 0, -1), (0, 1, 0), type="ORTHO", ortho_scale=max(columns, rows))
front.location = FRONT @ Vector((0, 0, 10))
picture = render(front, width, height)
(folder / "blender-lights.f32").write_bytes(array.array("f", picture).tobytes())

for thing in spheres:
    thing.hide_render = True
seen = []
LOOKS = [((1, 0, 0), (0, 1, 0)), ((-1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)),
         ((0, -1, 0), (0, 0, -1)), ((0, 0, 1), (0, 1, 0)), ((0, 0, -1), (0, 1, 0))]
for towards, up in LOOKS:
    look = render(camera(towards, up, type="PERSP", angle=math.radians(60)), 16, 16)
    seen += look[4 * (16 * 8 + 8) : 4 * (16 * 8 + 9)]
(folder / "blender-background.f32").write_bytes(array.array("f", seen).tobytes())
