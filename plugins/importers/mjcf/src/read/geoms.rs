//! Reads geoms: their forms, masses and looks.

use nalgebra::Vector3;
use tatu_importers_common::{Mass, Solid};
use tatu_plugin_api::safe::Result;

use super::{Reader, Source, bodies::ends};
use crate::{
    attributes::Attributes,
    compiler::Compiler,
    model::{Geom, GeomForm, Look},
};

/// Density of geoms that state none, kg/m^3.
const DEFAULT_DENSITY: f64 = 1000.0;
/// Colour of geoms that state none.
const DEFAULT_RGBA: [f64; 4] = [0.5, 0.5, 0.5, 1.0];

impl Reader<'_, '_> {
    /// Reads a geom; `None` if its form cannot be read, which is reported.
    pub(super) fn geom(&mut self, source: &Source, a: &Attributes<'_>, name: String) -> Result<Option<Geom>> {
        let place = &a.element.place;
        let mut pose = source.compiler.pose(a)?;
        let kind = a.text("type").unwrap_or_else(|| "sphere".into());
        let mut size = a.partial("size", [0.0; 3])?;
        let mesh = a.text("mesh");
        if let Some((middle, half)) = ends(a)? {
            pose = middle;
            match kind.as_str() {
                "box" | "ellipsoid" => size = [size[0], size[0], half],
                _ => size[1] = half,
            }
        }
        let fitted = mesh.is_some() && kind != "mesh" && kind != "sdf";
        if fitted {
            self.report.warn(place, "a form that is fitted to a mesh is replaced by the mesh");
        }
        let needed = match kind.as_str() {
            _ if mesh.is_some() => 0,
            "sphere" => 1,
            "capsule" | "cylinder" => 2,
            "box" | "ellipsoid" => 3,
            _ => 0,
        };
        if size[..needed].iter().any(|x| *x <= 0.0) {
            return Err(a.invalid("size", &format!("{needed} lengths greater than 0 for a geom of the type {kind}")));
        }
        let form = match kind.as_str() {
            _ if mesh.is_some() => match self.mesh(source, &mesh.unwrap_or_default(), a.element)? {
                Some(mesh) => GeomForm::Mesh(mesh),
                None => return Ok(None),
            },
            "plane" => GeomForm::Plane([size[0], size[1]]),
            "sphere" => GeomForm::Ellipsoid([size[0]; 3]),
            "ellipsoid" => GeomForm::Ellipsoid(size),
            "capsule" => GeomForm::Capsule { radius: size[0], half: size[1] },
            "cylinder" => GeomForm::Cylinder { radius: size[0], half: size[1] },
            "box" => GeomForm::Box(size),
            "hfield" => {
                let name = a.text("hfield").ok_or_else(|| a.invalid("hfield", "the name of a height field"))?;
                match self.height_field(source, &name, a.element)? {
                    Some(mesh) => GeomForm::Heights(mesh),
                    None => return Ok(None),
                }
            }
            "mesh" => return Err(a.invalid("mesh", "the name of a mesh")),
            "sdf" => {
                self.report.warn(place, "geoms of the type `sdf` are omitted");
                return Ok(None);
            }
            _ => return Err(a.invalid("type", "a type of geoms, such as box or mesh")),
        };
        let mask = |name: &str| a.integer(name, 1).map(|x| x as u32);
        let group = a.integer("group", 0)?;
        let mut geom = Geom {
            name,
            form,
            pose,
            contype: mask("contype")?,
            conaffinity: mask("conaffinity")?,
            condim: a.integer("condim", 3)?,
            group,
            friction: a.partial("friction", [1.0, 0.005, 0.0001])?,
            mass: Mass::ZERO,
            look: self.look(source, a)?,
        };
        if a.switch("shellinertia")?.unwrap_or(false) {
            self.report.warn(place, "`shellinertia` is ignored: the geom is weighed as a solid");
        }
        let weighs = source.compiler.mass_groups[0] <= group as f64 && group as f64 <= source.compiler.mass_groups[1];
        if weighs && let Some(solid) = solid(&geom.form) {
            let stated = if a.has("mass") { Some(a.positive("mass", 0.0)?) } else { None };
            geom.mass = solid.mass(stated, a.positive("density", DEFAULT_DENSITY)?).moved(&geom.pose);
        }
        if source.compiler.discards_visuals && !geom.collides() {
            // The mass remains.
            geom.look.rgba[3] = 0.0;
        }
        Ok(Some(geom))
    }

    fn look(&mut self, source: &Source, a: &Attributes<'_>) -> Result<Look> {
        let own = a.array::<4>("rgba")?;
        let material = match a.text("material") {
            Some(name) => self.material(source, &name, a.element)?,
            None => None,
        };
        let own = own.filter(|rgba| material.is_none() || *rgba != DEFAULT_RGBA);
        let look = match (own, material) {
            (Some(rgba), material) => Look { rgba, texture: material.and_then(|m| m.texture), is_default: false },
            (None, Some(material)) => material,
            (None, None) => Look { rgba: DEFAULT_RGBA, texture: None, is_default: true },
        };
        Ok(Look { rgba: look.rgba.map(|x| x.clamp(0.0, 1.0)), ..look })
    }

    /// Determines the masses of all bodies.
    pub(super) fn finish_masses(&mut self, compiler: &Compiler) -> Result {
        for body in &mut self.model.bodies {
            let from_geoms = match compiler.inertia_from_geoms {
                Some(from_geoms) => from_geoms,
                None => body.inertial.is_none(),
            };
            let parts: Vec<Mass> = body.geoms.iter().map(|g| g.mass).collect();
            let stated = body.inertial.filter(|_| !from_geoms || parts.iter().all(|p| p.mass == 0.0));
            body.mass = match stated {
                Some(mass) => mass,
                None if from_geoms => Mass::sum(&parts),
                None => Mass::ZERO,
            };
        }
        for body in self.model.bodies.iter_mut().skip(1) {
            body.mass.mass = body.mass.mass.max(compiler.least_mass);
            let least = compiler.least_inertia;
            body.mass = body.mass.with_moments(|m| m.map(|x| if least > 0.0 { x.max(least) } else { x }));
            if compiler.balance_inertia {
                let uneven = |m: Vector3<f64>| 2.0 * m.max() > m.sum();
                body.mass = body.mass.with_moments(|m| if uneven(m) { Vector3::repeat(m.mean()) } else { m });
            }
        }
        let total: f64 = self.model.bodies.iter().skip(1).map(|b| b.mass.mass).sum();
        if let Some(wanted) = compiler.total_mass.filter(|_| total > 0.0) {
            self.model.bodies.iter_mut().skip(1).for_each(|b| b.mass = b.mass.scaled(wanted / total));
        }
        Ok(())
    }
}

/// Returns the solid of a form; `None` for forms without a mass.
fn solid(form: &GeomForm) -> Option<Solid> {
    Some(match form {
        GeomForm::Plane(_) | GeomForm::Heights(_) => return None,
        GeomForm::Ellipsoid(half) => Solid::ellipsoid(*half),
        GeomForm::Capsule { radius, half } => Solid::capsule(*radius, *half),
        GeomForm::Cylinder { radius, half } => Solid::cylinder(*radius, *half),
        GeomForm::Box(half) => Solid::cuboid(*half),
        GeomForm::Mesh(mesh) => mesh.solid,
    })
}
