//! Factorisations for each view (PVF): a mean and principal components.
//!
//! The components of a view are functions of light and channel weighted for each texel, or images weighted for
//! each light: their length says which.

use super::BtfScalar;
use super::factor::products;
use super::header::BtfHead;
use super::source::BtfCursor;
use crate::error::{Error, Result};
use crate::job::Held;
use crate::numeric::dot;
use crate::planes::Planes;

/// The factorisations of all views.
#[derive(Debug)]
pub(super) struct PerView(Vec<ViewFactors>);

/// That of one view: value = components x weights + mean.
#[derive(Debug)]
struct ViewFactors {
    scalar: BtfScalar,
    form: ViewForm,
    count: usize,
    mean: Vec<f32>,
    components: Vec<f32>,
    weights: Vec<f32>,
    _held: Held,
}

/// What the components of a view are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ViewForm {
    /// Functions of light and channel, and a row of weights for each texel.
    Functions,
    /// Images in all channels, and a row of weights for each light.
    Images,
}

impl PerView {
    pub(super) fn read(head: &BtfHead, cursor: &mut BtfCursor) -> Result<Self> {
        cursor.u32("the number of components")?;
        let slots = cursor.u32("the number of views")? as usize;
        if slots != head.sampling.views() {
            return Err(Error::invalid(format!(
                "the BTF file has factors of {slots} views and directions of {}: it is damaged",
                head.sampling.views()
            )));
        }
        (0..slots).map(|view| ViewFactors::read(view, head, cursor)).collect::<Result<_>>().map(Self)
    }

    /// The components of each view, and the numbers of the first.
    pub(super) fn stored(&self) -> (Vec<usize>, Option<BtfScalar>) {
        (self.0.iter().map(|view| view.count).collect(), self.0.first().map(|view| view.scalar))
    }

    /// The image of a light of a view, in all channels.
    pub(super) fn image(&self, (view, light): (usize, usize), planes: &mut Planes) {
        self.0[view].image(light, planes);
    }
}

impl ViewFactors {
    fn read(view: usize, head: &BtfHead, cursor: &mut BtfCursor) -> Result<Self> {
        let named = format!("the factors of view {view}");
        let scalar = BtfScalar::of_size(cursor.u8(&named)?, &named)?;
        let mut count = || cursor.u32(&named).map(u64::from);
        let (components, weights, length) = (count()?, count()?, count()?);
        let form = ViewForm::of(view, weights, length, head)?;
        if components > weights.max(length) {
            return Err(Error::invalid(format!(
                "{named} in the BTF file have {components} components: expected at most {}",
                weights.max(length)
            )));
        }
        let numbers = components.saturating_mul(length + weights + 1).saturating_add(length);
        cursor.expect(&named, numbers.saturating_mul(scalar.bytes()))?;
        let held = cursor.job().hold(&named, numbers.saturating_mul(4))?;
        cursor.numbers(&format!("the eigenvalues of view {view}"), components, scalar)?;
        let mut matrix = |what: &str, count| cursor.numbers(&format!("{what} of view {view}"), count, scalar);
        Ok(Self {
            scalar,
            form,
            count: components as usize,
            mean: matrix("the mean", length)?,
            components: matrix("the components", length * components)?,
            weights: matrix("the weights", weights * components)?,
            _held: held,
        })
    }

    fn image(&self, light: usize, planes: &mut Planes) {
        let (count, channels) = (self.count, planes.count());
        for (channel, plane) in planes.iter_mut().enumerate() {
            match self.form {
                ViewForm::Functions => {
                    let row = channel + channels * light;
                    let function = &self.components[row * count..][..count];
                    products(function, &self.weights, count, plane);
                    plane.iter_mut().for_each(|value| *value += self.mean[row]);
                }
                ViewForm::Images => {
                    let weights = &self.weights[light * count..][..count];
                    for (texel, value) in plane.iter_mut().enumerate() {
                        let row = channel + channels * texel;
                        *value = dot(&self.components[row * count..][..count], weights) + self.mean[row];
                    }
                }
            }
        }
    }
}

impl ViewForm {
    fn of(view: usize, weights: u64, length: u64, head: &BtfHead) -> Result<Self> {
        let (channels, texels) = (head.channels.len() as u64, head.size.texels() as u64);
        let lights = head.sampling.lights(view) as u64;
        let [functions, images] = [channels * lights, channels * texels];
        match (length, weights) {
            shape if shape == (functions, texels) => Ok(Self::Functions),
            shape if shape == (images, lights) => Ok(Self::Images),
            _ => Err(Error::invalid(format!(
                "the factors of view {view} in the BTF file have {weights} weights of components of {length} values: \
                 expected {texels} of {functions}, or {lights} of {images}"
            ))),
        }
    }
}
