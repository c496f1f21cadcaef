//! A small texture of each kind of model, for tests.

use super::{ParametricField, PerViewModel, SeparableModel, TexelModel, ViewFunction};
use crate::direction::Direction;
use crate::field::Basis;
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// One of each kind, grey and in colour.
pub(crate) fn all() -> Vec<ParametricField> {
    let views: Vec<Direction> =
        (0..5).map(|i| Direction::from_angles(0.2 * f64::from(i), 2.4 * f64::from(i))).collect();
    let per_view = |function| TexelModel::PerView(PerViewModel::new(&views, function).unwrap());
    let separable = SeparableModel::new(&views[..4], &views, 2, Space::Srgb).unwrap();
    let models = [
        TexelModel::Lafortune { lobes: 1 },
        TexelModel::Lafortune { lobes: 2 },
        TexelModel::Ggx,
        per_view(ViewFunction::Basis(Basis::Ptm, Space::Srgb)),
        per_view(ViewFunction::Lobes(1)),
        TexelModel::Separable(separable),
    ];
    models.into_iter().flat_map(|model| [1, 3].map(|channels| example(model.clone(), channels))).collect()
}

fn example(model: TexelModel, channels: usize) -> ParametricField {
    let mut stream = Stream::new(8, Purpose::Sample, [channels as u64]);
    let size = Size::new(5, 3);
    let planes = model.numbers(channels);
    let data = (0..planes * size.texels()).map(|_| 0.05 + 0.5 * stream.unit() as f32).collect();
    ParametricField::new(model, channels, Planes::from_vec(size, planes, data).unwrap()).unwrap()
}
