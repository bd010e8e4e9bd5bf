//! The circuit of a battery: a source whose voltage depends on its charge, in series with a resistance and two parallel
//! loads, one of constant current and one of given power.

/// The cells of a battery, connected in series.
#[derive(Debug, Clone, PartialEq)]
pub struct BatteryCells {
    /// Full charge, C.
    pub capacity: f64,
    /// Open-circuit voltages, V, at equally spaced charges, from empty to full; at least one.
    pub voltages: Vec<f64>,
    /// Internal resistance, Ohm.
    pub resistance: f64,
}

/// The voltage and current of a battery at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryOutput {
    /// Voltage between the terminals, V.
    pub voltage: f64,
    /// Current of both loads, A.
    pub current: f64,
}

impl BatteryCells {
    /// Returns the open-circuit voltage at a charge from 0 to 1.
    pub fn open_voltage(&self, charge: f64) -> f64 {
        let Some(last) = self.voltages.len().checked_sub(1) else { return 0.0 };
        let at = charge.clamp(0.0, 1.0) * last as f64;
        let i = (at as usize).min(last.saturating_sub(1));
        let next = self.voltages[(i + 1).min(last)];
        self.voltages[i] + (next - self.voltages[i]) * (at - i as f64)
    }

    /// Returns the output at a charge from 0 to 1. The loads draw the constant current `idle`, A, and the power
    /// `power`, W. If the battery cannot deliver the power, it delivers the maximum available power; an empty battery
    /// delivers nothing.
    pub fn deliver(&self, charge: f64, idle: f64, power: f64) -> BatteryOutput {
        if charge <= 0.0 {
            return BatteryOutput { voltage: 0.0, current: 0.0 };
        }
        let open = self.open_voltage(charge);
        // The current cannot exceed the short-circuit current, which is unlimited without resistance.
        let idle = if self.resistance > 0.0 { idle.min(open / self.resistance) } else { idle };
        let left = open - self.resistance * idle;
        let root = (left * left - 4.0 * self.resistance * power).max(0.0).sqrt();
        // The smaller solution of R i^2 - left i + power = 0, in a form that is also valid for R = 0.
        let most = if self.resistance > 0.0 { 0.5 * left / self.resistance } else { f64::INFINITY };
        let drawn = if left + root > 0.0 { (2.0 * power / (left + root)).min(most) } else { 0.0 };
        let current = idle + drawn;
        BatteryOutput { voltage: open - self.resistance * current, current }
    }

    /// Returns the charge, 0 to 1, after a current, A, has flowed for a time, s.
    pub fn charge_after(&self, charge: f64, current: f64, time: f64) -> f64 {
        (charge - current * time / self.capacity).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells() -> BatteryCells {
        BatteryCells { capacity: 3600.0, voltages: vec![9.0, 11.1, 12.6], resistance: 0.5 }
    }

    #[test]
    fn voltage_is_linear_between_the_points_of_the_curve() {
        let it = cells();
        for (charge, voltage) in [(0.0, 9.0), (0.25, 10.05), (0.5, 11.1), (0.75, 11.85), (1.0, 12.6), (2.0, 12.6)] {
            assert!((it.open_voltage(charge) - voltage).abs() < 1e-12, "{charge}");
        }
        assert_eq!(BatteryCells { voltages: vec![6.0], ..cells() }.open_voltage(0.3), 6.0);
    }

    #[test]
    fn loads_receive_the_requested_power() {
        let it = cells();
        let BatteryOutput { voltage, current } = it.deliver(1.0, 0.4, 20.0);
        assert!((voltage * (current - 0.4) - 20.0).abs() < 1e-9, "the power");
        assert!((12.6 - 0.5 * current - voltage).abs() < 1e-12, "voltage drop at the resistance");
        assert_eq!(it.deliver(1.0, 0.4, 0.0).current, 0.4);
        let ideal = BatteryCells { resistance: 0.0, ..cells() };
        assert!((ideal.deliver(1.0, 0.0, 126.0).current - 10.0).abs() < 1e-12);
    }

    #[test]
    fn power_is_limited_by_the_internal_resistance() {
        // A source of 12.6 V with 0.5 Ohm delivers at most 12.6^2 / 4 / 0.5 = 79.38 W, at half its voltage.
        let most = cells().deliver(1.0, 0.0, 1e6);
        assert!((most.voltage - 6.3).abs() < 1e-12 && (most.voltage * most.current - 79.38).abs() < 1e-9);
        let shorted = cells().deliver(1.0, 1e6, 1.0);
        assert!(shorted.voltage.abs() < 1e-12 && (shorted.current - 25.2).abs() < 1e-12, "{shorted:?}");
        assert_eq!(cells().deliver(0.0, 1.0, 1.0), BatteryOutput { voltage: 0.0, current: 0.0 });
    }

    #[test]
    fn charge_decreases_by_the_current_and_stops_at_zero() {
        assert!((cells().charge_after(1.0, 1.0, 360.0) - 0.9).abs() < 1e-12);
        assert_eq!(cells().charge_after(0.1, 10.0, 3600.0), 0.0);
    }
}
