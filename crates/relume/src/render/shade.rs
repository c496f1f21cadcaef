//! The light reflected by a point of the object to the viewer.
//!
//! The value of a field is the light leaving a texel under a unit light, cosine included. It is looked up for
//! the direction of the light in the tangent frame of the point, so bumps are lit from the side of the light,
//! all around the object. Shadowing is threefold: the functions contain the shadows of the texture itself; a
//! point of the *object* that faces away from the light is dark, with a smooth fade over the last few degrees
//! above its horizon, or below the lowest lights that were measured (attached shadow); and a shadow map determines the points hidden by the rest of the
//! object (cast shadow). Highlights, which a function of light alone cannot move with the viewer, are added
//! from the normals of the texture (Hel-Or, Malzbender, Gelb, HPL-2003-16, section 2) by a GGX lobe
//! ([`crate::microfacet`]). An environment ([`super::environment`]) adds light from all around, without cast shadows.
//! Everything is summed in linear light.

use super::environment::{ImportanceTable, PlacedSamples, Prefiltered, TangentFrame};
use super::horizon::AttachedShadow;
use super::material::{LitTexture, Lookup};
use super::mesh::{Mesh, Tangents};
use super::mip_map::MipMap;
use super::raster::Setup;
use super::relief::Subdivided;
use super::scene::{RenderOptions, TexelShading};
use super::shadow::ShadowMap;
use super::vector::Vec3;
use super::view::View;
use crate::direction::{Direction, Directions};
use crate::size::Size;

/// The common data of all points.
pub struct Shader<'a> {
    pub mesh: &'a Mesh,
    /// The visible mesh, if it is displaced.
    pub moved: Option<&'a Subdivided>,
    /// Heights with their slopes, and the factor by which frames are tilted.
    pub slopes: Option<(&'a MipMap, f64)>,
    pub tangents: Tangents,
    pub material: &'a LitTexture,
    pub attached: AttachedShadow,
    pub view: View,
    pub options: &'a RenderOptions,
    /// One for each light, or none.
    pub shadows: Vec<ShadowMap>,
    pub ambient: Option<AmbientLight>,
}

/// The environment, prepared.
pub enum AmbientLight {
    Prefiltered(Box<Prefiltered>),
    /// With the number of samples of a point, and the seed.
    Sampled(ImportanceTable, usize, u64),
}

/// A triangle of the original mesh, and barycentric coordinates in it.
type MeshPlace = (usize, [f64; 3]);

/// A point of the object with the frame of the texture there, on the visible side.
struct SurfacePoint {
    position: Vec3,
    tangent: Vec3,
    bitangent: Vec3,
    normal: Vec3,
    /// The normal before it is tilted by the slopes of the relief.
    untilted: Vec3,
    /// The normal of the visible triangle, on the same side.
    face_normal: Vec3,
    to_viewer: Vec3,
}

impl SurfacePoint {
    /// A world vector in the frame of the texture.
    fn in_tangent_frame(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }
}

impl Shader<'_> {
    /// The linear colour of the point of the triangle seen at sample position (x, y).
    pub fn color(&self, setup: &Setup, x: f64, y: f64, lookup: &mut Lookup) -> [f64; 3] {
        let Some(barycentric) = setup.barycentric(x, y) else { return [0.0; 3] };
        let place = self.origin(setup, barycentric);
        let point = self.tilted(self.point(setup, barycentric, place), setup, (x, y), place);
        let mut sum = [0.0; 3];
        let mut fetched = self.ambient.is_some();
        if fetched {
            self.fetch(setup, (x, y), place, lookup);
            sum = self.under_environment(&point, (x, y), lookup);
        }
        for (i, light) in self.options.lights.iter().enumerate() {
            let lit = self.lit_share(&point, light.direction.into(), self.shadows.get(i));
            if lit == 0.0 {
                continue;
            }
            if !fetched {
                self.fetch(setup, (x, y), place, lookup);
                fetched = true;
            }
            let color = self.reflected(&point, light.direction.into(), lookup);
            (0..3).for_each(|c| sum[c] += lit * f64::from(light.color[c]) * color[c]);
        }
        sum
    }

    /// Looks up the texels of a place.
    fn fetch(&self, setup: &Setup, sample: (f64, f64), place: MeshPlace, lookup: &mut Lookup) {
        let footprint = self.footprint(setup, sample, place, self.material.texels().size());
        lookup.footprint = footprint;
        self.material.texels().fetch(self.coordinates(place), footprint, &mut lookup.values);
    }

    /// What looked-up texels reflect of the environment. The object does not hide any of it from itself.
    fn under_environment(&self, point: &SurfacePoint, (x, y): (f64, f64), lookup: &mut Lookup) -> [f64; 3] {
        let mut sum = [0.0; 3];
        match &self.ambient {
            None => {}
            Some(AmbientLight::Prefiltered(prefiltered)) => {
                let SurfacePoint { tangent, bitangent, normal, to_viewer, .. } = *point;
                let frame = TangentFrame { tangent, bitangent, normal };
                sum = prefiltered.reflected(self.material, lookup, &frame, to_viewer);
            }
            Some(AmbientLight::Sampled(table, samples, seed)) => {
                let at = PlacedSamples { samples: *samples, seed: *seed, place: [x as u64, y as u64] };
                table.for_each(at, |direction, color| {
                    let lit = self.lit_share(point, direction, None);
                    if lit > 0.0 {
                        let reflected = self.reflected(point, direction, lookup);
                        (0..3).for_each(|c| sum[c] += lit * color[c] * reflected[c]);
                    }
                });
            }
        }
        sum
    }

    /// The visible mesh.
    pub fn geometry(&self) -> &Mesh {
        self.moved.map_or(self.mesh, |moved| &moved.mesh)
    }

    /// The triangle of the original mesh, and the barycentric coordinates in it.
    fn origin(&self, setup: &Setup, barycentric: [f64; 3]) -> MeshPlace {
        match self.moved {
            Some(moved) => moved.origin(setup.triangle, barycentric),
            None => (setup.triangle as usize, barycentric),
        }
    }

    /// Texture coordinates of a position, tiling included.
    fn coordinates(&self, (triangle, barycentric): MeshPlace) -> [f64; 2] {
        let corners = self.mesh.triangles()[triangle].map(|i| self.mesh.texcoords()[i as usize]);
        std::array::from_fn(|k| {
            let along: f64 = corners.iter().zip(barycentric).map(|(c, b)| f64::from(c[k]) * b).sum();
            along * self.options.tiling[k]
        })
    }

    /// The longer distance to the positions of the neighbouring samples on a texture of `size`, in texels.
    fn footprint(&self, setup: &Setup, (x, y): (f64, f64), place: MeshPlace, size: Size) -> f64 {
        let here = self.coordinates(place);
        let square_distance = |x: f64, y: f64| {
            setup.barycentric(x, y).map_or(f64::INFINITY, |barycentric| {
                let there = self.coordinates(self.origin(setup, barycentric));
                let x = (there[0] - here[0]) * size.width as f64;
                let y = (there[1] - here[1]) * size.height as f64;
                x * x + y * y
            })
        };
        square_distance(x + 1.0, y).max(square_distance(x, y + 1.0)).sqrt()
    }

    /// The visible point, with the frame of the original mesh.
    fn point(&self, setup: &Setup, seen: [f64; 3], (triangle, barycentric): MeshPlace) -> SurfacePoint {
        let mix = |v: [Vec3; 3], b: [f64; 3]| v[0] * b[0] + v[1] * b[1] + v[2] * b[2];
        let geometry = self.geometry();
        let corners = geometry.corners(geometry.triangles()[setup.triangle as usize]);
        let position = mix(corners, seen);
        let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).unit();
        let vertices = self.mesh.triangles()[triangle];
        let smooth = mix(vertices.map(|i| Vec3::from(self.mesh.normals()[i as usize])), barycentric).unit();
        let normal = smooth.or(face).unwrap_or(Vec3::new(0.0, 0.0, 1.0));
        let face_normal = face.map_or(normal, |f| if f.dot(normal) < 0.0 { -f } else { f });
        let (tangents, handedness) = self.tangents.of_triangle(triangle, vertices);
        let along = mix(tangents, barycentric);
        let tangent = (along - normal * normal.dot(along)).unit().unwrap_or(normal.any_perpendicular());
        let bitangent = normal.cross(tangent) * handedness.sign();
        let to_viewer = self.view.towards_viewer(position);
        // Seen from behind, the surface shows the same relief inverted.
        let side = if face_normal.dot(to_viewer) < 0.0 { -1.0 } else { 1.0 };
        let (normal, face_normal) = (normal * side, face_normal * side);
        SurfacePoint { position, tangent, bitangent, normal, untilted: normal, face_normal, to_viewer }
    }

    /// The point with its frame tilted by the slopes of the relief and orthonormalised.
    fn tilted(
        &self,
        point: SurfacePoint,
        setup: &Setup,
        sample: (f64, f64),
        place: MeshPlace,
    ) -> SurfacePoint {
        let Some((slopes, factor)) = self.slopes else { return point };
        let mut values = Vec::new();
        let footprint = self.footprint(setup, sample, place, slopes.size());
        slopes.fetch(self.coordinates(place), footprint, &mut values);
        let [p, q] = [1, 2].map(|k| factor * f64::from(values[k]));
        let tilted = point.normal - point.tangent * p - point.bitangent * q;
        let normal = tilted.unit().unwrap_or(point.normal);
        let flat = |v: Vec3, n: Vec3| v - n * n.dot(v);
        let tangent = flat(point.tangent, normal).unit().unwrap_or(normal.any_perpendicular());
        let bitangent = flat(flat(point.bitangent, normal), tangent).unit().unwrap_or(point.bitangent);
        SurfacePoint { normal, tangent, bitangent, ..point }
    }

    /// The share of a light left by attached and cast shadows.
    fn lit_share(&self, point: &SurfacePoint, light: Vec3, shadow: Option<&ShadowMap>) -> f64 {
        let above = |normal: Vec3| self.attached.share(light.dot(normal));
        // For a bump, the horizon of the object itself still counts.
        let own = if self.slopes.is_some() && self.moved.is_none() { above(point.untilted) } else { 1.0 };
        let attached = own * above(point.normal);
        if attached == 0.0 {
            return 0.0;
        }
        attached * shadow.map_or(1.0, |map| map.visibility(point.position, point.face_normal))
    }

    /// The light reflected by the texture to the viewer under a unit light above its horizon.
    fn reflected(&self, point: &SurfacePoint, light: Vec3, lookup: &mut Lookup) -> [f64; 3] {
        let local = point.in_tangent_frame(light);
        let view = point.in_tangent_frame(point.to_viewer);
        let directions = Directions {
            light: Direction::from_disk(local.x, local.y),
            view: Direction::from_disk(view.x, view.y),
        };
        let color = self.material.color(lookup, directions);
        match self.options.shading {
            TexelShading::Plain { .. } => color.map(|c| c * local.z),
            TexelShading::Reflectance => {
                let highlight = self.highlight(point, local, &lookup.values);
                color.map(|c| c + highlight)
            }
        }
    }

    fn highlight(&self, point: &SurfacePoint, light: Vec3, values: &[f32]) -> f64 {
        match self.material.normal(values).and_then(|n| Vec3::from(n).unit()) {
            Some(normal) if self.options.specular.strength > 0.0 => {
                self.options.specular.lobe(normal, light, point.in_tangent_frame(point.to_viewer))
            }
            _ => 0.0,
        }
    }
}
