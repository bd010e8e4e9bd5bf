//! Aerodynamics of a rotor, in its own frame: +z is the direction of the thrust.

/// The constants of a rotor.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotor {
    /// Maximum speed, rad/s.
    pub max_speed: f64,
    /// Thrust per squared speed, N s^2.
    pub thrust: f64,
    /// Drag torque per thrust, m.
    pub torque: f64,
    /// 1 if the rotor rotates counter-clockwise, seen from above; -1 if it rotates clockwise.
    pub direction: f64,
    /// Time constants of an increasing and of a decreasing speed, s.
    pub lag: [f64; 2],
    /// Loss of thrust per unit of rotor speed and axial velocity, N s^2/m.
    pub inflow: f64,
    /// Force against the velocity across the axis, per unit of rotor speed and velocity, N s^2/m.
    pub drag: f64,
    /// Torque against the velocity across the axis, per unit of rotor speed and velocity, N s^2.
    pub rolling: f64,
    /// Inertia about the axis, kg m^2.
    pub inertia: f64,
}

/// The wrench of a rotor in its own frame, and the components of the wrench that the actuator reports.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RotorLoad {
    pub force: [f64; 3],
    pub torque: [f64; 3],
    /// Thrust along +z, N.
    pub thrust: f64,
    /// Torque of the air about the axis, against the rotation, N m.
    pub drag_torque: f64,
}

/// The speed of a rotor during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorSpeed {
    /// Speed at the end of the step, rad/s.
    pub end: f64,
    /// Mean speed, rad/s.
    pub mean: f64,
    /// Mean of the squared speed, rad^2/s^2.
    pub mean_square: f64,
}

impl Rotor {
    /// Returns the speed during a step of duration `dt` that starts with the speed `now` and approaches `wanted`.
    ///
    /// The means are exact, so the momentum that a body gains does not depend on the duration of steps.
    pub fn spin(&self, now: f64, wanted: f64, dt: f64) -> RotorSpeed {
        let wanted = wanted.clamp(0.0, self.max_speed);
        let tau = self.lag[usize::from(wanted < now)];
        if tau <= 0.0 || dt <= 0.0 {
            return RotorSpeed { end: wanted, mean: wanted, mean_square: wanted * wanted };
        }
        let (x, away) = (dt / tau, now - wanted);
        // Integrals of exp(-t / tau) and its square over the step, divided by dt.
        let (one, two) = (-libm::expm1(-x) / x, -libm::expm1(-2.0 * x) / (2.0 * x));
        RotorSpeed {
            end: wanted + away * libm::exp(-x),
            mean: wanted + away * one,
            mean_square: wanted * wanted + 2.0 * wanted * away * one + away * away * two,
        }
    }

    /// Returns the load on the mount. `velocity` and `turn` are the linear and angular velocity of the mount in the
    /// rotor's frame, m/s and rad/s; `acceleration` is the angular acceleration of the rotor, rad/s^2.
    pub fn load(&self, spin: RotorSpeed, velocity: [f64; 3], turn: [f64; 3], acceleration: f64) -> RotorLoad {
        let RotorSpeed { mean, mean_square, .. } = spin;
        let [u, v, w] = velocity;
        let thrust = self.thrust * mean_square - self.inflow * mean * w;
        let drag_torque = self.torque * self.thrust * mean_square;
        let (drag, rolling) = (self.drag * mean, self.rolling * mean);
        // The rate of change of the angular momentum, due to the rotation of the mount and to the acceleration of the
        // rotor.
        let momentum = self.inertia * self.direction * mean;
        let gyro = [-turn[1] * momentum, turn[0] * momentum];
        RotorLoad {
            force: [-drag * u, -drag * v, thrust],
            torque: [
                gyro[0] - rolling * u,
                gyro[1] - rolling * v,
                -self.direction * (drag_torque + self.inertia * acceleration),
            ],
            thrust,
            drag_torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotor() -> Rotor {
        Rotor {
            max_speed: 1000.0,
            thrust: 1e-5,
            torque: 0.016,
            direction: 1.0,
            lag: [0.02, 0.04],
            inflow: 0.0,
            drag: 0.0,
            rolling: 0.0,
            inertia: 0.0,
        }
    }

    #[test]
    fn the_mean_square_does_not_depend_on_the_length_of_steps() {
        for (from, to) in [(0.0, 800.0), (900.0, 100.0)] {
            let whole = rotor().spin(from, to, 0.1);
            let (mut now, mut mean, mut square) = (from, 0.0, 0.0);
            for _ in 0..50 {
                let part = rotor().spin(now, to, 0.002);
                (now, mean, square) = (part.end, mean + part.mean / 50.0, square + part.mean_square / 50.0);
            }
            assert!((now - whole.end).abs() < 1e-9 && (mean - whole.mean).abs() < 1e-9);
            assert!((square - whole.mean_square).abs() < 1e-6, "{square} {}", whole.mean_square);
        }
    }

    #[test]
    fn the_speed_is_limited_and_lags_differently_up_and_down() {
        assert_eq!(rotor().spin(0.0, -5.0, 0.01).end, 0.0);
        let up = rotor().spin(0.0, 1e9, 0.02).end;
        assert!((up - 1000.0 * (1.0 - libm::exp(-1.0))).abs() < 1e-9, "{up}");
        let down = rotor().spin(1000.0, 0.0, 0.04).end;
        assert!((down - 1000.0 * libm::exp(-1.0)).abs() < 1e-9, "{down}");
    }

    #[test]
    fn loads_follow_their_laws() {
        let spin = rotor().spin(500.0, 500.0, 0.01);
        let load = rotor().load(spin, [0.0; 3], [0.0; 3], 0.0);
        assert!((load.thrust - 2.5).abs() < 1e-12 && load.force == [0.0, 0.0, load.thrust]);
        // The drag torque on a counter-clockwise rotor is clockwise.
        assert!((load.torque[2] + 0.016 * 2.5).abs() < 1e-12);
        let air = Rotor { inflow: 1e-3, drag: 1e-4, rolling: 1e-6, ..rotor() };
        let load = air.load(spin, [2.0, 0.0, 3.0], [0.0; 3], 0.0);
        assert!((load.thrust - (2.5 - 1e-3 * 500.0 * 3.0)).abs() < 1e-12);
        assert!((load.force[0] + 0.1).abs() < 1e-12 && (load.torque[0] + 1e-3).abs() < 1e-12);
    }

    #[test]
    fn a_turning_rotor_is_a_gyroscope() {
        // A rotation of the mount about x tilts the angular momentum (0, 0, H) towards -y, at the rate turn * H; the
        // torque on the mount is along +y.
        let heavy = Rotor { inertia: 1e-4, ..rotor() };
        let load = heavy.load(heavy.spin(500.0, 500.0, 0.01), [0.0; 3], [2.0, 0.0, 0.0], 0.0);
        assert!((load.torque[1] - 2.0 * 1e-4 * 500.0).abs() < 1e-12, "{:?}", load.torque);
        // The acceleration of the rotor causes an opposite torque on the mount.
        let load = heavy.load(heavy.spin(500.0, 500.0, 0.01), [0.0; 3], [0.0; 3], 100.0);
        assert!((load.torque[2] + 0.04 + 0.01).abs() < 1e-12, "{:?}", load.torque);
    }
}
