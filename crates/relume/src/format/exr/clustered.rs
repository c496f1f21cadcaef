//! Textures in clusters in EXR files: the channel `cluster` holds the cluster of each texel, `number.0` and so on its
//! numbers; `relumeClusters` is the number of clusters and that of their axes, `relumeClusterSpaces` for each cluster
//! the mean and then each axis, as coefficients of the functions of the basis.

use super::codec;
use super::container::{self, Layer};
use super::field::{attribute, basis_of, layout_of, ordered, parts_of, space_of};
use super::{ExrDepth, numbers};
use crate::error::{Error, Result};
use crate::field::{ClusterSpaces, ClusteredField};
use crate::job::Job;

pub(super) const COUNTS_KEY: &str = "relumeClusters";
const SPACES_KEY: &str = "relumeClusterSpaces";

/// Whether a file holds a texture in clusters.
pub(super) fn is_clustered(layer: &Layer) -> bool {
    layer.attributes.contains_key(COUNTS_KEY)
}

/// The bytes of a texture in clusters. In 32-bit floats nothing is lost.
///
/// # Errors
/// Limits exceeded, and a cancelled job.
pub fn encode_clustered(field: &ClusteredField, depth: ExrDepth, job: &Job) -> Result<Vec<u8>> {
    let spaces = field.spaces();
    let mut attributes = parts_of(field.basis(), field.layout(), field.space(), depth);
    attributes.push((COUNTS_KEY, format!("{} {}", spaces.clusters(), spaces.axes())));
    attributes.push((SPACES_KEY, numbers::text_of(spaces.coefficients(), depth)));
    container::encode(&channel_names(spaces.axes()), field.planes(), depth, &attributes, job)
}

/// The texture in clusters of a file of [`encode_clustered`].
///
/// # Errors
/// A file that holds no such texture, is damaged or exceeds the limits.
pub fn decode_clustered(bytes: &[u8], job: &Job) -> Result<ClusteredField> {
    let layer = codec::decode(bytes, job)?;
    if !is_clustered(&layer) {
        return Err(Error::unsupported("the EXR file holds no texture in clusters"));
    }
    clustered_of(&layer, job)
}

/// The texture in clusters that attributes describe.
pub(super) fn clustered_of(layer: &Layer, job: &Job) -> Result<ClusteredField> {
    let layout = layout_of(layer)?;
    let basis = basis_of(layer, &layout, job)?;
    let text = attribute(layer, COUNTS_KEY)?;
    let counts: Option<Vec<usize>> = text.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    let Some(&[clusters, axes]) = counts.as_deref() else {
        return Err(Error::invalid(format!(
            "the EXR field's attribute '{COUNTS_KEY}' holds '{}': expected the numbers of clusters and of axes",
            text.escape_default()
        )));
    };
    let values = numbers::from_text(attribute(layer, SPACES_KEY)?, "the clusters")?;
    let spaces = ClusterSpaces::new(layout.planes(basis.len()), axes, values)?;
    if spaces.clusters() != clusters {
        return Err(Error::invalid(format!(
            "the EXR field holds {} clusters where its attribute '{COUNTS_KEY}' says {clusters}",
            spaces.clusters()
        )));
    }
    let planes = ordered(layer, &channel_names(axes))?;
    ClusteredField::new(basis, layout, space_of(layer)?, spaces, planes)
}

fn channel_names(axes: usize) -> Vec<String> {
    std::iter::once("cluster".to_owned()).chain((0..axes).map(|k| format!("number.{k}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::clustered_example;
    use crate::format::{Content, FieldFormat, decode_field, encode_field, read};

    #[test]
    fn clusters_come_back_to_the_bit_and_any_reader_of_fields_takes_them() {
        let (field, job) = (clustered_example(), Job::default());
        let bytes = encode_clustered(&field, ExrDepth::Float, &job).unwrap();
        assert_eq!(decode_clustered(&bytes, &job).unwrap(), field);
        let opened = read(&*bytes, "clusters.exr", &job).unwrap();
        assert_eq!(opened.content(), Content::Field);
        assert_eq!(opened.into_field().unwrap().field, field.expanded(&job).unwrap());
    }

    #[test]
    fn halves_keep_clusters_and_round_numbers() {
        let (field, job) = (clustered_example(), Job::default());
        let bytes = encode_clustered(&field, ExrDepth::Half, &job).unwrap();
        let read = decode_clustered(&bytes, &job).unwrap();
        assert_eq!(read.planes().plane(0), field.planes().plane(0));
        let pairs = read.planes().as_slice().iter().zip(field.planes().as_slice());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-3));
    }

    #[test]
    fn damaged_clusters_are_refused_in_a_sentence() {
        let (field, job) = (clustered_example(), Job::default());
        let layer = |change: &dyn Fn(&mut Layer)| {
            let bytes = encode_clustered(&field, ExrDepth::Float, &job).unwrap();
            let mut layer = codec::decode(&bytes, &job).unwrap();
            change(&mut layer);
            clustered_of(&layer, &job).unwrap_err().to_string()
        };
        let with = |key: &str, value: &str| {
            layer(&|layer| {
                layer.attributes.insert(key.to_owned(), value.to_owned());
            })
        };
        assert!(with(COUNTS_KEY, "three").contains("expected the numbers of clusters"));
        assert!(with(COUNTS_KEY, "4 2").contains("says 4"));
        assert!(with(COUNTS_KEY, "3 99999999999999999").contains("axes over 4 functions"));
        assert!(with(SPACES_KEY, "*").contains("damaged"));
        assert!(with(SPACES_KEY, "AAAAAA==").contains("cannot have 1 coefficients"));
        assert!(layer(&|layer| layer.planes.plane_mut(0)[4] = 3.0).contains("belongs to the cluster 3"));
        let text = layer(&|layer| layer.names[1] = "other".to_owned());
        assert!(text.contains("no channel 'number.0'"), "{text}");
        let plain =
            encode_field(&field.expanded(&job).unwrap(), FieldFormat::Exr(ExrDepth::Float), None, &job);
        let plain = plain.unwrap();
        assert!(decode_clustered(&plain, &job).is_err() && decode_field(&plain, &job).is_ok());
    }
}
