//! Masses as MuJoCo takes them.

use nalgebra::Matrix3;
use tatu_exporters_common::{ExportReport, MassProperties, XmlWriter, number, numbers};

/// Mass of a moving body without any, kg: MuJoCo requires one.
const LEAST_MASS: f64 = 1e-6;
/// Moments of inertia of such a body, kg m^2.
const LEAST_INERTIA: f64 = 1e-9;
/// Smallest moment of inertia that MuJoCo accepts, kg m^2.
const MIN_MOMENT: f64 = 2e-14;
/// Relative error of moments up to which a tensor is that of a thin plate, whose greatest moment is the sum of the others.
const ROUNDING: f64 = 1e-12;

/// Returns by how much the greatest moment of a tensor exceeds the sum of the others, as a share of it.
fn excess(inertia: &Matrix3<f64>) -> f64 {
    let moments = inertia.symmetric_eigenvalues();
    let most = moments.max();
    if most > 0.0 { (2.0 * most - moments.sum()) / most } else { 0.0 }
}

/// Writes the `<inertial>` of a moving body. Returns whether MuJoCo has to balance its inertia.
pub fn write_inertial(
    xml: &mut XmlWriter,
    mass: Option<&MassProperties>,
    path: &str,
    report: &mut ExportReport,
) -> bool {
    let Some(MassProperties { mass, com, inertia }) = mass else {
        report.lost(format!("MuJoCo requires that what moves has a mass: {LEAST_MASS} kg is stated"), path);
        let attributes =
            [("pos", "0 0 0".to_owned()), ("mass", number(LEAST_MASS)), ("diaginertia", numbers([LEAST_INERTIA; 3]))];
        xml.empty("inertial", &attributes);
        return false;
    };
    let mut inertia = (inertia + inertia.transpose()) / 2.0;
    let least = inertia.symmetric_eigenvalues().min();
    if least < MIN_MOMENT {
        report.lost(format!("MuJoCo requires moments of inertia of at least {MIN_MOMENT} kg m^2"), path);
        inertia += Matrix3::identity() * (MIN_MOMENT - least);
    }
    let excess = excess(&inertia);
    let mut balance = false;
    if excess > ROUNDING {
        report.lost(
            "MuJoCo replaces moments of inertia of which one exceeds the sum of the others by their mean \
             (`balanceinertia`)",
            path,
        );
        balance = true;
    } else if excess > -ROUNDING {
        // Rounding in MuJoCo must not make a thin plate impossible.
        inertia += Matrix3::identity() * (2.0 * ROUNDING * inertia.symmetric_eigenvalues().max());
    }
    let i = &inertia;
    let moments = [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]];
    let mut attributes = vec![("pos", numbers([com.x, com.y, com.z])), ("mass", number(*mass))];
    match moments[3..] == [0.0; 3] {
        true => attributes.push(("diaginertia", numbers(moments[..3].iter().copied()))),
        false => attributes.push(("fullinertia", numbers(moments))),
    }
    xml.empty("inertial", &attributes);
    balance
}
