//! What boundaries of shadows and highlights that move between the lights add to a texture under an environment: they are not
//! linear, so the corrections are summed up light by light.

use super::Environment;
use super::cells::cells;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::{ReflectanceField, Shapes};
use crate::job::Job;
use crate::planes::Planes;
use crate::render::relight::relight;

/// Lights that stand for the environment: corrections are small, so fewer than of the linear part do.
const CELLS: usize = 512;

/// Adds to a linear picture of three planes, for fields of the basis `shapes`; others stay as they are.
pub(super) fn add(
    field: &ReflectanceField,
    environment: &Environment,
    picture: &mut Planes,
    job: &Job,
) -> Result<()> {
    let Some(shapes) = Shapes::of(field, job)? else { return Ok(()) };
    let channels = field.layout().channels();
    job.check("the texture under a light of the environment", field.size(), 8 * channels as u64)?;
    let above: Vec<_> = cells(environment, CELLS).into_iter().filter(|cell| cell.direction.z > 0.0).collect();
    job.start("moving boundaries under the environment", above.len() as u64);
    for cell in above {
        let light = Direction::from_disk(cell.direction.x, cell.direction.y);
        let linear = relight(field, light).planes;
        let mut moved = linear.clone();
        shapes.correct(light, &mut moved);
        for (c, out) in picture.iter_mut().enumerate() {
            let share = (cell.power[c] / std::f64::consts::PI) as f32;
            let plane = c.min(channels - 1);
            for ((out, linear), moved) in out.iter_mut().zip(linear.plane(plane)).zip(moved.plane(plane)) {
                let light = |value: f32| field.space().to_linear(value).max(0.0);
                *out += share * (light(*moved) - light(*linear));
            }
        }
        job.advance(1)?;
    }
    Ok(())
}
