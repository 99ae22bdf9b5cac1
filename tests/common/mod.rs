// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shared by the integration tests.
#![allow(dead_code, reason = "no test uses all of it")]

pub mod program;

use brdf_baker::bake::Backend;
use brdf_baker::gpu::Gpu;

/// The Vulkan device of the tests, under the validation and synchronisation layers.
///
/// Without a device a test says that it skips; with `REQUIRE_GPU=1` that is a failure.
pub fn gpu() -> Option<Gpu> {
    match Gpu::open("auto", true) {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set: {error}"),
        Err(error) => {
            eprintln!("skipped: no Vulkan device ({error})");
            None
        }
    }
}

/// Runs `body` on the test device; any message of the layers, leaks at the end included, fails the test.
pub fn on_gpu(body: impl FnOnce(&Backend)) {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    body(&backend);
    let Backend::Gpu(gpu) = backend else { unreachable!("made two lines above") };
    let messages = gpu.close();
    assert!(messages.is_empty(), "the validation layers say: {messages:#?}");
}

/// Numbers in [0, 1) from a fixed seed: SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// One member or more of every family of distributions, corners of their parameters included.
pub const NDFS: [&str; 10] = [
    "ggx",
    "beckmann",
    "blinn-phong",
    "gtr:gamma=1",
    "gtr:gamma=1.5",
    "gtr:gamma=3",
    "abc:a2=1",
    "abc:a2=3",
    "abc:a1=50,a2=2",
    "charlie",
];

/// Anisotropic lobes, corners of ratio and azimuth included.
pub const ELLIPTIC: [&str; 4] =
    ["ggx:ratio=0.04,azimuth=75", "ggx:ratio=0.1,azimuth=85", "ggx:ratio=0.3,azimuth=30", "ggx:ratio=0.7"];

/// Every Fresnel term, with constants of a gem, of glass from both sides, of a silvery and of a coloured metal.
pub const FRESNELS: [&str; 7] = [
    "one",
    "schlick",
    "dielectric:ior=1.5",
    "dielectric:ior=2.4",
    "dielectric:ior=0.6666666666666666",
    "conductor:eta=1.5/1/0.7,k=7.6/6.6/5.4",
    "conductor:eta=0.2/1.1/1.25,k=3.9/2.6/2.3",
];
