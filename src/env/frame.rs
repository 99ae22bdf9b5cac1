// SPDX-License-Identifier: MIT OR Apache-2.0
//! How an environment is turned, and mirrored, on its way into a cube.
//!
//! A picture stays as it is: directions of the output are carried into the picture's own axes, which is exact at every
//! mip. Turning is right-handed: by 90° about +Y, what was at +Z comes to lie at +X.

use super::FileAxes;

/// An orthogonal map from directions of the output to directions of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Row i, times a direction of the output, is component i in the picture.
    rows: [[f64; 3]; 3],
}

impl Frame {
    /// The picture as it is.
    pub const IDENTITY: Frame = Frame { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// The environment mirrored first, x becoming −x, where `mirror` asks for it; then turned about the X, the Y and the
    /// Z axis by `turns_deg`, in this order, about axes that stay fixed. Multiples of 90° are exact.
    pub fn new(mirror: bool, turns_deg: [f64; 3]) -> Frame {
        let [(sx, cx), (sy, cy), (sz, cz)] = turns_deg.map(sin_cos_deg);
        let turn_x = [[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]];
        let turn_y = [[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]];
        let turn_z = [[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]];
        let forward = product(turn_z, product(turn_y, turn_x));
        let sign = if mirror { -1.0 } else { 1.0 };
        let inverse: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| forward[j][i]));
        Frame { rows: [inverse[0].map(|v| sign * v), inverse[1], inverse[2]] }
    }

    /// The same for a file whose axes point elsewhere.
    pub fn for_file(&self, axes: &FileAxes) -> Frame {
        Frame { rows: product(self.rows, axes.rows()) }
    }

    /// The same before a viewer with a frame of its own: from directions of `view`'s output to the picture's.
    pub fn seen_through(&self, view: &Frame) -> Frame {
        Frame { rows: product(self.rows, view.rows) }
    }

    /// Row i, times a direction of the output, is component i in the picture.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        self.rows
    }

    /// The direction in the picture that `d`, a direction of the output, shows.
    pub fn to_picture(&self, d: [f64; 3]) -> [f64; 3] {
        self.rows.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
    }

    /// The direction of the output that shows `d`, a direction in the picture. The inverse of [`Frame::to_picture`].
    pub fn from_picture(&self, d: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|j| (0..3).map(|i| self.rows[i][j] * d[i]).sum())
    }

    /// Does it mirror?
    pub fn mirrors(&self) -> bool {
        let [a, b, c] = self.rows;
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2] < 0.0
    }

    /// Where only azimuths change: what is added to the azimuth φ of the output ([`crate::env`]) to get the picture's,
    /// in radians.
    pub fn azimuth_rad(&self) -> Option<f64> {
        let upright = self.rows[1] == [0.0, 1.0, 0.0] && !self.mirrors();
        upright.then(|| self.rows[2][0].atan2(self.rows[0][0]))
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°.
fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let quarters = (angle_deg / 90.0).round();
    let (sin, cos) = (angle_deg - 90.0 * quarters).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u32 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn turns_are_right_handed() {
        assert_eq!(Frame::new(false, [0.0, 90.0, 0.0]).from_picture(Z), X);
        assert_eq!(Frame::new(false, [90.0, 0.0, 0.0]).from_picture(Y), Z);
        assert_eq!(Frame::new(false, [0.0, 0.0, -270.0]).from_picture(X), Y);
        // About X first, then about Y.
        assert_eq!(Frame::new(false, [90.0, 90.0, 0.0]).from_picture(Y), X);
    }

    #[test]
    fn mirroring_comes_before_turning() {
        let frame = Frame::new(true, [0.0, 90.0, 0.0]);
        assert_eq!(frame.from_picture(X), [0.0, 0.0, 1.0]);
        assert_eq!(frame.from_picture(Z), X);
        assert!(frame.mirrors() && frame.azimuth_rad().is_none());
    }

    #[test]
    fn axes_of_the_file_come_last() {
        // The environment is turned by 90°: what was at +Z is at +X, and the file has it at −X.
        let frame = Frame::new(false, [0.0, 90.0, 0.0]).for_file(&FileAxes::parse("-x,y,z").expect("it is a name"));
        assert_eq!(frame.from_picture(Z), X.map(|v| -v));
        assert!(frame.mirrors());
    }

    #[test]
    fn to_picture_inverts_from_picture() {
        for mirror in [false, true] {
            let frame = Frame::new(mirror, [12.0, -77.0, 190.5]);
            let d = frame.to_picture(frame.from_picture([0.2, -0.5, 0.7]));
            assert!(d.iter().zip([0.2, -0.5, 0.7]).all(|(a, b)| (a - b).abs() < 1e-15), "{d:?}");
        }
    }

    #[test]
    fn azimuth_is_that_of_the_picture() {
        let frame = Frame::new(false, [0.0, 30.0, 0.0]);
        let phi = frame.azimuth_rad().expect("it is upright");
        let [x, _, z] = frame.to_picture(X);
        assert!((z.atan2(x) - phi).abs() < 1e-15);
        assert!(Frame::new(false, [1.0, 30.0, 0.0]).azimuth_rad().is_none());
    }
}
