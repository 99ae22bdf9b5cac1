# SPDX-License-Identifier: MIT OR Apache-2.0
"""Reads the sample files with libraries that are not ours, and compares them with values.json.

OpenImageIO, OpenEXR, Pillow and NumPy read what they know. Of KTX, KTX2, DDS and Babylon.js' environments, the headers are
taken apart here after their specifications; imagecodecs decodes blocks, zstandard levels, Pillow pictures. Source code is
compiled or imported by its own language.
"""

import io
import json
import pathlib
import re
import runpy
import shutil
import struct
import subprocess
import sys
import tempfile

import imagecodecs
import numpy
import OpenEXR
import OpenImageIO as oiio
import zstandard
from PIL import Image

folder = pathlib.Path(sys.argv[1])
compared = {}


def fail(entry, reader, what):
    sys.exit(f"{reader}: {entry['file']}: {what}")


def compare(entry, reader, level, pixels, tolerance=0.0):
    """pixels: rows × columns × components, the faces of a cube or the layers of an array below each other. Tolerance: relative
    from 1 on."""
    stated = entry["levels"][level]
    rows = stated["height"] * entry["faces"]
    if pixels.shape[:2] != (rows, stated["width"]):
        fail(entry, reader, f"level {level} is {pixels.shape}, expected {rows} rows of {stated['width']}")
    if len(stated["probes"]) < 9:
        fail(entry, reader, f"level {level} has {len(stated['probes'])} probes")
    for probe in stated["probes"]:
        found = pixels[probe["face"] * stated["height"] + probe["y"], probe["x"]]
        expected = numpy.array(probe["values"], dtype=numpy.float64)
        found = numpy.asarray(found, dtype=numpy.float64)
        # NaN compares as different. Components beyond the channels hold 0, a fourth one 1, where there are any.
        allowed = tolerance * numpy.maximum(1.0, abs(expected))
        beyond = numpy.array([0.0, 0.0, 0.0, 1.0])[len(expected) : len(found)]
        if not (abs(found[: len(expected)] - expected) <= allowed).all() or (found[len(expected) :] != beyond).any():
            fail(entry, reader, f"level {level} at {probe}: found {found}")
        compared[reader] = compared.get(reader, 0) + 1


def first_layer(entry):
    """What a reader finds that knows no arrays."""
    level = entry["levels"][0]
    probes = [probe for probe in level["probes"] if probe["face"] == 0]
    return {**entry, "faces": 1, "levels": [{**level, "probes": probes}]}


def compare_text(entry, reader, get, prefix="brdf-baker."):
    for key, value in {**entry["meta"], "channels": ",".join(entry["channels"])}.items():
        if get(prefix + key) != value:
            fail(entry, reader, f"{prefix}{key} is {get(prefix + key)!r}, expected {value!r}")
    if entry["decode"]:
        stated = get(prefix + "encoding"), get(prefix + "encoding.decode")
        if stated != (entry["encoding"], entry["decode"]):
            fail(entry, reader, f"states the encoding {stated}")


# Texels, as GPUs store them.


def of_formula(rgba, formula):
    rgb, a = rgba[..., :3], rgba[..., 3:]
    return {
        "pow(rgb, 2.2) / a": lambda: rgb**2.2 / a,
        "(8 rgb a)^2": lambda: (8 * rgb * a) ** 2,
        "(rgb (8 - 7 a))^2": lambda: (rgb * (8 - 7 * a)) ** 2,
    }[formula]()


def small_floats(bits, mantissa_bits):
    exponent, mantissa = bits >> mantissa_bits, bits & (1 << mantissa_bits) - 1
    share = mantissa / 2.0**mantissa_bits
    return numpy.where(exponent == 0, share * 2.0**-14, (1 + share) * 2.0 ** (exponent.astype(float) - 15))


def texels(entry, data, width, height, pictures):
    """Values of a level, and how far they may be off."""
    name = entry["encoding"]
    shape = (pictures * height, width, -1)
    if name.startswith("bc"):
        columns, rows = -(-width // 4), -(-height // 4)
        kind = {"bc4": ("BC4", 8), "bc5": ("BC5", 16), "bc6h": ("BC6HU", 16)}[name]
        size = columns * rows * kind[1]
        planes = []
        for face in range(pictures):
            block = data[face * size : (face + 1) * size]
            channels = {"bc4": (), "bc5": (2,), "bc6h": (3,)}[name]
            pixels = imagecodecs.bcn_decode(
                block, getattr(imagecodecs.BCN.FORMAT, kind[0]), shape=(4 * rows, 4 * columns, *channels)
            )
            planes.append(pixels.reshape(4 * rows, 4 * columns, -1)[:height, :width])
        pixels = numpy.concatenate(planes).astype(numpy.float64)
        # Blocks of integers are decoded to bytes there, by truncation.
        return (pixels, 0.0) if name == "bc6h" else (pixels / 255, 1.01 / 255)
    if name in ("rgbd8", "rgbm8", "rgbp8"):
        rgba = numpy.frombuffer(data, numpy.uint8).reshape(*shape[:2], 4) / 255.0
        return of_formula(rgba, entry["decode"]), 1e-6
    if name in ("a2b10g10r10", "rgb9e5", "b10g11r11"):
        word = numpy.frombuffer(data, "<u4").astype(numpy.int64).reshape(shape[:2])
        if name == "a2b10g10r10":
            parts = [(word >> s & 1023) / 1023 for s in (0, 10, 20)] + [(word >> 30) / 3]
        elif name == "rgb9e5":
            parts = [(word >> s & 511) * 2.0 ** ((word >> 27).astype(float) - 24) for s in (0, 9, 18)]
        else:
            parts = [small_floats(word & 2047, 6), small_floats(word >> 11 & 2047, 6), small_floats(word >> 22, 5)]
        return numpy.stack(parts, axis=-1), 1e-7
    kind, largest = {"16f": ("<f2", None), "32f": ("<f4", None), "16unorm": ("<u2", 65535), "8unorm": ("u1", 255)}[
        re.fullmatch("(?:rgba|rgb|rg|r)(.*)", name).group(1)
    ]
    pixels = numpy.frombuffer(data, kind).reshape(shape).astype(numpy.float64)
    return (pixels / largest, 1e-7) if largest else (pixels, 0.0)


def level_size(entry, level):
    stated = entry["levels"][level]
    return stated["width"], stated["height"]


def unit(encoding):
    """Texels along a side, and bytes, of what is stored together."""
    if encoding.startswith("bc"):
        return 4, 8 if encoding == "bc4" else 16
    if encoding in ("a2b10g10r10", "rgb9e5", "b10g11r11", "rgbd8", "rgbm8", "rgbp8"):
        return 1, 4
    count, bits = re.fullmatch("(rgba|rgb|rg|r)([0-9]+).*", encoding).groups()
    return 1, len(count) * int(bits) // 8


def read_ktx2(entry):
    data = (folder / entry["file"]).read_bytes()
    scheme = struct.unpack_from("<I", data, 44)[0]
    if scheme != (2 if entry["compression"] == "zstd" else 0):
        fail(entry, "KTX2", f"supercompression scheme {scheme}")
    for level in range(len(entry["levels"])):
        offset, length, plain = struct.unpack_from("<QQQ", data, 80 + 24 * level)
        stored = data[offset : offset + length]
        if scheme:
            stored = zstandard.ZstdDecompressor().decompress(stored)
        if len(stored) != plain:
            fail(entry, "KTX2", f"level {level} has {len(stored)} bytes, not {plain}")
        pixels, tolerance = texels(entry, stored, *level_size(entry, level), entry["faces"])
        compare(entry, "KTX2", level, pixels, tolerance)


GL = {
    "r16f": 0x822D, "rg16f": 0x822F, "rgba16f": 0x881A, "r32f": 0x822E, "rg32f": 0x8230, "rgba32f": 0x8814,
    "rgba8unorm": 0x8058, "rg16unorm": 0x822C, "rgba16unorm": 0x805B, "b10g11r11": 0x8C3A, "rgb9e5": 0x8C3D,
    "bc6h": 0x8E8F,
}  # fmt: skip


def read_ktx(entry):
    data = (folder / entry["file"]).read_bytes()
    if data[:12] != b"\xabKTX 11\xbb\r\n\x1a\n" or data[12:16] != b"\x01\x02\x03\x04":
        fail(entry, "KTX", "identifier")
    words = struct.unpack_from("<12I", data, 16)
    gl_type, type_size, gl_format, internal, base, width, height, depth, elements, faces, mips, pairs = words
    if internal != GL[entry["encoding"]] or (width, height) != level_size(entry, 0):
        fail(entry, "KTX", f"header {words}")
    if (depth, elements, faces, mips) != (0, 0, entry["faces"], len(entry["levels"])):
        fail(entry, "KTX", f"header {words}")
    text, at = {}, 64
    while at < 64 + pairs:
        (size,) = struct.unpack_from("<I", data, at)
        key, value = data[at + 4 : at + 4 + size].split(b"\0", 1)
        text[key.decode()] = value.removesuffix(b"\0").decode()
        at += 4 + -(-size // 4) * 4
    compare_text(entry, "KTX", text.get)
    if entry["faces"] == 6:
        compare_filament(entry, text["sh"])
    side, unit_bytes = unit(entry["encoding"])
    for level in range(mips):
        width, height = level_size(entry, level)
        (size,) = struct.unpack_from("<I", data, at)
        row, rows = -(-width // side) * unit_bytes, -(-height // side)
        stride = -(-row // 4) * 4
        if size != stride * rows:
            fail(entry, "KTX", f"level {level} has {size} bytes a face")
        stored = numpy.frombuffer(data, numpy.uint8, size * faces, at + 4).reshape(-1, stride)[:, :row]
        pixels, tolerance = texels(entry, stored.tobytes(), width, height, faces)
        compare(entry, "KTX", level, pixels, tolerance)
        at += 4 + size * faces
    if at != len(data):
        fail(entry, "KTX", f"{len(data) - at} bytes are left")


NORMALS = numpy.array([[1, 0, 0], [0, 1, 0], [0, 0, -1], [0.6, -0.64, 0.48], [-0.48, 0.6, 0.64]])


def irradiance(entry):
    """E/π at NORMALS by the coefficients of the orthonormal basis that the file states."""
    e = numpy.array([float(v) for v in entry["meta"]["sh.irradiance"].split()]).reshape(9, 3)
    x, y, z = NORMALS.T
    k = numpy.sqrt(numpy.array([1, 3, 3, 3, 15, 15, 1.25, 15, 3.75]) / (4 * numpy.pi))
    one = numpy.ones_like(x)
    terms = numpy.stack([one, y, z, x, x * y, y * z, 3 * z * z - 1, z * x, x * x - y * y], axis=-1)
    return (terms * k) @ e, terms


def compare_filament(entry, text):
    lines = numpy.array([[float(v) for v in line.split()] for line in text.strip().split("\n")])
    expected, terms = irradiance(entry)
    if lines.shape != (9, 3) or abs(terms @ lines - expected).max() > 1e-6:
        fail(entry, "KTX", f"sh is {text!r}")
    compared["KTX sh"] = compared.get("KTX sh", 0) + len(NORMALS)


def read_env(entry):
    data = (folder / entry["file"]).read_bytes()
    if data[:8] != bytes.fromhex("86168796f6d69636"):
        fail(entry, "env", "magic number")
    end = data.index(0, 8)
    manifest, pictures = json.loads(data[8:end].decode("latin-1")), data[end + 1 :]
    if (manifest["version"], manifest["width"]) != (2, entry["levels"][0]["width"]):
        fail(entry, "env", f"{manifest}")
    compare_text(entry, "env", manifest["brdf-baker"].get)
    places = manifest["specular"]["mipmaps"]
    if len(places) != 6 * len(entry["levels"]) or sum(p["length"] for p in places) != len(pictures):
        fail(entry, "env", "pictures")
    for level in range(len(entry["levels"])):
        faces = []
        for place in places[6 * level : 6 * level + 6]:
            png = pictures[place["position"] : place["position"] + place["length"]]
            with Image.open(io.BytesIO(png)) as image:
                if image.mode != "RGBA":
                    fail(entry, "env", f"a picture is {image.mode}")
                faces.append(numpy.asarray(image) / 255.0)
        compare(entry, "env", level, of_formula(numpy.concatenate(faces), entry["decode"]), 1e-6)
    # Babylon.js' way from the polynomial: harmonics, and their sum.
    p = {key: numpy.array(value) for key, value in manifest["irradiance"].items()}
    c = numpy.sqrt(4 * numpy.pi)
    one = (p["xx"] + p["yy"] + p["zz"]) / 3
    l20, l22 = (2 * p["zz"] - p["xx"] - p["yy"]) / 6, (p["xx"] - p["yy"]) / 2
    # Its bands carry the cosine's factors twice: 1, 2/3 and 1/4 once more.
    sums = [one] + [1.5 * p[k] for k in "yzx"] + [4 * v for v in (p["xy"], p["yz"], l20, p["zx"], l22)]
    expected, terms = irradiance(entry)
    if abs(terms @ numpy.stack(sums) - expected).max() > 1e-6 * c:
        fail(entry, "env", f"irradiance {p}")
    compared["env irradiance"] = compared.get("env irradiance", 0) + len(NORMALS)


DXGI = {
    "rgba32f": 2, "rgba16f": 10, "rgba16unorm": 11, "rg32f": 16, "a2b10g10r10": 24, "b10g11r11": 26, "rgba8unorm": 28,
    "rg16f": 34, "rg16unorm": 35, "r32f": 41, "rg8unorm": 49, "r16f": 54, "r16unorm": 56, "r8unorm": 61, "rgb9e5": 67,
    "bc4": 80, "bc5": 83, "bc6h": 95,
}  # fmt: skip


def read_dds(entry):
    data = (folder / entry["file"]).read_bytes()
    size, _, height, width, _, _, mips = struct.unpack_from("<7I", data, 4)
    caps, caps2 = struct.unpack_from("<2I", data, 108)
    dxgi, dimension, misc, elements, _ = struct.unpack_from("<5I", data, 128)
    is_cube = entry["shape"] == "cube"
    if data[:4] != b"DDS " or size != 124 or data[84:88] != b"DX10" or (width, height) != level_size(entry, 0):
        fail(entry, "DDS", "header")
    if (dxgi, dimension, misc, elements) != (DXGI[entry["encoding"]], 3, 4 if is_cube else 0, max(1, entry["layers"])):
        fail(entry, "DDS", f"DX10 header {(dxgi, dimension, misc, elements)}")
    if mips != len(entry["levels"]) or caps & 0x1000 == 0 or caps2 != (0xFE00 if is_cube else 0):
        fail(entry, "DDS", f"{mips} mips, caps {caps:#x} {caps2:#x}")
    # Each face with all its mips.
    side, unit_bytes = unit(entry["encoding"])
    levels, at = [[] for _ in range(mips)], 148
    for _ in range(entry["faces"]):
        for level in range(mips):
            width, height = level_size(entry, level)
            length = -(-width // side) * -(-height // side) * unit_bytes
            levels[level].append(data[at : at + length])
            at += length
    if at != len(data):
        fail(entry, "DDS", f"{len(data) - at} bytes are left")
    for level, faces in enumerate(levels):
        pixels, tolerance = texels(entry, b"".join(faces), *level_size(entry, level), entry["faces"])
        compare(entry, "DDS", level, pixels, tolerance)
    # Readers that know some of these.
    if entry["encoding"] in ("bc5", "rgba8unorm", "bc4") and not is_cube:
        with Image.open(folder / entry["file"]) as image:
            pixels = numpy.asarray(image).astype(numpy.float64) / 255
            pixels = pixels.reshape(pixels.shape[0], pixels.shape[1], -1)[..., : len(entry["channels"])]
            compare(first_layer(entry), "Pillow", 0, pixels, 1.01 / 255)
    if entry["encoding"] == "bc6h" and not is_cube and not entry["layers"]:
        source = oiio.ImageInput.open(str(folder / entry["file"]))
        compare(entry, "OpenImageIO", 0, source.read_image(0, 0, 0, 3, "float"))


def read_npy(entry):
    pixels = numpy.load(folder / entry["file"])
    if entry["layers"] and pixels.shape[0] != entry["layers"]:
        fail(entry, "NumPy", f"has the shape {pixels.shape}")
    if pixels.dtype != (numpy.float16 if "16f" in entry["encoding"] else numpy.float32):
        fail(entry, "NumPy", f"holds {pixels.dtype}")
    compare(entry, "NumPy", 0, pixels.reshape(-1, *pixels.shape[-2:]))


def read_json(entry):
    file = json.loads((folder / entry["file"]).read_text("utf-8"))
    compare_text(entry, "JSON", file["facts"].get)
    if file.get("layers", 0) != entry["layers"]:
        fail(entry, "JSON", f"has {file.get('layers')} layers")
    pixels = numpy.array(file["values"]).astype(numpy.float32)
    compare(entry, "JSON", 0, pixels.reshape(entry["faces"] * file["height"], file["width"], -1))


# Source code: what its own language makes of it.


def run(entry, command, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    if done.returncode or done.stderr:
        fail(entry, command[0], f"{done.stdout}{done.stderr}")
    return done.stdout


def programs(entry, file, work):
    """Commands; the last prints the array, and then, where there is a function, values in the middle of every texel."""
    name, small = file.stem.upper(), file.stem.lower()
    sample = "16" not in entry["encoding"] and not entry["layers"]
    w, h, n = f"{name}_WIDTH", f"{name}_HEIGHT", f"{name}_CHANNELS"
    # All texels.
    layers = f"{name}_LAYERS"
    texels = f"{w} * {h} * {layers}" if entry["layers"] else f"{w} * {h}"
    if file.suffix in (".c", ".h"):
        element = "uint16_t" if "16" in entry["encoding"] else "float"
        stated = f", {layers} = {entry['layers']}" if entry["layers"] else ""
        declared = f'#include "{file}"\n' if file.suffix == ".h" else (
            f"#include <stdint.h>\nenum {{ {w} = {level_size(entry, 0)[0]}, {h} = {level_size(entry, 0)[1]},"
            f" {n} = {len(entry['channels'])}{stated} }};\nextern const {element} {name}[{texels} * {n}];\n"
            f"void {small}_sample(float u, float v, float out[{n}]);\n"
        )  # fmt: skip
        loop = f"""for (int y = 0; y < {h}; y++) for (int x = 0; x < {w}; x++) {{
            float out[{n}]; {small}_sample((x + 0.5f) / {w}, (y + 0.5f) / {h}, out);
            for (int c = 0; c < {n}; c++) printf("%.9g\\n", out[c]);
        }}""" if sample else ""  # fmt: skip
        (work / "main.c").write_text(
            f"#include <stdio.h>\n{declared}int main(void) {{\nfor (int i = 0; i < {texels} * {n}; i++)"
            f' printf("%.9g\\n", (double){name}[i]);\n{loop}\nreturn 0; }}\n'
        )
        sources = [file, work / "main.c"] if file.suffix == ".c" else [work / "main.c"]
        yield ["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", *sources, "-o", work / "main"]
        yield [work / "main"]
    elif file.suffix == ".rs":
        yield ["rustc", "--edition=2021", "-Dwarnings", "--crate-type=rlib", f"--crate-name={small}", file, "--out-dir", work]
        loop = f"""for y in 0..{h} {{ for x in 0..{w} {{
            let at = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
            for value in {small}_sample(at(x, {w}), at(y, {h})) {{ println!("{{value:?}}"); }}
        }} }}""" if sample else ""  # fmt: skip
        (work / "main.rs").write_text(
            f"use {small}::*;\nfn main() {{ assert_eq!({name}.len(), {texels} * {n});\n"
            f'for value in &{name} {{ println!("{{value:?}}"); }}\n{loop} }}\n'
        )
        yield ["rustc", "--edition=2021", "-Dwarnings", work / "main.rs", "--extern", f"{small}={work}/lib{small}.rlib", "-o", work / "main"]
        yield [work / "main"]
    else:
        module = work / f"{file.stem}.mjs"
        if file.suffix == ".ts":
            tsc = folder.parent / "node_modules" / ".bin" / "tsc"
            yield [tsc, "--strict", "--target", "es2022", "--module", "es2022", "--outDir", work, file]
            yield ["mv", work / f"{file.stem}.js", module]
        else:
            shutil.copy(file, module)
        loop = f"""for (let y = 0; y < m.{h}; y++) for (let x = 0; x < m.{w}; x++)
            console.log(m.{small}Sample((x + 0.5) / m.{w}, (y + 0.5) / m.{h}).join("\\n"));""" if sample else ""  # fmt: skip
        (work / "main.mjs").write_text(f'import * as m from "./{module.name}";\nconsole.log(m.{name}.join("\\n"));\n{loop}')
        yield ["node", work / "main.mjs"]


def read_source(entry):
    file = (folder / entry["file"]).resolve()
    comment = "#" if file.suffix == ".py" else "//"
    pairs = re.findall(rf'^{comment} (\S+) = (".*")$', file.read_text("ascii"), re.M)
    compare_text(entry, "source", {key: json.loads(value) for key, value in pairs}.get)
    stated = entry["levels"][0]
    rows = stated["height"] * entry["faces"]
    count = stated["width"] * rows * len(entry["channels"])
    is_words = "16" in entry["encoding"]
    if file.suffix == ".py":
        module = runpy.run_path(str(file))
        array, sample = module[file.stem.upper()], module.get(f"{file.stem}_sample")
        numbers = list(array)
        for y in range(stated["height"] if sample else 0):
            for x in range(stated["width"]):
                numbers += sample((x + 0.5) / stated["width"], (y + 0.5) / stated["height"])
    else:
        with tempfile.TemporaryDirectory() as work:
            for command in programs(entry, file, pathlib.Path(work)):
                text = run(entry, command)
        numbers = [float(v) for v in text.split()]
    has_function = not is_words and not entry["layers"]
    if len(numbers) != count * (2 if has_function else 1):
        fail(entry, "source", f"has {len(numbers)} numbers")
    shape = (rows, stated["width"], -1)
    reader = f"source {file.suffix}"
    if is_words:
        words = numpy.array(numbers, numpy.uint16)
        is_half = "16f" in entry["encoding"]
        pixels = words.view(numpy.float16) if is_half else words.astype(numpy.float64) / 65535
        compare(entry, reader, 0, pixels.reshape(shape), 0.0 if is_half else 1e-7)
    else:
        compare(entry, reader, 0, numpy.array(numbers[:count], numpy.float32).reshape(shape))
        if has_function:
            compare(entry, f"{reader} function", 0, numpy.array(numbers[count:]).reshape(shape), 2e-5)


def levels_of(entry, parts):
    """Of a file that has a part for each level, or for each layer."""
    return [numpy.concatenate(parts)] if entry["layers"] else parts


def read_oiio(entry):
    path = folder / entry["file"]
    source = oiio.ImageInput.open(str(path))
    if source is None:
        fail(entry, "OpenImageIO", oiio.geterror())
    parts = entry["layers"] or len(entry["levels"])
    found = []
    for part in range(parts):
        if not source.seek_subimage(part, 0):
            fail(entry, "OpenImageIO", f"has no part {part}")
        spec = source.spec()
        pixels = source.read_image(part, 0, 0, spec.nchannels, "float")
        if pixels is None:
            fail(entry, "OpenImageIO", source.geterror())
        found.append(pixels)
        if path.suffix == ".exr":
            expected = "half" if "16f" in entry["encoding"] else "float"
            if str(spec.format) != expected:
                fail(entry, "OpenImageIO", f"holds {spec.format}, expected {expected}")
            if spec.getattribute("compression") != "zip":
                fail(entry, "OpenImageIO", f"compression is {spec.getattribute('compression')}")
            if part == 0:
                compare_text(entry, "OpenImageIO", spec.getattribute)
    if source.seek_subimage(parts, 0):
        fail(entry, "OpenImageIO", "has more parts than levels")
    for level, pixels in enumerate(levels_of(entry, found)):
        # Integers are divided in single precision there.
        compare(entry, "OpenImageIO", level, pixels, 1e-7 if path.suffix == ".png" else 0.0)


def read_openexr(entry):
    with OpenEXR.File(str(folder / entry["file"]), separate_channels=True) as source:
        if len(source.parts) != (entry["layers"] or len(entry["levels"])):
            fail(entry, "OpenEXR", f"has {len(source.parts)} parts")
        found = []
        for i, part in enumerate(source.parts):
            names = "RGBA"[: len(entry["channels"])]
            if set(part.channels) != set(names):
                fail(entry, "OpenEXR", f"has the channels {sorted(part.channels)}")
            planes = [part.channels[name].pixels for name in names]
            expected = numpy.float16 if "16f" in entry["encoding"] else numpy.float32
            if any(plane.dtype != expected for plane in planes):
                fail(entry, "OpenEXR", f"holds {planes[0].dtype}")
            found.append(numpy.stack(planes, axis=-1))
            name = {"table": None, "array": f"layer{i}"}.get(entry["shape"], f"mip{i}")
            if name and part.name() != name:
                fail(entry, "OpenEXR", f"part {i} is named {part.name()}")
        for level, pixels in enumerate(levels_of(entry, found)):
            compare(entry, "OpenEXR", level, pixels)
        compare_text(entry, "OpenEXR", source.parts[0].header.get)


def read_png(entry):
    with Image.open(folder / entry["file"]) as image:
        if image.info.get("gamma") != 1.0 or "srgb" in image.info:
            fail(entry, "Pillow", f"does not state linear values: {image.info}")
        compare_text(entry, "Pillow", image.info.get)
        # Pillow reduces colours of 16 bits to 8: those values are left to OpenImageIO.
        if entry["encoding"] not in ("rgb16unorm", "rgba16unorm"):
            pixels = numpy.asarray(image, dtype=numpy.float64)
            largest = 65535.0 if "16" in entry["encoding"] else 255.0
            pixels = pixels.reshape(pixels.shape[0], pixels.shape[1], -1) / largest
            pixels = of_formula(pixels, entry["decode"]) if entry["decode"] else pixels
            compare(entry, "Pillow", 0, pixels, 1e-6 if entry["decode"] else 1e-7)
    # OpenImageIO multiplies alpha in unless it is asked not to.
    if entry["decode"] is None and not entry["encoding"].startswith("rgba"):
        read_oiio(entry)
    if entry["encoding"] == "rgba16unorm":
        config = oiio.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)
        source = oiio.ImageInput.open(str(folder / entry["file"]), config)
        compare(entry, "OpenImageIO", 0, source.read_image(0, 0, 0, 4, "float"), 1e-7)


def read_hdr(entry):
    read_oiio(entry)
    lines = (folder / entry["file"]).read_bytes().split(b"\n\n")[0].decode().split("\n")
    pairs = dict(line[2:].split("=", 1) for line in lines if line.startswith("# ") and "=" in line)
    compare_text(entry, "plain text", pairs.get)


def read_exr(entry):
    read_oiio(entry)
    read_openexr(entry)


READERS = {
    "dds": read_dds, "env": read_env, "exr": read_exr, "hdr": read_hdr, "json": read_json, "ktx": read_ktx,
    "ktx2": read_ktx2, "npy": read_npy, "png": read_png,
    **dict.fromkeys(["c", "h", "js", "py", "rs", "ts"], read_source),
}  # fmt: skip

entries = json.loads((folder / "values.json").read_text())
used = set()
for entry in entries:
    suffix = entry["file"].rsplit(".", 1)[1]
    READERS[suffix](entry)
    used.add(suffix)

if used != set(READERS):
    sys.exit(f"no file was written for {set(READERS) - used}")
print(f"readers: {len(entries)} files; texels equal:", ", ".join(f"{name} {n}" for name, n in compared.items()))
