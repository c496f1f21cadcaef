//! Options on how photographs are read, and what is undone in them.

use std::ffi::OsString;
use std::path::PathBuf;

use relume::capture::develop::{InputSpace, TurnedFrames};
use relume::capture::{Pairing, pictures_in};
use relume::{Named, Rect, Size};

use crate::args;

/// How photographs are read, and what is undone in them.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Photographs")]
pub struct PhotographArgs {
    /// Pair lights and photographs by name, or in order of sorted names [default: name]
    #[arg(long, value_parser = args::named::<Pairing>())]
    pub pair: Option<Pairing>,
    /// Refuse photographs that the camera recorded as turned unlike the first (alike), turn each as recorded (apply), or
    /// take all as they are stored (ignore) [default: alike]
    #[arg(long, value_name = "HOW", value_parser = args::named::<TurnedFrames>())]
    pub orientation: Option<TurnedFrames>,
    /// Read integer samples as sRGB-encoded or as linear, or as the one that a matt surface explains better (auto)
    /// [default: srgb]
    #[arg(long, value_name = "SPACE", value_parser = args::named::<InputSpace>())]
    pub input_space: Option<InputSpace>,
    /// A text file with the intensity of each light, one number or red, green and blue a line, to divide by
    #[arg(long, value_name = "FILE")]
    pub intensities: Option<PathBuf>,
    /// A photograph without the lamp, to take the light of the room away
    #[arg(long, value_name = "FILE")]
    pub ambient_frame: Option<PathBuf>,
    /// A photograph of a white card in place of the surface, to divide by; or a folder of them, one for each light in
    /// order of names
    #[arg(long, value_name = "FILE")]
    pub white_card: Option<PathBuf>,
    /// The width of the photographed surface in millimetres: the vectors of the light file are positions in millimetres
    /// from its middle, and the fall-off of their light is undone
    #[arg(long, value_name = "MM", value_parser = args::within(0.1, 100_000.0, "millimetres"))]
    pub surface_mm: Option<f64>,
    /// The distance of all lamps from the middle of the surface in millimetres, where the light file has directions
    #[arg(long, value_name = "MM", requires = "surface_mm", value_parser = args::within(0.1, 1e6, "millimetres"))]
    pub lamp_mm: Option<f64>,
    /// Find how the exposures of the photographs differ, and undo it
    #[arg(long)]
    pub equalize: bool,
    /// White balance: a rectangle of the photographs that shows something grey; left, top, width and height in pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = rectangle)]
    pub grey: Option<Rect<usize>>,
    /// Find how photographs moved against the first, and move them back
    #[arg(long)]
    pub align: bool,
    /// Make one texel of every N x N pixels
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub reduce: Option<u32>,
    /// Use only this rectangle of the photographs: left, top, width and height in pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = rectangle)]
    pub crop: Option<Rect<usize>>,
}

impl PhotographArgs {
    /// The first option given, for a verb whose input has no photographs.
    pub fn given(&self) -> Option<&'static str> {
        let all = [
            (self.pair.is_some(), "--pair"),
            (self.orientation.is_some(), "--orientation"),
            (self.input_space.is_some(), "--input-space"),
            (self.intensities.is_some(), "--intensities"),
            (self.ambient_frame.is_some(), "--ambient-frame"),
            (self.white_card.is_some(), "--white-card"),
            (self.surface_mm.is_some(), "--surface-mm"),
            (self.equalize, "--equalize"),
            (self.grey.is_some(), "--grey"),
            (self.align, "--align"),
            (self.reduce.is_some(), "--reduce"),
            (self.crop.is_some(), "--crop"),
        ];
        all.iter().find(|(given, _)| *given).map(|(_, name)| *name)
    }

    /// The options as they are typed.
    pub fn words(&self) -> Vec<OsString> {
        let rectangle = |r: Rect<usize>| format!("{},{},{},{}", r.x, r.y, r.size.width, r.size.height).into();
        let path = |path: &Option<PathBuf>| path.as_ref().map(|path| path.clone().into_os_string());
        let number = |number: Option<f64>| number.map(|n| n.to_string().into());
        let valued: [(&str, Option<OsString>); 11] = [
            ("--pair", self.pair.map(|pair| pair.name().into())),
            ("--orientation", self.orientation.map(|how| how.name().into())),
            ("--input-space", self.input_space.map(|space| space.name().into())),
            ("--intensities", path(&self.intensities)),
            ("--ambient-frame", path(&self.ambient_frame)),
            ("--white-card", path(&self.white_card)),
            ("--surface-mm", number(self.surface_mm)),
            ("--lamp-mm", number(self.lamp_mm)),
            ("--grey", self.grey.map(rectangle)),
            ("--reduce", self.reduce.map(|n| n.to_string().into())),
            ("--crop", self.crop.map(rectangle)),
        ];
        let flags = [("--equalize", self.equalize), ("--align", self.align)];
        let valued = valued.into_iter().filter_map(|(name, value)| Some([name.into(), value?])).flatten();
        let flags = flags.into_iter().filter(|(_, given)| *given).map(|(name, _)| name.into());
        valued.chain(flags).collect()
    }

    /// Whether options ask for what the photographs themselves tell.
    pub fn measure(&self) -> bool {
        self.align || self.equalize || self.grey.is_some()
    }

    /// The files that the options name, and those of a folder of white cards.
    pub fn files(&self) -> Vec<PathBuf> {
        let cards = self.white_card.iter().filter_map(|folder| pictures_in(folder).ok()).flatten();
        let all = [&self.intensities, &self.ambient_frame, &self.white_card];
        all.into_iter().flatten().cloned().chain(cards).collect()
    }
}

/// Four numbers of a rectangle.
fn rectangle(text: &str) -> std::result::Result<Rect<usize>, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => {
            Ok(Rect::new(x, y, Size::new(width, height)))
        }
        _ => Err("expected four whole numbers such as 100,80,512,512, the last two at least 1".to_owned()),
    }
}
