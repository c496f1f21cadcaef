//! Which file and channel feeds each input of a surface shader.

use super::MaterialMaps;
use super::presets::{DataMap, MapContent};
use crate::format::NormalY;

/// The written files and what they hold.
pub(super) struct MaterialSlots<'a> {
    pub files: Vec<(String, MapContent)>,
    pub has_opacity: bool,
    pub maps: &'a MaterialMaps,
}

/// A channel of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct MapSlot {
    pub file: String,
    /// The number of channels of the file.
    pub channels: usize,
    pub channel: usize,
    /// Whether it holds one minus the value.
    pub inverted: bool,
}

impl MaterialSlots<'_> {
    /// The file of colours.
    pub fn color(&self) -> Option<&str> {
        self.files
            .iter()
            .find(|(_, content)| matches!(content, MapContent::Color { .. }))
            .map(|(file, _)| &**file)
    }

    /// The file of normals, those with +Y where there are both.
    pub fn normal(&self) -> Option<(&str, NormalY)> {
        let of = |wanted: NormalY| {
            let is = |(_, content): &&(String, MapContent)| *content == MapContent::Normal(wanted);
            self.files.iter().find(is).map(|(file, _)| (&**file, wanted))
        };
        of(NormalY::Up).or(of(NormalY::Down))
    }

    /// Where a plane of data is, single files first; `None` where it is not known.
    pub fn data(&self, wanted: DataMap) -> Option<MapSlot> {
        self.maps.data(wanted)?;
        let slot = |(file, content): &(String, MapContent)| {
            let (channel, inverted) = content.place_of(wanted)?;
            let channels = if let MapContent::Packed(maps) = content { maps.len() } else { 1 };
            Some(MapSlot { file: file.clone(), channels, channel, inverted })
        };
        let all = || self.files.iter().filter_map(slot);
        all().find(|slot| slot.channels == 1).or_else(|| all().next())
    }

    /// The opacity: a file of its own, or the fourth channel of the colours.
    pub fn opacity(&self) -> Option<MapSlot> {
        if let Some(slot) = self.data(DataMap::Opacity) {
            return Some(slot);
        }
        let file = self.color().filter(|_| self.has_opacity)?.to_owned();
        Some(MapSlot { file, channels: 4, channel: 3, inverted: false })
    }
}
