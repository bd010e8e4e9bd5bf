//! Tests of the actuators `propeller` and `buoyancy` against closed forms.

use crate::kit::*;

const G: f64 = 9.81;

fn hull(mass: f64, more: &str) -> String {
    cuboid("hull", [0.4, 0.4, 0.2], [0.0, 0.0, 0.0], &format!("dynamic = true\nmass_kg = {mass:?}\n{more}"))
}

fn actuator(kind: &str, more: &str) -> String {
    format!("[[object]]\nkind = \"actuator\"\nactuator = \"{kind}\"\nparent = \"/hull\"\nalias = \"it\"\n{more}\n")
}

#[test]
fn a_propeller_lifts_and_turns_its_hull() {
    // At half the maximum speed the thrust is a quarter of 40 N. The drag torque rotates the hull against the rotor.
    let propeller = actuator(
        "propeller",
        "max_speed_rad_s = 1000.0\nmax_thrust_n = 40.0\ntorque_per_thrust_m = 0.02\nspeed_rad_s = 500.0\n\
         time_constant_s = 0.0\ntime_constant_down_s = 0.0",
    );
    let lines = TestFolder::scene(&(hull(0.5, "") + &propeller)).trace(&["/hull"], &["--seconds", "1"]);
    let last = lines.last().unwrap();
    let ([_, _, v], [_, _, turn]) =
        (last.object::<3>("/hull", "linear_velocity"), last.object::<3>("/hull", "angular_velocity"));
    let t = last.time();
    assert!((v - (10.0 / 0.5 - G) * t).abs() < 1e-6, "{v}");
    let about_z = 0.5 * (0.16 + 0.16) / 12.0;
    assert!((turn + 0.02 * 10.0 / about_z * t).abs() < 1e-5, "{turn}");
}

#[test]
fn the_momentum_of_a_lagging_propeller_is_exact() {
    // The rotor's speed is w(t) = W (1 - e^(-t/tau)), and the impulse is the integral of k w^2.
    let (tau, most) = (0.2, 40.0);
    let propeller = actuator(
        "propeller",
        "max_speed_rad_s = 1000.0\nmax_thrust_n = 40.0\ntorque_per_thrust_m = 0.0\nspeed_rad_s = 1000.0\ntime_constant_s = 0.2",
    );
    let lines = TestFolder::scene(&(hull(1.0, "") + &propeller)).trace(&["/hull"], &["--seconds", "1"]);
    for line in lines {
        let t = line.time();
        let e = f64::exp(-t / tau);
        let impulse = most * (t - 2.0 * tau * (1.0 - e) + 0.5 * tau * (1.0 - e * e));
        let [_, _, v] = line.object::<3>("/hull", "linear_velocity");
        assert!((v - (impulse - G * t)).abs() < 1e-6, "{v} at {t}");
    }
}

#[test]
fn a_hull_heaves_as_its_waterline_says() {
    // A hull of 16 kg with an area of 0.16 m^2 sinks in by 0.1 m, half of its height. Released 0.03 m above this
    // position, it oscillates at sqrt(rho g A / m).
    let water = actuator("buoyancy", "size_m = [0.4, 0.4, 0.2]");
    let at = hull(16.0, "").replace("[0.0, 0.0, 0.0]", "[0.0, 0.0, 0.03]");
    let lines = TestFolder::scene(&format!("dt_s = 0.01\nphysics_dt_s = 0.002\n{at}{water}"))
        .trace(&["/hull"], &["--seconds", "3"]);
    let w = (1000.0 * G * 0.16 / 16.0_f64).sqrt();
    for line in lines {
        let [_, _, z] = line.object::<3>("/hull", "position");
        let wanted = 0.03 * f64::cos(w * line.time());
        assert!((z - wanted).abs() < 0.0015, "{z} against {wanted} at {}", line.time());
    }
}

#[test]
fn drag_brakes_exactly_as_much_as_it_says() {
    // A current of 1 m/s carries a floating hull along. With half of the hull in the water, v = 1 - e^(-D t / (2 m)).
    let water = actuator(
        "buoyancy",
        "size_m = [0.4, 0.4, 0.2]\ncurrent_m_s = [1.0, 0.0, 0.0]\nlinear_drag = [32.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    );
    let lines = TestFolder::scene(&(hull(16.0, "") + &water)).trace(&["/hull"], &["--seconds", "2"]);
    let last = lines.last().unwrap();
    let [v, ..] = last.object::<3>("/hull", "linear_velocity");
    let wanted = 1.0 - f64::exp(-last.time());
    assert!((v - wanted).abs() < 2e-3, "{v} against {wanted}");
}
