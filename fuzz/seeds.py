# SPDX-License-Identifier: MIT OR Apache-2.0
"""Makes the corpus: small files of every kind that is read, and files that claim more than they hold.

Usage: python3 fuzz/seeds.py SAMPLES. SAMPLES is the folder that `cargo run --release --example write_samples` wrote; needs
Pillow, OpenImageIO and numpy. What it makes is committed: run it when a reader is new.
"""

import io
import json
import pathlib
import shutil
import struct
import sys
import zlib

import numpy
import OpenImageIO as oiio
from PIL import Image

samples = pathlib.Path(sys.argv[1])
corpus = pathlib.Path(__file__).parent / "corpus"
shutil.rmtree(corpus, ignore_errors=True)


def put(target, name, content):
    folder = corpus / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)


# Of our own files one a container and kind of encoding, the smallest.
for extension in ["ktx2", "exr", "hdr", "png", "dds", "ktx", "env", "npy", "json"]:
    for path in sorted(samples.glob(f"*.{extension}")):
        if path.stat().st_size < 3000 and not path.stem.startswith("array_bc") and any(
            word in path.stem
            for word in ["table_rg16f", "array_rg16f", "table_rgba8unorm", "map_rgba16f", "map_rgbd8", "bc6h", "cube_rgba16f_zstd", "table_bc5_zstd", "rgbe8", "rgb16unorm"]
        ) or (extension == "env" and path.stat().st_size < 20000):
            put(extension, path.name, path.read_bytes())
for extension in ["rs", "py"]:
    put("source", f"table.{extension}", (samples / f"table_rg16f.{extension}").read_bytes())
put("source", "array.c", (samples / "array_rg16f.c").read_bytes())
put("source", "words.c", (samples / "table_rg16unorm.c").read_bytes())

# Panoramas and tables of others: 8 x 4 texels.
rng = numpy.random.default_rng(1)
pixels = (0.5 + rng.random((4, 8, 3))).astype(numpy.float32)


def write(extension, attributes={}, format="half", tile=None, shape=(8, 4), channels=3):
    path = samples / f"seed.{extension}"
    data = numpy.resize(pixels, (shape[1], shape[0], channels)).astype(numpy.float32)
    spec = oiio.ImageSpec(shape[0], shape[1], channels, format)
    if tile:
        spec.tile_width, spec.tile_height = tile
    for key, value in attributes.items():
        spec.attribute(key, value)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(data) and out.close(), oiio.geterror()
    return path.read_bytes()


for compression in ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]:
    content = write("exr", {"compression": compression})
    put("environment", f"{compression}.exr", content)
    put("picture", f"{compression}.exr", content)
put("environment", "tiles.exr", write("exr", {"compression": "zip"}, "float", (16, 16)))
put("exr", "tiles.exr", write("exr", {"compression": "piz"}, "float", (16, 16)))
hdr = write("hdr", shape=(16, 8))
put("environment", "runs.hdr", hdr)
put("environment", "flat.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes(range(100, 132)))
put("picture", "runs.hdr", hdr)
put("hdr", "runs.hdr", hdr)
image = Image.fromarray((160 * pixels).astype(numpy.uint8))


def encoded(picture, kind, **options):
    out = io.BytesIO()
    picture.save(out, kind, **options)
    return out.getvalue()


grey16 = Image.fromarray(numpy.arange(32, dtype=numpy.uint16).reshape(4, 8) * 2000)

def torn(png):
    """A palette that ends in the middle of a colour."""
    start = png.index(b"PLTE") - 4
    (length,) = struct.unpack(">I", png[start : start + 4])
    chunk = b"PLTE" + png[start + 8 : start + 8 + length] + b"\x12\x34"
    crc = struct.pack(">I", zlib.crc32(chunk))
    return png[:start] + struct.pack(">I", length + 2) + chunk + crc + png[start + 12 + length :]


palette = encoded(image.quantize(8), "PNG", transparency=1)
for name, content in {
    "rgb.png": encoded(image, "PNG"),
    "grey16.png": encoded(grey16, "PNG"),
    "palette.png": palette,
    "torn_palette.png": torn(palette),
    "grey1.png": encoded(image.convert("1"), "PNG"),
}.items():
    put("environment", name, content)
    put("picture", name, content)
    put("png", name, content)
put("environment", "baseline.jpg", encoded(image, "JPEG", quality=60))
put("environment", "progressive.jpg", encoded(image, "JPEG", quality=60, progressive=True, subsampling=2))
put("environment", "grey.jpg", encoded(image.convert("L"), "JPEG", restart_marker_blocks=1))
put("environment", "cmyk.jpg", encoded(image.convert("CMYK"), "JPEG"))


def ktx2(vk_format, size, faces, data, scheme=0, length=None):
    """The largest level alone; no descriptor, which these readers do not look at."""
    size = size if isinstance(size, tuple) else (size, size)
    head = struct.pack("<9I", vk_format, 2, size[0], size[1], 0, 0, faces, 1, scheme)
    index = struct.pack("<4I2Q", 0, 0, 0, 0, 0, 0)
    level = struct.pack("<3Q", 104, len(data), len(data) if length is None else length)
    return b"\xabKTX 20\xbb\r\n\x1a\n" + head + index + level + data


# A frame of Zstandard with a raw block, and one whose block is a byte 2^17 times.
def zstd(data, window=0x58):
    return b"\x28\xb5\x2f\xfd\x00" + bytes([window]) + struct.pack("<I", len(data) << 3 | 1)[:3] + data


def zstd_run(byte, count, window=0x58):
    return b"\x28\xb5\x2f\xfd\x00" + bytes([window]) + struct.pack("<I", count << 3 | 3)[:3] + bytes([byte])


halves = struct.pack("<4e", 1, 2, 3, 1)
put("environment", "cube.ktx2", ktx2(97, 2, 6, halves * 24))
put("environment", "zlib.ktx2", ktx2(97, 2, 6, zlib.compress(halves * 24), 3, 192))
put("environment", "zstd.ktx2", ktx2(97, 2, 6, zstd(halves * 24), 2, 192))
put("environment", "bc6h.ktx2", ktx2(143, 4, 6, bytes(range(96))))
put("picture", "table.ktx2", ktx2(97, 2, 1, halves * 4))
put("picture", "zstd.ktx2", ktx2(97, 2, 1, zstd(halves * 4), 2, 32))
put("picture", "bc7.ktx2", ktx2(145, 4, 1, bytes(range(16))))
for name in ["table_rg16f", "table_bc6h", "cube_b10g11r11"]:
    content = (samples / f"{name}.dds").read_bytes()
    put("environment" if "cube" in name else "picture", f"{name}.dds", content)
for extension in ["ktx", "npy"]:
    put("picture", f"table.{extension}", (samples / f"table_rg16f.{extension}").read_bytes())
for extension in ["ktx2", "dds", "exr"]:
    put("picture", f"array.{extension}", (samples / f"array_rg16f.{extension}").read_bytes())

# Files that claim more than they hold.
big_hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n\x02\x02\x40\x00"
put("environment", "huge.hdr", big_hdr)
put("hdr", "huge.hdr", b"#?RADIANCE\n\n-Y 4294967295 +X 4294967295\n\x02\x02\x40\x00")


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, depth, color, data=b""):
    head = chunk(b"IHDR", struct.pack(">2I5B", width, height, depth, color, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


put("environment", "huge.png", png(16384, 8192, 16, 6))
put("png", "huge.png", png(2**31 - 1, 2**31 - 1, 16, 6))
put("picture", "huge.png", png(8192, 8192, 16, 6))
jpeg = corpus / "environment" / "baseline.jpg"
content = jpeg.read_bytes()
at = content.index(b"\xff\xc0")
put("environment", "huge.jpg", content[: at + 5] + struct.pack(">2H", 8192, 16384) + content[at + 9 :])
# Colour that is sampled finer than brightness.
progressive = (corpus / "environment" / "progressive.jpg").read_bytes()
at = progressive.index(b"\xff\xc2") + 10
frame = bytearray(progressive[at : at + 9])
frame[1::3] = b"\x11\x22\x11"
put("environment", "fine_colour.jpg", progressive[:at] + bytes(frame) + progressive[at + 9 :])
for name, scheme in [("plain", 0), ("zstd", 2), ("zlib", 3)]:
    put("environment", f"huge_{name}.ktx2", ktx2(109, 4096, 6, b"", scheme, 6 * 4096 * 4096 * 16))
    put("picture", f"huge_{name}.ktx2", ktx2(109, 8192, 1, b"", scheme, 8192 * 8192 * 16))
run = zstd_run(7, 131072)
put("picture", "bomb.ktx2", ktx2(109, (8192, 1), 1, run, 2, 131072))
put("environment", "bomb.ktx2", ktx2(109, 4096, 6, run * 4, 2, 6 * 4096 * 4096 * 16))
# A window of 3.75 TiB, and one of 128 MiB.
put("picture", "window.ktx2", ktx2(97, 2, 1, zstd(halves * 4, 0xFF), 2, 32))
put("environment", "window.ktx2", ktx2(97, 2, 6, zstd(halves * 24, 0x88), 2, 192))
dds = bytearray((samples / "cube_b10g11r11.dds").read_bytes())
dds[12:20] = struct.pack("<2I", 4096, 4096)
put("environment", "huge.dds", bytes(dds))
dds[12:20] = struct.pack("<2I", 2**31, 2**31)
put("dds", "huge.dds", bytes(dds))
# Arrays of two thousand million layers, and of a number that wraps to those that there are.
for extension, at in [("ktx2", 32), ("dds", 140)]:
    for name, layers in [("huge", 2**31), ("wraps", 2**30 + 3)]:
        content = bytearray((samples / f"array_rg16f.{extension}").read_bytes())
        content[at : at + 4] = struct.pack("<I", layers)
        for target in [extension, "picture"]:
            put(target, f"{name}_layers.{extension}", bytes(content))


def exr_claiming(content, width, height):
    """The same header with larger windows."""
    content = bytearray(content)
    for name in [b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"]:
        at = content.index(name) + len(name) + 4
        content[at : at + 16] = struct.pack("<4i", 0, 0, width - 1, height - 1)
    return bytes(content)


for compression in ["none", "piz", "dwaa"]:
    content = (corpus / "environment" / f"{compression}.exr").read_bytes()
    put("environment", f"huge_{compression}.exr", exr_claiming(content, 16384, 8192))
    put("exr", f"huge_{compression}.exr", exr_claiming(content, 2**30, 2**30))
    put("picture", f"huge_{compression}.exr", exr_claiming(content, 8192, 8192))
content = bytearray((corpus / "environment" / "zip.exr").read_bytes())
at = content.index(b"displayWindow\0box2i\0") + 24
content[at : at + 16] = struct.pack("<4i", -(2**31) + 9, -(2**31) + 9, 16383 - 2**31 + 9, 8191 - 2**31 + 9)
put("environment", "far_window.exr", bytes(content))


def npy(header, length=None):
    return b"\x93NUMPY\x02\x00" + struct.pack("<I", len(header) if length is None else length) + header


put("npy", "long_header.npy", npy(b"", 2**32 - 1))
put("npy", "brackets.npy", npy(b"(" * 4000))
put("npy", "huge.npy", npy(b"{'descr': '<f4', 'fortran_order': False, 'shape': (4294967295, 4294967295, 4), }\n"))
put("npy", "huge_number.npy", npy(b"{'descr': '<f4', 'fortran_order': False, 'shape': (" + b"9" * 4000 + b", 1), }\n"))
put("json", "brackets.json", b"[" * 4000)
put("json", "layers.json", b'{"width": 1, "height": 1, "layers": 4294967295, "encoding": "r32f", "values": [0]}')
facts = {
    "channels": "r", "table": "split-sum+albedo", "ndf": "ggx", "visibility": "smith", "fresnel": "schlick",
    "axes": "n_dot_v,roughness", "points": "centers", "order": "ascending,ascending",
    "layer0.table": "split-sum", "layer0.channels": "scale", "layer1.table": "albedo", "layer1.channels": "albedo",
    "layer1.fresnel": "one", "layer1.visibility": "smith-uncorrelated",
}  # fmt: skip
tables = {"width": 2, "height": 1, "layers": 2, "encoding": "r32f", "values": [0.9, 0.8, 0.7, 0.6]}
tables["facts"] = {f"brdf-baker.{key}": value for key, value in facts.items()}
put("json", "tables.json", json.dumps(tables).encode())
put("json", "zeros.json", b'{"width": 50, "height": 20, "encoding": "r32f", "values": [' + b"0," * 999 + b"0]}")
# One picture of a Babylon.js environment that stands for every face of its largest mips.
picture = png(2048, 2048, 8, 6, b"\0" * (1 + 4 * 2048) * 2048)
place = {"position": 0, "length": len(picture)}
levels = 12
manifest = {
    "version": 2,
    "width": 2048,
    "imageType": "image/png",
    "specular": {"mipmaps": [place] * (6 * levels)},
}
put("env", "shared.env", bytes.fromhex("86168796f6d69636") + json.dumps(manifest).encode() + b"\0" + picture)

# Recipes: as people write them, everything in a line, and deeper than any value may be.
put(
    "recipe",
    "studio.toml",
    b"""output = "baked"

[[bake]]
table = "split-sum"
for = ["bevy", "three"]
size = 0x40

[[env]]
input = ["probes/**/*.exr", "sky.hdr"]
output = "{folder}/{name}.ktx2"
exposure = -1.5e0
mirror = true
""",
)
put(
    "recipe",
    "inline.toml",
    """bake = [{ table = "albedo", "output" = 'a.exr' }]
env = [{ input = \"\"\"é
\"\"\", rotate-xyz = [0, 90.0, inf] }] # end
""".encode(),
)
put("recipe", "deep.toml", b"[[env]]\na = " + b"[" * 40 + b"]" * 40 + b"\nb.c.d = 1979-05-27T07:32:00Z\n")

size = sum(path.stat().st_size for path in corpus.rglob("*") if path.is_file())
print(f"{sum(1 for p in corpus.rglob('*') if p.is_file())} files, {size} bytes")
