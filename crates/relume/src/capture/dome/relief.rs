//! The height field under the dome: what lies beyond its borders, its slopes and its normals.

use crate::names::named;
use crate::planes::Planes;
use crate::size::Size;

/// What lies beyond the borders of the maps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ReliefBorder {
    /// The maps are repeated: light and shadow cross the borders of a seamless material.
    Wrap,
    /// The height of the border texels is continued.
    #[default]
    Clamp,
}

named!(ReliefBorder { Wrap => "wrap", Clamp => "clamp" });

/// Heights with their border. Rows are stored three times in sequence, so that a row shifted by any number of
/// texels is one slice.
#[derive(Debug, Clone)]
pub struct Relief {
    size: Size,
    border: ReliefBorder,
    extended: Vec<f32>,
    lowest: f32,
    highest: f32,
}

impl Relief {
    /// The relief of one plane of finite heights in texels.
    pub fn new(height: &Planes, border: ReliefBorder) -> Self {
        let size = height.size();
        let mut extended = Vec::with_capacity(3 * size.texels());
        for row in height.plane(0).chunks_exact(size.width) {
            let (first, last) = (row[0], row[size.width - 1]);
            match border {
                ReliefBorder::Wrap => (0..3).for_each(|_| extended.extend_from_slice(row)),
                ReliefBorder::Clamp => {
                    extended.extend(std::iter::repeat_n(first, size.width));
                    extended.extend_from_slice(row);
                    extended.extend(std::iter::repeat_n(last, size.width));
                }
            }
        }
        let (lowest, highest) = height.range(0);
        Self { size, border, extended, lowest, highest }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// What lies beyond the borders.
    pub fn border(&self) -> ReliefBorder {
        self.border
    }

    /// The highest texel.
    pub fn highest(&self) -> f32 {
        self.highest
    }

    /// The difference between the highest and the lowest texel.
    pub fn range(&self) -> f32 {
        self.highest - self.lowest
    }

    /// The longest distance, in texels, to which a ray is followed: twice around the maps. Beyond it a
    /// periodic relief has shown nearly all its heights, and a clamped one is flat.
    pub fn reach(&self) -> f64 {
        2.0 * (self.size.width + self.size.height) as f64
    }

    /// Row `y` from column `shift` on, as wide as the map; both may lie outside.
    pub fn row(&self, y: isize, shift: isize) -> &[f32] {
        let width = self.size.width as isize;
        let start = match self.border {
            ReliefBorder::Wrap => shift.rem_euclid(width),
            ReliefBorder::Clamp => width + shift.clamp(-width, width),
        };
        let start = 3 * self.size.width * inside(self.border, y, self.size.height) + start as usize;
        &self.extended[start..start + self.size.width]
    }

    /// The texel that represents (x, y), which may lie outside.
    pub fn texel(&self, x: isize, y: isize) -> usize {
        let column = inside(self.border, x, self.size.width);
        self.size.index(column, inside(self.border, y, self.size.height))
    }

    /// The height at (x, y), which may lie outside.
    pub fn at(&self, x: isize, y: isize) -> f32 {
        self.row(y, 0)[inside(self.border, x, self.size.width)]
    }

    /// The height between texels, bilinear.
    pub fn between(&self, x: f64, y: f64) -> f64 {
        let (column, row) = (x.floor(), y.floor());
        let (s, t) = (x - column, y - row);
        let corner = |i: isize, j: isize| f64::from(self.at(column as isize + i, row as isize + j));
        let top = corner(0, 0) * (1.0 - s) + corner(1, 0) * s;
        let bottom = corner(0, 1) * (1.0 - s) + corner(1, 1) * s;
        top * (1.0 - t) + bottom * t
    }

    /// Unit normals by central differences; one-sided at a clamped border.
    pub fn normals(&self) -> Planes {
        let mut normals = Planes::zeros(self.size, 3);
        let Size { width, height } = self.size;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let normal = self.normal(x as isize, y as isize);
            (0..3).for_each(|k| normals.plane_mut(k)[self.size.index(x, y)] = normal[k]);
        }
        normals
    }

    fn normal(&self, x: isize, y: isize) -> [f32; 3] {
        let span = |at: isize, side: usize| match self.border {
            ReliefBorder::Clamp => 2.min(side as isize - at) - 1 + 1.min(at),
            ReliefBorder::Wrap => 2,
        };
        let slope = |rise: f32, span: isize| if span > 0 { rise / span as f32 } else { 0.0 };
        let along_x = slope(self.at(x + 1, y) - self.at(x - 1, y), span(x, self.size.width));
        // Rows run down, y runs up.
        let along_y = slope(self.at(x, y - 1) - self.at(x, y + 1), span(y, self.size.height));
        let length = (along_x * along_x + along_y * along_y + 1.0).sqrt();
        [-along_x / length, -along_y / length, 1.0 / length]
    }
}

fn inside(border: ReliefBorder, at: isize, side: usize) -> usize {
    match border {
        ReliefBorder::Wrap => at.rem_euclid(side as isize) as usize,
        ReliefBorder::Clamp => at.clamp(0, side as isize - 1) as usize,
    }
}

/// A relief of heights at (x, y), for tests.
#[cfg(test)]
pub(super) fn relief_of(size: Size, border: ReliefBorder, height: impl Fn(f64, f64) -> f64) -> Relief {
    let values = (0..size.texels()).map(|i| height((i % size.width) as f64, (i / size.width) as f64) as f32);
    Relief::new(&Planes::from_vec(size, 1, values.collect()).unwrap(), border)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(border: ReliefBorder) -> Relief {
        let size = Size::new(5, 4);
        let data = (0..20).map(|i| ((i * i * 7) % 23) as f32).collect();
        Relief::new(&Planes::from_vec(size, 1, data).unwrap(), border)
    }

    #[test]
    fn shifted_rows_are_the_texels_they_name() {
        for border in [ReliefBorder::Wrap, ReliefBorder::Clamp] {
            let relief = relief(border);
            for (y, shift) in (-9..9).flat_map(|y| (-14..14).map(move |s| (y, s))) {
                let row: Vec<f32> = (0..5).map(|x| relief.at(x + shift, y)).collect();
                assert_eq!(relief.row(y, shift), row, "{border:?} {y} {shift}");
                assert_eq!(relief.row(0, 0)[0], relief.between(0.0, 0.0) as f32);
            }
        }
        assert_eq!(relief(ReliefBorder::Wrap).at(-1, 5), relief(ReliefBorder::Wrap).at(4, 1));
        assert_eq!(relief(ReliefBorder::Clamp).at(-1, 5), relief(ReliefBorder::Clamp).at(0, 3));
    }

    #[test]
    fn the_normals_of_a_plane_are_the_planes_everywhere() {
        let size = Size::new(6, 5);
        // z = 0.5 x - 0.25 y with y up: rows fall by one as y rises by one.
        let data = (0..30).map(|i| 0.5 * (i % 6) as f32 + 0.25 * (i / 6) as f32).collect();
        let relief = Relief::new(&Planes::from_vec(size, 1, data).unwrap(), ReliefBorder::Clamp);
        let length = (0.25f32 + 0.0625 + 1.0).sqrt();
        let normals = relief.normals();
        for i in 0..30 {
            let found = [0, 1, 2].map(|k| normals.plane(k)[i]);
            let truth = [-0.5 / length, 0.25 / length, 1.0 / length];
            assert!(found.iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-6), "texel {i}: {found:?}");
        }
    }
}
