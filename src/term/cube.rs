// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cube faces: face and position → direction. GLSL twin: `shaders/term/cube.glsl`.
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

/// The face that a direction (of any length) meets, and where: face, s, t. The inverse of
/// [`direction`]. On an edge the lower axis wins (x before y before z).
pub fn locate(d: [f64; 3]) -> (u32, f64, f64) {
    let [x, y, z] = d;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        if x >= 0.0 { (0, -z / ax, -y / ax) } else { (1, z / ax, -y / ax) }
    } else if ay >= az {
        if y >= 0.0 { (2, x / ay, z / ay) } else { (3, x / ay, -z / ay) }
    } else if z >= 0.0 {
        (4, x / az, -y / az)
    } else {
        (5, -x / az, -y / az)
    }
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
}
