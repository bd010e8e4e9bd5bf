//! Computes covariances of readings from the noise that a scene declares for sensors.

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Turn, Value},
};
use toml_edit::{Item, Table, TableLike};

use crate::Props;

/// Returns the 3 x 3 covariance matrix of a sensor's field with three components, in row-major order. The matrix is
/// diagonal. Noise that depends on the measured value is evaluated at 0, and errors that grow without bound are
/// ignored.
pub fn matrix(turn: &Turn<'_>, p: &Props, id: tatu_object, field: &str) -> Value {
    let [x, y, z] = variances(turn, p, id, field);
    Value::Floats(vec![x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z])
}

/// Returns the variances of the components of a sensor's field; 0 if the scene declares no noise for it.
pub fn variances(turn: &Turn<'_>, p: &Props, id: tatu_object, field: &str) -> [f64; 3] {
    let noise = turn.get(id, p.noise).ok().and_then(|v| v.as_str()).unwrap_or_default();
    if noise.is_empty() {
        return [0.0; 3];
    }
    let rate = turn.f64(id, p.rate).ok().filter(|r| *r > 0.0);
    let rate = rate.or_else(|| turn.f64(0, p.dt).ok().map(|dt| 1.0 / dt)).unwrap_or(0.0);
    declared_variances(&noise, field, rate)
}

/// Returns the variances described by a noise declaration for a sensor with the measurement rate `rate`, Hz.
fn declared_variances(noise: &str, field: &str, rate: f64) -> [f64; 3] {
    let Ok(all) = noise.parse::<toml_edit::DocumentMut>() else { return [0.0; 3] };
    let Some(own) = all.get(field).and_then(Item::as_table_like) else { return [0.0; 3] };
    let none = Table::new();
    let walk = own.get("walk").and_then(Item::as_table_like).unwrap_or(&none);
    let each = |table: &dyn TableLike, key: &str, i: usize| table.get(key).map_or(0.0, |v| number(v, i));
    std::array::from_fn(|i| {
        let normal = [sigma(own, i), each(own, "shift_sigma", i), each(walk, "sigma", i)];
        let normal: f64 = normal.iter().map(|s| s * s).sum();
        let uniform =
            ["uniform", "shift"].map(|key| each(own, key, i)).iter().map(|half| half * half / 3.0).sum::<f64>();
        let rounding = each(own, "step", i);
        normal + uniform + each(own, "density", i).powi(2) * rate + rounding * rounding / 12.0
    })
}

/// Returns the value of a key of a noise declaration for component `i`. The declaration contains a list with an element
/// per component, or a number for all components.
fn number(item: &Item, i: usize) -> f64 {
    let one = |v: &toml_edit::Value| v.as_float().or_else(|| v.as_integer().map(|n| n as f64));
    let list = item.as_array().map(|list| list.get(i).and_then(one));
    list.unwrap_or_else(|| item.as_value().and_then(one)).unwrap_or(0.0)
}

/// Returns the standard deviation of component `i` for the value 0. The key `sigma` of a noise declaration is a number,
/// a polynomial (a list of coefficients), or a list with a polynomial per component.
fn sigma(own: &dyn TableLike, i: usize) -> f64 {
    let Some(item) = own.get("sigma") else { return 0.0 };
    match item.as_array() {
        Some(list) => match list.get(i).and_then(|v| v.as_array()) {
            Some(polynomial) => number(&Item::Value(polynomial.clone().into()), 0),
            None => number(item, 0),
        },
        None => number(item, i),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(noise: &str, wanted: [f64; 3]) {
        let got = declared_variances(noise, "imu.acceleration", 100.0);
        assert!(got.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{noise}: {got:?}");
    }

    #[test]
    fn variances_are_those_of_the_declared_noise() {
        let one = |x: f64| [x; 3];
        near("", one(0.0));
        near("[\"imu.gyro\"]\nsigma = 1.0", one(0.0));
        near("[\"imu.acceleration\"]\nsigma = 0.1", one(0.01));
        // A polynomial with the value 0.1 at 0.
        near("[\"imu.acceleration\"]\nsigma = [0.1, 3.0]", one(0.01));
        near("[\"imu.acceleration\"]\nsigma = [[0.1, 1.0], [0.2], [0.3, 0.0]]", [0.01, 0.04, 0.09]);
        near("[\"imu.acceleration\"]\nuniform = 0.3\nstep = 0.12", one(0.03 + 0.0012));
        near("[\"imu.acceleration\"]\ndensity = 0.02", one(0.04));
        near(
            "[\"imu.acceleration\"]\nshift_sigma = [1, 2, 3]\nwalk = { sigma = [1, 0, 0], tau_s = 10 }",
            [2.0, 4.0, 9.0],
        );
    }
}
