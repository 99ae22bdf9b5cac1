# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bakes the preset of every engine and checks it from outside: files are read with OpenImageIO, Pillow, ktx-parse, node and
numpy, and compared at 9 places with values that are computed here, by other means and from a list of conventions of its own.

Tables: every value is integrated over the half vector by brute force. Environments: a sky whose radiance is 1 + d.axis/2,
another axis in every channel. Filtered, it is 1 + c d.axis/2 with c the mean cosine of the kernel, so a texel tells the
direction that it shows and the roughness that it holds."""

import base64
import json
import pathlib
import re
import struct
import subprocess
import sys

import numpy
import OpenEXR
from PIL import Image

program, work = sys.argv[1], pathlib.Path(sys.argv[2])
here = pathlib.Path(__file__).parent
work.mkdir(parents=True, exist_ok=True)
compared = 0


def fail(what):
    sys.exit(f"targets: {what}")


def run(*arguments):
    done = subprocess.run([program, *arguments], cwd=work, capture_output=True, text=True)
    if done.returncode != 0:
        fail(f"{' '.join(arguments)}: {done.stderr}")


def agree(what, found, expected, tolerance):
    global compared
    found, expected = numpy.asarray(found, float), numpy.asarray(expected, float)
    # NaN compares as different.
    if found.shape != expected.shape or not (numpy.abs(found - expected) <= tolerance * numpy.maximum(1, expected)).all():
        fail(f"{what}: found {found}, expected {expected} within {tolerance}")
    compared += 1


# --- values of tables ---------------------------------------------------------------------------------------------------


def half_vectors(count=700):
    """Nodes in (u, phi) on [0, 1] x [0, pi] and their weights; u is mapped by each distribution."""
    u, w = numpy.polynomial.legendre.leggauss(count)
    phi, w_phi = numpy.polynomial.legendre.leggauss(count // 2)
    u, w = 0.5 * (u + 1), 0.5 * w
    phi, w_phi = 0.5 * numpy.pi * (phi + 1), 0.5 * w_phi
    return u[:, None], phi[None, :], w[:, None] * w_phi[None, :]


U, PHI, WEIGHT = half_vectors()


def reflect(n_dot_v, cos_h):
    """v.h and n.l for half vectors with this cosine."""
    sin_h, sin_v = numpy.sqrt(1 - cos_h**2), numpy.sqrt(1 - n_dot_v**2)
    v_dot_h = sin_h * numpy.cos(PHI) * sin_v + cos_h * n_dot_v
    return v_dot_h, 2 * v_dot_h * cos_h - n_dot_v


def ggx(n_dot_v, roughness, geometry):
    """scale and bias; half vectors are distributed like D n.h."""
    alpha = roughness**2
    tan2 = alpha**2 * U / (1 - U)
    cos_h = 1 / numpy.sqrt(1 + tan2)
    v_dot_h, n_dot_l = reflect(n_dot_v, cos_h)
    lit = (n_dot_l > 0) & (v_dot_h > 0)
    n_dot_l, v_dot_h = numpy.where(lit, n_dot_l, 1), numpy.where(lit, v_dot_h, 0)
    if geometry == "smith":
        over = lambda x: numpy.sqrt(1 + alpha**2 * (1 - x**2) / x**2)
        g = 2 / (over(n_dot_v) + over(n_dot_l))
    else:  # Schlick, k = alpha/2
        one = lambda x: x / (x * (1 - alpha / 2) + alpha / 2)
        g = one(n_dot_v) * one(n_dot_l)
    value = WEIGHT * g * v_dot_h / (n_dot_v * cos_h)
    bias = (value * (1 - v_dot_h) ** 5).sum()
    return value.sum() - bias, bias


def cloth(n_dot_v, roughness):
    """Charlie with Neubelt's term; half vectors evenly over the hemisphere."""
    alpha = roughness**2
    # Most of the lobe lies at the horizon, so u is the cosine's square root.
    cos_h, jacobian = U**2, 2 * U
    v_dot_h, n_dot_l = reflect(n_dot_v, cos_h)
    lit = (n_dot_l > 0) & (v_dot_h > 0)
    n_dot_l, v_dot_h = numpy.where(lit, n_dot_l, 1), numpy.where(lit, v_dot_h, 0)
    d = (2 + 1 / alpha) / (2 * numpy.pi) * (1 - cos_h**2) ** (0.5 / alpha)
    v = 1 / (4 * (n_dot_l + n_dot_v - n_dot_l * n_dot_v))
    return (WEIGHT * jacobian * 2 * numpy.pi * d * v * n_dot_l * 4 * v_dot_h).sum()


def disney(n_dot_v, roughness):
    """Unity's normalised diffuse term less 1/2; light directions evenly over the hemisphere."""
    n_dot_l = U
    l_dot_v = numpy.sqrt(1 - n_dot_l**2) * numpy.sqrt(1 - n_dot_v**2) * numpy.cos(PHI) + n_dot_l * n_dot_v
    f90 = 0.5 + roughness * (1 + l_dot_v)
    scatter = lambda x: 1 + (f90 - 1) * (1 - x) ** 5
    return (WEIGHT * 2 * n_dot_l * scatter(n_dot_l) * scatter(n_dot_v)).sum() / 1.03571 - 0.5


def average(roughness):
    x, w = numpy.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (x + 1), 0.5 * w
    return sum(2 * x_ * w_ * sum(ggx(x_, roughness, "smith")) for x_, w_ in zip(x, w))


# --- readers ------------------------------------------------------------------------------------------------------------


def unpack_a2b10g10r10(words):
    return numpy.stack([(words >> shift) & 1023 for shift in (0, 10, 20)], axis=-1) / 1023


def unpack_b10g11r11(words):
    def small(bits, mantissa_bits):
        exponent, mantissa = bits >> mantissa_bits, (bits & ((1 << mantissa_bits) - 1)) / (1 << mantissa_bits)
        return numpy.where(exponent == 0, mantissa * 2.0**-14, (1 + mantissa) * 2.0 ** (exponent.astype(float) - 15))

    return numpy.stack([small(words & 2047, 6), small((words >> 11) & 2047, 6), small(words >> 22, 5)], axis=-1)


def unpack_rgbd(pixels):
    pixels = pixels.astype(float) / 255
    return pixels[..., :3] ** 2.2 / pixels[..., 3:]


def read_ktx2(path):
    printed = subprocess.run(["node", here_node / "levels.mjs", path], capture_output=True, text=True, check=True)
    file = json.loads(printed.stdout)
    kind, components = {83: ("<f2", 2), 97: ("<f2", 4), 103: ("<f4", 2), 109: ("<f4", 4)}[file["vkFormat"]]
    levels, pictures = [], file["faces"] * max(1, file["layers"])
    for i, level in enumerate(file["levels"]):
        size = [max(1, file["height"] >> i), max(1, file["width"] >> i), components]
        levels.append(numpy.frombuffer(base64.b64decode(level), kind).astype(float).reshape(pictures, *size))
    return levels


def read_dds(path):
    data = path.read_bytes()
    height, width = struct.unpack_from("<2I", data, 12)
    mips = max(1, struct.unpack_from("<I", data, 28)[0])
    if data[84:88] != b"DX10":
        fail(f"{path.name} has no DX10 header")
    dxgi, _, misc = struct.unpack_from("<3I", data, 128)
    faces = 6 if misc & 4 else 1
    kind, components = {10: ("<f2", 4), 24: ("<u4", 1), 34: ("<f2", 2), 35: ("<u2", 2)}[dxgi]
    texels = numpy.frombuffer(data[148:], kind)
    levels, at = [[] for _ in range(mips)], 0
    for _ in range(faces):
        for i in range(mips):
            h, w = max(1, height >> i), max(1, width >> i)
            levels[i].append(texels[at : at + h * w * components].reshape(h, w, components))
            at += h * w * components
    if at != len(texels):
        fail(f"{path.name} holds {len(texels) - at} values too many")
    convert = {10: lambda v: v.astype(float), 24: lambda v: unpack_a2b10g10r10(v[..., 0]), 34: lambda v: v.astype(float),
               35: lambda v: v / 65535}[dxgi]
    return [convert(numpy.stack(level)) for level in levels]


def read_ktx1(path):
    data = path.read_bytes()
    if data[:12] != b"\xabKTX 11\xbb\r\n\x1a\n":
        fail(f"{path.name} is no KTX")
    (endian, gl_type, _, _, internal, _, width, height, _, _, faces, mips, key_bytes) = struct.unpack_from("<13I", data, 12)
    if (endian, gl_type, internal, faces) != (0x04030201, 0x8C3A, 0x8C3A, 6):
        fail(f"{path.name}: type {gl_type:#x}, internal format {internal:#x}, {faces} faces")
    keys, at = {}, 64
    while at < 64 + key_bytes:
        (size,) = struct.unpack_from("<I", data, at)
        key, _, value = data[at + 4 : at + 4 + size].partition(b"\0")
        keys[key.decode()] = value.rstrip(b"\0").decode()
        at += 4 + (size + 3) // 4 * 4
    levels = []
    for i in range(mips):
        (face_bytes,) = struct.unpack_from("<I", data, at)
        h, w = max(1, height >> i), max(1, width >> i)
        if face_bytes != 4 * h * w:
            fail(f"{path.name}: level {i} has {face_bytes} bytes a face")
        words = numpy.frombuffer(data, "<u4", 6 * h * w, at + 4).reshape(6, h, w)
        levels.append(unpack_b10g11r11(words))
        at += 4 + 6 * face_bytes
    return levels, keys


def read_env(path):
    data = path.read_bytes()
    if data[:8] != bytes([0x86, 0x16, 0x87, 0x96, 0xF6, 0xD6, 0x96, 0x36]):
        fail(f"{path.name} is no .env")
    end = data.index(b"\0", 8)
    header = json.loads(data[8:end])
    if header.get("version") != 2:
        fail(f"{path.name}: {header}")
    pictures = []
    for entry in header["specular"]["mipmaps"]:
        from io import BytesIO

        start = end + 1 + entry["position"]
        pictures.append(unpack_rgbd(numpy.asarray(Image.open(BytesIO(data[start : start + entry["length"]])).convert("RGBA"))))
    count = header["width"].bit_length()
    if len(pictures) != 6 * count:
        fail(f"{path.name} holds {len(pictures)} pictures")
    return [numpy.stack(pictures[6 * i : 6 * i + 6]) for i in range(count)], header


def read_exr(path):
    with OpenEXR.File(str(path), separate_channels=True) as source:
        levels = []
        for part in source.parts:
            names = [name for name in "RGBA" if name in part.channels]
            levels.append(numpy.stack([part.channels[name].pixels.astype(float) for name in names], axis=-1)[None])
        return levels


def read_png(path):
    return [numpy.asarray(Image.open(path))[None]]


def read_c(path):
    """The numbers of the array in a C header, half floats as their words."""
    source = re.sub(r"/\*.*?\*/|//[^\n]*", "", path.read_text(), flags=re.S)
    name, dimensions, body = re.search(r"(\w+)\s*((?:\[\w+\])+)\s*=\s*\{(.*?)\};", source, flags=re.S).groups()
    words = re.findall(r"0x[0-9a-fA-F]+|[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?", body)
    if any(word.startswith("0x") for word in words):
        return numpy.array([int(word, 16) for word in words], numpy.uint16)
    return numpy.array([float(word) for word in words])


def read_js(path):
    module = work / (path.stem + ".mjs")
    module.write_text(path.read_text())
    script = f"import * as table from '{module}'; const array = Object.values(table).find(v => ArrayBuffer.isView(v)); console.log(JSON.stringify([...array]))"
    printed = subprocess.run(["node", "--input-type=module", "-e", script], capture_output=True, text=True, check=True)
    return numpy.array(json.loads(printed.stdout), numpy.uint16)


here_node = pathlib.Path(sys.argv[3])

# --- tables -------------------------------------------------------------------------------------------------------------

centers = lambda i, n: (i + 0.5) / n
edges = lambda i, n: i / (n - 1)


def bake_table(target, table, file, *more):
    run("bake", table, "--for", target, *more)
    path = work / file
    if not path.is_file():
        fail(f"{target}: {file} was not written")
    return path


def check_table(target, values, size, at, expected, tolerance):
    """values: rows x columns x components."""
    width, height = size
    if values.shape[:2] != (height, width):
        fail(f"{target}: {values.shape} instead of {height} rows of {width}")
    for y in sorted({height // 8, height // 2, height - 1}):
        for x in (width // 8, width // 2, width - 1):
            found = values[y, x]
            wanted = expected(*at(x, y))
            agree(f"{target} at ({x}, {y})", found[: len(wanted)], wanted, tolerance)


halves = lambda words, w, h, n: words.astype("<u2").view("<f2").astype(float).reshape(h, w, n)
smith = lambda v, r: ggx(v, r, "smith")


def multi(v, r, geometry="smith"):
    scale, bias = ggx(v, r, geometry)
    return bias, scale + bias, cloth(v, r)


check_table("bevy", read_ktx2(bake_table("bevy", "split-sum", "dfg.ktx2"))[0][0], (128, 128),
            lambda x, y: (centers(x, 128), centers(y, 128)), smith, 1e-3)
# Small: a fit takes a while. The last row is at 1.57 rad. Layer 0 is the matrix; for a mirror seen from above it flattens nearly everything.
area_lights = read_ktx2(bake_table("bevy", "ltc", "ltc.ktx2", "--size", "9"))[0]
if area_lights.shape != (2, 9, 9, 4) or not 0 < area_lights[0, 0, 0, 3] < 1e-3:
    fail(f"bevy: ltc.ktx2 holds {area_lights.shape}, its first texel {area_lights[0, 0, 0]}")
check_table("bevy", area_lights[1], (9, 9), lambda x, y: (max(1 - edges(y, 9) ** 2, numpy.cos(1.57)), edges(x, 9)),
            lambda v, r: (sum(smith(v, r)), smith(v, r)[1], 0), 2e-3)
check_table("three", halves(read_js(bake_table("three", "split-sum", "dfg_lut.js")), 16, 16, 2), (16, 16),
            lambda x, y: (centers(y, 16), centers(x, 16)), smith, 1e-3)
check_table("babylon", unpack_rgbd(read_png(bake_table("babylon", "split-sum", "brdf.png"))[0][0]), (256, 256),
            lambda x, y: (centers(x, 256), centers(y, 256)), multi, 2e-2)
filament = lambda shift: lambda x, y: (centers(x, 128), min(1, (y + 0.5 + shift) / 128))
for shift, flags in ((1, []), (0, ["--exact-rows"])):
    words = read_c(bake_table("filament", "split-sum", "dfg.h", *flags))
    check_table("filament", halves(words, 128, 128, len(words) // 128**2), (128, 128), filament(shift), multi, 2e-3)
check_table("gltf", read_png(bake_table("gltf", "split-sum", "lut_ggx.png"))[0][0] / 255, (1024, 1024),
            lambda x, y: (centers(x, 1024), centers(y, 1024)), smith, 3e-3)
check_table("godot", read_exr(bake_table("godot", "split-sum", "dfg.exr"))[0][0], (128, 128),
            lambda x, y: (centers(x, 128), 1 - centers(y, 128)), lambda v, r: multi(v, r, "schlick"), 2e-3)
check_table("materialx", read_exr(bake_table("materialx", "split-sum", "albedo_table.exr"))[0][0], (64, 64),
            lambda x, y: (centers(x, 64), centers(y, 64) ** 0.5), smith, 5e-4)
check_table("unity-hdrp", read_dds(bake_table("unity-hdrp", "split-sum", "fgd_ggx_disney.dds"))[0][0], (64, 64),
            lambda x, y: (max(edges(x, 64), 1e-4) ** 2, max(edges(y, 64), 1e-3)),
            lambda v, r: (*multi(v, r)[:2], disney(v, r)), 2e-3)
check_table("unreal", read_dds(bake_table("unreal", "split-sum", "preintegrated_gf.dds"))[0][0], (128, 32),
            lambda x, y: (centers(x, 128), centers(y, 32)), smith, 5e-4)
check_table("blender", read_c(bake_table("blender", "split-sum", "brdf_ggx.h")).reshape(64, 64, 2), (64, 64),
            lambda x, y: (max(1 - edges(y, 64) ** 2, 1e-6), max(edges(x, 64), 1e-3)), smith, 2e-3)
check_table("blender albedo", read_c(bake_table("blender", "albedo", "ggx_E.h")).reshape(32, 32, 1), (32, 32),
            lambda x, y: (max(edges(y, 32), 1e-4), max(edges(x, 32), 1e-3)), lambda v, r: (sum(smith(v, r)),), 5e-4)
check_table("blender average", read_c(bake_table("blender", "average-albedo", "ggx_Eavg.h")).reshape(1, 32, 1), (32, 1),
            lambda x, y: (max(edges(x, 32), 1e-3),), lambda r: (average(r),), 5e-4)
check_table("openpbr", read_c(bake_table("openpbr", "albedo", "ideal_metal_energy_complement.h")).reshape(32, 32, 1) / 65535,
            (32, 32), lambda x, y: (edges(x, 32), max(edges(y, 32), 1e-3)), lambda v, r: (1 - sum(smith(v, r)),), 5e-4)
words = read_c(bake_table("openpbr", "average-albedo", "ideal_metal_average_energy_complement.h"))
check_table("openpbr average", words.reshape(1, 32, 1) / 65535, (32, 1), lambda x, y: (max(edges(x, 32), 1e-3),),
            lambda r: (1 - average(r),), 5e-4)
print(f"targets: {compared} places of tables agree")
compared = 0

# --- environments -------------------------------------------------------------------------------------------------------


def write_sky(path, height=256):
    theta = numpy.pi * (numpy.arange(height)[:, None] + 0.5) / height
    phi = 2 * numpy.pi * ((numpy.arange(2 * height)[None, :] + 0.5) / (2 * height) - 0.5)
    d = [numpy.cos(phi) * numpy.sin(theta), numpy.cos(theta) + 0 * phi, numpy.sin(phi) * numpy.sin(theta)]
    planes = {name: (1 + 0.5 * v).astype(numpy.float32) for name, v in zip("RGB", d)}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, planes).write(str(path))


def mean_cosine(roughness):
    """Of D n.l with N = V = R over light directions; 2/3 is a cosine's."""
    if roughness == 0:
        return 1.0
    alpha = roughness**2
    x, w = numpy.polynomial.legendre.leggauss(400)
    u, w = 0.5 * (x + 1), 0.5 * w
    # dω_l = 4 n.h dω_h, and u is distributed like D n.h.
    cos_h2 = 1 / (1 + alpha**2 * u / (1 - u))
    cos_l = 2 * cos_h2 - 1
    lit = numpy.where(cos_l > 0, cos_l, 0)
    return (w * lit * cos_l).sum() / (w * lit).sum()


FACES = [lambda s, t: (1, -t, -s), lambda s, t: (-1, -t, s), lambda s, t: (s, 1, t), lambda s, t: (s, -1, -t),
         lambda s, t: (s, -t, 1), lambda s, t: (-s, -t, -1)]


def cube_direction(face, x, y, size):
    d = numpy.array(FACES[face](2 * (x + 0.5) / size - 1, 2 * (y + 0.5) / size - 1), float)
    return d / numpy.linalg.norm(d)


def equirect_direction(face, x, y, height):
    theta, phi = numpy.pi * (y + 0.5) / height, numpy.pi * ((x + 0.5) / height - 1)
    return numpy.array([numpy.cos(phi) * numpy.sin(theta), numpy.cos(theta), numpy.sin(phi) * numpy.sin(theta)])


def check_map(what, levels, size, mips, roughness, world, tolerance, direction=cube_direction, lambert=False):
    if len(levels) < mips or levels[0].shape[1] != size:
        fail(f"{what}: {len(levels)} levels, the first {levels[0].shape}")
    for m in range(mips):
        height = max(1, size >> m)
        cosine = 2 / 3 if lambert else mean_cosine(roughness(m) if roughness else 0)
        places = [(f, height // 3, height // 4) for f in range(levels[m].shape[0])]
        places += [(0, 0, 0), (0, height - 1, height // 2), (len(levels[m]) - 1, height // 2, height - 1)]
        for face, x, y in places:
            expected = 1 + 0.5 * cosine * numpy.array(world(*direction(face, x, y, height)))
            # Where a texel of mip 0 is wide, its mean is not its centre's value; nor where the sky's own texels are.
            slack = tolerance + (0.6 / height**2 + 4e-3 if m == 0 else 0)
            agree(f"{what}: mip {m}, face {face} ({x}, {y})", levels[m][face, y, x, :3], expected, slack)


write_sky(work / "sky.exr")
quadratic = lambda last: lambda m: 1 - (1 - m / last) ** 0.5
linear = lambda last: lambda m: m / last
same = lambda x, y, z: (x, y, z)
playcanvas = same


def env(target, *files):
    run("env", "sky.exr", "--for", target)
    for file in files:
        if not (work / file).is_file():
            fail(f"{target}: {file} was not written")
    return [work / file for file in files]


specular, diffuse = env("bevy", "sky_specular.ktx2", "sky_diffuse.ktx2")
reversed_z = lambda x, y, z: (x, y, -z)
levels = read_ktx2(specular)
check_map("bevy", levels, 512, 8, linear(7), reversed_z, 2e-3)
if len(levels) != 8:
    fail(f"bevy: {len(levels)} mips")
check_map("bevy diffuse", read_ktx2(diffuse), 32, 1, None, reversed_z, 2e-3, lambert=True)

(specular,) = env("three", "sky_specular.ktx2")
levels = read_ktx2(specular)
check_map("three", levels, 256, 6, quadratic(5), lambda x, y, z: (-x, y, z), 2e-3)
if len(levels) != 6:
    fail(f"three: {len(levels)} mips")

(file,) = env("babylon", "sky.env")
levels, header = read_env(file)
babylon = lambda m: 0 if m == 0 else min(1, 2 ** (m / 0.8) / 256) ** 0.5
check_map("babylon", levels, 256, 9, babylon, lambda x, y, z: (z, y, x), 3e-2)
# Irradiance over pi of the sky is 1 + d.axis/3 in each channel. Babylon.js divides the linear part by 2/3 when it reads it.
polynomial = header["irradiance"]
for i, axis in enumerate("zyx"):
    agree(f"babylon: irradiance along {axis}", numpy.array(polynomial[axis]), numpy.eye(3)[i] * 2 / 9, 2e-3)

specular, skybox = env("filament", "sky_ibl.ktx", "sky_skybox.ktx")
mirrored = lambda x, y, z: (z, y, -x)
levels, keys = read_ktx1(specular)
check_map("filament", levels, 256, 5, quadratic(4), mirrored, 3e-2)
check_map("filament skybox", read_ktx1(skybox)[0], 256, 1, None, mirrored, 3e-2)
harmonics = numpy.array([[float(v) for v in line.split()] for line in keys["sh"].strip().splitlines()])
agree("filament: sh", harmonics[0], [1, 1, 1], 2e-3)

specular, diffuse = env("gltf", "sky_specular.ktx2", "sky_lambertian.ktx2")
check_map("gltf", read_ktx2(specular), 512, 8, linear(7), same, 2e-3)
check_map("gltf diffuse", read_ktx2(diffuse), 256, 1, None, same, 2e-3, lambert=True)

for target in ("godot", "blender"):
    (file,) = env(target, "sky_equirect.exr")
    check_map(target, read_exr(file), 1024, 1, None, same, 2e-3, equirect_direction)

specular, diffuse = env("materialx", "sky_specular.exr", "sky_irradiance.exr")
materialx = lambda m: m / 7 if m / 7 < 0.5 else min(1, 2 * (m / 7 - 0.375)) ** 0.5
check_map("materialx", read_exr(specular), 512, 8, materialx, same, 2e-3, equirect_direction)
check_map("materialx diffuse", read_exr(diffuse), 64, 1, None, same, 2e-3, equirect_direction, lambert=True)

(file,) = env("playcanvas", "sky_atlas.png")
pixels = read_png(file)[0][0].astype(float) / 255
atlas = (pixels[..., :3] * (8 - 7 * pixels[..., 3:])) ** 2
tiles = [(0, 0, 512, 0)] + [(0, 512 - (512 >> i), 512 >> i, 2 * i / 11 if i < 6 else 1) for i in range(1, 7)]
tiles += [(512 - (512 >> i), 512 - (512 >> i), 512 >> i, 0) for i in range(1, 6)] + [(128, 384, 64, None)]
for left, top, width, roughness in tiles:
    cosine = 2 / 3 if roughness is None else mean_cosine(roughness)
    for x, y in ((0, 0), (width // 4, width // 8), (width - 1, width // 3), (width // 2, width // 2 - 1)):
        # A gutter of one texel goes on across the edges.
        phi = 2 * numpy.pi * ((x - 0.5) / (width - 2) - 0.5)
        theta = numpy.pi * (y - 0.5) / (width // 2 - 2)
        d = numpy.array([numpy.cos(phi) * numpy.sin(theta), numpy.cos(theta), numpy.sin(phi) * numpy.sin(theta)])
        wide = 16 / (width - 2) ** 2 if roughness == 0 else 0
        expected = 1 + 0.5 * cosine * numpy.array(playcanvas(*d))
        agree(f"playcanvas: tile at ({left}, {top}), texel ({x}, {y})", atlas[top + y, left + x], expected, 2e-2 + wide)

(file,) = env("unity-hdrp", "sky_specular.dds")
unity = lambda m: (1.7 - max(0, 2.89 - 2.8 * m / 6) ** 0.5) / 1.4
check_map("unity-hdrp", read_dds(file), 256, 7, unity, same, 2e-3)

(file,) = env("unreal", "sky_specular.dds")
unreal = lambda m: 0 if m == 0 else min(1, 2 ** ((1 - (7 - m)) / 1.2))
check_map("unreal", read_dds(file), 128, 8, unreal, lambda x, y, z: (x, z, y), 2e-3)

print(f"targets: {compared} places of environments agree")
