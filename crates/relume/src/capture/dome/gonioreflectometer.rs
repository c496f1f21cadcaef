//! A virtual gonioreflectometer: images of one surface for pairs of a light and a view direction.
//!
//! What depends on the view alone ([`Sight`]) is found once for all lights of a view, and what depends on the light
//! alone ([`Illumination`]) once for all views, as far as the memory allows; the rest is found again, with the same
//! result.

use super::{Dome, Illumination, Sight};
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::job::{Held, Job};
use crate::memory::Footprint;
use crate::parallel;
use crate::picture::Picture;
use crate::raster::{Raster, Samples};
use crate::size::Size;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// The bits of a direction.
type DirectionKey = [u64; 3];

fn key(direction: Direction) -> DirectionKey {
    direction.to_array().map(f64::to_bits)
}

/// A surface under a dome, and the pairs of directions at which it is measured.
#[derive(Debug)]
pub struct Gonioreflectometer {
    dome: Dome,
    pairs: Vec<Directions>,
    /// The light of lamps that occur with several views, as many as fit.
    lit: HashMap<DirectionKey, Arc<Illumination>>,
    /// What the last viewer saw.
    last: Mutex<Option<Arc<Sight>>>,
    _held: Held,
}

impl Gonioreflectometer {
    /// Lights the surface by the lamps that occur with several views. They are kept in at most half of the memory
    /// that is free beside two images.
    ///
    /// # Errors
    /// A light or view less than about half a degree above the surface; a cancelled job; too little memory.
    pub fn new(dome: Dome, pairs: Vec<Directions>, job: &Job) -> Result<Self> {
        let one = Illumination::footprint(dome.size());
        let lights = repeated_lights(&pairs);
        let room = job.free_bytes().saturating_sub(2 * Self::image_footprint(dome.size()).peak) / 2;
        let fitting = usize::try_from(room / one.kept.max(1)).unwrap_or(usize::MAX);
        let count = lights.len().min(fitting);
        let held = job.hold("the light of all lamps", one.kept * count as u64)?;
        if count > 0 {
            job.check_bytes("the light of a lamp", one.peak - one.kept)?;
        }
        job.start("lighting", count as u64);
        let mut lit = HashMap::new();
        for light in lights.into_iter().take(count) {
            lit.insert(key(light), Arc::new(dome.illumination(light, job)?));
            job.advance(1)?;
        }
        Ok(Self { dome, pairs, lit, last: Mutex::new(None), _held: held })
    }

    /// The memory of one image beside the dome: its light and its sight, found anew, and the picture, which stays.
    pub fn image_footprint(size: Size) -> Footprint {
        let (lit, sight) = (Illumination::footprint(size), Sight::footprint(size));
        let picture = Footprint::of_texels(size, 12, 12);
        Footprint { peak: sight.kept + lit.peak.max(lit.kept + picture.peak), kept: picture.kept }
    }

    /// The surface.
    pub fn dome(&self) -> &Dome {
        &self.dome
    }

    /// Width and height of the images.
    pub fn size(&self) -> Size {
        self.dome.size()
    }

    /// The measured pairs, in order.
    pub fn pairs(&self) -> &[Directions] {
        &self.pairs
    }

    /// The names of the channels.
    pub fn channels(&self) -> [&'static str; 3] {
        ["R", "G", "B"]
    }

    /// Whether values hold the cosine at the light: always, they are radiances.
    pub fn holds_cosine(&self) -> bool {
        true
    }

    /// The image of pair `number`, linear: from any thread, in any order. Those of one view are faster one after
    /// another. The memory is [`Gonioreflectometer::image_footprint`].
    ///
    /// # Errors
    /// A direction less than about half a degree above the surface; a cancelled job.
    ///
    /// # Panics
    /// When there is no such pair.
    pub fn image(&self, number: usize, job: &Job) -> Result<Raster> {
        let Directions { light, view } = self.pairs[number];
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let sight = match last.filter(|sight| sight.view() == view) {
            Some(sight) => sight,
            None => {
                let sight = Arc::new(self.dome.sight(view, job)?);
                *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&sight));
                sight
            }
        };
        let picture = self.dome.image(&sight, &*self.light(light, job)?, job)?;
        let [r, g, b] = [0, 1, 2].map(|k| picture.planes.plane(k));
        let samples = r.iter().zip(g).zip(b).flat_map(|((r, g), b)| [*r, *g, *b]).collect();
        Raster::new(self.size(), 3, Samples::F32(samples))
    }

    /// What `finish` makes of the images of consecutive pairs, in order; images are made in parallel.
    ///
    /// # Errors
    /// As [`Gonioreflectometer::image`], and errors of `finish`.
    ///
    /// # Panics
    /// When there are no such pairs.
    pub fn images<T: Send>(
        &self,
        numbers: Range<usize>,
        finish: impl Fn(Picture) -> Result<T> + Sync,
        job: &Job,
    ) -> Result<Vec<T>> {
        let pairs = &self.pairs[numbers];
        let views: Vec<&[Directions]> = pairs.chunk_by(|a, b| a.view == b.view).collect();
        let sights: Vec<Sight> =
            parallel::try_map(views.iter(), |pairs| self.dome.sight(pairs[0].view, job))?;
        let seen =
            sights.iter().zip(views).flat_map(|(sight, pairs)| pairs.iter().map(move |pair| (sight, pair)));
        let seen: Vec<(&Sight, &Directions)> = seen.collect();
        let made = |(sight, pair): &(&Sight, &Directions)| {
            finish(self.dome.image(sight, &*self.light(pair.light, job)?, job)?)
        };
        parallel::try_map(seen.iter(), made)
    }

    fn light(&self, light: Direction, job: &Job) -> Result<Arc<Illumination>> {
        match self.lit.get(&key(light)) {
            Some(lit) => Ok(Arc::clone(lit)),
            None => self.dome.illumination(light, job).map(Arc::new),
        }
    }
}

/// The lights that occur more than once, in order of their first occurrence.
fn repeated_lights(pairs: &[Directions]) -> Vec<Direction> {
    let mut uses: HashMap<DirectionKey, usize> = HashMap::new();
    pairs.iter().for_each(|pair| *uses.entry(key(pair.light)).or_default() += 1);
    let mut lights = Vec::new();
    for pair in pairs {
        // Taken out, so that each is listed once.
        if uses.remove(&key(pair.light)).is_some_and(|count| count > 1) {
            lights.push(pair.light);
        }
    }
    lights
}

#[cfg(test)]
mod tests {
    use super::super::sampling::{all_pairs, random_pairs};
    use super::super::{Bounce, DomeOptions, lights};
    use super::*;
    use crate::limits::Limits;
    use crate::maps::SurfaceMaps;
    use crate::planes::Planes;

    fn device(pairs: Vec<Directions>, job: &Job) -> Gonioreflectometer {
        let size = Size::new(24, 20);
        let height = (0..size.texels()).map(|i| 2.0 * ((i % 24) as f32 * 0.8).sin() + (i / 24 % 5) as f32);
        let maps = SurfaceMaps {
            height: Planes::from_vec(size, 1, height.collect()).unwrap(),
            albedo: Planes::from_vec(size, 3, vec![0.6; 3 * size.texels()]).unwrap(),
            normal: None,
            roughness: None,
            metallic: None,
        };
        let dome = Dome::new(maps, &DomeOptions { bounce: Bounce::Once, ..Default::default() }, job).unwrap();
        Gonioreflectometer::new(dome, pairs, job).unwrap()
    }

    #[test]
    fn images_are_the_same_in_any_order_and_however_much_light_is_kept() {
        let pairs = [all_pairs(&lights(4), &lights(3)), random_pairs(3, 1)].concat();
        let job = Job::default();
        let all = device(pairs.clone(), &job);
        assert_eq!((all.lit.len(), all.pairs().len()), (4, 15));
        let dome = Dome::footprint(all.size(), all.dome().options());
        let kept = Illumination::footprint(all.size()).kept;
        let small = Job::new(Limits {
            max_bytes: dome.kept + 2 * Gonioreflectometer::image_footprint(all.size()).peak + 5 * kept,
            ..Default::default()
        });
        let few = device(pairs, &small);
        assert!(few.lit.len() < 4, "{}", few.lit.len());
        let planes = all.images(0..15, |picture| Ok(picture.planes), &job).unwrap();
        for (number, planes) in planes.iter().enumerate().rev() {
            for device in [&all, &few] {
                let Samples::F32(samples) = device.image(number, &job).unwrap().samples().clone() else {
                    panic!("images are linear");
                };
                let same = (0..samples.len()).all(|i| samples[i] == planes.plane(i % 3)[i / 3]);
                assert!(same, "image {number}");
            }
        }
        assert_eq!(all.images(4..6, |picture| Ok(picture.planes), &job).unwrap(), planes[4..6]);
    }

    #[test]
    fn lights_are_kept_if_they_occur_again() {
        let [a, b] = [lights(2)[0], lights(2)[1]];
        let pair = |light, view| Directions { light, view };
        assert_eq!(repeated_lights(&[pair(a, a), pair(b, a), pair(b, b)]), [b]);
        assert_eq!(repeated_lights(&[pair(b, a), pair(a, a), pair(b, b), pair(a, b), pair(a, a)]), [b, a]);
    }
}
