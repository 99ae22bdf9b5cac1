// SPDX-License-Identifier: MIT OR Apache-2.0
//! Means over convex spherical polygons, whatever the picture and however it is turned.

use super::Rgb;
use super::faces::Grid;
use super::turned::Field;
use crate::env::{Environment, Frame, Picture};

/// An environment, ready for means over polygons.
pub struct Means<'a> {
    kind: Kind<'a>,
    frame: Frame,
}

enum Kind<'a> {
    Equirect(Field<'a>),
    Cube(Box<Grid<'a>>),
}

impl<'a> Means<'a> {
    /// Prepares an environment.
    pub fn new(environment: &'a Environment<'_>) -> Self {
        let kind = match &environment.picture {
            Picture::Equirect(picture) => Kind::Equirect(Field::new(picture)),
            Picture::Cube(picture) => Kind::Cube(Box::new(Grid::new(picture))),
        };
        Self { kind, frame: environment.frame }
    }

    /// Mean radiance over a convex polygon of great circles, smaller than a hemisphere and not empty. Corners are
    /// directions of the output, of any length, in order; at most 8.
    pub fn mean(&self, corners: &[[f64; 3]]) -> [f64; 3] {
        let mut inside = [[0.0; 3]; MOST_CORNERS];
        let inside = &mut inside[..corners.len()];
        inside.iter_mut().zip(corners).for_each(|(i, c)| *i = self.frame.to_picture(*c));
        let mean: Rgb = match &self.kind {
            Kind::Equirect(field) => field.mean(inside),
            Kind::Cube(grid) => grid.mean(inside),
        };
        // Radiance is not negative; rounding may leave −1e−17 beside a sun.
        mean.map(|v| v.max(0.0))
    }
}

/// Of a polygon.
const MOST_CORNERS: usize = 8;
