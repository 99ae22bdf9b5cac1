// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a game does with the files that its build script baked: here it only looks at them.

use half::f16;
use ktx2::Reader;

static DFG: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/dfg.ktx2"));
static SKY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/sky.ktx2"));

fn main() {
    let [scale, bias] = dfg(0.5, 0.4);
    println!("gold of roughness 0.4 seen at 60 degrees reflects {:.4} of red light", 1.0 * scale + bias);
    let sky = Reader::new(SKY).expect("the build script wrote KTX2").header();
    println!("the sky has {} faces of {} texels and {} mips", sky.face_count, sky.pixel_width, sky.level_count);
}

/// The table's nearest texel: two half floats, n·v to the right, roughness downwards.
fn dfg(n_dot_v: f32, roughness: f32) -> [f32; 2] {
    let file = Reader::new(DFG).expect("the build script wrote KTX2");
    let size = file.header().pixel_width;
    let texels = file.levels().next().expect("a table has a level").data;
    let [x, y] = [n_dot_v, roughness].map(|c| ((c * size as f32) as u32).min(size - 1));
    let at = 4 * (y * size + x) as usize;
    [0, 2].map(|i| f16::from_le_bytes([texels[at + i], texels[at + i + 1]]).to_f32())
}
