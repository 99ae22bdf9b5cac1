// SPDX-License-Identifier: MIT OR Apache-2.0
//! Environments from files: layouts, formats, orientation, adjustments, turning, and damaged files.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use brdf_baker::bake::Backend;
use brdf_baker::bake::specular::{SpecularJob, SpecularRequest};
use brdf_baker::env::import::{self, Adjust, Color, Imported, Layout, Options};
use brdf_baker::env::orientation::normalized;
use brdf_baker::env::{CubeMap, Environment, Equirect, FileAxes, Frame, Picture};
use brdf_baker::format::{Encoding, Format, Ktx2};
use brdf_baker::progress::ignore;
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::verify::environment::{Extent, check};
use brdf_baker::{Error, Result};
use exr::prelude as ex;
use exr::prelude::WritableImage;
use image_dds::ddsfile::{
    AlphaMode, Caps2, D3D10ResourceDimension, D3DFormat, Dds, DxgiFormat, FourCC, NewD3dParams, NewDxgiParams,
    PixelFormatFlags,
};
use tempfile::TempDir;

mod common;
use common::{Random, on_gpu};

type Rgb = [f32; 3];

// ---- Scenes and files ----

/// Uneven colours: no two texels alike. The values are halves.
fn speckled(size: u32) -> CubeMap {
    let mut random = Random(5);
    CubeMap::from_fn(size, |_| [0; 3].map(|_: i32| half::f16::from_f64(4.0 * random.next()).to_f32()))
}

/// Red grows along +X, green along +Y, blue along +Z.
fn compass(d: [f64; 3]) -> Rgb {
    normalized(d).map(|v| (0.5 + 0.5 * v) as f32)
}

/// A picture in rows from the top.
#[derive(Clone)]
struct Plane {
    width: usize,
    texels: Vec<Rgb>,
}

impl Plane {
    fn height(&self) -> usize {
        self.texels.len() / self.width
    }
}

/// Faces, by name, where a drawing puts them; `~` before a name turns it by 180°. Gaps hold texels that must not be read.
fn arranged(cube: &CubeMap, drawing: &[&str]) -> Plane {
    let n = cube.size as usize;
    let rows: Vec<Vec<&str>> = drawing.iter().map(|row| row.split(' ').collect()).collect();
    let width = n * rows[0].len();
    let mut texels = vec![[f32::NAN; 3]; width * n * rows.len()];
    for (i, row) in rows.iter().enumerate() {
        for (j, name) in row.iter().enumerate() {
            let names = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];
            let Some(face) = names.iter().position(|f| f == &name.trim_start_matches('~')) else { continue };
            for y in 0..n {
                for x in 0..n {
                    let (fx, fy) = if name.starts_with('~') { (n - 1 - x, n - 1 - y) } else { (x, y) };
                    texels[(i * n + y) * width + j * n + x] = cube.texel(face as u32, fx as u32, fy as u32);
                }
            }
        }
    }
    Plane { width, texels }
}

const CROSS: &[&str] = &[". +Y . .", "-X +Z +X -Z", ". -Y . ."];
const VERTICAL_CROSS: &[&str] = &[". +Y .", "-X +Z +X", ". -Y .", ". ~-Z ."];
const STRIP: &[&str] = &["+X -X +Y -Y +Z -Z"];
const VERTICAL_STRIP: &[&str] = &["+X", "-X", "+Y", "-Y", "+Z", "-Z"];
const LAYOUTS: [(Layout, &[&str]); 4] = [
    (Layout::Cross, CROSS),
    (Layout::VerticalCross, VERTICAL_CROSS),
    (Layout::Strip, STRIP),
    (Layout::VerticalStrip, VERTICAL_STRIP),
];

fn write_exr(path: &Path, plane: &Plane) {
    let at = |p: ex::Vec2<usize>| {
        let [r, g, b] = plane.texels[p.1 * plane.width + p.0];
        (r, g, b)
    };
    exr::prelude::write_rgb_file(path, plane.width, plane.height(), |x, y| at(ex::Vec2(x, y))).unwrap();
}

fn write_hdr(path: &Path, plane: &Plane) {
    let pixels: Vec<image::Rgb<f32>> = plane.texels.iter().map(|t| image::Rgb(*t)).collect();
    let file = std::fs::File::create(path).unwrap();
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, plane.width, plane.height()).unwrap();
}

fn write_png8(path: &Path, plane: &Plane) {
    let bytes = plane.texels.iter().flatten().map(|v| v.round() as u8).collect();
    image::RgbImage::from_raw(plane.width as u32, plane.height() as u32, bytes).unwrap().save(path).unwrap();
}

fn rgba(cube: &CubeMap) -> impl Iterator<Item = f32> {
    cube.texels.iter().flat_map(|t| [t[0], t[1], t[2], 1.0])
}

fn f32_bytes(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(f32::to_le_bytes).collect()
}

fn f16_bytes(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(|v| half::f16::from_f32(v).to_le_bytes()).collect()
}

/// The files that our own writer makes; read back by another reader elsewhere.
fn ktx2(cube: &CubeMap, encoding: &str) -> Vec<u8> {
    let texture = Texture {
        shape: Shape::Cube,
        width: cube.size,
        height: cube.size,
        channels: ["r", "g", "b"].map(String::from).to_vec(),
        levels: vec![cube.texels.as_flattened().to_vec()],
        meta: Meta::default(),
    };
    Ktx2.to_bytes(Path::new("t.ktx2"), &texture, Encoding::parse(encoding).unwrap().into()).unwrap()
}

/// A KTX2 cube of one level, any format, any supercompression scheme. No descriptor: readers of texels need none.
fn bare_ktx2(size: u32, vk_format: u32, scheme: u32, level: &[u8], uncompressed: usize) -> Vec<u8> {
    let mut out = vec![0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];
    for word in [vk_format, 1, size, size, 0, 0, 6, 1, scheme, 104, 0, 0, 0] {
        out.extend(u32::to_le_bytes(word));
    }
    for word in [0u64, 0, 104, level.len() as u64, uncompressed as u64] {
        out.extend(word.to_le_bytes());
    }
    out.extend(level);
    out
}

fn dds(size: u32, format: DxgiFormat, data: Vec<u8>) -> Vec<u8> {
    let mut dds = Dds::new_dxgi(NewDxgiParams {
        height: size,
        width: size,
        depth: None,
        format,
        mipmap_levels: None,
        array_layers: Some(6),
        caps2: Some(Caps2::CUBEMAP | Caps2::CUBEMAP_ALLFACES),
        is_cubemap: true,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        alpha_mode: AlphaMode::Opaque,
    })
    .unwrap();
    dds.data = data;
    let mut out = vec![];
    dds.write(&mut out).unwrap();
    out
}

fn put(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn read(path: impl AsRef<Path>) -> Result<Imported> {
    import::read(path.as_ref(), &Options::default(), &mut ignore)
}

fn cube_of(imported: Imported) -> CubeMap {
    match imported.environment.picture {
        Picture::Cube(cube) => cube.into_owned(),
        Picture::Equirect(_) => panic!("not a cube"),
    }
}

fn refused(path: impl AsRef<Path>, options: &Options, words: &[&str]) {
    let error = import::read(path.as_ref(), options, &mut ignore).expect_err("it must be refused");
    let text = format!("{error}; {}", error.help());
    for word in words {
        assert!(text.contains(word), "'{word}' is not in: {text}");
    }
    assert!(!error.help().is_empty(), "no way out: {text}");
}

fn job(size: u32, law: &str) -> SpecularJob {
    SpecularRequest { size: Some(size), roughness_law: law.into(), ..SpecularRequest::default() }.resolve().unwrap()
}

// ---- Layouts ----

#[test]
fn neighbours_in_a_drawing_continue_each_other() {
    // The drawings above, independent of the reader's table: on a smooth scene no step between neighbours of two faces
    // is larger than between those of one.
    let n = 16;
    let cube = CubeMap::from_fn(n as u32, compass);
    for drawing in [CROSS, VERTICAL_CROSS] {
        let plane = arranged(&cube, drawing);
        let at = |x: usize, y: usize| plane.texels[y * plane.width + x];
        let step = |a: Rgb, b: Rgb| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let mut seams = 0;
        for y in 0..plane.height() {
            for x in 0..plane.width {
                for (nx, ny) in [(x + 1, y), (x, y + 1)] {
                    if nx < plane.width && ny < plane.height() {
                        let (a, b) = (at(x, y), at(nx, ny));
                        if a[0].is_nan() || b[0].is_nan() {
                            continue;
                        }
                        seams += usize::from(nx % n == 0 && nx > x || ny % n == 0 && ny > y);
                        assert!(step(a, b) < 0.07, "{drawing:?}: ({x}, {y}) {a:?} beside ({nx}, {ny}) {b:?}");
                    }
                }
            }
        }
        // Five seams between six faces.
        assert_eq!(seams, 5 * n);
    }
}

#[test]
fn the_same_cube_comes_out_of_every_layout_and_container() {
    let folder = TempDir::new().unwrap();
    let cube = speckled(6);
    let same = |path: &Path, layout: &str| {
        let imported = read(path).unwrap();
        assert_eq!(imported.layout, layout, "{}", path.display());
        assert_eq!(cube_of(imported), cube, "{}", path.display());
    };
    for (layout, drawing) in LAYOUTS {
        let path = folder.path().join(format!("{}.exr", layout.name()));
        write_exr(&path, &arranged(&cube, drawing));
        same(&path, layout.name());
    }

    // Six files: in a folder, by a pattern, in a list.
    for (i, names) in
        ["px nx py ny pz nz", "PosX NegX PosY NegY PosZ NegZ", "right left up down front back"].iter().enumerate()
    {
        let inner = folder.path().join(format!("faces{i}"));
        std::fs::create_dir(&inner).unwrap();
        for (face, name) in names.split(' ').enumerate() {
            let texels = cube.texels[face * 36..][..36].to_vec();
            write_exr(&inner.join(format!("{name}.exr")), &Plane { width: 6, texels });
        }
        same(&inner, "faces");
    }
    same(&folder.path().join("faces0/{face}.exr"), "faces");
    same(&folder.path().join("faces2/{face}.exr"), "faces");
    let list: Vec<String> =
        ["px", "nx", "py", "ny", "pz", "nz"].map(|f| format!("{}/faces0/{f}.exr", folder.path().display())).to_vec();
    same(Path::new(&list.join(",")), "faces");

    // Containers.
    same(&put(&folder, "a.ktx2", &ktx2(&cube, "rgba32f")), "cube");
    same(&put(&folder, "b.ktx2", &ktx2(&cube, "rgba16f")), "cube");
    let halves = f16_bytes(rgba(&cube));
    let zstd = ruzstd::encoding::compress_to_vec(halves.as_slice(), ruzstd::encoding::CompressionLevel::Fastest);
    same(&put(&folder, "c.ktx2", &bare_ktx2(6, 97, 2, &zstd, halves.len())), "cube");
    let mut zlib = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::fast());
    std::io::copy(&mut halves.as_slice(), &mut zlib).unwrap();
    same(&put(&folder, "d.ktx2", &bare_ktx2(6, 97, 3, &zlib.finish().unwrap(), halves.len())), "cube");
    let rgb = f32_bytes(cube.texels.as_flattened().iter().copied());
    same(&put(&folder, "e.ktx2", &bare_ktx2(6, 106, 0, &rgb, rgb.len())), "cube");
    same(&put(&folder, "f.dds", &dds(6, DxgiFormat::R32G32B32A32_Float, f32_bytes(rgba(&cube)))), "cube");
    same(&put(&folder, "g.dds", &dds(6, DxgiFormat::R16G16B16A16_Float, halves)), "cube");

    // Half a cube of the program's own making: its mips lie below each other, and mip 0 is a standing strip.
    let texture = brdf_baker::format::for_path(Path::new("x.exr")).unwrap();
    let baked = job(6, "linear").run(&cube, &Backend::Cpu, &mut ignore).unwrap();
    let bytes = texture.to_bytes(Path::new("x.exr"), &baked, Encoding::parse("rgba32f").unwrap().into()).unwrap();
    same(&put(&folder, "h.exr", &bytes), "vertical-strip");
}

#[test]
fn mips_of_a_dds_file_are_passed_over() {
    let folder = TempDir::new().unwrap();
    let cube = speckled(4);
    let mut file = Dds::new_d3d(NewD3dParams {
        height: 4,
        width: 4,
        depth: None,
        format: D3DFormat::A32B32G32R32F,
        mipmap_levels: Some(3),
        caps2: Some(Caps2::CUBEMAP | Caps2::CUBEMAP_ALLFACES),
    })
    .unwrap();
    file.data = (0..6)
        .flat_map(|face| {
            let faces = cube.texels[face * 16..][..16].iter().flat_map(|t| [t[0], t[1], t[2], 1.0]);
            f32_bytes(faces.chain([9.0; 4 * (4 + 1)]))
        })
        .collect();
    // The writer leaves the code of this format out.
    file.header.spf.flags = PixelFormatFlags::FOURCC;
    file.header.spf.fourcc = Some(FourCC(FourCC::A32B32G32R32F));
    let mut bytes = vec![];
    file.write(&mut bytes).unwrap();
    assert_eq!(cube_of(read(put(&folder, "m.dds", &bytes)).unwrap()), cube);
    refused(put(&folder, "short.dds", &bytes[..bytes.len() - 4]), &Options::default(), &["cut short"]);
}

#[test]
fn a_smooth_scene_is_the_same_as_panorama_and_as_cube() {
    let panorama = Equirect::from_fn(256, |u, v| hills(Equirect::direction(u, v)));
    let cube = CubeMap::from_fn(128, hills);
    let job = job(32, "linear");
    let [a, b] =
        [job.run(&panorama, &Backend::Cpu, &mut ignore).unwrap(), job.run(&cube, &Backend::Cpu, &mut ignore).unwrap()];
    for (mip, (a, b)) in a.levels.iter().zip(&b.levels).enumerate() {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-3 * b, "mip {mip}: {a} and {b}");
        }
    }
}

#[test]
fn sizes_that_fit_no_layout_are_refused_with_the_list() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("odd.exr");
    write_exr(&path, &Plane { width: 5, texels: vec![[1.0; 3]; 20] });
    refused(
        &path,
        &Options::default(),
        &["5x4", "equirect 2:1", "strip 6:1", "vertical-strip 1:6", "cross 4:3", "vertical-cross 3:4"],
    );
    let cross = Options { layout: Some(Layout::Cross), ..Options::default() };
    refused(&path, &cross, &["5x4", "4:3", "--layout"]);
    assert!(Layout::parse("crss").unwrap_err().help().contains("'cross'"));
    // 4:3, but no whole faces.
    let odd = folder.path().join("odd_faces.hdr");
    std::fs::write(&odd, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8193 +X 16386\n").unwrap();
    refused(&odd, &Options::default(), &["16386x8193", "16384x8192"]);

    // Faces: not square, of several sizes, one missing, in two sets.
    let faces = folder.path().join("faces");
    std::fs::create_dir(&faces).unwrap();
    refused(&faces, &Options::default(), &["no six faces", "px nx py ny pz nz", "right left top bottom front back"]);
    let write = |name: &str, width: usize, height: usize| {
        write_exr(&faces.join(name), &Plane { width, texels: vec![[1.0; 3]; width * height] });
    };
    ["px", "nx", "py", "ny", "pz"].iter().for_each(|name| write(&format!("{name}.exr"), 2, 2));
    refused(&faces, &Options::default(), &["no six faces"]);
    write("nz.exr", 2, 3);
    refused(&faces, &Options::default(), &["nz.exr", "square"]);
    write("nz.exr", 3, 3);
    refused(&faces, &Options::default(), &["nz.exr", "2x2"]);
    write("nz.exr", 2, 2);
    assert!(read(&faces).is_ok());
    refused(&faces, &cross, &["--layout cross"]);
    ["right", "left", "top", "bottom", "front", "back"].iter().for_each(|name| write(&format!("{name}.exr"), 2, 2));
    refused(&faces, &Options::default(), &["2 sets"]);
}

// ---- Formats ----

#[test]
fn integers_are_srgb_unless_told() {
    let folder = TempDir::new().unwrap();
    let codes = [[0.0, 255.0, 188.0]; 8];
    let path = folder.path().join("a.png");
    write_png8(&path, &Plane { width: 4, texels: codes.to_vec() });
    let texel = |options: &Options, path: &Path| {
        import::read(path, options, &mut ignore).unwrap().environment.picture.texels()[3]
    };
    let srgb = texel(&Options::default(), &path);
    assert!(srgb[0] == 0.0 && srgb[1] == 1.0 && (srgb[2] - 0.502_886).abs() < 1e-6, "{srgb:?}");
    let linear = Options { color: Some(Color::Linear), ..Options::default() };
    assert_eq!(texel(&linear, &path), [0.0, 1.0, 188.0 / 255.0]);

    // 16 bits, grey with alpha, and JPEG.
    let deep = folder.path().join("b.png");
    image::ImageBuffer::<image::LumaA<u16>, _>::from_raw(4, 2, [13107u16, 7].repeat(8)).unwrap().save(&deep).unwrap();
    assert_eq!(texel(&linear, &deep), [0.2; 3]);
    assert!((texel(&Options::default(), &deep)[0] - 0.033_105).abs() < 1e-6);
    let jpeg = folder.path().join("c.jpg");
    image::RgbImage::from_pixel(32, 16, image::Rgb([200, 200, 200])).save(&jpeg).unwrap();
    assert!((texel(&linear, &jpeg)[1] - 200.0 / 255.0).abs() < 0.005);

    // KTX2 and DDS say it themselves.
    let bytes: Vec<u8> = [188, 0, 255, 9].repeat(6);
    let unorm = put(&folder, "d.ktx2", &bare_ktx2(1, 37, 0, &bytes, bytes.len()));
    let srgb = put(&folder, "e.ktx2", &bare_ktx2(1, 43, 0, &bytes, bytes.len()));
    assert_eq!(texel(&Options::default(), &unorm)[0], 188.0 / 255.0);
    assert!((texel(&Options::default(), &srgb)[0] - 0.502_886).abs() < 1e-6);
    assert_eq!(texel(&linear, &srgb)[0], 188.0 / 255.0);
    let bgra = put(&folder, "f.dds", &dds(1, DxgiFormat::B8G8R8A8_UNorm, bytes));
    assert_eq!(texel(&Options::default(), &bgra), [1.0, 0.0, 188.0 / 255.0]);
}

#[test]
fn block_compressed_cubes_are_read() {
    let folder = TempDir::new().unwrap();
    // BC6H, mode 11 (00011): both ends of every channel alike, all indices 0; unquantised as the specification says,
    // ((code << 16) + 0x8000) >> 10, then times 31/64: the bits of a half.
    let code = [0x1e0u128, 0x1f0, 0x100];
    let block = (0..3).fold(0b00011u128, |block, c| block | code[c] << (5 + 10 * c) | code[c] << (35 + 10 * c));
    let expected = code.map(|c| {
        let unquantised = (((c as u32) << 16) + 0x8000) >> 10;
        half::f16::from_bits(((unquantised * 31) >> 6) as u16).to_f32()
    });
    let bytes = block.to_le_bytes().repeat(6);
    for path in [
        put(&folder, "a.ktx2", &bare_ktx2(4, 143, 0, &bytes, bytes.len())),
        put(&folder, "b.dds", &dds(4, DxgiFormat::BC6H_UF16, bytes.clone())),
    ] {
        let cube = cube_of(read(&path).unwrap());
        assert!(cube.texels.iter().all(|t| *t == expected), "{:?} instead of {expected:?}", cube.texels[0]);
    }
    refused(
        put(&folder, "c.ktx2", &bare_ktx2(4, 158, 0, &bytes, bytes.len())),
        &Options::default(),
        &["VkFormat 158", "rgba16f"],
    );
    refused(
        put(&folder, "d.ktx2", &bare_ktx2(4, 0, 1, &bytes, bytes.len())),
        &Options::default(),
        &["Basis Universal"],
    );
}

/// Layers of channels, as the `exr` crate writes them.
fn layer(
    name: &str,
    size: (usize, usize),
    encoding: ex::Encoding,
    channels: &[(&str, ex::FlatSamples)],
) -> ex::Layer<ex::AnyChannels<ex::FlatSamples>> {
    let list = channels.iter().map(|(name, samples)| ex::AnyChannel::new(*name, samples.clone())).collect();
    let attributes = if name.is_empty() { ex::LayerAttributes::default() } else { ex::LayerAttributes::named(name) };
    ex::Layer::new(size, attributes, encoding, ex::AnyChannels::sort(list))
}

/// Halves whose number tells their place: 1 + index/64, plus an offset.
fn ramp(count: usize, offset: f32) -> Vec<half::f16> {
    (0..count).map(|i| half::f16::from_f32(offset + 1.0 + i as f32 / 64.0)).collect()
}

fn rgb_of(count: usize) -> Vec<(&'static str, ex::FlatSamples)> {
    [("R", 0.0), ("G", 10.0), ("B", 20.0)]
        .map(|(name, offset)| (name, ex::FlatSamples::F16(ramp(count, offset))))
        .to_vec()
}

#[test]
fn every_compression_and_block_kind_of_openexr_is_read() {
    let folder = TempDir::new().unwrap();
    let (width, height) = (32, 16);
    let expected: Vec<Rgb> =
        (0..width * height).map(|i| [0.0, 10.0, 20.0].map(|o| o + 1.0 + i as f32 / 64.0)).collect();
    use ex::Compression as C;
    for compression in [C::Uncompressed, C::RLE, C::ZIP1, C::ZIP16, C::PIZ, C::PXR24, C::B44, C::B44A] {
        for blocks in [ex::Blocks::ScanLines, ex::Blocks::Tiles(ex::Vec2(12, 7))] {
            let encoding = ex::Encoding { compression, blocks, line_order: ex::LineOrder::Increasing };
            let path = folder.path().join("a.exr");
            let image = ex::Image::from_layer(layer("", (width, height), encoding, &rgb_of(width * height)));
            image.write().to_file(&path).unwrap();
            let imported = read(&path).unwrap();
            assert!(imported.notes.is_empty(), "{:?}", imported.notes);
            let lossy = matches!(compression, C::B44 | C::B44A);
            for (found, expected) in imported.environment.picture.texels().iter().zip(&expected) {
                let near = found.iter().zip(expected).all(|(f, e)| (f - e).abs() <= if lossy { 0.05 * e } else { 0.0 });
                assert!(near, "{compression:?}, {blocks:?}: {found:?} instead of {expected:?}");
            }
        }
    }
}

#[test]
fn parts_layers_and_luminance_of_openexr_are_found() {
    let folder = TempDir::new().unwrap();
    let size = (4, 2);
    let plain = ex::Encoding::UNCOMPRESSED;
    let write = |name: &str, layers: Vec<ex::Layer<ex::AnyChannels<ex::FlatSamples>>>| {
        let path = folder.path().join(name);
        let bounds = ex::IntegerBounds::from_dimensions(size);
        let attributes = ex::ImageAttributes::new(bounds);
        ex::Image::from_layers(attributes, layers).write().to_file(&path).unwrap();
        path
    };
    let first = |path: &Path, part: Option<&str>| {
        let options = Options { part: part.map(String::from), ..Options::default() };
        let imported = import::read(path, &options, &mut ignore).unwrap();
        (imported.environment.picture.texels()[0], imported.notes)
    };
    let samples = |offset: f32| ex::FlatSamples::F32(ramp(8, offset).iter().map(|v| v.to_f32()).collect());

    // The first part has no colour.
    let depth = layer("depth", size, plain, &[("Z", samples(5.0))]);
    let beauty = layer("beauty", size, plain, &rgb_of(8));
    let second = layer("second", size, plain, &[("R", samples(7.0)), ("G", samples(8.0)), ("B", samples(9.0))]);
    let path = write("parts.exr", vec![depth, beauty, second]);
    assert_eq!(first(&path, None).0, [1.0, 11.0, 21.0]);
    assert_eq!(first(&path, Some("second")).0, [8.0, 9.0, 10.0]);
    let part = Options { part: Some("third".into()), ..Options::default() };
    refused(&path, &part, &["'third'", "beauty", "second", "depth"]);

    // Grey; floats and halves mixed.
    let path = write("grey.exr", vec![layer("", size, plain, &[("Y", samples(2.0)), ("A", samples(0.0))])]);
    assert_eq!(first(&path, None).0, [3.0; 3]);
    let path = write(
        "chroma.exr",
        vec![layer("", size, plain, &[("Y", samples(2.0)), ("RY", samples(0.0)), ("BY", samples(0.0))])],
    );
    refused(&path, &Options::default(), &["luminance and chroma"]);

    // Layers in one part: the only one is taken, several are not guessed.
    let left = [("left.R", samples(1.0)), ("left.G", samples(2.0)), ("left.B", samples(3.0))];
    let right = [("right.R", samples(4.0)), ("right.G", samples(5.0)), ("right.B", samples(6.0))];
    let path = write("left.exr", vec![layer("", size, plain, &left)]);
    let (texel, notes) = first(&path, None);
    assert!(texel == [2.0, 3.0, 4.0] && notes[0].contains("'left'"), "{texel:?} {notes:?}");
    let path = write("stereo.exr", vec![layer("", size, plain, &[left, right].concat())]);
    refused(&path, &Options::default(), &["left, right", "--part"]);
    assert_eq!(first(&path, Some("right")).0, [5.0, 6.0, 7.0]);
    let path = write("depth.exr", vec![layer("", size, plain, &[("Z", samples(5.0))])]);
    refused(&path, &Options::default(), &["no flat channels", "Z"]);
}

#[test]
fn a_data_window_lies_in_the_display_window() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("window.exr");
    let write = |position: (i32, i32), size: (usize, usize)| {
        let mut part = layer("", size, ex::Encoding::FAST_LOSSLESS, &rgb_of(size.0 * size.1));
        part.attributes.layer_position = ex::Vec2(position.0, position.1);
        let display = ex::IntegerBounds::new((10, 20), (8, 4));
        ex::Image::from_layers(ex::ImageAttributes::new(display), vec![part]).write().to_file(&path).unwrap();
        read(&path).unwrap()
    };
    // Smaller: columns 2 to 4, rows 1 and 2 of the display window.
    let imported = write((12, 21), (3, 2));
    assert!(
        imported.notes[0].contains("3x2 at 12,21") && imported.notes[0].contains("8x4 at 10,20"),
        "{:?}",
        imported.notes
    );
    let texels = imported.environment.picture.texels();
    assert_eq!(
        (texels.len(), texels[0], texels[8 + 2], texels[16 + 4]),
        (32, [0.0; 3], [1.0, 11.0, 21.0], [1.0 + 5.0 / 64.0, 11.0 + 5.0 / 64.0, 21.0 + 5.0 / 64.0])
    );
    assert_eq!(texels.iter().filter(|t| t[0] > 0.0).count(), 6);
    // Larger on all sides: overscan is cut off.
    let imported = write((9, 18), (11, 8));
    let texels = imported.environment.picture.texels();
    let at = |x: f32, y: f32| 1.0 + (y * 11.0 + x) / 64.0;
    assert_eq!((texels[0][0], texels[31][0]), (at(1.0, 2.0), at(8.0, 5.0)));
}

#[test]
fn damaged_and_strange_files_are_errors_at_every_length() {
    let folder = TempDir::new().unwrap();
    let plane = Plane { width: 8, texels: (0..32).map(|i| [i as f32, 1.0, 2.0]).collect() };
    let cube = speckled(2);
    write_exr(&folder.path().join("a.exr"), &plane);
    let tiles = ex::Encoding {
        compression: ex::Compression::ZIP16,
        blocks: ex::Blocks::Tiles(ex::Vec2(4, 4)),
        line_order: ex::LineOrder::Increasing,
    };
    ex::Image::from_layer(layer("", (8, 4), tiles, &rgb_of(32)))
        .write()
        .to_file(folder.path().join("tiles.exr"))
        .unwrap();
    write_hdr(&folder.path().join("a.hdr"), &plane);
    write_png8(&folder.path().join("a.png"), &plane);
    image::RgbImage::from_pixel(32, 16, image::Rgb([200, 100, 50])).save(folder.path().join("a.jpg")).unwrap();
    put(&folder, "a.ktx2", &ktx2(&cube, "rgba16f"));
    let halves = f16_bytes(rgba(&cube));
    let zstd = ruzstd::encoding::compress_to_vec(halves.as_slice(), ruzstd::encoding::CompressionLevel::Fastest);
    put(&folder, "z.ktx2", &bare_ktx2(2, 97, 2, &zstd, halves.len()));
    put(&folder, "a.dds", &dds(2, DxgiFormat::R16G16B16A16_Float, halves));
    for name in ["a.exr", "tiles.exr", "a.hdr", "a.png", "a.jpg", "a.ktx2", "z.ktx2", "a.dds"] {
        let whole = std::fs::read(folder.path().join(name)).unwrap();
        assert!(read(folder.path().join(name)).is_ok(), "{name}");
        let (mut passed, mut last_error) = (0, 0);
        for length in 0..whole.len() {
            match read(put(&folder, "cut", &whole[..length])) {
                Err(Error::Input { .. }) => last_error = length,
                Err(other) => panic!("{name} cut to {length} bytes: {other:?}"),
                Ok(_) => passed += 1,
            }
        }
        // Ends that hold no texels may be missing: a PNG's and a JPEG's end marks.
        assert!(
            passed <= 12 && last_error + 13 >= whole.len(),
            "{name}: {passed} lengths passed, last error at {last_error} of {}",
            whole.len()
        );
        // Flipped bytes may pass, but never panic.
        let mut random = Random(9);
        for _ in 0..300 {
            let mut bytes = whole.clone();
            let at = (random.next() * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << (random.next() * 8.0) as u32;
            let _ = read(put(&folder, "flipped", &bytes));
        }
    }
    refused(put(&folder, "text.exr", b"hello, this is text"), &Options::default(), &["format", ".hdr"]);
    refused(put(&folder, "empty.exr", b""), &Options::default(), &["empty"]);
    assert!(matches!(read(folder.path().join("none.exr")), Err(Error::Io { .. })));
}

// ---- Adjustments ----

fn panorama_of(texels: Vec<Rgb>) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("p.exr");
    write_exr(&path, &Plane { width: 4, texels });
    (folder, path)
}

#[test]
fn texels_that_are_not_finite_are_refused_or_repaired() {
    let mut texels = vec![[1.0f32; 3]; 8];
    texels[5] = [f32::NAN, 1.0, 1.0];
    texels[6] = [f32::INFINITY, 1.0, 1.0];
    let (_folder, path) = panorama_of(texels);
    refused(&path, &Options::default(), &["2 of its texels", "column 1, row 1", "--repair"]);
    let repair = Options { adjust: Adjust { repair: true, ..Adjust::default() }, ..Options::default() };
    let imported = import::read(&path, &repair, &mut ignore).unwrap();
    assert_eq!(imported.adjusted.repaired, 2);
    assert!(imported.environment.picture.texels().iter().flatten().all(|v| *v == 1.0));

    // In a cross the place is the picture's; gaps do not count.
    let folder = TempDir::new().unwrap();
    let cross = folder.path().join("cross.exr");
    let mut plane = arranged(&speckled(2), VERTICAL_CROSS);
    plane.texels[6 * 6 + 3] = [f32::NAN; 3];
    write_exr(&cross, &plane);
    refused(&cross, &Options::default(), &["1 of its texels", "column 3, row 6"]);
}

#[test]
fn negative_texels_count_as_0_and_are_counted() {
    let mut texels = vec![[1.0f32; 3]; 8];
    texels[2] = [-3894.0, 1.0, 2.0];
    texels[3] = [1.0, -0.5, -0.25];
    let (_folder, path) = panorama_of(texels);
    let imported = read(&path).unwrap();
    let negative = imported.adjusted.negative.unwrap();
    assert_eq!((negative.count, negative.lowest), (2, -3894.0));
    assert_eq!(imported.environment.picture.texels()[2..4], [[0.0, 1.0, 2.0], [1.0, 0.0, 0.0]]);
}

#[test]
fn exposure_by_powers_of_two_is_exact_and_scale_multiplies() {
    let texels: Vec<Rgb> = speckled(2).texels[..8].to_vec();
    let (_folder, path) = panorama_of(texels.clone());
    let adjusted =
        |adjust: Adjust| import::read(&path, &Options { adjust, ..Options::default() }, &mut ignore).unwrap();
    let brighter = adjusted(Adjust { exposure_ev: 3.0, scale: 0.5, ..Adjust::default() });
    let plain = adjusted(Adjust::default());
    let (a, b) = (brighter.environment.picture.texels(), plain.environment.picture.texels());
    assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| *a == 4.0 * b));
    // And so is every mip.
    let job = job(16, "linear");
    let [a, b] = [&brighter, &plain].map(|i| job.run(&i.environment, &Backend::Cpu, &mut ignore).unwrap());
    assert!(a.levels.iter().flatten().zip(b.levels.iter().flatten()).all(|(a, b)| *a == 4.0 * b), "a mip differs");
}

#[test]
fn clamping_reports_the_energy_that_it_removes() {
    let mut texels = vec![[1.0f32; 3]; 8];
    texels[1] = [100.0, 50.0, 0.0];
    let (_folder, path) = panorama_of(texels);
    let clamp =
        Options { adjust: Adjust { clamp: Some(20.0), exposure_ev: 1.0, ..Adjust::default() }, ..Options::default() };
    let imported = import::read(&path, &clamp, &mut ignore).unwrap();
    assert_eq!(imported.environment.picture.texels()[1], [20.0, 10.0, 0.0]);
    assert_eq!(imported.adjusted.clamped, 1);
    // 7 · 6 + 300 before and 7 · 6 + 30 after.
    assert!((imported.adjusted.removed - 270.0 / 342.0).abs() < 1e-9, "{}", imported.adjusted.removed);
}

#[test]
fn cancelling_while_reading_is_an_answer() {
    // Larger than the step between two looks at the listener, so that the decoders are in the middle of it.
    let folder = TempDir::new().unwrap();
    let mut random = Random(3);
    let plane = Plane {
        width: 1024,
        texels: (0..1024 * 512).map(|_| [0; 3].map(|_: i32| (255.0 * random.next()) as f32)).collect(),
    };
    write_exr(&folder.path().join("a.exr"), &plane);
    write_hdr(&folder.path().join("a.hdr"), &plane);
    write_png8(&folder.path().join("a.png"), &plane);
    let cube = speckled(256);
    put(&folder, "a.ktx2", &ktx2(&cube, "rgba16f"));
    put(&folder, "a.dds", &dds(256, DxgiFormat::R16G16B16A16_Float, f16_bytes(rgba(&cube))));
    for name in ["a.exr", "a.hdr", "a.png", "a.ktx2", "a.dds"] {
        for last in [0, 1] {
            let mut looks = 0;
            let stop = &mut |_: brdf_baker::progress::Progress<'_>| {
                looks += 1;
                if looks > last { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
            };
            let answer = import::read(&folder.path().join(name), &Options::default(), stop);
            assert!(matches!(answer, Err(Error::Cancelled)), "{name}, look {last}: {answer:?}");
        }
    }
}

// ---- Turning ----

/// Smooth, without any symmetry.
fn hills(d: [f64; 3]) -> Rgb {
    let [x, y, z] = normalized(d);
    [1.0 + 0.5 * x * y - 0.3 * z, 1.5 + 0.4 * x - 0.5 * y * z, 1.2 + (x * z + 0.2 * y) * 0.6].map(|v| v as f32)
}

#[test]
fn turning_the_picture_is_turning_the_scene() {
    let turns =
        [(false, [0.0, 30.0, 0.0]), (false, [20.0, -40.0, 110.0]), (true, [0.0, 0.0, 0.0]), (true, [-15.0, 70.0, 5.0])];
    let job = job(16, "linear");
    let bake = |environment: &Environment<'_>| job.run(environment, &Backend::Cpu, &mut ignore).unwrap();
    let panorama = Equirect::from_fn(128, |u, v| hills(Equirect::direction(u, v)));
    let cube = CubeMap::from_fn(64, hills);
    for (mirror, turns_deg) in turns {
        // By hand: about X, then Y, then Z; what ends at d began at the inverse.
        let began = |d: [f64; 3]| {
            let [a, b, c] = turns_deg.map(|v: f64| -v.to_radians());
            let [x, y, z] = d;
            let [x, y] = [x * c.cos() - y * c.sin(), x * c.sin() + y * c.cos()];
            let [z, x] = [z * b.cos() - x * b.sin(), z * b.sin() + x * b.cos()];
            let [y, z] = [y * a.cos() - z * a.sin(), y * a.sin() + z * a.cos()];
            [if mirror { -x } else { x }, y, z]
        };
        let expected =
            bake(&Environment::from(&Equirect::from_fn(128, |u, v| hills(began(Equirect::direction(u, v))))));
        let frame = Frame::new(mirror, turns_deg);
        for environment in [Environment::from(&panorama), Environment::from(&cube)] {
            let turned = bake(&Environment { frame, ..environment });
            for (mip, (a, b)) in turned.levels.iter().zip(&expected.levels).enumerate() {
                let off = a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f32::max);
                assert!(off <= 1e-3, "mirror {mirror}, {turns_deg:?}, mip {mip}: off by {off:e}");
            }
        }
    }
}

#[test]
fn quarter_turns_permute_faces() {
    on_gpu(|backend| {
        let mut random = Random(11);
        let panorama = Equirect::from_fn(64, |_, _| [0; 3].map(|_: i32| (0.2 + random.next()) as f32));
        let cube = speckled(32);
        let job = job(32, "linear");
        for environment in [Environment::from(&panorama), Environment::from(&cube)] {
            let straight = job.run(&environment, backend, &mut ignore).unwrap();
            let frame = Frame::new(false, [0.0, 90.0, 0.0]);
            let turned = job.run(&Environment { frame, ..environment }, backend, &mut ignore).unwrap();
            // +Z comes to +X, +X to −Z, −Z to −X, −X to +Z; their axes along.
            for (mip, (a, b)) in turned.levels.iter().zip(&straight.levels).enumerate() {
                let face = a.len() / 6;
                for (to, from) in [(0, 4), (5, 0), (1, 5), (4, 1)] {
                    for (a, b) in a[to * face..][..face].iter().zip(&b[from * face..][..face]) {
                        assert!((a - b).abs() <= 2e-5 * b, "mip {mip}, face {to}: {a} instead of {b}");
                    }
                }
            }
        }
    });
}

// ---- Cubes as sources ----

/// A dim cube of noise with lights of one texel: at a corner, on an edge, and inside a face.
fn lit_cube(size: u32) -> CubeMap {
    let mut random = Random(21);
    let mut cube = CubeMap::from_fn(size, |d| {
        let [x, y, z] = normalized(d);
        let lamp = 0.6 * x + 0.64 * y + 0.48 * z > (2.0f64).to_radians().cos();
        let noise = 0.05 + 0.1 * random.next();
        [noise, noise * (1.2 + 0.2 * y), noise].map(|v| (v + if lamp { 200.0 } else { 0.0 }) as f32)
    });
    let n = size as usize;
    for (texel, value) in [(0, 2000.0), (n * n + n / 3 * n + n - 1, 500.0), (3 * n * n + n / 2 * n + n / 3, 1000.0)] {
        cube.texels[texel] = [value, 0.5 * value, 0.2 * value];
    }
    cube
}

#[test]
fn every_mip_of_a_cube_agrees_with_a_brute_force_sum() {
    on_gpu(|backend| {
        for (size, law, frame) in [
            (128, "linear", Frame::IDENTITY),
            (100, "quadratic", Frame::new(true, [10.0, 20.0, 30.0])),
            (9, "quadratic", Frame::IDENTITY),
        ] {
            let cube = lit_cube(size);
            let job = job(256, law);
            let environment = Environment { frame, ..Environment::from(&cube) };
            let baked = job.run(&environment, backend, &mut ignore).unwrap();
            let errors = check(&job, &environment, &baked, Extent { random: 30, bright: 12 }, &mut ignore).unwrap();
            assert_eq!(errors.len(), 8);
            for e in errors {
                println!("faces of {size}, {law}: mip {} rms {:.1e}, max {:.1e}", e.mip, e.rms, e.max);
                assert!(e.rms <= 1e-3 && e.max <= 1e-2, "{size} {law}: mip {}: {:e} {:e}", e.mip, e.rms, e.max);
            }
            // Mip 0 keeps the mean.
            let (found, expected) = (brdf_baker::verify::cube::mean(&job, &baked, 0), cube.mean());
            assert!(found.iter().zip(expected).all(|(f, e)| (f / e - 1.0).abs() <= 1e-6), "{found:?} {expected:?}");
        }
    });
}

#[test]
fn gpu_agrees_with_its_twin_on_cubes() {
    on_gpu(|backend| {
        let cube = lit_cube(48);
        let frame = Frame::new(false, [5.0, 15.0, 0.0]);
        let environment = Environment { frame, ..Environment::from(&cube) };
        let job = job(64, "quadratic");
        let [gpu, cpu] = [backend, &Backend::Cpu].map(|b| job.run(&environment, b, &mut ignore).unwrap());
        for mip in 1..gpu.levels.len() {
            let mut errors: Vec<f32> =
                gpu.levels[mip].iter().zip(&cpu.levels[mip]).map(|(a, b)| (a / b - 1.0).abs()).collect();
            errors.sort_by(f32::total_cmp);
            let (worst, median) = (errors[errors.len() - 1], errors[errors.len() / 2]);
            println!("mip {mip} worst {worst:.1e}, median {median:.1e}");
            assert!(worst <= 1e-4 && median <= 2e-6, "mip {mip}: {worst:e} {median:e}");
        }
    });
}

#[test]
fn the_truths_of_panoramas_and_cubes_agree() {
    // One scene that both hold exactly enough: a smooth one.
    use brdf_baker::term::zonal::Peak;
    use brdf_baker::verify::cube_truth::CubeTruth;
    use brdf_baker::verify::environment::{Scale, Truth};
    let scale = Scale { width_rad: 0.1, peak: Peak::Axis };
    let panorama = Equirect::from_fn(256, |u, v| hills(Equirect::direction(u, v)));
    let cube = CubeMap::from_fn(128, hills);
    let kernel = |h: &mut [f64]| h.iter_mut().for_each(|h| *h = if *h < 0.5 { (-*h / 0.01).exp() } else { 0.0 });
    for n in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], normalized([1.0, 1.0, 1.0]), normalized([-0.3, 0.1, -0.9])] {
        let a = Truth::new(&panorama).integral(n, scale, kernel);
        let b = CubeTruth::new(&cube).integral(n, scale, kernel);
        assert!(a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 2e-4), "{n:?}: {a:?} {b:?}");
    }
    // White integrates to the kernel's norm: 4π ∫ exp(−h/0.01) dh.
    let white = CubeMap::from_fn(64, |_| [1.0; 3]);
    let norm = 4.0 * std::f64::consts::PI * 0.01 * (1.0 - (-50f64).exp());
    let found = CubeTruth::new(&white).integral(normalized([0.5, 0.2, 0.9]), scale, kernel);
    assert!(found.iter().all(|v| (v / norm - 1.0).abs() < 1e-5), "{found:?} {norm}");
}

#[test]
fn metadata_repeats_every_choice() {
    let options = Options {
        layout: Some(Layout::VerticalCross),
        color: Some(Color::Linear),
        part: Some("beauty".into()),
        adjust: Adjust { exposure_ev: -1.5, scale: 0.1, clamp: Some(1e3), repair: true },
        mirror: true,
        file_axes: FileAxes::parse("x,y,-z").unwrap(),
        turns_deg: [0.1, -45.0, 1.0 / 3.0],
    };
    let imported = Imported {
        environment: Environment {
            picture: Picture::Cube(std::borrow::Cow::Owned(speckled(1))),
            frame: Frame::IDENTITY,
        },
        layout: "vertical-cross",
        adjusted: import::Adjusted { removed: 0.25, ..Default::default() },
        notes: vec![],
    };
    let mut meta = Meta::default();
    options.describe(&imported, &mut meta);
    assert_eq!(Options::from_meta(&meta).unwrap(), options);
    assert_eq!(meta.get("input.clamp.removed"), Some("25.0000 % of the mean radiance"));
    meta.set("input.rotate", "1,2");
    assert!(Options::from_meta(&meta).is_err());
    assert_eq!(Options::from_meta(&Meta::default()).unwrap(), Options::default());
}

#[test]
fn png_of_another_program_is_read_from_memory_order() {
    // Rows from the top, texels from the left.
    let folder = TempDir::new().unwrap();
    let mut bytes = vec![];
    let picture = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb([x as u8, y as u8, 7]));
    picture.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    let linear = Options { color: Some(Color::Linear), ..Options::default() };
    let imported = import::read(&put(&folder, "o.png", &bytes), &linear, &mut ignore).unwrap();
    assert_eq!(imported.environment.picture.texels()[6], [2.0, 1.0, 7.0].map(|v: f32| v / 255.0));
}
