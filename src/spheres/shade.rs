// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels of the preview in f64: `shaders/spheres/*`, function by function. What each does is said there.

use super::lut::Lut;
use super::maps::Maps;
use super::pictures::Pictures;
use super::scene::{RADIUS, Scene, Seen};
use super::{Lighting, Method};
use crate::env::Frame;
use crate::term::cube::locate;
use crate::term::fresnel::schlick::schlick_weight;
use crate::term::surface::{body, compensation, specular};
use crate::term::visibility::{Directions, Visibility};

/// All that a picture is computed from.
pub(super) struct Shade<'a> {
    pub scene: &'a Scene,
    pub maps: &'a Maps,
    pub pictures: &'a Pictures,
    pub visibility: &'static Visibility,
    pub lighting: &'a Lighting,
    pub compensate: bool,
    pub background: Option<f32>,
    pub frame: Frame,
    pub method: Method,
}

#[derive(Clone, Copy)]
struct Surface {
    base: [f64; 3],
    metallic: f64,
    roughness: f64,
    f0: f64,
    edge: [f64; 3],
    sphere: usize,
    n: [f64; 3],
    split: [f64; 3],
}

fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + share * (b - a)
}

fn mix3(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| mix(a[c], b[c], share))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Shade<'_> {
    /// A pixel: radiance, and the share that is covered by spheres.
    pub fn pixel(&self, x: u32, y: u32) -> [f64; 4] {
        let middle = self.scene.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let parts = if self.is_alone(middle) { vec![middle] } else { self.scene.parts(x, y).to_vec() };
        let mut sum = [0.0; 4];
        for seen in &parts {
            let (light, covered) = match *seen {
                Seen::Sphere(sphere, n) => {
                    let surface = self.surface_at(sphere, n);
                    let shaded = match self.method {
                        Method::SplitSum => self.split_sum(&surface),
                        Method::Reference => self.reference(&surface),
                    };
                    (shaded, 1.0)
                }
                Seen::Behind(from_middle) => (self.behind(from_middle), 0.0),
            };
            (0..3).for_each(|c| sum[c] += light[c]);
            sum[3] += covered;
        }
        sum.map(|v| v / parts.len() as f64)
    }

    /// Does a rough sphere fill the pixel, so that one look of the reference will do?
    pub fn is_alone(&self, middle: Seen) -> bool {
        let Seen::Sphere(sphere, n) = middle else { return false };
        let most = 1.0 - 0.75 / (RADIUS * self.scene.tile_px());
        n[2] * n[2] > 1.0 - most * most && self.lighting.of_sphere[sphere].is_some()
    }

    fn lookup(&self, level: u32, d: [f64; 3]) -> [f64; 3] {
        let (first, size, _) = self.maps.levels.levels[level as usize];
        let (face, s, t) = locate(self.frame.to_picture(d));
        let n = f64::from(size);
        let place = [s, t].map(|c| (0.5 * c + 0.5) * n + 0.5);
        let whole = place.map(|p| p.floor().min(n));
        let share = [place[0] - whole[0], place[1] - whole[1]];
        let row = size + 2;
        let index = (first + (face * row + whole[1] as u32) * row + whole[0] as u32) as usize;
        let texel = |i: usize| {
            let [r, g, b, _] = self.maps.levels.texels[i];
            [r, g, b].map(f64::from)
        };
        let above = mix3(texel(index), texel(index + 1), share[0]);
        let below = mix3(texel(index + row as usize), texel(index + row as usize + 1), share[0]);
        mix3(above, below, share[1])
    }

    fn filtered(&self, d: [f64; 3], roughness: f64) -> [f64; 3] {
        let of = |level: u32| f64::from(self.maps.levels.levels[level as usize].2);
        let mut upper = 0;
        while upper + 1 < self.maps.mips && of(upper) < roughness {
            upper += 1;
        }
        let lower = upper.saturating_sub(1);
        let (from, to) = (of(lower), of(upper));
        let share = if to > from { ((roughness - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        mix3(self.lookup(lower, d), self.lookup(upper, d), share)
    }

    fn table(&self, n_dot_v: f64, roughness: f64) -> [f64; 3] {
        let Lut { width, height, warps, place, texels, .. } = &self.maps.table;
        let (width, height) = (*width, *height);
        let last = [f64::from(width - 1), f64::from(height - 1)];
        let place: [f64; 2] = std::array::from_fn(|i| {
            let (scale, shift) = place[i];
            (warps[i].position(n_dot_v, roughness) * scale + shift).clamp(0.0, last[i])
        });
        let whole = [place[0].floor().min((last[0] - 1.0).max(0.0)), place[1].floor().min((last[1] - 1.0).max(0.0))];
        let right = usize::from(width > 1);
        let down = if height > 1 { width as usize } else { 0 };
        let index = whole[1] as usize * width as usize + whole[0] as usize;
        std::array::from_fn(|c| {
            let at = |i: usize| f64::from(texels[i][c]);
            let share = place[0] - whole[0];
            let (above, below) =
                (mix(at(index), at(index + right), share), mix(at(index + down), at(index + down + right), share));
            mix(above, below, place[1] - whole[1])
        })
    }

    fn leaving(&self, s: &Surface, light: [[f64; 3]; 3], diffuse_light: [f64; 3]) -> [f64; 3] {
        let albedo = (s.split[0] + s.split[1]).max(1e-6);
        let gain_of = |f0: f64| if self.compensate { compensation(f0, albedo) } else { 1.0 };
        let gain_f0 = gain_of(s.f0);
        let reflected = (s.f0 * s.split[0] + s.split[1]) * gain_f0;
        std::array::from_fn(|c| {
            let split = light.map(|part| part[c]);
            specular(split, s.base[c], s.edge[c], s.f0, s.metallic, gain_of(s.base[c]), gain_f0)
                + body(s.base[c], s.metallic, reflected) * diffuse_light[c]
        })
    }

    fn paint(&self, s: &mut Surface) {
        let (n, p) = (s.n, self.pictures);
        let (width, height) = (p.width as usize, p.height as usize);
        let u = 0.5 + n[0].atan2(n[2]) / std::f64::consts::TAU;
        let v = n[1].clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        let mut place = [u * width as f64 - 0.5, (v * height as f64 - 0.5).max(0.0)];
        if place[0] < 0.0 {
            place[0] += width as f64;
        }
        let (x, y) = (place[0] as usize, place[1] as usize);
        let at =
            |x: usize, y: usize, i: usize, c: usize| f64::from(p.texels[y.min(height - 1) * width + x % width][i][c]);
        let share = [place[0].fract(), place[1].fract()];
        let value = |i: usize, c: usize| {
            mix(
                mix(at(x, y, i, c), at(x + 1, y, i, c), share[0]),
                mix(at(x, y + 1, i, c), at(x + 1, y + 1, i, c), share[0]),
                share[1],
            )
        };
        (0..3).for_each(|c| s.base[c] *= value(0, c));
        s.metallic *= value(0, 3);
        s.roughness *= value(1, 3);
        let scale = 1.0 / (n[0] * n[0] + n[2] * n[2]).max(1e-12).sqrt();
        let east = [n[2] * scale, 0.0, -n[0] * scale];
        let north = cross(n, east);
        s.n = crate::env::orientation::normalized(std::array::from_fn(|i| {
            value(1, 0) * east[i] + value(1, 1) * north[i] + value(1, 2) * n[i]
        }));
    }

    fn surface_at(&self, sphere: usize, n: [f64; 3]) -> Surface {
        let of = &self.scene.spheres[sphere];
        let mut s = Surface {
            base: of.base,
            metallic: of.metallic,
            roughness: of.roughness,
            f0: of.f0,
            edge: of.edge,
            sphere,
            n,
            split: [0.0; 3],
        };
        if self.pictures.width > 0 {
            self.paint(&mut s);
        }
        s.split = self.table(s.n[2].clamp(1e-4, 1.0), s.roughness);
        s
    }

    fn behind(&self, from_middle: [f64; 2]) -> [f64; 3] {
        match self.background {
            Some(radiance) => [f64::from(radiance); 3],
            None => {
                let [x, y] = from_middle.map(|v| v * 1.1547 / f64::from(self.scene.size.1));
                self.filtered([x, y, -1.0], 0.45)
            }
        }
    }

    fn split_sum(&self, s: &Surface) -> [f64; 3] {
        let light = self.filtered(mirrored(s.n), s.roughness);
        self.leaving(s, s.split.map(|part| light.map(|l| part * l)), self.diffuse(s))
    }

    fn diffuse(&self, s: &Surface) -> [f64; 3] {
        self.lookup(self.maps.diffuse_level(self.method), s.n)
    }

    fn source(&self, d: [f64; 3], lod: f64) -> [f64; 3] {
        let level = (lod + 0.5).floor().clamp(0.0, f64::from(self.maps.source_levels() - 1));
        self.lookup(self.maps.source_level + level as u32, d)
    }

    fn reference(&self, s: &Surface) -> [f64; 3] {
        let lobes = &self.lighting.lobes;
        if lobes.is_empty() {
            return self.integral(s, self.lighting.of_sphere[s.sphere]);
        }
        let at = s.roughness * (lobes.len() - 1) as f64;
        let lower = (at as usize).min(lobes.len() - 2);
        mix3(self.integral(s, lobes[lower]), self.integral(s, lobes[lower + 1]), at - lower as f64)
    }

    fn integral(&self, s: &Surface, lobe: Option<usize>) -> [f64; 3] {
        let n_dot_v = s.n[2].max(1e-4);
        let other = if s.n[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let t = crate::env::orientation::normalized(cross(other, s.n));
        let b = cross(s.n, t);
        let about =
            |[x, y]: [f64; 2], z: f64| -> [f64; 3] { std::array::from_fn(|i| x * t[i] + y * b[i] + z * s.n[i]) };
        let mut sums = [[0.0; 3]; 3];
        let mut add = |light: [f64; 3], v_dot_h: f64| {
            let schlick = schlick_weight(1.0 - v_dot_h);
            let parts = [1.0 - schlick, schlick, v_dot_h * (1.0 - v_dot_h) * schlick];
            for (sum, part) in sums.iter_mut().zip(parts) {
                (0..3).for_each(|c| sum[c] += part * light[c]);
            }
        };
        match lobe {
            None => {
                let d = Directions {
                    n_dot_l: n_dot_v,
                    n_dot_v,
                    n_dot_h: 1.0,
                    v_dot_h: n_dot_v,
                    sigma_l: n_dot_v,
                    sigma_v: n_dot_v,
                    alpha: 0.0,
                };
                let g = n_dot_v * (self.visibility.g_over_n_dot_v)(&d);
                let light = self.lookup(self.maps.source_level, mirrored(s.n));
                add(light.map(|l| g * l), n_dot_v);
            }
            Some(of) => {
                let (row, nodes) = &self.lighting.rows[of];
                let alpha = row.lobe.map_or(0.0, |lobe| lobe.alpha);
                let sigma_v = row.projected_area(n_dot_v);
                for node in nodes {
                    let n_dot_h = (1.0 - node.xy[0].powi(2) - node.xy[1].powi(2)).max(0.0).sqrt();
                    let h = about(node.xy, n_dot_h);
                    let v_dot_h = h[2];
                    let l = [2.0 * v_dot_h * h[0], 2.0 * v_dot_h * h[1], 2.0 * v_dot_h * h[2] - 1.0];
                    let n_dot_l: f64 = (0..3).map(|i| s.n[i] * l[i]).sum();
                    if v_dot_h <= 0.0 || n_dot_l <= 0.0 {
                        continue;
                    }
                    let sigma_l = row.projected_area(n_dot_l);
                    let d = Directions { n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha };
                    let f = node.weight * v_dot_h / n_dot_h * (self.visibility.g_over_n_dot_v)(&d);
                    let light = self.source(l, node.lod + 0.5 * v_dot_h.log2());
                    add(light.map(|l| f * l), v_dot_h);
                }
            }
        }
        self.leaving(s, sums, self.diffuse(s))
    }
}

/// The view, +Z, mirrored about n.
fn mirrored(n: [f64; 3]) -> [f64; 3] {
    [2.0 * n[2] * n[0], 2.0 * n[2] * n[1], 2.0 * n[2] * n[2] - 1.0]
}
