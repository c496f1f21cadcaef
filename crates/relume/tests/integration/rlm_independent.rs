//! A second decoder of `.rlm` files, written from `docs/formats.md` alone, compared with the first.

use std::collections::VecDeque;

use relume::field::basis::WeightedDirection;
use relume::field::{Basis, PackedFunctions, PlaneLayout};
use relume::format::rlm;
use relume::numeric::random::{Purpose, Stream};
use relume::random_field::joint_color::JointColor;
use relume::random_field::level::Level;
use relume::random_field::marginal::Marginal;
use relume::random_field::neighbourhood::{all_around, causal};
use relume::random_field::{
    Budget, FieldModel, Fields, Heights, Model, ModelOptions, PhotographClusters, Structure, Tiles,
    combine_field, model_field, model_lights,
};
use relume::render::relight;
use relume::{Job, Planes, ReflectanceField, Size, Space};

/// Added to the version where detail depends on the place.
const WITH_LOCAL_DETAIL: u8 = 16;

/// The bits of the body of a file, in order.
struct Bits(VecDeque<u8>);

impl Bits {
    fn number(&mut self, count: usize) -> u64 {
        (0..count).fold(0, |value, _| value << 1 | u64::from(self.0.pop_front().unwrap()))
    }

    fn float(&mut self) -> f32 {
        f32::from_bits(self.number(32) as u32)
    }

    fn half(&mut self) -> f32 {
        half::f16::from_bits(self.number(16) as u16).to_f32()
    }

    fn name(&mut self) -> String {
        let length = self.number(8);
        (0..length).map(|_| self.number(8) as u8 as char).collect()
    }

    /// A number of the adaptive Rice code with the given sum and count.
    fn rice(&mut self, state: &mut (u64, u64)) -> i64 {
        let k = (0..).find(|k| state.1 << k >= state.0).unwrap();
        let mut zeros = 0;
        while zeros < 24 && self.number(1) == 0 {
            zeros += 1;
        }
        let u = if zeros == 24 { self.number(22) } else { zeros << k | self.number(k) };
        *state = (state.0 + u, state.1 + 1);
        if state.1 == 32 {
            *state = (state.0.div_ceil(2), 16);
        }
        if u.is_multiple_of(2) { (u / 2) as i64 } else { -((u / 2) as i64) - 1 }
    }
}

/// Checks the header and returns the version and the bits after it.
fn body(bytes: &[u8]) -> (u8, Bits) {
    assert_eq!(bytes[..4], *b"RLM\x1a");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let mut sum = u32::MAX;
    for byte in &bytes[9..] {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 };
        }
    }
    assert_eq!((word(5), word(9) as usize), (!sum, bytes.len() - 13));
    let bits = bytes[13..].iter().flat_map(|byte| (0..8).rev().map(move |i| byte >> i & 1));
    (bytes[4], Bits(bits.collect()))
}

/// Checks the bits of one model against the model.
fn check_model(bits: &mut Bits, model: &Model, version: u8) {
    let (d, factor, levels) = (bits.number(16) as usize, bits.number(8), bits.number(8));
    assert_eq!(
        (d, factor, levels),
        (model.planes(), model.kernel.factor() as u64, model.levels.len() as u64)
    );
    let own: Vec<bool> = (0..d).map(|_| bits.number(1) == 1).collect();
    assert_eq!(own, model.mixing.own);
    let mut m = 0;
    let mut weights = Vec::new();
    for own in own {
        m += usize::from(own);
        weights.extend((0..m).map(|_| bits.float()));
    }
    assert_eq!(weights, model.mixing.weights);
    assert_eq!((0..d).map(|_| bits.half()).collect::<Vec<f32>>(), model.gains);
    if version % WITH_LOCAL_DETAIL >= 4 {
        check_color(bits, model.color.as_ref());
    }
    model.marginals.iter().for_each(|marginal| check_marginal(bits, marginal));
    for level in &model.levels {
        assert_eq!(8 << bits.number(3), level.burn_in);
        assert_eq!((bits.float(), bits.number(32)), (level.log_evidence, u64::from(level.texels)));
        for (family, offsets) in [(causal as fn(usize) -> _, &level.neighbours), (all_around, &level.coarse)]
        {
            let near: Vec<_> = family(bits.number(9) as usize);
            let used: Vec<_> = near.into_iter().filter(|_| bits.number(1) == 1).collect();
            assert_eq!(&used, offsets);
        }
        let noise: Vec<f32> = (0..m * (m + 1) / 2).map(|_| bits.float()).collect();
        let rows: Vec<f32> = (0..2 * m).map(|_| bits.half()).collect();
        let columns: Vec<f32> = (0..m).map(|_| bits.half()).collect();
        assert_eq!((&noise, &rows, &columns), (&level.noise, &level.weights.rows, &level.weights.columns));
        let mut states = [(4, 1); 2];
        let neighbours = level.neighbours.len() + level.coarse.len();
        for i in 0..neighbours * m * m {
            let of_others = usize::from(i / m % m != i % m);
            assert_eq!(bits.rice(&mut states[of_others]), i64::from(level.weights.codes[i]));
        }
    }
    if version >= WITH_LOCAL_DETAIL {
        model.levels.iter().for_each(|level| check_local_detail(bits, level));
    }
}

fn check_local_detail(bits: &mut Bits, level: &Level) {
    assert_eq!(bits.number(8), u64::from(level.unevenness));
    assert_eq!(bits.number(1) == 1, level.gain.is_some());
    let Some(gain) = &level.gain else { return };
    assert_eq!((bits.half(), bits.half()), (gain.deviation, gain.gradient));
    let (mut state, mut code) = ((4, 1), 128);
    for &expected in &gain.codes {
        code += bits.rice(&mut state);
        assert_eq!(code, i64::from(expected));
    }
}

fn check_marginal(bits: &mut Bits, marginal: &Marginal) {
    let is_curve = bits.number(1) == 1;
    let (first, second) = (bits.float(), bits.float());
    match marginal {
        Marginal::Normal { mean, deviation } => {
            assert_eq!((is_curve, first, second), (false, *mean, *deviation))
        }
        Marginal::Curve { low, high, codes } => {
            assert_eq!((is_curve, first, second, codes[0]), (true, *low, *high, 0));
            let mut state = (4, 1);
            for pair in codes.windows(2) {
                assert_eq!(bits.rice(&mut state), i64::from(pair[1]) - i64::from(pair[0]));
            }
        }
    }
}

fn check_color(bits: &mut Bits, color: Option<&JointColor>) {
    assert_eq!(bits.number(1) == 1, color.is_some());
    let Some(color) = color else { return };
    assert_eq!(bits.number(16) as usize, color.first);
    check_marginal(bits, &color.lightness);
    for (opponent, (nodes, quantiles)) in color.opponents.iter().zip([(9, 17), (25, 9)]) {
        assert_eq!((bits.float(), bits.float()), (opponent.low, opponent.high));
        let (mut lowest, mut others) = ((4, 1), (4, 1));
        let mut start = 0;
        for node in opponent.codes.chunks_exact(quantiles) {
            start += bits.rice(&mut lowest);
            let mut code = start;
            assert_eq!(i64::from(node[0]), code);
            for &quantile in &node[1..] {
                code += bits.rice(&mut others);
                assert_eq!(i64::from(quantile), code);
            }
        }
        assert_eq!(opponent.codes.len(), nodes * quantiles);
    }
}

/// Checks all but the codes of a structure, which take as many bytes as announced.
fn check_structure(bits: &mut Bits, structure: &Structure) {
    let numbers = [bits.number(16), bits.number(16), bits.number(16), bits.number(4)];
    let Structure { tile, tiles, scales, .. } = *structure;
    assert_eq!(numbers, [tile.width, tile.height, tiles, scales].map(|v| v as u64));
    let steps: Vec<f32> = structure.steps.iter().map(|_| bits.half()).collect();
    assert_eq!(steps, structure.steps);
    let length = bits.number(32) as usize;
    bits.0.drain(..8 * length);
}

/// The table of clusters, the models, and the range map.
fn check_clusters(bits: &mut Bits, field: &FieldModel, clusters: &PhotographClusters, version: u8) {
    let Basis::Learned(learned) = &field.basis else { panic!("a table is of learned functions") };
    let table = learned.packed().unwrap();
    let (lights, views) = (bits.number(16) as usize, bits.number(16) as usize);
    let count = bits.number(8) as usize;
    assert_eq!((lights, views, count), (table.lights.len(), table.views.len(), clusters.models.len()));
    assert_eq!(vec![bits.float(); count], table.steps);
    for direction in table.lights.iter().chain(&table.views) {
        assert_eq!([bits.float(), bits.float()], direction.disk);
        assert_eq!(bits.float(), direction.weight);
    }
    let (mut state, mut labels, mut steps) = ((4, 1), Vec::new(), Vec::new());
    for pair in 0..lights * views {
        labels.push(match bits.number(1) {
            1 => labels[pair - 1],
            _ if bits.number(1) == 1 => labels[pair - lights],
            _ => bits.number(8) as usize,
        });
        let before = if pair % lights > 0 { steps[pair - 1] } else { 0 };
        steps.push(before + bits.rice(&mut state));
    }
    for (k, codes) in table.codes.chunks_exact(lights * views).enumerate() {
        for (pair, code) in codes.iter().enumerate() {
            assert_eq!(i64::from(*code), if labels[pair] == k { steps[pair] } else { 0 });
        }
    }
    clusters.models.iter().for_each(|model| check_model(bits, model, version));
    assert_eq!(bits.number(1) == 1, clusters.range.is_some());
    let Some(range) = &clusters.range else { return };
    check_model(bits, range, version);
    assert_eq!(bits.number(1) == 1, range.structure.is_some());
    range.structure.iter().for_each(|structure| check_structure(bits, structure));
}

/// A model of three clusters of photographs, with a range map.
fn of_clusters() -> FieldModel {
    let job = Job::default();
    let options = ModelOptions { levels: 1, candidates: 6, ..ModelOptions::default() };
    let joint = |layout: PlaneLayout, seed: f32| {
        let base = field(Basis::Constant, layout, Space::Srgb);
        let planes = base.coefficients().as_slice().iter().map(|v| v.powf(seed)).collect();
        let planes = Planes::from_vec(base.size(), base.coefficients().count(), planes).unwrap();
        let made = model_field(&base.with_coefficients(planes).unwrap(), &options, &job).unwrap().0;
        let Fields::Joint(model) = made.fields else { panic!("one model") };
        *model
    };
    let models = [1.0, 1.5, 2.0].map(|seed| joint(PlaneLayout::RGB, seed)).to_vec();
    let direction = |i: usize| WeightedDirection { disk: [0.15 * i as f32, -0.1 * i as f32], weight: 0.5 };
    let code = |i: usize| if i / 20 == (i % 20 / 3) % 3 { 30 + (i % 4) as i32 } else { 0 };
    let table = PackedFunctions {
        lights: (0..5).map(direction).collect(),
        views: (0..4).map(direction).collect(),
        channels: 1,
        steps: vec![1.0 / 32.0; 3],
        codes: (0..60).map(code).collect(),
    };
    let range = Some(Box::new(joint(PlaneLayout::LUMINANCE, 1.0)));
    let clusters = PhotographClusters { models, range };
    FieldModel::of_clusters(table, Space::Srgb, clusters, Size::new(32, 30)).unwrap()
}

#[test]
fn a_model_of_clusters_is_read_by_the_other_decoder() {
    assert_eq!(check(&of_clusters()), 6);
}

/// Reads a file from its first byte to its last, and compares it with the model.
fn check(field: &FieldModel) -> u8 {
    let (version, mut bits) = body(&rlm::encode(field).unwrap());
    let names = [field.basis.name(), field.layout.name(), &field.space.to_string()].map(str::to_owned);
    assert_eq!([bits.name(), bits.name(), bits.name()], names);
    let source = field.source;
    for number in [source.width, source.height, source.photographs, source.channels] {
        assert_eq!(bits.number(32), u64::from(number));
    }
    if let Fields::Clusters(clusters) = &field.fields {
        check_clusters(&mut bits, field, clusters, version);
        assert!(bits.0.len() < 8 && bits.0.iter().all(|&bit| bit == 0));
        return version;
    }
    let mut lights = Vec::new();
    let edition = version % WITH_LOCAL_DETAIL;
    if edition >= 3 {
        let heights = match bits.number(2) {
            0 => None,
            1 => Some(None),
            2 => Some(Some(f64::from_bits(bits.number(64)))),
            other => panic!("kind {other}"),
        };
        assert_eq!(heights, field.heights.map(|heights| heights.mm_per_texel));
        let count = bits.number(8);
        lights = (0..count).map(|_| [bits.float(), bits.float()]).collect();
    }
    match &field.fields {
        Fields::Joint(model) => {
            assert!(lights.is_empty());
            check_model(&mut bits, model, version);
            let has_structure = edition == 2 || edition >= 3 && bits.number(1) == 1;
            assert_eq!(has_structure, model.structure.is_some());
            model.structure.iter().for_each(|structure| check_structure(&mut bits, structure));
        }
        Fields::PerLight(models) => {
            assert_eq!(lights, models.iter().map(|light| light.disk).collect::<Vec<_>>());
            models.iter().for_each(|light| check_model(&mut bits, &light.model, version));
        }
        Fields::Clusters(_) => panic!("read above"),
    }
    assert!(bits.0.len() < 8 && bits.0.iter().all(|&bit| bit == 0));
    version
}

fn field(basis: Basis, color: PlaneLayout, space: Space) -> ReflectanceField {
    let (size, mut stream) = (Size::new(32, 30), Stream::new(7, Purpose::Sample, [0]));
    let count = color.planes(basis.len());
    let data =
        (0..size.texels() * count).map(|i| 0.1 + 0.1 * (i % 6) as f32 + stream.unit() as f32).collect();
    ReflectanceField::new(basis, color, space, Planes::from_vec(size, count, data).unwrap()).unwrap()
}

/// Waves that are rough where they are high.
fn uneven() -> ReflectanceField {
    let (size, mut stream) = (Size::new(96, 96), Stream::new(7, Purpose::Sample, [0]));
    let value = |i: usize| {
        let wave = ((i % 96) as f32 / 6.0).sin() * ((i / 96) as f32 / 6.0).cos();
        0.5 + 0.2 * wave + (0.1 + 0.09 * wave) * (stream.unit() as f32 - 0.5)
    };
    let planes = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
    ReflectanceField::new(Basis::Constant, PlaneLayout::LUMINANCE, Space::Srgb, planes).unwrap()
}

#[test]
fn every_kind_of_model_is_read_by_the_other_decoder() {
    let job = Job::default();
    let options = ModelOptions { levels: 2, candidates: 6, coarse: 5, ..ModelOptions::default() };
    let plain = |field: &ReflectanceField, marginals| {
        let options = ModelOptions { marginals, ..options };
        model_field(field, &options, &job).unwrap().0
    };
    let combined = |field: &ReflectanceField| {
        let tiles = Tiles { texels: field, size: Size::new(32, 15) };
        let budget = Budget { bytes: 400, cost: &rlm::structure_bytes };
        combine_field(field, tiles, &budget, &options, &job).unwrap().0
    };
    let colour = field(Basis::Constant, PlaneLayout::RGB, Space::Srgb);
    let functions = field(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb);
    let mut made = Vec::new();
    for (marginals, version) in [(true, 4), (false, 1)] {
        made.extend([(plain(&colour, marginals), version), (plain(&functions, marginals), version)]);
    }
    made.push((combined(&colour), 4));
    let grey = field(Basis::Constant, PlaneLayout::LUMINANCE, Space::Srgb);
    made.extend([(plain(&grey, true), 1), (combined(&grey), 2)]);
    let relief = field(Basis::Constant, PlaneLayout::LUMINANCE, Space::Linear);
    for (mm_per_texel, model) in [(None, plain(&relief, true)), (Some(0.037), combined(&relief))] {
        made.push((FieldModel { heights: Some(Heights { mm_per_texel }), ..model }, 3));
    }
    let lights = relume::capture::dome::lights(8);
    let picture = |light| relight(&functions, light).planes;
    made.push((model_lights(&functions, &lights, &picture, &options, &job).unwrap().0, 4));
    made.push((plain(&uneven(), true), 1));
    let (mut with_gains, mut without) = (0, 0);
    for (mut field, version) in made {
        let has_gains = |model: &Model| model.levels.iter().any(|level| level.gain.is_some());
        let models = field.fields.models();
        let is_local = models.iter().any(|(_, model)| model.has_local_detail());
        with_gains += usize::from(models.iter().any(|(_, model)| has_gains(model)));
        assert_eq!(check(&field), if is_local { version + WITH_LOCAL_DETAIL } else { version });
        remove_local_detail(&mut field);
        without += usize::from(check(&field) == version);
    }
    assert!(with_gains == 1 && without == 11, "{with_gains} {without}");
}

fn remove_local_detail(field: &mut FieldModel) {
    let models: Vec<&mut Model> = match &mut field.fields {
        Fields::Joint(model) => vec![model],
        Fields::PerLight(lights) => lights.iter_mut().map(|light| &mut light.model).collect(),
        Fields::Clusters(clusters) => clusters.models.iter_mut().collect(),
    };
    for model in models {
        model.structure.iter_mut().for_each(|structure| structure.predicts = false);
        for level in &mut model.levels {
            (level.gain, level.unevenness) = (None, 0);
        }
    }
}
