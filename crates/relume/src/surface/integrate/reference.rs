//! The slow truth of the Poisson solution: conjugate gradients (M. R. Hestenes, E. Stiefel, 1952) on the
//! normal equations over the pairs of neighbours, sharing nothing with the fast method.

use super::SurfaceBorder;
use crate::size::Size;
use crate::surface::slopes::Slopes;

/// A pair of neighbours and the difference their heights should have.
struct Edge {
    from: usize,
    to: usize,
    rise: f64,
}

/// Heights, zero on average, row after row from the top.
pub fn poisson(slopes: &Slopes, border: SurfaceBorder) -> Vec<f64> {
    let edges = edges(slopes, border);
    let mut heights = vec![0.0; slopes.size().texels()];
    let mut rest = vec![0.0; heights.len()];
    for edge in &edges {
        rest[edge.to] += edge.rise;
        rest[edge.from] -= edge.rise;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut direction = rest.clone();
    let mut square = dot(&rest, &rest);
    let enough = 1e-26 * square;
    for _ in 0..20 * heights.len() {
        if square <= enough {
            break;
        }
        let image = laplacian(&edges, &direction);
        let step = square / dot(&direction, &image);
        heights.iter_mut().zip(&direction).for_each(|(h, d)| *h += step * d);
        rest.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
        let next = dot(&rest, &rest);
        direction.iter_mut().zip(&rest).for_each(|(d, r)| *d = r + next / square * *d);
        square = next;
    }
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    heights.iter_mut().for_each(|h| *h -= mean);
    heights
}

fn edges(slopes: &Slopes, border: SurfaceBorder) -> Vec<Edge> {
    let size @ Size { width, height } = slopes.size();
    let mut edges = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let from = size.index(x, y);
        if x + 1 < width || border == SurfaceBorder::Periodic {
            let to = size.index((x + 1) % width, y);
            edges.push(Edge { from, to, rise: 0.5 * (slopes.p[from] + slopes.p[to]) });
        }
        if y + 1 < height || border == SurfaceBorder::Periodic {
            let to = size.index(x, (y + 1) % height);
            edges.push(Edge { from, to, rise: -0.5 * (slopes.q[from] + slopes.q[to]) });
        }
    }
    // A side of one texel is its own neighbour, which carries no information.
    edges.retain(|edge| edge.from != edge.to);
    edges
}

fn laplacian(edges: &[Edge], heights: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; heights.len()];
    for edge in edges {
        let difference = heights[edge.to] - heights[edge.from];
        image[edge.to] += difference;
        image[edge.from] -= difference;
    }
    image
}
