//! The options of a synthesis, whatever the method, and the resulting plan.

use super::auto::{Asked, Auto, Choice, Chosen, Exemplars};
use super::fitted::Advised;
use super::method::{LaidTiles, MadeTexture, Plan, SynthesisMethod};
use super::metric::NamedMetric;
use super::sizes::Room;
use super::trend;
use crate::error::{Error, Result};
use crate::field::Domain;
use crate::job::Job;
use crate::names::Named;
use crate::numeric::lattice::Lattice;
use crate::numeric::periods::Pattern;
use crate::size::Size;
use crate::synthesis::elements::ElementOptions;
use crate::synthesis::pixel::{EfrosLeungOptions, NeighbourSearch, PatchMatchOptions, WeiLevoyOptions};
use crate::synthesis::search::{KernelBasis, SearchMethod, SearchOptions};
use crate::synthesis::{Blend, BlockOptions, Boundary, Guidance, Tolerance};

/// Options of a synthesis. `None` leaves the choice to the method: the sizes of blocks and windows and the
/// number of levels are then fitted to the exemplars ([`SynthOptions::fitted`]). Options of other methods than
/// the chosen one are refused by [`SynthOptions::approach`].
#[derive(Debug, Clone, PartialEq)]
pub struct SynthOptions {
    /// The method.
    pub method: SynthesisMethod,
    /// Its size in texels.
    pub size: Size,
    /// Whether it tiles.
    pub boundary: Boundary,
    /// The meaning of the distance of two texels.
    pub metric: NamedMetric,
    /// The light directions over which functions are compared.
    pub domain: Domain,
    /// The guide that the texture follows.
    pub guidance: Option<Guidance>,
    /// Whether the texture changes from side to side as its exemplar does, instead of following a guide.
    pub follow_trend: bool,
    /// Seed of the random choices.
    pub seed: u64,
    /// Side of the blocks in texels; `None` as the analysis suggests.
    pub block: Option<usize>,
    /// Texels by which blocks overlap; `None` for [`BlockOptions::customary_overlap`].
    pub overlap: Option<usize>,
    /// The tolerance within which candidates are drawn.
    pub tolerance: Option<Tolerance>,
    /// How blocks are joined.
    pub blend: Option<Blend>,
    /// Texels on either side of a cut within which blocks are blended.
    pub feather: Option<usize>,
    /// The search for blocks: a hint, which affects speed only.
    pub search: Option<SearchMethod>,
    /// The basis of the projection search.
    pub kernels: Option<KernelBasis>,
    /// Whether blocks of large exemplars are searched at a reduced resolution first: many times faster, nearly as good.
    pub coarse: bool,
    /// Whether the rejection curve of the projection search is measured, which takes time.
    pub curve: bool,
    /// Side of the window of texels that pixel methods compare, odd; `None` as the analysis suggests.
    pub neighbourhood: Option<usize>,
    /// How much farther than the best a window may be to be a candidate, as a fraction of the best squared
    /// distance.
    pub epsilon: Option<f64>,
    /// Resolutions, each half the one before; `None` as the analysis suggests.
    pub levels: Option<usize>,
    /// Leaves of the tree that is searched for neighbourhoods; 0 searches all of them instead. `None` without a
    /// coherence searches the continuations of neighbours only.
    pub codewords: Option<usize>,
    /// Candidates for each continuation of a neighbour; nothing else is searched.
    pub coherence: Option<usize>,
    /// The number of improvements of matches and texels at each level.
    pub rounds: Option<usize>,
    /// The penalty for overused parts of the exemplars.
    pub uniformity: Option<f64>,
    /// The number of tiles of the Roller; `None` for [`LaidTiles::TILES`].
    pub tiles: Option<usize>,
    /// The lattice of the texture, if known; otherwise it is measured.
    pub period: Option<Lattice>,
    /// The number of textures to choose from; `None` for [`Auto::TRIES`].
    pub tries: Option<usize>,
}

impl Default for SynthOptions {
    /// Blocks as the analysis suggests, joined along cuts into 256 x 256 texels with open edges, compared as functions
    /// over the hemisphere.
    fn default() -> Self {
        Self {
            method: SynthesisMethod::Quilting,
            size: BlockOptions::default().size,
            boundary: Boundary::Open,
            metric: NamedMetric::Function,
            domain: Domain::Hemisphere,
            guidance: None,
            follow_trend: false,
            seed: 0,
            block: None,
            overlap: None,
            tolerance: None,
            blend: None,
            feather: None,
            search: None,
            kernels: None,
            coarse: false,
            curve: false,
            neighbourhood: None,
            epsilon: None,
            levels: None,
            codewords: None,
            coherence: None,
            rounds: None,
            uniformity: None,
            tiles: None,
            period: None,
            tries: None,
        }
    }
}

/// How a texture is to be made.
#[derive(Debug, Clone, PartialEq)]
pub enum Approach {
    /// By one plan.
    Plan(Plan),
    /// By one method, whose open sizes are fitted to the exemplars.
    Fitted(Box<SynthOptions>),
    /// By several plans, of which the best is kept.
    Auto(Auto),
}

/// A texture, its plan, and how that was chosen.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The plan.
    pub plan: Plan,
    /// The texture.
    pub made: MadeTexture,
    /// The sizes that were fitted to the exemplars.
    pub advised: Option<Advised>,
    /// How the plan was chosen, where several were tried.
    pub choice: Option<Choice>,
}

impl Approach {
    /// Makes the texture.
    ///
    /// # Errors
    /// As [`Plan::run`] and [`Auto::run`].
    pub fn run(&self, exemplars: &Exemplars<'_>, job: &Job) -> Result<Outcome> {
        match self {
            Self::Plan(plan) => {
                let made = plan.run(exemplars.planes, job)?;
                Ok(Outcome { plan: plan.clone(), made, advised: None, choice: None })
            }
            Self::Fitted(options) => {
                let options = options.guided_by_trend(exemplars, job)?;
                let room = Room::measure(exemplars.planes, options.size, job)?;
                let (options, advised) = options.fitted(&room);
                let plan = options.plan()?;
                plan.validate()?;
                let made = plan.run(exemplars.planes, job)?;
                Ok(Outcome { plan, made, advised: Some(advised), choice: None })
            }
            Self::Auto(auto) => {
                let Chosen { made, choice } = auto.run(exemplars, job)?;
                let plan = choice.tries[choice.kept].plan.clone();
                Ok(Outcome { plan, made, advised: None, choice: Some(choice) })
            }
        }
    }
}

/// An option that belongs to some methods only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Special {
    /// Its name.
    pub name: &'static str,
    /// Whether it is given.
    pub is_given: bool,
    /// The methods that it belongs to.
    pub methods: &'static [SynthesisMethod],
}

impl SynthOptions {
    /// The options that belong to some methods only.
    pub fn special(&self) -> [Special; 19] {
        use SynthesisMethod::{Auto, EfrosLeung, Elements, PatchMatch, Quilting, Roller, WeiLevoy};
        const BLOCKS: &[SynthesisMethod] = &[Quilting, Auto];
        const GUIDED: &[SynthesisMethod] = &[Quilting, EfrosLeung, WeiLevoy, PatchMatch, Auto];
        let tolerance = match self.tolerance {
            Some(Tolerance::Absolute(_)) => "delta",
            _ => "tolerance",
        };
        let special = |name, is_given, methods| Special { name, is_given, methods };
        [
            special("block", self.block.is_some(), BLOCKS),
            special("overlap", self.overlap.is_some(), BLOCKS),
            special(tolerance, self.tolerance.is_some(), BLOCKS),
            special("blend", self.blend.is_some(), BLOCKS),
            special("feather", self.feather.is_some(), BLOCKS),
            special("search", self.search.is_some(), BLOCKS),
            special("kernels", self.kernels.is_some(), BLOCKS),
            special("coarse", self.coarse, BLOCKS),
            special("tiles", self.tiles.is_some(), &[Roller]),
            special("period", self.period.is_some(), &[Roller, Elements]),
            special("follow-trend", self.follow_trend, GUIDED),
            special("tries", self.tries.is_some(), &[Auto]),
            special("neighbourhood", self.neighbourhood.is_some(), &[EfrosLeung, WeiLevoy, PatchMatch]),
            special("epsilon", self.epsilon.is_some(), &[EfrosLeung]),
            special("levels", self.levels.is_some(), &[WeiLevoy, PatchMatch]),
            special("codewords", self.codewords.is_some(), &[WeiLevoy]),
            special("coherence", self.coherence.is_some(), &[WeiLevoy]),
            special("rounds", self.rounds.is_some(), &[PatchMatch]),
            special("uniformity", self.uniformity.is_some(), &[PatchMatch]),
        ]
    }

    /// The first given option that the chosen method does not have.
    pub fn stranger(&self) -> Option<Special> {
        self.special().into_iter().find(|one| one.is_given && !one.methods.contains(&self.method))
    }

    /// The chosen method with its options, checked.
    ///
    /// # Errors
    /// Options without meaning, and options of another method than the chosen one.
    pub fn approach(&self) -> Result<Approach> {
        if let Some(Special { name, methods, .. }) = self.stranger() {
            let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
            return Err(Error::usage(format!(
                "{name} does not apply to the method {}: it is an option of {}",
                self.method.name(),
                names.join(" and ")
            )));
        }
        if let (Some(kernels), Some(search)) = (self.kernels, self.search)
            && search != SearchMethod::Projection
        {
            return Err(Error::usage(format!(
                "the kernels {} are of the search projection, and the search is {}: leave out one of them",
                kernels.name(),
                search.name()
            )));
        }
        if self.follow_trend && self.guidance.is_some() {
            return Err(Error::usage(
                "a texture follows a guide or the trend of its exemplar: choose one of them",
            ));
        }
        if self.method == SynthesisMethod::Auto {
            let asked = Asked { block: self.block, overlap: self.overlap, trend: self.follow_trend };
            return Ok(Approach::Auto(Auto::new(self.tries, self.blocks(), asked)?));
        }
        // Sizes that are left open are checked when they are known; the others now, before the work.
        let plan = self.plan()?;
        if self.open_sizes().is_empty() && !self.follow_trend {
            plan.validate()?;
            return Ok(Approach::Plan(plan));
        }
        self.tolerant().plan()?.validate()?;
        Ok(Approach::Fitted(Box::new(self.clone())))
    }

    /// The same with the guide that makes it follow the trend of its exemplar, where that is asked for.
    fn guided_by_trend(&self, exemplars: &Exemplars<'_>, job: &Job) -> Result<Self> {
        let guide = || trend::guidance(exemplars.planes, self.size, self.boundary, job);
        let guidance = if self.follow_trend { Some(guide()?) } else { self.guidance.clone() };
        Ok(Self { guidance, ..self.clone() })
    }

    /// The plan of the chosen method, with customary sizes where none are given.
    pub(super) fn plan(&self) -> Result<Plan> {
        Ok(match self.method {
            SynthesisMethod::EfrosLeung => Plan::EfrosLeung(self.efros_leung()),
            SynthesisMethod::WeiLevoy => Plan::WeiLevoy(self.wei_levoy(), self.boundary),
            SynthesisMethod::PatchMatch => Plan::PatchMatch(self.patch_match()),
            SynthesisMethod::Roller => Plan::Roller(self.laid_tiles()?),
            SynthesisMethod::Elements => Plan::Elements(self.elements()?),
            SynthesisMethod::Quilting | SynthesisMethod::Auto => Plan::Quilting(self.blocks()),
            SynthesisMethod::Noise => {
                return Err(Error::usage("the method noise makes windows of an endless plane only"));
            }
        })
    }

    fn blocks(&self) -> BlockOptions {
        let default = BlockOptions::default();
        let block = self.block.unwrap_or(default.block);
        BlockOptions {
            size: self.size,
            block,
            overlap: self.overlap.unwrap_or_else(|| BlockOptions::customary_overlap(block)),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            blend: self.blend.unwrap_or(default.blend),
            feather: self.feather.unwrap_or(default.feather),
            boundary: self.boundary,
            guidance: self.guidance.clone(),
            seed: self.seed,
            search: SearchOptions {
                method: self.search.unwrap_or_default(),
                basis: self.kernels.unwrap_or_default(),
                curve: self.curve,
                coarse: self.coarse,
                ..SearchOptions::default()
            },
        }
    }

    fn efros_leung(&self) -> EfrosLeungOptions {
        let default = EfrosLeungOptions::default();
        EfrosLeungOptions {
            size: self.size,
            window: self.neighbourhood.unwrap_or(default.window),
            epsilon: self.epsilon.unwrap_or(default.epsilon),
            boundary: self.boundary,
            guidance: self.guidance.clone(),
            seed: self.seed,
        }
    }

    fn wei_levoy(&self) -> WeiLevoyOptions {
        let default = WeiLevoyOptions::default();
        WeiLevoyOptions {
            size: self.size,
            window: self.neighbourhood.unwrap_or(default.window),
            levels: self.levels.unwrap_or(default.levels),
            search: self.neighbour_search(),
            guidance: self.guidance.clone(),
            seed: self.seed,
        }
    }

    /// How Wei-Levoy searches: as given, and by the classical tree where only its leaves are given, or where
    /// continued pieces would not follow a guide.
    fn neighbour_search(&self) -> NeighbourSearch {
        match (self.coherence, self.codewords) {
            (None, None) if self.guidance.is_some() => NeighbourSearch::Tsvq(NeighbourSearch::CODEWORDS),
            (None, None) => NeighbourSearch::CONTINUED,
            (None, Some(0)) => NeighbourSearch::Full,
            (None, Some(codewords)) => NeighbourSearch::Tsvq(codewords),
            (Some(candidates), codewords) => {
                let codewords = codewords.unwrap_or(NeighbourSearch::CODEWORDS);
                NeighbourSearch::Coherence { candidates, codewords }
            }
        }
    }

    fn patch_match(&self) -> PatchMatchOptions {
        let default = PatchMatchOptions::default();
        PatchMatchOptions {
            size: self.size,
            window: self.neighbourhood.unwrap_or(default.window),
            levels: self.levels.unwrap_or(default.levels),
            rounds: self.rounds.unwrap_or(default.rounds),
            uniformity: self.uniformity.unwrap_or(default.uniformity),
            guidance: self.guidance.clone(),
            boundary: if self.follow_trend { Boundary::Open } else { Boundary::Torus },
            seed: self.seed,
            ..default
        }
    }

    fn laid_tiles(&self) -> Result<LaidTiles> {
        if self.guidance.is_some() {
            return Err(Error::usage("the method roller lays tiles in random order and follows no guides"));
        }
        let tiles = self.tiles.unwrap_or(LaidTiles::TILES);
        let mut laid = LaidTiles::new(tiles, self.size, self.boundary, self.seed);
        laid.options.pattern = self.period.map(Pattern::Lattice);
        Ok(laid)
    }

    fn elements(&self) -> Result<ElementOptions> {
        if self.guidance.is_some() {
            return Err(Error::usage("the method elements lays them in random order and follows no guides"));
        }
        let (size, boundary, lattice, seed) = (self.size, self.boundary, self.period, self.seed);
        Ok(ElementOptions { size, boundary, lattice, seed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_decide_the_plan_before_anything_is_made() {
        let approach = |options: SynthOptions| options.approach();
        let plan = |options| match approach(options).unwrap() {
            Approach::Plan(plan) => plan,
            Approach::Fitted(_) | Approach::Auto(_) => panic!("one way was asked for, and all sizes"),
        };
        let blocks = SynthOptions { block: Some(48), ..SynthOptions::default() };
        assert_eq!(
            plan(blocks),
            Plan::Quilting(BlockOptions { block: 48, overlap: 8, ..Default::default() })
        );
        let scanlines = SynthOptions {
            method: SynthesisMethod::WeiLevoy,
            codewords: Some(0),
            neighbourhood: Some(5),
            levels: Some(4),
            ..Default::default()
        };
        let full = WeiLevoyOptions { search: NeighbourSearch::Full, ..Default::default() };
        assert_eq!(plan(scanlines), Plan::WeiLevoy(full, Boundary::Open));
        let closed =
            SynthOptions { method: SynthesisMethod::Roller, boundary: Boundary::Torus, ..Default::default() };
        assert!(
            matches!(plan(closed), Plan::Roller(laid) if !laid.options.oblique && laid.options.tiles == 4)
        );
    }

    #[test]
    fn options_of_other_methods_are_refused_by_name() {
        let strange = SynthOptions { method: SynthesisMethod::Roller, rounds: Some(3), ..Default::default() };
        let message = strange.approach().unwrap_err().to_string();
        assert_eq!(message, "rounds does not apply to the method roller: it is an option of patchmatch");
        let noise = SynthOptions { method: SynthesisMethod::Noise, ..Default::default() };
        assert!(noise.approach().unwrap_err().to_string().contains("endless"));
        let none = SynthOptions { method: SynthesisMethod::Auto, tries: Some(0), ..Default::default() };
        assert!(none.approach().unwrap_err().to_string().contains("0 tries"));
    }
}
