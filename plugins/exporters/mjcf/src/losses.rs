//! Reports what MJCF does not hold, or holds differently.

use tatu_exporters_common::{Export, Mechanisms, Tie};

/// Reports friction rules, and properties of joints.
pub fn report(all: &Mechanisms, export: &mut Export<'_>) {
    let frictions = all.bodies.iter().flat_map(|b| &b.parts).filter_map(|p| Some((p.item, p.surface?.friction)));
    let rule = export.reader.text(0, "scene.friction_rule").into_owned();
    if rule != "greatest" {
        for (item, _) in frictions.filter(|(_, friction)| *friction != 1.0) {
            let text =
                format!("the friction of a pair is the greater one in MuJoCo, not by the rule `{rule}` of the scene");
            export.report.lost(text, &all.items[item].path);
        }
    }
    for body in &all.bodies {
        if let Tie::Joint { item, joint, .. } = &body.tie
            && joint.has_motor()
        {
            let text = "MJCF has no greatest speed of position control (`max_velocity`)";
            export.report.note(text, &all.items[*item].path);
        }
    }
}
