//! Writes a small outdoor environment for the demo: a blue sky with a low sun, haze at the horizon, tiled ground.
//!
//! `cargo run --release --example make_sky -- sky.exr`

use brdf_baker::env::Equirect;
use exr::prelude::write_rgb_file;

const HEIGHT: u32 = 256;

fn main() {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: make_sky FILE.exr");
        std::process::exit(2);
    };
    let sky = Equirect::from_fn(HEIGHT, |u, v| radiance(Equirect::direction(u, v)));
    let texel = |x: usize, y: usize| {
        let [r, g, b] = sky.texels[y * sky.width as usize + x];
        (r, g, b)
    };
    if let Err(error) = write_rgb_file(&path, sky.width as usize, sky.height as usize, texel) {
        eprintln!("error: cannot write '{path}': {error}");
        std::process::exit(2);
    }
}

/// Linear radiance from direction `d`; +Y is up.
fn radiance(d: [f64; 3]) -> [f32; 3] {
    let [x, y, z] = d;
    let sun = normalized([0.75, 0.42, 0.51]);
    let towards_sun = (x * sun[0] + y * sun[1] + z * sun[2]).clamp(-1.0, 1.0);
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t.clamp(0.0, 1.0));

    if y < 0.0 {
        // A floor 1.6 below the eye, in tiles of 2 × 2; it fades into the haze with distance.
        let (along, across) = (-1.6 * x / y, -1.6 * z / y);
        let tile = if ((0.5 * along).floor() + (0.5 * across).floor()).rem_euclid(2.0) < 1.0 { 0.32 } else { 0.12 };
        let floor = [tile, 0.92 * tile, 0.8 * tile];
        return mix([0.55, 0.6, 0.68], floor, -9.0 * y).map(|c| c as f32);
    }
    let blue = mix([0.75, 0.85, 1.0], [0.12, 0.28, 0.75], y.sqrt());
    // A disc of 1° (a texel is 0.7°) and the glow around it.
    let disc = if towards_sun > (0.5f64).to_radians().cos() { 1500.0 } else { 0.0 };
    let glow = 6.0 * towards_sun.max(0.0).powf(350.0) + 0.5 * towards_sun.max(0.0).powf(12.0);
    let warm = [1.0, 0.86, 0.65];
    [0, 1, 2].map(|k| (blue[k] + warm[k] * (glow + disc)) as f32)
}

fn normalized(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}
