// SPDX-License-Identifier: MIT OR Apache-2.0
//! Directions and solid angles on a cube's faces. [`crate::term::cube`] says where faces look and how they are stored.

pub use crate::term::cube::locate;

/// Solid angle, in steradians, of the rectangle between a face's middle and (s, t); negative where s·t is.
/// A texel from (s0, t0) to (s1, t1) covers `solid_angle(s1, t1) − solid_angle(s0, t1) − solid_angle(s1, t0) +
/// solid_angle(s0, t0)`; a whole face covers 4·`solid_angle(1, 1)` = 4π/6.
pub fn solid_angle(s: f64, t: f64) -> f64 {
    (s * t / (1.0 + s * s + t * t).sqrt()).atan()
}

/// The point (s, t) of a face that texel (x, y) of `size` × `size` has its centre at.
pub fn centre(x: u32, y: u32, size: u32) -> (f64, f64) {
    let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
    (at(x), at(y))
}

/// `v` at length 1.
pub fn normalized(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::term::cube::direction;

    #[test]
    fn locate_inverts_direction() {
        for face in 0..6 {
            for (s, t) in [(0.0, 0.0), (0.5, -0.25), (-0.75, 0.125), (0.25, 0.875)] {
                let d = direction(face, s, t).map(|v| v * 3.0);
                assert_eq!(locate(d), (face, s, t));
            }
        }
    }

    #[test]
    fn a_face_is_a_sixth_of_the_sphere() {
        let sixth = 4.0 * std::f64::consts::PI / 6.0;
        assert!((4.0 * solid_angle(1.0, 1.0) - sixth).abs() < 1e-15);
    }
}
