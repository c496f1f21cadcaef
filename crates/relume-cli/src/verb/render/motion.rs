//! What moves from frame to frame: the object on a turntable, or a light.

use relume::render::{Camera, Light, RenderOptions, Sweep};
use relume::{Error, Result};
use std::f64::consts::TAU;

use crate::film::FilmArgs;

/// Options of everything that moves.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "In motion")]
pub struct MotionArgs {
    /// Turn the object once around in N pictures; the lights stay with the viewer
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=10_000), conflicts_with = "sweep")]
    turntable: Option<u16>,
    /// N lights in a circle (orbit:N) or over the viewer from left to right (arc:N), one in each picture
    #[arg(long, value_name = "PATH:N", conflicts_with = "light")]
    sweep: Option<Sweep>,
    #[command(flatten)]
    film: FilmArgs,
}

impl MotionArgs {
    /// The number of pictures; `None` for a still.
    pub fn frames(&self) -> Option<usize> {
        self.turntable.map(usize::from).or(self.sweep.map(|sweep| sweep.directions().len()))
    }

    /// How the pictures are written.
    pub fn film(&self) -> &FilmArgs {
        &self.film
    }

    /// Refuses a rate of frames for a still.
    pub fn refuse_rate(&self) -> Result<()> {
        match self.film.fps {
            Some(_) => Err(Error::usage(
                "--fps is of an animation: give --turntable or --sweep as well, or leave it out",
            )),
            None => Ok(()),
        }
    }

    /// What is rendered in a picture.
    pub fn at(&self, frame: usize, args: &super::Args, still: &RenderOptions) -> RenderOptions {
        if let Some(count) = self.turntable {
            let turned = TAU * frame as f64 / f64::from(count);
            let camera = Camera { azimuth_rad: still.camera.azimuth_rad + turned, ..still.camera };
            let lights = super::in_world(&camera, &super::lights(args));
            return RenderOptions { camera, lights, ..still.clone() };
        }
        if let Some(sweep) = self.sweep {
            let light = Light { direction: sweep.directions()[frame], color: [1.0; 3] };
            return RenderOptions { lights: super::in_world(&still.camera, &[light]), ..still.clone() };
        }
        still.clone()
    }
}
