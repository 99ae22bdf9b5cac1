"""Reads the sample files with OpenImageIO, OpenEXR and Pillow and compares them with values.json."""

import json
import pathlib
import sys

import numpy
import OpenEXR
import OpenImageIO as oiio
from PIL import Image

folder = pathlib.Path(sys.argv[1])
compared = {}


def fail(entry, reader, what):
    sys.exit(f"{reader}: {entry['file']}: {what}")


def compare(entry, reader, level, pixels, tolerance=0.0):
    """pixels: rows × columns × components, the faces of a cube below each other."""
    stated = entry["levels"][level]
    rows = stated["height"] * entry["faces"]
    if pixels.shape[:2] != (rows, stated["width"]):
        fail(entry, reader, f"level {level} is {pixels.shape}, expected {rows} rows of {stated['width']}")
    for probe in stated["probes"]:
        found = pixels[probe["face"] * stated["height"] + probe["y"], probe["x"]]
        expected = numpy.array(probe["values"], dtype=numpy.float64)
        found = numpy.asarray(found, dtype=numpy.float64)
        # NaN compares as different. Components beyond the channels hold 0, where the container has them at all.
        if not (numpy.abs(found[: len(expected)] - expected) <= tolerance).all() or found[len(expected) :].any():
            fail(entry, reader, f"level {level} at {probe}: found {found}")
        compared[reader] = compared.get(reader, 0) + 1


def compare_text(entry, reader, get, prefix="brdf-baker."):
    for key, value in {**entry["meta"], "channels": ",".join(entry["channels"])}.items():
        if get(prefix + key) != value:
            fail(entry, reader, f"{prefix}{key} is {get(prefix + key)!r}, expected {value!r}")


def read_oiio(entry):
    path = folder / entry["file"]
    source = oiio.ImageInput.open(str(path))
    if source is None:
        fail(entry, "OpenImageIO", oiio.geterror())
    for level in range(len(entry["levels"])):
        if not source.seek_subimage(level, 0):
            fail(entry, "OpenImageIO", f"has no part {level}")
        spec = source.spec()
        pixels = source.read_image(level, 0, 0, spec.nchannels, "float")
        if pixels is None:
            fail(entry, "OpenImageIO", source.geterror())
        # Integers are divided in single precision there.
        compare(entry, "OpenImageIO", level, pixels, 1e-7 if path.suffix == ".png" else 0.0)
        if path.suffix == ".exr":
            expected = "half" if "16f" in entry["encoding"] else "float"
            if str(spec.format) != expected:
                fail(entry, "OpenImageIO", f"holds {spec.format}, expected {expected}")
            if spec.getattribute("compression") != "zip":
                fail(entry, "OpenImageIO", f"compression is {spec.getattribute('compression')}")
            if level == 0:
                compare_text(entry, "OpenImageIO", spec.getattribute)
    if source.seek_subimage(len(entry["levels"]), 0):
        fail(entry, "OpenImageIO", "has more parts than levels")


def read_openexr(entry):
    with OpenEXR.File(str(folder / entry["file"]), separate_channels=True) as source:
        if len(source.parts) != len(entry["levels"]):
            fail(entry, "OpenEXR", f"has {len(source.parts)} parts")
        for level, part in enumerate(source.parts):
            names = "RGBA"[: len(entry["channels"])]
            if set(part.channels) != set(names):
                fail(entry, "OpenEXR", f"has the channels {sorted(part.channels)}")
            planes = [part.channels[name].pixels for name in names]
            expected = numpy.float16 if "16f" in entry["encoding"] else numpy.float32
            if any(plane.dtype != expected for plane in planes):
                fail(entry, "OpenEXR", f"holds {planes[0].dtype}")
            compare(entry, "OpenEXR", level, numpy.stack(planes, axis=-1))
            if entry["faces"] == 6 and part.name() != f"mip{level}":
                fail(entry, "OpenEXR", f"part {level} is named {part.name()}")
        compare_text(entry, "OpenEXR", source.parts[0].header.get)


def read_pillow(entry):
    with Image.open(folder / entry["file"]) as image:
        if image.info.get("gamma") != 1.0 or "srgb" in image.info:
            fail(entry, "Pillow", f"does not state linear values: {image.info}")
        compare_text(entry, "Pillow", image.info.get)
        # Pillow reduces 16-bit RGB to 8 bits: those values are left to OpenImageIO.
        if entry["encoding"] != "rgb16unorm":
            pixels = numpy.asarray(image, dtype=numpy.float64)
            largest = 65535.0 if "16" in entry["encoding"] else 255.0
            pixels = pixels.reshape(pixels.shape[0], pixels.shape[1], -1) / largest
            compare(entry, "Pillow", 0, pixels, 1e-7)


def read_hdr_header(entry):
    lines = (folder / entry["file"]).read_bytes().split(b"\n\n")[0].decode().split("\n")
    pairs = dict(line[2:].split("=", 1) for line in lines if line.startswith("# ") and "=" in line)
    compare_text(entry, "plain text", pairs.get)


entries = json.loads((folder / "values.json").read_text())
for entry in entries:
    suffix = pathlib.Path(entry["file"]).suffix
    if suffix != ".ktx2":
        read_oiio(entry)
    if suffix == ".exr":
        read_openexr(entry)
    if suffix == ".png":
        read_pillow(entry)
    if suffix == ".hdr":
        read_hdr_header(entry)

if set(compared) != {"OpenImageIO", "OpenEXR", "Pillow"}:
    sys.exit(f"a reader compared nothing: {compared}")
print("readers:", ", ".join(f"{reader} {n} texels equal" for reader, n in compared.items()))
