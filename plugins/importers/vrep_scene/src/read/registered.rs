//! What stands beside the objects of a scene: collections, and the objects of old versions for collisions, distances,
//! inverse kinematics and windows of buttons.

use super::{
    cursor::{Cursor, Read},
    section::{object, tags},
    unknown::Unknowns,
};

/// An item of a collection.
#[derive(Debug, Clone, Default)]
pub struct Item {
    /// Handle of the object.
    pub object: i32,
    /// 0 loose, 1 tree, 2 tree without its base, 3 chain, 4 chain without its tip, 5 all objects.
    pub kind: u8,
    /// Whether it is taken away.
    pub remove: bool,
}

/// A collection.
#[derive(Debug, Clone, Default)]
pub struct Collection {
    /// Its name.
    pub name: String,
    /// Its handle, from 2,000,000.
    pub handle: i32,
    /// Items, in order.
    pub items: Vec<Item>,
}

/// `GRP`
pub fn collection(c: &mut Cursor<'_>, unknown: &mut Unknowns) -> Read<Collection> {
    let mut collection = Collection { handle: -1, ..Default::default() };
    let tags = tags!(Collection {
        "Grn" => |k, c, _| Ok(k.name = c.text()?),
        "Gix" => |k, c, _| Ok(k.handle = c.i32()?),
        "Asg" => |k, c, u| {
            let mut item = Item::default();
            let tags = tags!(Item {
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

/// A collision or distance object.
#[derive(Debug, Clone, Default)]
pub struct Pair {
    /// Its name.
    pub name: String,
    /// Its handle.
    pub handle: i32,
    /// Handles of what is looked at; -1: everything.
    pub of: [i32; 2],
}

/// `COL`, `DST`
pub fn pair(c: &mut Cursor<'_>, unknown: &mut Unknowns) -> Read<Pair> {
    let mut pair = Pair { handle: -1, of: [-1; 2], ..Default::default() };
    let tags = tags!(Pair {
        "Nme" => |p, c, _| Ok(p.name = c.text()?),
        "Inx" => |p, c, _| Ok((p.of, p.handle) = ([c.i32()?, c.i32()?], c.i32()?)),
    });
    const IGNORED: &[&str] = &["Par", "Cwt", "Col", "Uis", "Trh", "_rh", "Var", "Swt", "Cv2", "Ups"];
    object(c, tags, IGNORED, &mut pair, unknown)?;
    Ok(pair)
}

/// An element of a group for inverse kinematics.
#[derive(Debug, Clone, Default)]
pub struct IkElement {
    /// Handle of the dummy at the tip.
    pub tip: i32,
    /// Handle of the base; -1: the world.
    pub base: i32,
    /// Bits: 1 x, 2 y, 4 z, 8 alpha and beta, 16 gamma.
    pub constraints: i32,
}

/// A group for inverse kinematics.
#[derive(Debug, Clone, Default)]
pub struct IkGroup {
    /// Its name.
    pub name: String,
    /// Its handle.
    pub handle: i32,
    /// Elements, in order.
    pub elements: Vec<IkElement>,
}

/// `IKO`
pub fn ik_group(c: &mut Cursor<'_>, unknown: &mut Unknowns) -> Read<IkGroup> {
    let mut group = IkGroup { handle: -1, ..Default::default() };
    let tags = tags!(IkGroup {
        "Oid" => |g, c, _| Ok(g.handle = c.i32()?),
        "Nme" => |g, c, _| Ok(g.name = c.text()?),
        "Ike" => |g, c, u| {
            let mut element = IkElement { tip: -1, base: -1, ..Default::default() };
            let tags = tags!(IkElement {
                "Ik2" => |e, c, _| Ok((e.tip, e.base) = (c.i32()?, c.i32()?)),
                "Ctr" => |e, c, _| Ok(e.constraints = c.i32()?),
            });
            object(c, tags, &["Oid", "Abc", "Pr2", "_r2", "Prc", "Wgt", "_gt", "Var", "Cv2"], &mut element, u)?;
            Ok(g.elements.push(element))
        },
    });
    const IGNORED: &[&str] = &[
        "Mit", "Dpg", "_pg", "Cmt", "Doo", "Var", "Ctr", "Wgt", "_gt", "Uis", "Jts", "_ts", "Avx", "Avt", "_vt", "Va2",
        "Cv2", "Jlw", "Va3", "Dmp",
    ];
    object(c, tags, IGNORED, &mut group, unknown)?;
    Ok(group)
}

/// A window of buttons of old versions.
#[derive(Debug, Clone, Default)]
pub struct Window {
    /// Its name.
    pub name: String,
    /// Its handle.
    pub handle: i32,
    /// Handle of the object that it belongs to; -1: none.
    pub object: i32,
    /// How many buttons it has.
    pub buttons: usize,
}

/// `BBK`
pub fn window(c: &mut Cursor<'_>, unknown: &mut Unknowns) -> Read<Window> {
    let mut window = Window { handle: -1, object: -1, ..Default::default() };
    let tags = tags!(Window {
        "Bkh" => |w, c, _| Ok(w.handle = c.i32()?),
        "Bkn" => |w, c, _| Ok(w.name = c.text()?),
        "Aoi" => |w, c, _| Ok(w.object = c.i32()?),
        "Btn" => |w, _, _| Ok(w.buttons += 1),
    });
    object(c, tags, &["Att", "Bks", "Bkp", "Bns", "Vew", "Rus", "Toj", "Cv2", "Uis"], &mut window, unknown)?;
    Ok(window)
}
