//! my_plugin: a part in Rust. A controller that holds the body it belongs to at a height: it reads the height, and
//! pushes.
//! - `my_plugin.height`: command, wanted height, m;
//! - `my_plugin.error`: reading, wanted minus actual height, m.
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use tatu_plugin_api::{safe::*, tatu_plugin};

/// The plugin. Data shared by all its parts would be stored here.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.part::<Holder>();
    }
}

/// One controller of a scene.
struct Holder {
    stiffness: f64,
    damping: f64,
    integral: f64,
}

/// The reading: wanted minus actual height, m.
const ERROR: usize = 0;

impl Part for Holder {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Holds the body that it belongs to at a height.";
    const MOMENTS: &'static [Moment] = &[Moment::PhysicsStep, Moment::Sense];
    const SCHEMAS: &'static [&'static str] = &["my_plugin/1"];
    /// The state is the integral of the error, m s. The host saves it in snapshots, hashes it, and zeroes it at a reset.
    const STATE: usize = 1;
    const PRESETS: &'static [Preset] = &[Preset {
        id: "soft",
        text: "A slow controller; the values are examples.",
        settings: "stiffness_n_m = 10.0\ndamping_ns_m = 8.0\nintegral = 4.0\n",
    }];

    fn params() -> Vec<Param> {
        let positive = |key| Param::float(key).range(0.0, f64::INFINITY);
        vec![
            positive("stiffness").unit("N/m").default(40.0).text("Force per error."),
            positive("damping").unit("N s/m").default(16.0).text("Force per speed."),
            positive("integral").default(40.0).text("Force per integral of the error, N/(m s)."),
        ]
    }
    fn commands() -> Vec<Param> {
        vec![Param::float("height").unit("m").default(1.0).text("Wanted height.")]
    }
    fn fields() -> Vec<Field> {
        vec![Field::f64("my_plugin.error").unit("m").text("Wanted minus actual height.")]
    }

    fn create(_: &ThisPlugin, _: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Holder {
            stiffness: params.f64("stiffness")?,
            damping: params.f64("damping")?,
            integral: params.f64("integral")?,
        })
    }
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        (self.stiffness, self.damping) = (params.f64("stiffness")?, params.f64("damping")?);
        self.integral = params.f64("integral")?;
        Ok(Change::Taken)
    }

    /// Pushes before each physics step.
    fn physics_step(&mut self, call: &mut PartCall<'_>) -> Result {
        let (body, height) = (call.owner(), call.pose(call.owner(), 0)?[2]);
        let off = call.commands()[0] - height;
        call.state[0] += off * call.dt();
        let up = self.stiffness * off + self.integral * call.state[0] - self.damping * call.twist(body)?[2];
        call.push(body, &[0.0, 0.0, up], &[0.0; 3])
    }

    /// Reports the error after each step, when the sensors have measured.
    fn sense(&mut self, call: &mut PartCall<'_>) -> Result {
        let height = call.pose(call.owner(), 0)?[2];
        call.report.f64(ERROR)[0] = call.commands()[0] - height;
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
