//! Hole filling: texels of a texture are replaced by copies of others without visible traces, such as
//! blemishes, colour charts, or the border that prevents a picture from tiling.
//!
//! - [`fill()`] fills the holes of a mask, from their edges inward: texel by texel, in the manner of the
//!   Efros-Leung method ([`super::pixel::grow`]), or by patches in the order of `patches`, or on a torus as a
//!   whole, coarse to fine ([`mod@super::pixel::patch_match`]), so that what is known on all sides counts at once;
//! - [`tileable`] clears a band along the border and fills it on the torus, or lays [`bridges`] over the border;
//!   [`close`] does so for an output of copies.
//!
//! Texels outside the holes are their own sources, so everything there is unchanged to the bit. The content
//! of a hole does not matter, not even if it is NaN.
//!
//! A [`Guidance`] steers the content of the holes: windows are compared by the guides too, also where the
//! texture is not known yet.

pub mod bridges;
mod patches;

use super::guidance::Guidance;
use super::options::Boundary;
use super::pixel::grow::{Growth, Task, check_output};
use super::pixel::patch_match::anchors::Anchors;
use super::pixel::patch_match::{Completed, PatchMatchOptions, complete};
use super::pixel::window::ComparedWindow;
use super::quantise::{Exemplar, Quantised};
use super::source_map::{SourceMap, Texel};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::names::named;
use crate::planes::Planes;
use crate::size::Size;
use bridges::{Bridging, LEAST_BAND};

/// The methods of filling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillMethod {
    /// Texel by texel, in the manner of the Efros-Leung method.
    Texels,
    /// Patch by patch, starting where edges lead into the hole.
    Patches,
    /// As a whole, coarse to fine, by matching patches; of textures that tile.
    Optimised,
    /// By blocks that bridge the border of a texture; of borders alone.
    Bridges,
}

named!(FillMethod {
    Patches => "patches",
    Texels => "efros-leung",
    Optimised => "patchmatch",
    Bridges => "bridges",
});

/// Options of [`fill()`] and [`tileable`].
#[derive(Debug, Clone, PartialEq)]
pub struct FillOptions {
    /// By texels, by patches, as a whole, or by bridges.
    pub method: FillMethod,
    /// Side of the window, or of the patches, in texels: odd, 3 to 1023.
    pub window: usize,
    /// How much farther than the best a window may be to be a candidate, as a fraction of the best squared
    /// distance: 0 to a million.
    pub epsilon: f64,
    /// Whether the texture continues at the opposite edge.
    pub boundary: Boundary,
    /// The guide of the filling: one over the texture, one over its desired content.
    pub guidance: Option<Guidance>,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for FillOptions {
    /// By patches of 11 that fit best, open edges.
    fn default() -> Self {
        Self {
            method: FillMethod::Patches,
            window: 11,
            epsilon: 0.0,
            boundary: Boundary::Open,
            guidance: None,
            seed: 0,
        }
    }
}

/// Fills the holes of a texture with copies of its own texels. `excluded` texels are not copied and remain
/// unchanged.
///
/// The result depends on the texels outside the holes and the options only.
///
/// # Errors
/// When a mask has another size, nothing or everything is a hole, no window lies outside holes and excluded
/// texels, the options are invalid, or the limits are exceeded.
pub fn fill(
    index: &Planes,
    holes: &[bool],
    excluded: Option<&[bool]>,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    check_holes(holes, index.size())?;
    job.check("the texture to fill", index.size(), 4 * index.count() as u64)?;
    let blank = blanked(index, holes).held(job, "the texture to fill")?;
    let unusable = match excluded {
        None => holes.to_vec(),
        Some(mask) if mask.len() != holes.len() => {
            return Err(Error::usage(format!(
                "the mask of excluded texels has {} texels, the texture {}",
                mask.len(),
                index.size()
            )));
        }
        Some(mask) => holes.iter().zip(mask).map(|(hole, excluded)| hole | excluded).collect(),
    };
    let source = Exemplar { index: &blank, excluded: Some(&unusable) };
    let known = |texel: usize| (!holes[texel]).then(|| place(texel, index.size()));
    fill_from(&[source], index.size(), known, options, job)
}

/// A texel of the only exemplar.
fn place(texel: usize, size: Size) -> Texel {
    Texel { exemplar: 0, y: (texel / size.width) as u32, x: (texel % size.width) as u32 }
}

/// Fills a band of `band` texels along each edge on the torus, so that the texture tiles. The
/// texels of the old border may be copied.
///
/// # Errors
/// When the band leaves nothing in the middle, or as [`fill()`].
pub fn tileable(
    exemplar: Exemplar<'_>,
    band: usize,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    let size = exemplar.index.size();
    let own = |texel: usize| place(texel, size);
    fill_band(&[exemplar], size, own, band, options, job)
}

/// Refills a band of `band` texels along each edge of an output of copies from its exemplars, so that it
/// tiles. The target of a guide covers the output.
///
/// # Errors
/// As [`tileable`].
pub fn close(
    map: &SourceMap,
    exemplars: &[Exemplar<'_>],
    band: usize,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    fill_band(exemplars, map.size(), |texel| map.copies()[texel], band, options, job)
}

/// Fills a band along each edge on the torus; `source` gives the sources of the other texels.
fn fill_band(
    exemplars: &[Exemplar<'_>],
    size: Size,
    source: impl Fn(usize) -> Texel,
    band: usize,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    let widest = size.width.min(size.height).saturating_sub(1) / 2;
    if widest == 0 {
        return Err(Error::usage(format!(
            "a texture of {size} texels has no middle between bands along its edges: both sides must be at least 3"
        )));
    }
    if !(1..=widest).contains(&band) {
        return Err(Error::usage(format!(
            "a band of {band} texels along each edge of {size} texels: choose 1 to {widest}"
        )));
    }
    // Also where no window is needed after all.
    ComparedWindow::check_side(options.window)?;
    if options.method == FillMethod::Bridges && band >= LEAST_BAND && options.guidance.is_none() {
        let sources = (0..size.texels()).map(&source).collect();
        if let Some(closed) = bridged(exemplars, size, sources, band, job)? {
            return Ok(closed);
        }
    }
    let middle = |at: usize, length: usize| (band..length - band).contains(&at);
    let known = |texel: usize| {
        let (x, y) = (texel % size.width, texel / size.width);
        (middle(x, size.width) && middle(y, size.height)).then(|| source(texel))
    };
    let method = match options.method {
        FillMethod::Bridges => FillMethod::Patches,
        method => method,
    };
    let options = FillOptions { method, boundary: Boundary::Torus, ..options.clone() };
    fill_from(exemplars, size, known, &options, job)
}

/// Lays bridges over the border; `None` if one fits nowhere in the exemplars.
fn bridged(
    exemplars: &[Exemplar<'_>],
    size: Size,
    sources: Vec<Texel>,
    band: usize,
    job: &Job,
) -> Result<Option<(SourceMap, Growth)>> {
    job.check("the texture to close", size, 2 * size_of::<Texel>() as u64)?;
    let quantised = Quantised::new(exemplars, job)?;
    let _codes = job.hold("the codes of the exemplars", quantised.bytes())?;
    let before = sources.clone();
    let mut bridging = Bridging::new(exemplars, &quantised, size, sources, band);
    if !bridging.run(job)? {
        return Ok(None);
    }
    let (window, positions) = bridging.blocks();
    let sources = bridging.into_sources();
    let texels = before.iter().zip(&sources).filter(|(before, after)| before != after).count() as u64;
    let growth = Growth { window, positions, step: quantised.step(), texels, candidates: texels };
    Ok(Some((SourceMap::new(size, exemplars, sources), growth)))
}

fn check_holes(holes: &[bool], size: Size) -> Result<()> {
    if holes.len() != size.texels() {
        return Err(Error::usage(format!(
            "the mask of holes has {} texels, the texture is {size}: they must have the same size",
            holes.len()
        )));
    }
    match holes.iter().filter(|hole| **hole).count() {
        0 => Err(Error::usage("the mask has no hole: mark the texels to fill")),
        all if all == holes.len() => {
            Err(Error::usage("the mask marks every texel: leave some from which to fill the others"))
        }
        _ => Ok(()),
    }
}

/// The same planes with the values of one outside texel in the holes, so that their former content has no
/// influence on the quantisation either.
fn blanked(index: &Planes, holes: &[bool]) -> Planes {
    let mut blank = index.clone();
    let outside = holes.iter().position(|hole| !hole).expect("some texel is no hole");
    for plane in blank.iter_mut() {
        let value = plane[outside];
        plane.iter_mut().zip(holes).filter(|(_, hole)| **hole).for_each(|(v, _)| *v = value);
    }
    blank
}

/// Fills the texels without a known source with copies of the exemplars.
fn fill_from(
    exemplars: &[Exemplar<'_>],
    size: Size,
    known: impl Fn(usize) -> Option<Texel>,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    if options.method == FillMethod::Bridges {
        return Err(Error::usage(
            "the method bridges closes the border of a texture: fill holes by patches, efros-leung or patchmatch",
        ));
    }
    check_output(size, options.window, options.boundary)?;
    if options.method == FillMethod::Optimised {
        return optimised(exemplars, size, known, options, job);
    }
    let task = Task {
        exemplars,
        guidance: options.guidance.as_ref(),
        size,
        boundary: options.boundary,
        window: match options.method {
            FillMethod::Texels => ComparedWindow::gaussian(options.window),
            _ => ComparedWindow::uniform(options.window),
        },
        epsilon: options.epsilon,
        seed: options.seed,
    };
    task.run(job, |grower, canvas, matches| {
        for (texel, source) in (0..size.texels()).filter_map(|texel| Some((texel, known(texel)?))) {
            canvas.put(texel, source, grower.exemplars);
        }
        match options.method {
            FillMethod::Texels => grower.grow(canvas, matches, job),
            _ => patches::fill(grower, canvas, matches, job),
        }
    })
}

/// Finds the texels without a known source all together.
fn optimised(
    exemplars: &[Exemplar<'_>],
    size: Size,
    known: impl Fn(usize) -> Option<Texel>,
    options: &FillOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    if options.boundary == Boundary::Open {
        return Err(Error::usage(
            "the method patchmatch fills textures that tile: say that this one does, or choose patches or \
             efros-leung",
        ));
    }
    job.check("the texels around the holes", size, 2 * size_of::<Option<Texel>>() as u64)?;
    let anchors = Anchors::new(size, (0..size.texels()).map(known).collect());
    let texels = anchors.free().count() as u64;
    let matching = PatchMatchOptions {
        size,
        window: options.window,
        guidance: options.guidance.clone(),
        seed: options.seed,
        ..PatchMatchOptions::default()
    };
    let Completed { map, optimised, step } = complete(exemplars, &matching, Some(anchors), job)?;
    Ok((
        map,
        Growth { window: options.window, positions: optimised.positions, step, texels, candidates: texels },
    ))
}

#[cfg(test)]
mod tests;
