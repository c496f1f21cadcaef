//! Pictures one after another: an animation (.png, .gif), a film (.mp4, by the program ffmpeg), or a folder of numbered files.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use relume::format::{Depth, PictureFormat, animation, encode_picture_with};
use relume::render::srgb8_from_linear;
use relume::{Error, ErrorKind, Footprint, Job, Picture, Result, Size, Space};

use crate::context::Context;
use crate::output::{self, Folder, Outputs, Temporary};

/// The rate unless another is asked for.
const FPS: u16 = 12;

/// Options of everything that has frames.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct FilmArgs {
    /// Frames per second of an animation or a film [default: 12]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub fps: Option<u16>,
}

/// How frames are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FilmFormat {
    Apng,
    Gif,
    Mp4,
    Folder,
}

/// Frames to be made: their number, size and channels.
#[derive(Debug, Clone, Copy)]
pub struct FilmShape {
    pub frames: usize,
    pub size: Size,
    pub channels: usize,
}

impl FilmFormat {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "gif" => Ok(Self::Gif),
            "mp4" => Ok(Self::Mp4),
            "png" | "apng" => Ok(Self::Apng),
            _ if output::is_stream(path) => Ok(Self::Apng),
            _ if PictureFormat::from_path(path).is_err() => Ok(Self::Folder),
            _ => Err(Error::usage(
                "frames are written as one animation, .png or .gif, as a film, .mp4, or as a folder of pictures: name it so",
            )
            .at(path)),
        }
    }
}

/// A film about to be made, whose place is claimed.
pub struct Film<'a> {
    path: &'a Path,
    format: FilmFormat,
    fps: u16,
    place: FilmPlace,
}

enum FilmPlace {
    File(Outputs),
    Folder(Folder),
}

impl<'a> Film<'a> {
    /// Claims the place of a film.
    ///
    /// # Errors
    /// A name of something else, a rate for a folder, a place that is taken, and ffmpeg that is needed and missing.
    pub fn claim(path: &'a Path, inputs: &[&Path], args: &FilmArgs, context: &Context) -> Result<Self> {
        let format = FilmFormat::of(path)?;
        if format == FilmFormat::Folder && args.fps.is_some() {
            return Err(Error::usage(
                "--fps is of an animation, and a folder of pictures is written: leave it out",
            ));
        }
        let place = match format {
            FilmFormat::Folder => FilmPlace::Folder(Folder::stage(path, inputs, context)?),
            _ => {
                let mut outputs = Outputs::new(context);
                outputs.file(path, inputs)?;
                FilmPlace::File(outputs)
            }
        };
        if format == FilmFormat::Mp4 {
            check_ffmpeg().map_err(|e| e.at(path))?;
        }
        Ok(Self { path, format, fps: args.fps.unwrap_or(FPS), place })
    }

    /// Makes the frames and writes them; gives the files.
    ///
    /// # Errors
    /// Errors of the frames, memory, errors of the system or of ffmpeg, and a cancelled job.
    pub fn write(
        self,
        shape: FilmShape,
        context: &Context,
        mut make: impl FnMut(usize) -> Result<Picture>,
    ) -> Result<Vec<PathBuf>> {
        let job = &context.job;
        match self.place {
            FilmPlace::Folder(folder) => {
                job.start("making pictures", shape.frames as u64);
                for i in 0..shape.frames {
                    let bytes = encode_picture_with(&make(i)?, PictureFormat::Png(Depth::Eight), job)?;
                    folder.add(format!("{i:04}.png"), &bytes)?;
                    job.advance(1)?;
                }
                folder.commit()
            }
            FilmPlace::File(mut outputs) => {
                let bytes = match self.format {
                    FilmFormat::Mp4 => mp4(self.path, self.fps, shape, job, &mut make),
                    format => animated(format, self.fps, shape, job, &mut make),
                };
                outputs.write(self.path, bytes.map_err(|e| e.at(self.path))?)?;
                outputs.commit()
            }
        }
    }
}

fn animated(
    format: FilmFormat,
    fps: u16,
    shape: FilmShape,
    job: &Job,
    make: &mut dyn FnMut(usize) -> Result<Picture>,
) -> Result<Vec<u8>> {
    let FilmShape { frames, size, channels } = shape;
    let bytes = 4 * (channels * frames) as u64;
    let pictures = Footprint::of_texels(size, bytes, bytes);
    let written = match format {
        FilmFormat::Gif => animation::gif_footprint(size, channels, frames),
        _ => animation::footprint(size, channels, frames),
    };
    job.check_bytes("the animation", pictures.then(written).peak)?;
    let _held = job.hold("the pictures of the animation", pictures.kept)?;
    let picture = |i: usize| job.proceed().and_then(|()| make(i));
    let pictures: Vec<Picture> = (0..frames).map(picture).collect::<Result<_>>()?;
    match format {
        FilmFormat::Gif => animation::encode_gif_with(&pictures, fps, job),
        _ => animation::encode_apng_with(&pictures, fps, job),
    }
}

fn check_ffmpeg() -> Result<()> {
    let found = Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    match found.is_ok_and(|status| status.success()) {
        true => Ok(()),
        false => Err(Error::new(
            ErrorKind::Unsupported,
            "an .mp4 is written by the program ffmpeg, which is not found: install it, or name a .gif, a .png or a folder",
        )),
    }
}

/// A process that ends with whoever started it.
struct FfmpegProcess(Child);

impl Drop for FfmpegProcess {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The bytes of a film in H.264, from frames that go to ffmpeg one by one.
fn mp4(
    path: &Path,
    fps: u16,
    shape: FilmShape,
    job: &Job,
    make: &mut dyn FnMut(usize) -> Result<Picture>,
) -> Result<Vec<u8>> {
    job.check("a frame", shape.size, 4 * shape.channels as u64 + 3)?;
    let failed = |e: &std::io::Error| Error::io("cannot write the film", e);
    let file = Temporary::file(output::folder_of(path)).map_err(|e| failed(&e))?;
    let mut encoder = FfmpegProcess(encoder(fps, shape.size, file.path()).map_err(|e| failed(&e))?);
    let mut frames = encoder.0.stdin.take().expect("the input is a pipe");
    job.start("making pictures", shape.frames as u64);
    let mut codes = vec![0; 3 * shape.size.texels()];
    for i in 0..shape.frames {
        codes_of(&make(i)?, &mut codes);
        // A process that has ended says why when it is asked.
        if frames.write_all(&codes).is_err() {
            break;
        }
        job.advance(1)?;
    }
    drop(frames);
    let status = encoder.0.wait().map_err(|e| failed(&e))?;
    if !status.success() {
        let message =
            format!("ffmpeg made no film of the frames ({status}): name a .gif, a .png or a folder instead");
        return Err(Error::new(ErrorKind::Io, message));
    }
    std::fs::read(file.path()).map_err(|e| failed(&e))
}

/// Starts ffmpeg on raw frames. Players want even sides and colours at half the resolution.
fn encoder(fps: u16, Size { width, height }: Size, file: &Path) -> std::io::Result<Child> {
    let size = format!("{width}x{height}");
    let rate = fps.to_string();
    Command::new("ffmpeg")
        .args(["-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &size])
        .args(["-framerate", &rate, "-i", "pipe:0", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"])
        .args([
            "-c:v",
            "libx264",
            "-crf",
            "18",
            "-pix_fmt",
            "yuv420p",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
            "-y",
        ])
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
}

/// Red, green and blue of each texel as sRGB codes.
fn codes_of(picture: &Picture, codes: &mut [u8]) {
    let picture = picture.to_space(Space::Linear);
    let (texels, channels) = (picture.size().texels(), picture.planes.count());
    let mut linear = vec![0.0; 3 * texels];
    for c in 0..3 {
        let plane = picture.planes.plane(c.min(channels - 1));
        linear.iter_mut().skip(c).step_by(3).zip(plane).for_each(|(out, &value)| *out = value);
    }
    srgb8_from_linear(&linear, codes);
}
