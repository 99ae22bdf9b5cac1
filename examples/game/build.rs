// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bakes the split-sum table and the environment of the first level. Cargo runs it again when the environment changes.

use std::path::Path;

use brdf_baker::Result;
use brdf_baker::asset::Baker;
use brdf_baker::bake::TableRequest;
use brdf_baker::bake::specular::SpecularRequest;

const SKY: &str = "assets/sky.hdr";

fn main() {
    println!("cargo::rerun-if-changed={SKY}");
    let out = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    if let Err(error) = bake(Path::new(&out)) {
        println!("cargo::error={error} ({})", error.help());
        std::process::exit(1);
    }
}

fn bake(out: &Path) -> Result<()> {
    // A machine that builds games may have no graphics card: software Vulkan or the processor then bake the same.
    let baker = Baker::open("auto")?;
    baker.table(&TableRequest { size: (64, 64), ..TableRequest::new("split-sum") }, out.join("dfg.ktx2"))?;
    let request = SpecularRequest { size: Some(64), ..SpecularRequest::default() };
    baker.environment(SKY, &request, out.join("sky.ktx2"))?;
    Ok(())
}
