//! Builds a scene from a file: objects with their poses, shapes with their meshes and masses, joints with their motors.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Vector3};
use tatu_plugin_api::{
    abi::{TATU_REPORT_LACK, TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::{Builder, Fail, Node, Result, Value},
};

use crate::{
    describe::map,
    dynamics::{self, ObjectTree},
    forms, graphs,
    read::{
        file::{FileObject, ObjectKind, VrepFile},
        mesh::MeshLeaf,
        pose::isometry,
        shape::Shape,
        surface::leaves,
    },
    registrations,
    report::ImportReport,
    revolution::detect_revolution,
    scripts, sensors,
    textures::ImportedImages,
    views,
};

/// Builds the whole scene; returns the report on objects that were changed or omitted.
pub fn scene(builder: &Builder<'_>, file: &VrepFile) -> Result<Vec<Value>> {
    let mut report = ImportReport::default();
    settings(builder, file)?;
    let mut nodes: BTreeMap<i32, Node<'_>> = BTreeMap::new();
    let order = in_order(file);
    let tree = ObjectTree::new(file, &order);
    let meant = registrations::referenced_objects(file);
    let mut images = ImportedImages::default();
    for i in order {
        let o = &file.objects[i];
        if scripts::is_holder(o) {
            continue;
        }
        let node =
            object(builder, (file, &tree, &meant), &mut images, o, nodes.get(&o.common.parent).copied(), &mut report)?;
        nodes.insert(o.common.id, node);
    }
    scripts::attach_scripts(builder, file, &nodes, &mut report)?;
    for (path, unknown) in &file.unknown.all {
        let first = unknown.spans.first().map_or(0, |span| span.at);
        report.add_count(
            "not understood",
            format!("section {path}, first at byte {first}; its data is stored with the scene unchanged"),
            unknown.count,
        );
    }
    log_report(builder, &report);
    let each = |(&(what, ref why), of): (&(&'static str, String), &Vec<(i32, String)>)| {
        let line = |(id, alias): &(i32, String)| {
            Value::Map(map! { "what": what, "why": why.as_str(), "object": *id, "alias": alias.as_str() })
        };
        of.iter().map(line).collect::<Vec<_>>()
    };
    Ok(report.0.iter().flat_map(each).collect())
}

/// Logs the report, with one line per reason that lists the affected objects.
fn log_report(builder: &Builder<'_>, report: &ImportReport) {
    for ((what, why), of) in &report.0 {
        let names: Vec<&str> = of.iter().take(8).map(|(_, alias)| alias.as_str()).collect();
        let more = if of.len() > 8 { format!(" and {} more", of.len() - 8) } else { String::new() };
        let severity = match *what {
            "without a script" => TATU_REPORT_LACK,
            "refused" | "without" => TATU_REPORT_WARNING,
            _ => TATU_REPORT_NOTE,
        };
        let objects = format!("{}{more}", names.join(", "));
        let text = match *what {
            "without" => format!("not supported: {objects}: {why}"),
            "refused" => format!("not imported: {objects}: {why}"),
            "kept" | "replaced" => format!("{objects}: {why}"),
            _ => format!("{what}: {objects}: {why}"),
        };
        builder.report(severity, None, &text);
    }
}

fn settings(builder: &Builder<'_>, file: &VrepFile) -> Result {
    let s = &file.settings;
    if let Some(dt) = s.step().filter(|dt| *dt >= 1e-6) {
        builder.setting("scene.dt", dt)?;
    }
    if s.is_present {
        builder.setting("scene.physics_dt", s.physics_step().max(1e-6))?;
    }
    match s.gravity.filter(|g| g.iter().all(|x| x.is_finite())) {
        Some(gravity) => builder.setting("scene.gravity", gravity),
        None => Ok(()),
    }
}

/// Returns the objects ordered so that parents precede children, and siblings are in the order of the file.
fn in_order(file: &VrepFile) -> Vec<usize> {
    let known: BTreeMap<i32, usize> = file.objects.iter().enumerate().map(|(i, o)| (o.common.id, i)).collect();
    let mut below: BTreeMap<Option<usize>, Vec<usize>> = BTreeMap::new();
    for (i, o) in file.objects.iter().enumerate() {
        below.entry(known.get(&o.common.parent).copied()).or_default().push(i);
    }
    for children in below.values_mut() {
        children.sort_by_key(|i| (file.objects[*i].common.order.unwrap_or(0), *i));
    }
    let mut out = Vec::with_capacity(file.objects.len());
    let mut open: Vec<usize> = below.get(&None).into_iter().flatten().rev().copied().collect();
    while let Some(i) = open.pop() {
        out.push(i);
        open.extend(below.get(&Some(i)).into_iter().flatten().rev());
    }
    out
}

fn object<'a>(
    builder: &Builder<'a>,
    (file, tree, meant): (&VrepFile, &ObjectTree<'_>, &BTreeSet<i32>),
    images: &mut ImportedImages,
    o: &FileObject,
    parent: Option<Node<'a>>,
    report: &mut ImportReport,
) -> Result<Node<'a>> {
    let c = &o.common;
    let kind = match &o.kind {
        ObjectKind::Shape(_) => "shape",
        ObjectKind::Joint(_) => "joint",
        ObjectKind::Force(_) => "force_sensor",
        ObjectKind::Proximity(_) | ObjectKind::Vision(_) => "sensor",
        ObjectKind::Graph(_) => "graph",
        ObjectKind::Camera(_) => "camera",
        ObjectKind::Light(_) => "light",
        ObjectKind::Path(_) => "path",
        _ => "dummy",
    };
    let alias = c.alias().replace('/', "_");
    let node = builder.object(kind, parent, &alias)?;
    let pose = isometry(&c.pose);
    let q = pose.rotation.coords;
    node.set("object.position", <[f64; 3]>::from(pose.translation.vector))?
        .set("object.quaternion", [q.x, q.y, q.z, q.w])?
        .set("object.model_base", c.model_base)?
        .set("object.layer", i64::from(c.layers()))?;
    let alias = if alias.is_empty() { kind } else { alias.as_str() };
    let own_suffix = |n: &&String| n.strip_prefix(alias).is_some_and(|r| r.is_empty() || is_number(r));
    if let Some(name) = c.name.as_ref().filter(own_suffix) {
        node.set("object.name", lower_suffix(name, tree.lowest_suffix).as_str())?;
    }
    let mut color_names = Vec::new();
    match &o.kind {
        ObjectKind::Shape(s) => color_names = shape(builder, (file, tree), images, o, s, node, report)?,
        ObjectKind::Joint(j) => dynamics::joint(file, tree, j, o, node, report)?,
        ObjectKind::Proximity(s) => sensors::proximity((file, tree), s, o, node, report)?,
        ObjectKind::Vision(s) => sensors::vision((file, tree), s, o, node, report)?,
        ObjectKind::Force(f) => sensors::force(f, o, node, report)?,
        ObjectKind::Graph(g) => graphs::graph(g, o, node, report)?,
        ObjectKind::Camera(k) => views::camera(k, node)?,
        ObjectKind::Light(l) => views::light(l, node)?,
        ObjectKind::Path(p) => views::path(p, node)?,
        ObjectKind::Dummy(d) => dynamics::link(tree, d, o, node, report)?,
        _ => report.add("without", format!("an object of the kind {} is replaced by a dummy", o.kind_name()), o),
    }
    node.set("object.data", scripts::data((file, tree), o, meant.contains(&c.id), &color_names))?;
    Ok(node)
}

/// Returns a name with its suffix reduced by the lowest suffix of the file. This is used for models, whose suffixes
/// only count the copies in the scene from which the model was saved.
fn lower_suffix(name: &str, lowest: i32) -> String {
    let Some((base, n)) = name.rsplit_once('#').and_then(|(base, n)| Some((base, n.parse::<i32>().ok()?))) else {
        return name.to_owned();
    };
    match n - lowest - 1 {
        _ if lowest < 0 => name.to_owned(),
        ..0 => base.to_owned(),
        n => format!("{base}#{n}"),
    }
}

/// Returns whether a suffix is `#` and a number, as in "#3".
fn is_number(suffix: &str) -> bool {
    suffix.strip_prefix('#').is_some_and(|n| n.len() < 9 && !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// Bit of `MeshLeaf::bits` that is set if only the edges of the leaf's triangles are drawn.
const WIRE_FRAME: u8 = 4;

/// Sets the properties of a shape. Returns the names of the colours of its parts.
fn shape<'a>(
    builder: &Builder<'a>,
    (file, tree): (&VrepFile, &ObjectTree<'_>),
    images: &mut ImportedImages,
    o: &FileObject,
    s: &Shape,
    node: Node<'a>,
    report: &mut ImportReport,
) -> Result<Vec<String>> {
    let overrides = tree.overrides(o);
    let Some(root) = &s.root else {
        report.add("refused", "the shape has no mesh", o);
        return node.set("shape.detectable", false).map(|_| Vec::new());
    };
    let dynamic = s.dynamic && !overrides.not_dynamic();
    let mut parts = Vec::new();
    let leaves = leaves(root);
    // A part that is drawn as lines usually coincides with another surface. If its triangles were drawn, both surfaces
    // would flicker.
    let is_lines = |leaf: &MeshLeaf| leaf.bits & WIRE_FRAME != 0 && !s.respondable && leaves.len() > 1;
    if leaves.iter().any(|l| is_lines(l.leaf)) {
        report.add("without", "a part of the shape is drawn as lines in the original, and is invisible here", o);
    }
    // The colour and opacity of a part are set only if they differ from those of the shape, because otherwise they
    // would override later changes of the shape's.
    let opacity = |leaf: &MeshLeaf| leaf.color.opacity.unwrap_or(1.0);
    let visible = || leaves.iter().filter(|l| !is_lines(l.leaf));
    let common = visible().next().map_or(1.0, |l| opacity(l.leaf));
    let mixed = visible().any(|l| opacity(l.leaf) != common);
    if !mixed && common < 1.0 {
        node.set("shape.opacity", common)?;
    }
    let color = visible().next().map(|l| l.leaf.color.diffuse);
    let colorful = visible().any(|l| Some(l.leaf.color.diffuse) != color);
    if let Some(color) = color.filter(|_| !colorful) {
        node.set("shape.color", color)?;
    }
    let mut names: Vec<String> = Vec::new();
    for leaf in visible() {
        let surface = file.surface(leaf.leaf, s.shared.as_ref(), o.section.at);
        let surface = surface.map_err(|e| Fail::argument(e.to_string()))?;
        if surface.triangles.is_empty() {
            continue;
        }
        let color = Value::from(leaf.leaf.color.diffuse);
        let texture = match &leaf.leaf.texture {
            Some(property) => images.texture((builder, file), property, o, report)?,
            None => None,
        };
        let drawn = |mut part: Vec<(Value, Value)>| {
            part.extend(colorful.then(|| (Value::text("color"), color.clone())));
            part.extend(mixed.then(|| (Value::text("opacity"), Value::Float(opacity(leaf.leaf)))));
            part.extend(texture.clone().map(|t| (Value::text("texture"), t)));
            part
        };
        let convex = leaf.leaf.convex || leaf.part.convex;
        let round = || if convex { forms::detect_round(&surface) } else { None };
        let form_part = |(form, size, place): forms::PlacedPrimitive| {
            let place = leaf.frame * place;
            let q = place.rotation.coords;
            let (at, turn) = (<[f64; 3]>::from(place.translation.vector), [q.x, q.y, q.z, q.w]);
            drawn(map! { "primitive": form, "size": size, "position": at, "quaternion": turn })
        };
        if let Some(form) = forms::declared_primitive(leaf.leaf, &surface).or_else(round) {
            parts.push(form_part(form));
            names.resize(parts.len(), leaf.leaf.color.name.clone());
            continue;
        }
        let rolls = convex && dynamic && s.respondable;
        let surface = match rolls.then(|| detect_revolution(&surface)).flatten() {
            Some((forms, behind)) => {
                parts.extend(forms.into_iter().map(form_part));
                behind
            }
            None => surface,
        };
        let surface = surface.moved(&leaf.frame);
        let number = builder.mesh(&surface.points, &surface.triangles)?;
        parts.push(drawn(map! { "primitive": "mesh", "mesh": number, "convex": convex }));
        names.resize(parts.len(), leaf.leaf.color.name.clone());
    }
    if parts.is_empty() {
        report.add("refused", "the mesh of the shape has no triangles", o);
    } else {
        let parts = parts.into_iter().map(Value::Map).collect();
        node.set("shape.primitive", "compound")?.set("shape.parts", Value::List(parts))?;
    }
    let waves = o.common.flags.special_property.unwrap_or(0x1F0) & 0x1F0;
    node.set("shape.respondable", s.respondable && !overrides.not_respondable())?
        .set("shape.respondable_mask", i64::from(s.mask))?
        .set("shape.dynamic", dynamic)?
        .set("shape.detectable", waves != 0 && !overrides.not_detectable())?;
    if dynamic && s.asleep {
        node.set("shape.asleep", true)?;
    }
    if waves != 0 && waves != 0x1F0 {
        node.set("shape.detectable_mask", i64::from(waves))?;
    }
    // A shape that consists only of lines would coincide with another surface if it were drawn as a surface.
    let lines_only = !s.respondable && leaves.iter().all(|l| l.leaf.bits & WIRE_FRAME != 0);
    if lines_only {
        report.add("without", "the shape is drawn as lines in the original, and is invisible here", o);
    }
    if overrides.not_visible() || lines_only {
        node.set("object.visible", false)?;
    }
    dynamics::material(file, s, dynamic, node)?;
    if tree.has_loop(o) {
        // Closed loops in which parts of a few grams and of kilograms meet are too stiff for reduced-coordinate joints.
        node.set("shape.joint_solver", "impulse")?;
    }
    let mass = if root.mass > 0.0 && root.mass.is_finite() { root.mass } else { 0.001 };
    let (com, inertia) = inertia(root);
    node.set("shape.mass", mass)?;
    if com.iter().all(|x| x.is_finite()) {
        node.set("shape.com", <[f64; 3]>::from(com))?;
    }
    let own = (inertia + inertia.transpose()) * (0.5 * mass);
    if own.iter().all(|x| x.is_finite()) && own.symmetric_eigenvalues().min() > 0.0 {
        node.set("shape.inertia", Value::Floats(own.as_slice().to_vec()))?;
    } else if dynamic {
        report.add(
            "replaced",
            "the inertia is physically impossible; the inertia of the geometry with uniform density is used instead",
            o,
        );
    }
    let [a, b, c, d, e, f] = s.velocity;
    if s.velocity.iter().all(|x| x.is_finite()) && s.velocity.iter().any(|x| *x != 0.0) {
        node.set("shape.initial_velocity", [a, b, c])?.set("shape.initial_angular_velocity", [d, e, f])?;
    }
    Ok(names)
}

/// Returns the centre of mass, m, and the inertia tensor divided by the mass, m^2, along the axes of the shape.
fn inertia(root: &crate::read::mesh::MeshPart) -> (Vector3<f64>, Matrix3<f64>) {
    if let (Some(com), Some(i)) = (root.com, root.inertia) {
        return (Vector3::from(com), Matrix3::from_row_slice(&i));
    }
    let axes = isometry(&root.axes);
    let turn = axes.rotation.to_rotation_matrix();
    let along = Matrix3::from_diagonal(&Vector3::from(root.moments));
    (axes.translation.vector, turn.matrix() * along * turn.matrix().transpose())
}
