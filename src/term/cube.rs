//! Cube faces: face and position ↔ direction, and solid angles. GLSL twin: `shaders/term/cube.glsl`.
//!
//! Faces are +X −X +Y −Y +Z −Z, numbered 0 to 5. `s` runs to the right and `t` downwards as the face is stored, both
//! from −1 to 1; on every face s × t points inwards, as the cube map tables of the Vulkan and KTX2 specifications say:
//!
//! | face | towards | s along | t along |
//! |---|---|---|---|
//! | 0 | +X | −Z | −Y |
//! | 1 | −X | +Z | −Y |
//! | 2 | +Y | +X | +Z |
//! | 3 | −Y | +X | −Z |
//! | 4 | +Z | +X | −Y |
//! | 5 | −Z | −X | −Y |

/// The point (s, t) of a face: a vector whose largest component is ±1. Normalise it to get a direction.
pub fn direction(face: u32, s: f64, t: f64) -> [f64; 3] {
    match face {
        0 => [1.0, -t, -s],
        1 => [-1.0, -t, s],
        2 => [s, 1.0, t],
        3 => [s, -1.0, -t],
        4 => [s, -t, 1.0],
        _ => [-s, -t, -1.0],
    }
}

/// The face that a direction (of any length) meets, and where: `[face, s, t]`. The inverse of [`direction`].
/// On an edge the lower axis wins (x before y before z).
pub fn locate(d: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = d;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        if x >= 0.0 { [0.0, -z / ax, -y / ax] } else { [1.0, z / ax, -y / ax] }
    } else if ay >= az {
        if y >= 0.0 { [2.0, x / ay, z / ay] } else { [3.0, x / ay, -z / ay] }
    } else if z >= 0.0 {
        [4.0, x / az, -y / az]
    } else {
        [5.0, -x / az, -y / az]
    }
}

/// Solid angle, in steradians, of the rectangle between a face's middle and (s, t); negative where s·t is.
/// A texel from (s0, t0) to (s1, t1) covers `solid_angle(s1, t1) − solid_angle(s0, t1) − solid_angle(s1, t0) +
/// solid_angle(s0, t0)`; a whole face covers 4·`solid_angle(1, 1)` = 4π/6.
pub fn solid_angle(s: f64, t: f64) -> f64 {
    (s * t / (1.0 + s * s + t * t).sqrt()).atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of the table above, as vectors: centre, s axis, t axis.
    const AXES: [[[f64; 3]; 3]; 6] = [
        [[1., 0., 0.], [0., 0., -1.], [0., -1., 0.]],
        [[-1., 0., 0.], [0., 0., 1.], [0., -1., 0.]],
        [[0., 1., 0.], [1., 0., 0.], [0., 0., 1.]],
        [[0., -1., 0.], [1., 0., 0.], [0., 0., -1.]],
        [[0., 0., 1.], [1., 0., 0.], [0., -1., 0.]],
        [[0., 0., -1.], [-1., 0., 0.], [0., -1., 0.]],
    ];

    #[test]
    fn direction_follows_the_table_of_the_specification() {
        for (face, [centre, s_axis, t_axis]) in AXES.iter().enumerate() {
            for (s, t) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-0.25, 0.75)] {
                let expected: [f64; 3] = std::array::from_fn(|i| centre[i] + s * s_axis[i] + t * t_axis[i]);
                assert_eq!(direction(face as u32, s, t), expected, "face {face} at ({s}, {t})");
            }
        }
    }

    #[test]
    fn locate_inverts_direction() {
        for face in 0..6 {
            for (s, t) in [(0.0, 0.0), (0.5, -0.25), (-0.75, 0.125), (0.25, 0.875)] {
                let d = direction(face, s, t).map(|v| v * 3.0);
                assert_eq!(locate(d), [f64::from(face), s, t]);
            }
        }
    }

    #[test]
    fn a_face_is_a_sixth_of_the_sphere() {
        let sixth = 4.0 * std::f64::consts::PI / 6.0;
        assert!((4.0 * solid_angle(1.0, 1.0) - sixth).abs() < 1e-15);
    }
}
