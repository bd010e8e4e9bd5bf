//! The sensor kind "floor".

use tatu_plugin_api::{
    abi::{TATU_DIM_OWN, TATU_IN_COLOR, TATU_IN_DISTANCE},
    fields,
    safe::{
        Beams, Change, Fail, Field, Form, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld,
    },
};

use crate::{presets, spots::SpotLayout};

/// The plugin, which has no state.
pub struct FloorPlugin;

/// The configuration of a row of reflectance sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorSensor {
    spots: SpotLayout,
    /// Maximum distance of detection, m.
    range: f64,
    /// Pairs of distance, m, and value of a white surface, by ascending distance; if empty, the value is always 1.
    response: Vec<[f64; 2]>,
    threshold: f64,
    skip_own_model: bool,
}

const MAX_SPOTS: i64 = 1024;
const MAX_RAYS: i64 = 256;

fields! {
    FloorSensor {
        VALUE: f64 = Field::new("reflectance.value")
            .dims([TATU_DIM_OWN, 1, 1])
            .unit("1")
            .text("Light reflected by each spot, 0 to 1.");
        DETECTED: i32 = Field::new("reflectance.detected")
            .dims([TATU_DIM_OWN, 1, 1])
            .text("Whether the value of each spot is at least the threshold: 1 or 0.");
    }
}

/// Returns the numbers of a parameter in pairs, or an error if a number is not finite or the last pair is incomplete.
fn pairs(params: &Params<'_>, key: &str) -> Result<Vec<[f64; 2]>> {
    let all = params.get(key)?.numbers().unwrap_or_default();
    let (pairs, rest) = all.as_chunks::<2>();
    if !rest.is_empty() || !all.iter().all(|x| x.is_finite()) {
        return Err(Fail::argument(format!("`{key}`: expected pairs of finite numbers, found {all:?}")));
    }
    Ok(pairs.to_vec())
}

impl FloorSensor {
    fn of(params: &Params<'_>) -> Result<Self> {
        let listed = pairs(params, "spots")?;
        let (count, rays) = (params.i64("count")?, params.i64("rays")?);
        if listed.len() as i64 > MAX_SPOTS {
            return Err(Fail::argument(format!("`spots`: expected at most {MAX_SPOTS} spots, found {}", listed.len())));
        }
        let centres =
            if listed.is_empty() { SpotLayout::in_a_row(count.max(1) as usize, params.f64("pitch")?) } else { listed };
        let response = pairs(params, "response")?;
        let rises = response.windows(2).all(|w| w[0][0] < w[1][0]);
        if !rises || response.iter().any(|[d, v]| *d < 0.0 || *v < 0.0) {
            return Err(Fail::argument(format!(
                "`response`: expected pairs of distance (m) and value, both at least 0, by increasing distance; found \
                 {response:?}"
            )));
        }
        let spots = SpotLayout {
            centres,
            rays: rays.max(1) as usize,
            diameter: params.f64("diameter")?,
            view: params.f64("view")?,
        };
        let (range, threshold) = (params.f64("range")?, params.f64("threshold")?);
        Ok(FloorSensor { spots, range, response, threshold, skip_own_model: params.bool("skip_own_model")? })
    }

    /// Returns the value of a white surface at a distance, m.
    fn white_value(&self, distance: f64) -> f64 {
        let (Some(first), Some(last)) = (self.response.first(), self.response.last()) else { return 1.0 };
        let after = self.response.partition_point(|[d, _]| *d < distance);
        match (after.checked_sub(1).and_then(|i| self.response.get(i)), self.response.get(after)) {
            (None, _) => first[1],
            (_, None) => last[1],
            (Some([d0, v0]), Some([d1, v1])) => v0 + (v1 - v0) * (distance - d0) / (d1 - d0),
        }
    }

    fn value(&self, distance: f64, color: [u8; 3]) -> f64 {
        if !distance.is_finite() {
            return 0.0;
        }
        let brightness = color.iter().map(|c| f64::from(*c)).sum::<f64>() / (3.0 * 255.0);
        self.white_value(distance) * brightness
    }

    fn detect(&self, out: &mut Readout<'_>) {
        for i in 0..self.spots.centres.len() {
            let Some(value) = out.slice(Self::VALUE).get_mut(i) else { return };
            *value = value.clamp(0.0, 1.0);
            let detected = *value >= self.threshold;
            if let Some(place) = out.slice(Self::DETECTED).get_mut(i) {
                *place = detected.into();
            }
        }
    }
}

impl Sensor for FloorSensor {
    type Plugin = FloorPlugin;
    const ID: &'static str = "floor";
    const TEXT: &'static str = "Measures the reflectance of several spots, for line following and cliff detection.";
    const SCHEMAS: &'static [&'static str] = &["reflectance/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_COLOR;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::int("count")
                .range(1.0, MAX_SPOTS as f64)
                .default(1_i64)
                .text("Number of spots along the sensor's x."),
            Param::float("pitch").unit("m").range(0.0, 1e3).default(0.01).text("Distance between neighbouring spots."),
            Param::floats("spots", 0)
                .unit("m")
                .default(Vec::<f64>::new())
                .text("Centres of the spots, x and y of each, instead of `count` and `pitch`."),
            Param::float("range").unit("m").range(1e-6, 1e6).default(0.05).text("Maximum distance of detection."),
            Param::int("rays").range(1.0, MAX_RAYS as f64).default(1_i64).text("Rays per spot, spread over its area."),
            Param::float("diameter")
                .unit("m")
                .range(0.0, 1e3)
                .default(0.0)
                .text("Diameter of a spot at the sensor, if it has several rays."),
            Param::float("view")
                .unit("rad")
                .range(0.0, 3.0)
                .default(0.0)
                .text("Full opening angle of a spot, if it has several rays."),
            Param::floats("response", 0).default(Vec::<f64>::new()).text(
                "Pairs of distance (m) and value of a white surface, interpolated linearly; empty: 1 up to the range.",
            ),
            Param::float("threshold").range(0.0, 1.0).default(0.5).text("Minimum value at which a spot is detected."),
            Param::bool("skip_own_model").default(true).text("Whether objects of the sensor's own model are ignored."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        FloorSensor::of(params)
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        let new = FloorSensor::of(params)?;
        // The number of spots determines the lengths of the fields, which an instance cannot change.
        let same = new.spots.centres.len() == self.spots.centres.len();
        *self = new;
        Ok(if same { Change::Taken } else { Change::Rebuild })
    }

    fn beams(&self) -> Result<Beams> {
        let (origins, directions) = self.spots.rays();
        Ok(Beams {
            form: Form::Rays(directions),
            far: self.range,
            skip_own_model: self.skip_own_model,
            visible: true,
            own: [self.spots.centres.len() as u32, 0, 0, 0],
            origins,
            ..Beams::default()
        })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let (distances, colors) = (sample.distances(), sample.colors());
        let spots = distances.chunks(self.spots.rays).zip(colors.chunks(self.spots.rays));
        for (place, (distances, colors)) in out.slice(Self::VALUE).iter_mut().zip(spots) {
            let sum: f64 = distances.iter().zip(colors).map(|(d, c)| self.value(*d, *c)).sum();
            *place = sum / self.spots.rays as f64;
        }
        self.detect(out);
        Ok(())
    }

    /// Clamps the noisy values to the range 0 to 1, and compares them with the threshold.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        self.detect(out);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(response: Vec<[f64; 2]>) -> FloorSensor {
        let spots = SpotLayout { centres: vec![[0.0; 2]], rays: 1, diameter: 0.0, view: 0.0 };
        FloorSensor { spots, range: 0.1, response, threshold: 0.5, skip_own_model: false }
    }

    #[test]
    fn a_response_is_linear_between_its_points_and_constant_beyond() {
        let it = floor(vec![[0.002, 0.8], [0.004, 1.0], [0.016, 0.4]]);
        for (distance, value) in [(0.0, 0.8), (0.002, 0.8), (0.003, 0.9), (0.004, 1.0), (0.01, 0.7), (0.09, 0.4)] {
            assert!((it.white_value(distance) - value).abs() < 1e-12, "{distance}: {}", it.white_value(distance));
        }
        assert_eq!(floor(Vec::new()).white_value(0.09), 1.0);
    }

    #[test]
    fn brightness_is_the_mean_of_the_channels_and_zero_without_a_surface() {
        let it = floor(Vec::new());
        assert_eq!(it.value(0.01, [255; 3]), 1.0);
        assert_eq!(it.value(0.01, [0; 3]), 0.0);
        assert!((it.value(0.01, [255, 0, 0]) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(it.value(f64::INFINITY, [255; 3]), 0.0);
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (FloorSensor::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(FloorSensor::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(FloorSensor::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
