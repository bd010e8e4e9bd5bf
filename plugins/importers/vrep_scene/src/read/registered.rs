//! Entities of a scene that are not objects: collections, and in old versions, collision objects, distance objects,
//! groups for inverse kinematics, and windows of buttons.

use serde::Serialize;

use super::{
    cursor::{Cursor, ReadResult},
    section::{object, tags},
    unknown::UnknownElements,
};

/// An item that is added to, or removed from, a collection.
#[derive(Debug, Clone, Default, Serialize)]
pub struct CollectionItem {
    /// Handle of the object to which the item refers.
    pub object: i32,
    /// 0 single object, 1 tree, 2 tree without its base, 3 chain, 4 chain without its tip, 5 all objects.
    pub kind: u8,
    /// Whether the item is subtracted from the collection.
    pub remove: bool,
}

/// A collection: a named set of objects.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Collection {
    /// Name of the collection.
    pub name: String,
    /// Handle of the collection, at least 2,000,000.
    pub handle: i32,
    /// Items, in the order in which they are applied.
    pub items: Vec<CollectionItem>,
}

/// Reads the section `GRP`, which contains a collection.
pub fn collection(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Collection> {
    let mut collection = Collection { handle: -1, ..Default::default() };
    let tags = tags!(Collection {
        "Grn" => |k, c, _| Ok(k.name = c.text()?),
        "Gix" => |k, c, _| Ok(k.handle = c.i32()?),
        "Asg" => |k, c, u| {
            let mut item = CollectionItem::default();
            let tags = tags!(CollectionItem {
                "Obj" => |i, c, _| Ok(i.object = c.i32()?),
                "Gty" => |i, c, _| Ok(i.kind = c.u8()?),
                "Var" => |i, c, _| Ok(i.remove = c.u8()? & 1 == 0),
            });
            object(c, tags, &["Cv2"], &mut item, u)?;
            Ok(k.items.push(item))
        },
    });
    object(c, tags, &["Par", "Uis", "Cv2", "Ups"], &mut collection, unknown)?;
    Ok(collection)
}

/// A collision or distance object: a named pair of entities whose collision or distance scripts read.
#[derive(Debug, Clone, Default, Serialize)]
pub struct EntityPair {
    /// Name of the collision or distance object.
    pub name: String,
    /// Handle of the collision or distance object.
    pub handle: i32,
    /// Handles of the two entities; -1: all objects.
    pub of: [i32; 2],
    /// Maximum distance that a distance object computes, m; 0: no limit.
    pub threshold: f64,
    /// Whether the pair is evaluated only on request.
    pub explicit: bool,
}

/// Reads the section `COL`, which contains a collision object.
pub fn collision(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<EntityPair> {
    let mut pair = EntityPair { handle: -1, of: [-1; 2], ..Default::default() };
    let tags = tags!(EntityPair {
        "Nme" => |p, c, _| Ok(p.name = c.text()?),
        "Inx" => |p, c, _| Ok((p.of, p.handle) = ([c.i32()?, c.i32()?], c.i32()?)),
        "Par" => |p, c, _| Ok(p.explicit = c.u8()? & 8 != 0),
    });
    object(c, tags, &["Cwt", "Col", "Uis", "Cv2", "Ups"], &mut pair, unknown)?;
    Ok(pair)
}

/// Reads the section `DST`, which contains a distance object.
pub fn distance(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<EntityPair> {
    let mut read = (EntityPair { handle: -1, of: [-1; 2], ..Default::default() }, 0.0);
    let tags = tags!((EntityPair, f64) {
        "Nme" => |p, c, _| Ok(p.0.name = c.text()?),
        "Inx" => |p, c, _| Ok((p.0.of, p.0.handle) = ([c.i32()?, c.i32()?], c.i32()?)),
        "Trh" | "_rh" => |p, c, _| Ok(p.1 = c.real()?),
        "Var" => |p, c, _| {
            let bits = c.u8()?;
            p.0.explicit = bits & 4 != 0;
            Ok(p.0.threshold = f64::from(bits & 1))
        },
    });
    object(c, tags, &["Swt", "Col", "Uis", "Cv2", "Ups"], &mut read, unknown)?;
    let (mut pair, threshold) = read;
    pair.threshold = if pair.threshold > 0.0 && threshold.is_finite() { threshold.max(0.0) } else { 0.0 };
    Ok(pair)
}

/// An element of an inverse kinematics group: a tip that must reach a target.
#[derive(Debug, Clone, Serialize)]
pub struct IkElement {
    /// Handle of the dummy at the tip.
    pub tip: i32,
    /// Handle of the target, which is the dummy that is linked to the tip; -1: none.
    pub target: i32,
    /// Handle of the base; -1: the world.
    pub base: i32,
    /// Handle of the object whose axes the constraints use; -1: the base.
    pub axes: i32,
    /// Flags of the constrained coordinates. 1: x; 2: y; 4: z; 8: alpha and beta; 16: gamma.
    pub constraints: i32,
    /// Accepted distance, m, and angle, rad.
    pub precision: [f64; 2],
    /// Weights of position and orientation.
    pub weights: [f64; 2],
    /// Whether the element is enabled.
    pub enabled: bool,
}

impl Default for IkElement {
    fn default() -> Self {
        let precision = [0.0005, 0.1_f64.to_radians()];
        IkElement {
            tip: -1,
            target: -1,
            base: -1,
            axes: -1,
            constraints: 31,
            precision,
            weights: [1.0; 2],
            enabled: true,
        }
    }
}

/// An inverse kinematics group.
#[derive(Debug, Clone, Default, Serialize)]
pub struct IkGroup {
    /// Name of the group.
    pub name: String,
    /// Handle of the group.
    pub handle: i32,
    /// Elements of the group, in the order of the file.
    pub elements: Vec<IkElement>,
    /// 0: pseudo-inverse; 1: damped least squares; 2: Jacobian transpose.
    pub method: i32,
    /// Maximum number of iterations.
    pub max_iterations: i32,
    /// Damping of damped least squares.
    pub damping: f64,
    /// Handle of the group on whose result this group depends; -1: none.
    pub after: i32,
    /// Flags. 1: enabled; 2: joints are restored if the position is not reached; 4: if the orientation is not; 8 and
    /// 16: solved depending on the result of another group; 32: the step of each joint is limited; 64: solved only on
    /// request.
    pub flags: u8,
}

/// Reads the section `IKO`, which contains a group for inverse kinematics.
pub fn ik_group(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<IkGroup> {
    let mut group = IkGroup { handle: -1, max_iterations: 3, damping: 0.1, after: -1, flags: 1, ..Default::default() };
    let tags = tags!(IkGroup {
        "Oid" => |g, c, _| Ok(g.handle = c.i32()?),
        "Nme" => |g, c, _| Ok(g.name = c.text()?),
        "Mit" => |g, c, _| Ok(g.max_iterations = c.i32()?),
        "Dpg" | "_pg" => |g, c, _| Ok(g.damping = c.real()?),
        "Cmt" => |g, c, _| Ok(g.method = c.i32()?),
        "Doo" => |g, c, _| Ok(g.after = c.i32()?),
        "Var" => |g, c, _| Ok(g.flags = c.u8()?),
        "Ike" => |g, c, u| Ok(g.elements.push(ik_element(c, u)?)),
    });
    const IGNORED: &[&str] =
        &["Ctr", "Wgt", "_gt", "Uis", "Jts", "_ts", "Avx", "Avt", "_vt", "Va2", "Cv2", "Jlw", "Va3", "Dmp"];
    object(c, tags, IGNORED, &mut group, unknown)?;
    Ok(group)
}

fn ik_element(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<IkElement> {
    let mut element = IkElement::default();
    let tags = tags!(IkElement {
        "Ik2" => |e, c, _| Ok((e.tip, e.base) = (c.i32()?, c.i32()?)),
        "Abc" => |e, c, _| Ok(e.axes = c.i32()?),
        // The file stores the angle before the distance.
        "Pr2" | "_r2" => |e, c, _| Ok(e.precision = { let [angle, distance] = c.reals()?; [distance, angle] }),
        "Wgt" | "_gt" => |e, c, _| Ok(e.weights = c.reals()?),
        "Ctr" => |e, c, _| Ok(e.constraints = c.i32()?),
        "Var" => |e, c, _| Ok(e.enabled = c.u8()? & 1 != 0),
    });
    object(c, tags, &["Oid", "Prc", "Cv2"], &mut element, unknown)?;
    Ok(element)
}

/// A button, label, slider or edit field of a window.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FileButton {
    /// Flags for type and appearance, as defined by V-REP's API.
    pub attributes: i32,
    /// Handle of the button, unique within its window.
    pub handle: i32,
    /// Numbers of columns and rows that the button spans, then its first column and row.
    pub cells: [i32; 4],
    /// Labels: normal, and while pressed.
    pub labels: [String; 2],
    /// Position of a slider, -1 to 1.
    pub slider: f64,
}

/// A window of buttons of old versions.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Window {
    /// Name of the window.
    pub name: String,
    /// Handle of the window.
    pub handle: i32,
    /// Handle of the object to which the window belongs; -1: no object.
    pub object: i32,
    /// Flags for the behaviour, as defined by V-REP's API.
    pub attributes: i32,
    /// Numbers of columns and rows of the grid on which buttons are placed.
    pub cells: [i32; 2],
    /// Buttons of the window.
    pub buttons: Vec<FileButton>,
}

/// Reads the section `BBK`, which contains a window of buttons.
pub fn window(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Window> {
    let mut window = Window { handle: -1, object: -1, ..Default::default() };
    let tags = tags!(Window {
        "Bkh" => |w, c, _| Ok(w.handle = c.i32()?),
        "Bkn" => |w, c, _| Ok(w.name = c.text()?),
        "Att" => |w, c, _| Ok(w.attributes = c.i32()?),
        "Bks" => |w, c, _| Ok(w.cells = [c.i32()?, c.i32()?]),
        "Aoi" => |w, c, _| Ok(w.object = c.i32()?),
        "Btn" => |w, c, u| {
            let button = button(c, u)?;
            Ok(w.buttons.push(button))
        },
    });
    object(c, tags, &["Bkp", "Bns", "Vew", "Rus", "Toj", "Cv2", "Uis"], &mut window, unknown)?;
    Ok(window)
}

fn button(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<FileButton> {
    let mut button = FileButton::default();
    let tags = tags!(FileButton {
        "Bva" | "_va" => |b, c, _| {
            (b.attributes, b.handle) = (c.i32()?, c.i32()?);
            b.cells = [c.i32()?, c.i32()?, c.i32()?, c.i32()?];
            b.labels = [c.text()?, c.text()?];
            Ok(b.slider = c.real()?)
        },
    });
    object(c, tags, &["Bnc", "Toj", "Cv2"], &mut button, unknown)?;
    Ok(button)
}
