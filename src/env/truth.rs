//! truth
use super::Equirect;
use std::f64::consts::{PI, TAU};

/// Integrates `kernel(h)·L` over the picture for a lobe around `n`.
/// `width_rad` = kernel's narrowest feature.
pub fn integrate(source: &Equirect, n: [f64; 3], width_rad: f64, kernel: impl Fn(f64) -> f64) -> [f64; 3] {
    let (w, h) = (source.width as usize, source.height as usize);
    let (d_theta, d_phi) = (PI / h as f64, TAU / w as f64);
    let phi_n = n[2].atan2(n[0]);
    let sin_n = n[0].hypot(n[2]);
    let theta_n = sin_n.atan2(n[1]);
    let cosines: Vec<f64> = (0..w).map(|j| ((j as f64 + 0.5) * d_phi - PI - phi_n).cos()).collect();
    // 2x2 gauss, sub-grid
    let mut total = [0.0; 3];
    let size = d_theta.max(d_phi);
    for y in 0..h {
        let theta = (y as f64 + 0.5) * d_theta;
        let (s, c) = theta.sin_cos();
        let row = source.row(y as u32);
        let omega = 2.0 * s * (0.5 * d_theta).sin() * d_phi;
        let (a, b) = (c * n[1], s * sin_n);
        let d_t = (theta - theta_n).abs() - d_theta;
        let near_row = d_t < 6.0 * size.max(width_rad);
        let mut sum = [0.0; 3];
        for x in 0..w {
            let mu = a + b * cosines[x];
            // chord distance
            let dist2 = 2.0 - 2.0 * mu;
            let fine = near_row && dist2 < (12.0 * size.max(width_rad)).powi(2);
            let horizon = mu.abs() < 1.5 * size;
            let k = if fine || horizon {
                let d = (dist2.max(0.0).sqrt() - size).max(0.0).max(width_rad);
                let parts = if fine { (size / (0.25 * d)).ceil().clamp(1.0, 64.0) } else { 1.0 };
                let parts = if horizon { parts.max(2.0) } else { parts };
                let np = parts as usize;
                let g = 0.5 / 3f64.sqrt();
                let (mut sk, mut sw) = (0.0, 0.0);
                for i in 0..2 * np {
                    let off = |i: usize| ((i / 2) as f64 + 0.5 + if i % 2 == 0 { -g } else { g }) / np as f64;
                    let t = (y as f64 + off(i)) * d_theta;
                    let (st, ct) = t.sin_cos();
                    for j in 0..2 * np {
                        let p = (x as f64 + off(j)) * d_phi - PI - phi_n;
                        // accurate h: half angle
                        let hh = ((t - theta_n) * 0.5).sin().powi(2) + st * sin_n * (p * 0.5).sin().powi(2);
                        let _ = ct;
                        sk += st * kernel(hh);
                        sw += st;
                    }
                }
                sk / sw
            } else if mu > 0.0 {
                kernel(0.5 * (1.0 - mu))
            } else {
                continue;
            };
            for q in 0..3 {
                sum[q] += k * f64::from(row[x][q]);
            }
        }
        for q in 0..3 {
            total[q] += sum[q] * omega;
        }
    }
    total
}
