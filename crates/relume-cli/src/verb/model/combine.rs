//! Models of regular materials: a compressed set of tiles, and a random field for what it leaves out.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Domain, IndexSpace, Metric};
use relume::format::rlm;
use relume::random_field::{Budget, Character, FieldModel, LevelReport, ModelOptions, Tiles, combine_field};
use relume::synthesis::roller::{RollerOptions, roll};
use relume::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap, gather, synthesize};
use relume::{Planes, ReflectanceField, Result, Size};

use crate::context::Context;

/// Arguments for structure and detail.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct CombineArgs {
    /// Copy the structure from compressed tiles and model only the detail: where the material is regular and
    /// 64 texels wide or more, always, or never
    #[arg(long, default_value = "auto", value_parser = when())]
    combine: When,
    /// Bytes that the tiles may take [default: 3000, and 900 for each plane of colour or function]
    #[arg(long, value_name = "BYTES")]
    structure_bytes: Option<usize>,
    /// How many tiles; more of them repeat less visibly and share the bytes
    #[arg(long, value_name = "K", default_value_t = 1)]
    tiles: usize,
}

/// Textures of a smaller side have too few periods to cut tiles from.
const LEAST_SIDE: usize = 64;

/// When to combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum When {
    Auto,
    Always,
    Never,
}

fn when() -> impl TypedValueParser<Value = When> {
    PossibleValuesParser::new(["auto", "always", "never"]).map(|name| match name.as_str() {
        "always" => When::Always,
        "never" => When::Never,
        _ => When::Auto,
    })
}

/// Where the tiles come from.
struct Laid {
    map: SourceMap,
    tile: Size,
    how: String,
}

impl CombineArgs {
    /// Whether a structure is asked for whatever the material is.
    pub fn is_asked_for(&self) -> bool {
        self.combine == When::Always
    }

    /// Whether a material of this kind is modelled by structure and detail.
    pub fn applies(&self, kind: &Character, size: Size) -> bool {
        match self.combine {
            When::Auto => kind.is_regular() && size.width.min(size.height) >= LEAST_SIDE,
            when => when == When::Always,
        }
    }

    /// The model, its levels, and where the structure comes from.
    pub fn model(
        &self,
        field: &ReflectanceField,
        options: &ModelOptions,
        context: &Context,
    ) -> Result<(FieldModel, Vec<LevelReport>, String)> {
        let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?;
        context.job.check("the index of the exemplar", field.size(), 4 * space.planes() as u64)?;
        let laid = self.laid(&space.index_planes(field), context)?;
        let texels = gather(&laid.map, &[field], &context.job)?;
        let tiles = Tiles { texels: &texels, size: laid.tile };
        let bytes = self.structure_bytes.unwrap_or_else(|| 3000 + 900 * space.planes());
        let budget = Budget { bytes, cost: &rlm::structure_bytes };
        let (model, levels) = combine_field(field, tiles, &budget, options, &context.job)?;
        Ok((model, levels, laid.how))
    }

    /// Tiles by the Roller, or where their seams would show one of blocks laid on a torus.
    fn laid(&self, index: &Planes, context: &Context) -> Result<Laid> {
        let exemplar = Exemplar { index, excluded: None };
        let options = RollerOptions { tiles: self.tiles, ..RollerOptions::default() };
        let rolled = roll(&exemplar, &options, &context.job)?;
        if rolled.report.is_acceptable() || self.tiles > 1 {
            let (tile, count) = (rolled.tiles.tile(), rolled.tiles.count());
            let how = format!("{count} x {tile} texels by the Roller");
            return Ok(Laid { map: rolled.tiles.map().clone(), tile, how });
        }
        let size = index.size();
        let block = (size.width.min(size.height) / 4).max(8);
        let options = BlockOptions {
            size,
            block,
            overlap: BlockOptions::customary_overlap(block),
            boundary: Boundary::Torus,
            ..BlockOptions::default()
        };
        let made = synthesize(&[exemplar], &options, &context.job)?;
        Ok(Laid { map: made.map, tile: size, how: format!("{size} texels of blocks of {block}") })
    }
}
