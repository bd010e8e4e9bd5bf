//! Sensors and actuators with targets and contacts, without a host.

#![allow(missing_docs)]

use tatu_plugin_api::{abi::*, fields, safe::*};
use tatu_plugin_testkit::{ActuatorBench, Inputs, Motion, Surroundings, measure, measure_all};

struct EmptyPlugin;

impl Plugin for EmptyPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(EmptyPlugin)
    }
    fn offer(_: &mut Offer<Self>) {}
}

fn target(object: tatu_object, z: f64) -> Option<Target> {
    Some(Target { object, pose: [0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0], twist: [0.0, 0.0, -z, 0.0, 0.0, 0.0] })
}

/// Reports the height of each target, and the distance along a ray to each.
struct Heights;

fields! {
    Heights {
        HEIGHT: f64 = Field::new("heights.height").per_target();
        SEEN: f64 = Field::new("heights.seen").per_beam();
    }
}

impl Sensor for Heights {
    type Plugin = EmptyPlugin;
    const ID: &'static str = "heights";
    const TEXT: &'static str = "Heights of targets.";
    const SCHEMAS: &'static [&'static str] = &["heights/1"];
    const INPUTS: u32 = TATU_IN_TARGETS | TATU_IN_DISTANCE;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Heights)
    }
    fn beams(&self) -> Result<Beams> {
        self.beams_for(0)
    }
    fn beams_for(&self, n_targets: usize) -> Result<Beams> {
        let form = Form::Rays(vec![[0.0, 0.0, 1.0]; n_targets]);
        Ok(Beams { form, far: 10.0, aimed: true, ..Beams::default() })
    }
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        assert_eq!(sample.targets().len(), rays.len());
        for (ray, target) in rays.iter_mut().zip(sample.targets()) {
            ray[5] = target.map_or(1.0, |t| t.pose[2].signum());
        }
        Ok(())
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        for (height, target) in out.slice(Self::HEIGHT).iter_mut().zip(sample.targets()) {
            *height = target.map_or(-1.0, |t| t.pose[2] - t.twist[2] + t.object as f64);
        }
        for (seen, (distance, ray)) in
            out.slice(Self::SEEN).iter_mut().zip(sample.distances().iter().zip(sample.rays()))
        {
            *seen = distance.min(99.0) * ray[5];
        }
        Ok(())
    }
}

#[test]
fn sensors_receive_targets_and_missing_ones() {
    let inputs = Inputs { targets: vec![target(5, 2.0), None, target(6, -3.0)], ..Inputs::default() };
    let told = measure::<Heights>(&[], inputs.clone()).unwrap();
    assert_eq!(told.f64s("heights.height").unwrap(), [9.0, -1.0, 0.0]);
    assert_eq!(told.f64s("heights.seen").unwrap(), [99.0, 99.0, -99.0]);
    let one = Inputs { targets: vec![target(1, 1.0)], ..Inputs::default() };
    let both = measure_all::<Heights>(&[], vec![Inputs::default(), inputs, one]).unwrap();
    let heights: Vec<Vec<f64>> = both.iter().map(|r| r.f64s("heights.height").unwrap()).collect();
    assert_eq!(heights, [vec![], vec![9.0, -1.0, 0.0], vec![3.0]]);
}

/// Pulls each target with its command, and pushes the mount with the forces of its contacts.
struct Puller<const INPUTS: u32>;

impl<const INPUTS: u32> Actuator for Puller<INPUTS> {
    type Plugin = EmptyPlugin;
    const ID: &'static str = "puller";
    const TEXT: &'static str = "Pulls.";
    const INPUTS: u32 = INPUTS;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn commands() -> Vec<Param> {
        vec![Param::float("pull").default(2.0)]
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Puller)
    }
    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        for (wrench, target) in out.target_wrenches.iter_mut().zip(drive.targets()) {
            wrench[2] = target.map_or(0.0, |t| -t.pose[2].signum() * drive.commands()[0]);
        }
        out.force[2] = drive.contacts().iter().map(|c| c.force).sum();
        out.torque[2] = drive.frictions().iter().map(|f| f[2]).sum();
        Ok(())
    }
}

#[test]
fn actuators_push_targets_and_receive_contacts() {
    const BOTH: u32 = TATU_IN_TARGETS | TATU_IN_CONTACTS;
    let around = || Surroundings {
        targets: vec![target(5, 2.0), None, target(6, -3.0)],
        contacts: vec![tatu_contact { force: 4.0, ..tatu_contact::default() }; 2],
        frictions: vec![[0.0, 0.0, 1.5], [0.0, 0.0, 1.0]],
    };
    let mut puller = ActuatorBench::<Puller<BOTH>>::new(&[]).unwrap();
    let push = puller.act_among(&[("pull", 3.0)], Motion::default(), around()).unwrap();
    let along: Vec<f64> = push.target_wrenches.iter().map(|w| w[2]).collect();
    assert_eq!((along, push.force[2], push.torque[2]), (vec![-3.0, 0.0, 3.0], 8.0, 2.5));
    let alone = puller.act(&[], Motion::default()).unwrap();
    assert!(alone.target_wrenches.is_empty() && alone.force == [0.0; 3]);
    let mut deaf = ActuatorBench::<Puller<TATU_IN_CONTACTS>>::new(&[]).unwrap();
    assert!(deaf.act_among(&[], Motion::default(), around()).is_err());
}
