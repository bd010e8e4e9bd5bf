//! Names of all elements of the file.

use std::collections::BTreeMap;

use tatu_exporters_common::{ExportReport, Mechanisms, NameSpace, Tie};
use tatu_plugin_api::abi::{TATU_KIND_DUMMY, TATU_KIND_FORCE_SENSOR, TATU_KIND_SENSOR};

/// Returns whether everything is below one dummy, which stands for the model as in imported files.
pub fn has_base(all: &Mechanisms) -> bool {
    let is_one_tree = all.items.iter().filter(|item| item.parent.is_none()).count() == 1;
    is_one_tree && all.items.first().is_some_and(|item| item.kind == TATU_KIND_DUMMY && !item.children.is_empty())
}

/// The names of elements, by what they stand for. Names of different kinds of elements may be equal.
pub struct Names {
    /// Names of bodies, by index; the world has none.
    pub bodies: Vec<String>,
    /// Names of joints, by the index of the joint's object.
    pub joints: BTreeMap<usize, String>,
    /// Names of sites, by the index of the dummy's or sensor's object.
    pub sites: BTreeMap<usize, String>,
    /// Names of geoms that have been used.
    pub geoms: NameSpace,
    /// Names of cameras and lights that have been used.
    pub views: NameSpace,
    /// Names of sensors that have been used.
    pub sensors: NameSpace,
}

impl Names {
    /// Names bodies, joints and sites; reports names that had to be changed.
    pub fn new(all: &Mechanisms, report: &mut ExportReport) -> Self {
        let (mut of_bodies, mut of_joints, mut of_sites) =
            (NameSpace::default(), NameSpace::default(), NameSpace::default());
        let mut bodies = vec![String::new()];
        let (mut joints, mut sites) = (BTreeMap::new(), BTreeMap::new());
        for (b, body) in all.bodies.iter().enumerate() {
            if b > 0 {
                bodies.push(of_bodies.name(all.name_of(b)));
            }
            if let Tie::Joint { item, .. } = body.tie {
                joints.insert(item, of_joints.name(&all.items[item].alias));
            }
            let has_site = |item: &usize| matches!(all.items[*item].kind, TATU_KIND_SENSOR | TATU_KIND_FORCE_SENSOR);
            let others = body.attached.iter().map(|a| a.item).filter(has_site);
            for item in body.frames.iter().map(|f| f.item).chain(others) {
                sites.insert(item, of_sites.name(&all.items[item].alias));
            }
        }
        for (kind, names) in [("bodies", &of_bodies), ("joints", &of_joints), ("sites", &of_sites)] {
            for change in names.changes() {
                report.note(format!("names of {kind} must differ"), &change);
            }
        }
        Names {
            bodies,
            joints,
            sites,
            geoms: NameSpace::default(),
            views: NameSpace::default(),
            sensors: NameSpace::default(),
        }
    }
}
