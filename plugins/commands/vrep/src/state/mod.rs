//! State of the plugin in each world, as plain data. Larger parts of the state have their own files.

pub(crate) mod collections;
pub(crate) mod consoles;
pub(crate) mod dialogs;
mod messages;
pub(crate) mod motions;
pub(crate) mod profiles;
pub(crate) mod registered;
mod tubes;
pub(crate) mod window_views;
pub(crate) mod windows;
pub(crate) mod wireless;

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
};

use serde::{Deserialize, Serialize};

use crate::{
    kit::*,
    vision::{results::VisionResults, work::WorkingImage},
};

use self::{
    collections::Collections, consoles::Consoles, dialogs::Dialogs, messages::MessageQueue, motions::ActiveMotion,
    profiles::Profiles, registered::Registrations, tubes::Tubes, wireless::PendingWireless,
};

/// The plugin's state in a world. Commands can call each other, so a borrow must not be held across a call to the host.
pub struct WorldState(RefCell<WorldStateInner>);

/// The data of [`WorldState`], which snapshots contain.
#[derive(Serialize, Deserialize)]
pub(crate) struct WorldStateInner {
    #[serde(skip)]
    host: Option<Host>,
    step: i64,
    /// Whether the registrations of the scene have been read.
    read: bool,
    pub(crate) registered: Registrations,
    pub(crate) channels: ScriptChannels,
    pub(crate) script_values: ScriptValues,
    /// Names of the signals for which threads wait, by resume word.
    pub(crate) waits: BTreeMap<u64, Vec<u8>>,
    /// Number of random numbers returned so far.
    pub(crate) drawn: u64,
    pub(crate) error_report_mode: i64,
    pub(crate) sets: ObjectSets,
    pub(crate) wireless: PendingWireless,
    pub(crate) dialogs: Dialogs,
    pub(crate) profiles: Profiles,
    pub(crate) last_error: Vec<u8>,
    pub(crate) vision: VisionRecord,
    pub(crate) motion: MotionRecord,
}

/// State of the communication between scripts.
#[derive(Serialize, Deserialize)]
pub(crate) struct ScriptChannels {
    pub(crate) consoles: Consoles,
    pub(crate) tubes: Tubes,
    pub(crate) messages: MessageQueue,
}

/// Settings of scripts, which scripts have made for themselves or for others.
#[derive(Serialize, Deserialize)]
pub(crate) struct ScriptValues {
    /// Suffixes that scripts have set with `setNameSuffix`.
    pub(crate) suffixes: BTreeMap<tatu_object, i64>,
    /// Simulation parameters of scripts, by script and name.
    pub(crate) parameters: BTreeMap<(tatu_object, Vec<u8>), Vec<u8>>,
}

/// The selection and the collections.
#[derive(Serialize, Deserialize)]
pub(crate) struct ObjectSets {
    pub(crate) selection: Vec<tatu_object>,
    pub(crate) collections: Collections,
}

/// Results and working images of vision sensors.
#[derive(Serialize, Deserialize)]
pub(crate) struct VisionRecord {
    /// Results of filters and callbacks, by vision sensor.
    pub(crate) seen: VisionResults,
    /// Working images, by vision sensor.
    pub(crate) work: BTreeMap<tatu_object, WorkingImage>,
}

/// Motions in progress, and paths that objects follow.
#[derive(Serialize, Deserialize)]
pub(crate) struct MotionRecord {
    /// The motions in progress, by their number.
    pub(crate) motions: BTreeMap<i64, ActiveMotion>,
    /// Number of motions started so far, including those along paths.
    pub(crate) moved: i64,
    /// Objects that follow a path: object, path, components to apply (1: position, 2: orientation), fraction of the
    /// path, velocity (m/s).
    pub(crate) follows: BTreeMap<i64, (tatu_object, tatu_object, i64, f64, f64)>,
}

impl WorldState {
    pub(crate) fn new(host: Host) -> Self {
        WorldState(RefCell::new(WorldStateInner::new(Some(host))))
    }

    /// Serializes the state for a snapshot.
    pub(crate) fn save(&self) -> Result<Vec<u8>> {
        let inner = self.0.try_borrow().map_err(|_| busy())?;
        postcard::to_stdvec(&*inner).map_err(|e| Fail::new(format!("the state could not be saved: {e}")))
    }

    /// Restores the state from a snapshot.
    pub(crate) fn load(&self, bytes: &[u8]) -> Result<()> {
        let mut new: WorldStateInner =
            postcard::from_bytes(bytes).map_err(|e| Fail::new(format!("the saved state is damaged: {e}")))?;
        let mut inner = self.0.try_borrow_mut().map_err(|_| busy())?;
        new.host = inner.host;
        *inner = new;
        Ok(())
    }
}

impl WorldStateInner {
    fn new(host: Option<Host>) -> Self {
        WorldStateInner {
            host,
            step: 0,
            read: false,
            registered: Registrations::default(),
            channels: ScriptChannels {
                consoles: Consoles::default(),
                tubes: Tubes::default(),
                messages: MessageQueue::default(),
            },
            script_values: ScriptValues { suffixes: BTreeMap::new(), parameters: BTreeMap::new() },
            waits: BTreeMap::new(),
            drawn: 0,
            error_report_mode: 1,
            sets: ObjectSets { selection: Vec::new(), collections: Collections::default() },
            wireless: PendingWireless::default(),
            dialogs: Dialogs::default(),
            profiles: Profiles::default(),
            last_error: Vec::new(),
            vision: VisionRecord { seen: VisionResults::new(), work: BTreeMap::new() },
            motion: MotionRecord { motions: BTreeMap::new(), moved: 0, follows: BTreeMap::new() },
        }
    }
}

/// Closes the consoles of scripts at the end of a simulation; incomplete lines are logged.
impl Drop for WorldStateInner {
    fn drop(&mut self) {
        let Some(host) = self.host else { return };
        self.channels.consoles.close_all(&mut |line| {
            host.log(TATU_LOG_INFO, &String::from_utf8_lossy(line));
        });
    }
}

fn busy() -> Fail {
    Fail::with_code(TATU_ERR_BUSY, "another command is using the state of the V-REP commands")
}

/// Borrows the state of the caller's world. The host does not report the start of a simulation, so the state is reset
/// when the step number is lower than in the last call.
pub(crate) fn state<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, WorldStateInner>> {
    let step = int_of(c, 0, c.plugin().p.step)?;
    let mut inner = c.instance().0.try_borrow_mut().map_err(|_| busy())?;
    if step < inner.step {
        *inner = WorldStateInner::new(inner.host);
    }
    inner.step = step;
    if inner.read {
        return Ok(inner);
    }
    inner.read = true;
    drop(inner);
    let (registered, collections) = registered::read(c)?;
    for window in &registered.windows {
        window_views::publish_window(c, window, registered.object(window.object))?;
    }
    let mut inner = c.instance().0.try_borrow_mut().map_err(|_| busy())?;
    inner.registered = registered;
    collections.into_iter().for_each(|k| inner.sets.collections.insert(k));
    Ok(inner)
}
