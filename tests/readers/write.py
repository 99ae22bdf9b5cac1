# SPDX-License-Identifier: MIT OR Apache-2.0
"""Writes environments with OpenEXR, OpenImageIO and Pillow, as other programs do, and states what they hold.

Usage: write.py FOLDER. `cargo run --example read_inputs -- FOLDER` reads them back.
"""

import json
import pathlib
import sys

import numpy
import OpenEXR
import OpenImageIO as oiio
from PIL import Image

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
WIDTH, HEIGHT = 64, 32
entries = []

y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(numpy.float32)
# Smooth, so that lossy compressions stay near; halves hold every value.
PICTURE = numpy.stack([1 + x / 64, 2 + y / 32, 1 + (x + y) / 128], axis=-1).astype(numpy.float16).astype(numpy.float32)


def state(name, pixels, tolerance, part=None, notes=0):
    probes = [(0, 0), (5, 3), (WIDTH - 1, 0), (0, HEIGHT - 1), (33, 17), (WIDTH - 1, HEIGHT - 1)]
    values = [{"x": px, "y": py, "rgb": [float(v) for v in pixels[py, px]]} for px, py in probes]
    entries.append({"file": name, "tolerance": tolerance, "part": part, "notes": notes, "probes": values})


def write_oiio(name, pixels, format, attributes, channels=None, tile=None):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], format)
    if channels:
        spec.channelnames = channels
    if tile:
        spec.tile_width, spec.tile_height = tile
    for key, value in attributes.items():
        if key == "display":
            spec.full_x, spec.full_y, spec.full_width, spec.full_height = value
        elif key == "data":
            spec.x, spec.y = value
        else:
            spec.attribute(key, value)
    out = oiio.ImageOutput.create(str(folder / name))
    if not out or not out.open(str(folder / name), spec) or not out.write_image(pixels) or not out.close():
        sys.exit(f"write.py: {name}: {oiio.geterror()}")


# Every compression, half and float, scan lines and tiles. Lossy ones within what their makers say.
LOSSY = {"b44": 0.02, "b44a": 0.02, "dwaa": 0.02, "dwab": 0.02}
for compression in ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]:
    for format in ["half", "float"]:
        for tile in [None, (16, 16)]:
            name = f"{compression}_{format}{'_tiles' if tile else ''}.exr"
            write_oiio(name, PICTURE, format, {"compression": compression}, tile=tile)
            state(name, PICTURE, LOSSY.get(compression, 1e-4 if compression == "pxr24" else 0.0))

# Tiles with mips: the largest level counts.
buffer = oiio.ImageBuf(oiio.ImageSpec(WIDTH, HEIGHT, 3, "half"))
buffer.set_pixels(oiio.ROI(), PICTURE)
if not oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, buffer, str(folder / "mips.exr")):
    sys.exit(f"write.py: mips.exr: {oiio.geterror()}")
state("mips.exr", PICTURE, 0.0)

# Grey, and colour with alpha and depth.
write_oiio("grey.exr", PICTURE[..., :1].copy(), "half", {}, channels=["Y"])
state("grey.exr", numpy.repeat(PICTURE[..., :1], 3, axis=-1), 0.0)
extra = numpy.concatenate([PICTURE, numpy.full((HEIGHT, WIDTH, 2), 7, numpy.float32)], axis=-1)
write_oiio("rgbaz.exr", extra, "half", {}, channels=["R", "G", "B", "A", "Z"])
state("rgbaz.exr", PICTURE, 0.0)

# A data window inside the display window, and one around it.
inner = numpy.zeros_like(PICTURE)
inner[4:20, 10:40] = PICTURE[4:20, 10:40]
write_oiio("inside.exr", inner[4:20, 10:40].copy(), "half", {"data": (10, 4), "display": (0, 0, WIDTH, HEIGHT)})
state("inside.exr", inner, 0.0, notes=1)
outer = numpy.pad(PICTURE, ((3, 2), (1, 4), (0, 0)), constant_values=9)
write_oiio("around.exr", outer, "half", {"data": (-1, -3), "display": (0, 0, WIDTH, HEIGHT)})
state("around.exr", PICTURE, 0.0, notes=1)

# Two parts, and two layers in one part.
parts = [
    OpenEXR.Part({}, {"Z": PICTURE[..., 0].copy()}, name="depth"),
    OpenEXR.Part({}, {"RGB": PICTURE}, name="beauty"),
    OpenEXR.Part({}, {"RGB": 2 * PICTURE}, name="twice"),
]
OpenEXR.File(parts).write(str(folder / "parts.exr"))
state("parts.exr", PICTURE, 0.0)
state("parts.exr", 2 * PICTURE, 0.0, part="twice")
names = [f"{side}.{channel}" for side in ["left", "right"] for channel in "RGB"]
write_oiio("stereo.exr", numpy.concatenate([PICTURE, 3 * PICTURE], axis=-1), "float", {}, channels=names)
state("stereo.exr", 3 * PICTURE, 0.0, part="right")

# Radiance HDR, run lengths included; 16-bit PNG; JPEG.
write_oiio("plain.hdr", PICTURE, "float", {})
state("plain.hdr", PICTURE, 0.01)


def srgb(code):
    return numpy.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


codes = numpy.round(PICTURE / 4 * 65535) / 65535
write_oiio("deep.png", codes.astype(numpy.float32), "uint16", {"oiio:ColorSpace": "sRGB"})
state("deep.png", srgb(codes), 2e-5)
bytes_ = numpy.round(PICTURE / 4 * 255).astype(numpy.uint8)
Image.fromarray(bytes_).save(folder / "photo.jpg", quality=100, subsampling=0)
state("photo.jpg", srgb(bytes_ / 255.0), 0.04)

(folder / "inputs.json").write_text(json.dumps(entries))
