//! The common part of all objects of a scene: elements up to `NXT`.

use super::{
    data::{self, CustomData, ScriptParameter},
    pose::{IDENTITY, StoredPose, quaternion_first},
    section::{ElementTag, tags},
};

/// Tag and payload of the first element of every object.
pub const SIGNATURE: (&str, &[u8]) = ("3do", &[0x39, 0x3A, 0x3B]);

/// The elements that are common to all kinds of objects.
#[derive(Debug, Clone)]
pub struct CommonPart {
    /// Pose in the frame of the parent, without the motion of a joint.
    pub pose: StoredPose,
    /// Handle, by which other objects in the file refer to this object.
    pub id: i32,
    /// Handle of the parent; -1 for a root object.
    pub parent: i32,
    /// Name that need not be unique; since 4.3.
    pub alias: Option<String>,
    /// Unique name, with its suffix.
    pub name: Option<String>,
    /// Properties stored as bits.
    pub flags: PropertyFlags,
    /// Whether the object is the base of a model.
    pub model_base: bool,
    /// Layers, one bit per layer.
    pub layer: u16,
    /// Order in which the object's scripts are called; since 4.4.
    pub script_priority: i32,
    /// Index among the object's siblings; since 4.3.
    pub order: Option<i32>,
    /// Size factor, which scripts can read.
    pub size_factor: f64,
    /// Custom data by tag, in the formats of all versions.
    pub data: CustomData,
    /// Parameters of the object's scripts; since 4.0.
    pub parameters: Vec<ScriptParameter>,
    /// Handles of other objects stored with the object, by tag.
    pub references: Vec<(String, Vec<i32>)>,
    /// Extension string, with options for renderers.
    pub extension: String,
    /// Acknowledgement of the model's author.
    pub acknowledgement: String,
}

/// The properties of an object that are stored as bits.
#[derive(Debug, Clone)]
pub struct PropertyFlags {
    /// Bits that affect the user interface and, in files from before 2011, hide the object.
    pub object_property: i32,
    /// Whether the file contained `object_property`.
    pub has_object_property: bool,
    /// Bits that determine how sensors and commands treat the object.
    pub special_property: Option<i32>,
    /// Bits of the properties that a model base overrides for its model.
    pub model_property: i32,
}

impl Default for CommonPart {
    fn default() -> Self {
        CommonPart {
            pose: IDENTITY,
            id: -1,
            parent: -1,
            alias: None,
            name: None,
            flags: PropertyFlags {
                object_property: 0,
                has_object_property: false,
                special_property: None,
                model_property: 0,
            },
            model_base: false,
            layer: 1,
            script_priority: 0,
            order: None,
            size_factor: 1.0,
            data: CustomData::default(),
            parameters: Vec::new(),
            references: Vec::new(),
            extension: String::new(),
            acknowledgement: String::new(),
        }
    }
}

/// Tags of the elements in the common part.
pub const TAGS: &[ElementTag<CommonPart>] = tags!(CommonPart {
    "Cfq" | "_fq" => |o, c, _| Ok(o.pose = quaternion_first(c)?),
    "Ids" => |o, c, _| Ok((o.id, o.parent) = (c.i32()?, c.i32()?)),
    "Ali" => |o, c, _| Ok(o.alias = Some(c.text()?)),
    "Nme" => |o, c, _| Ok(o.name = Some(c.text()?)),
    "Op2" => |o, c, _| Ok((o.flags.object_property, o.flags.has_object_property) = (c.i32()?, true)),
    "Var" => |o, c, _| Ok(o.model_base = c.u8()? & 1 != 0),
    "Va2" => |o, c, _| Ok(o.model_base = c.u8()? & 1 != 0),
    "Va3" => |o, c, _| Ok(o.model_base = c.u8()? & 1 != 0),
    "Omp" => |o, c, _| Ok(o.flags.special_property = Some(c.i32()?)),
    "Mpo" => |o, c, _| Ok(o.flags.model_property = c.i32()?),
    "Lar" => |o, c, _| Ok(o.layer = c.u16()?),
    "Sep" => |o, c, _| Ok(o.script_priority = c.i32()?),
    "Cor" => |o, c, _| Ok(o.order = Some(c.i32()?)),
    "Sfa" | "_fa" => |o, c, _| Ok(o.size_factor = c.real()?),
    "Cda" => |o, c, u| data::tagged(&mut o.data, c, u),
    "Cod" => |o, c, u| data::numbered(&mut o.data, c, u),
    "Lsp" => |o, c, u| data::parameters(&mut o.parameters, c, u),
    "Crh" => |o, c, _| {
        let n = c.count()?;
        let mut handles = Vec::new();
        for _ in 0..n {
            let (_kind, handle, _zero) = (c.i32()?, c.i32()?, c.i32()?);
            handles.push(handle);
        }
        if n > 0 {
            o.references.push((String::new(), handles));
        }
        Ok(())
    },
    "Cr2" => |o, c, _| {
        let tag = c.text()?;
        let n = c.count()?;
        let mut handles = Vec::new();
        for _ in 0..n {
            handles.push(c.i32()?);
        }
        o.references.push((tag, handles));
        Ok(())
    },
    "Rst" => |o, c, _| Ok(o.extension = c.text()?),
    "Ack" => |o, c, _| Ok(o.acknowledgement = c.text()?),
});

/// Known elements that are not used: user interface, editors, and data needed only to write the file again.
pub const IGNORED: &[&str] = &[
    "3do", "Ots", "Oot", "Oma", "Omi", "Alt", "_lt", "Am2", "Amv", "Anm", "Hci", "Sci", "Va4", "Om5", "_m5", "Omr",
    "_mr", "Sfb", "_fb", "Orh", "Or2", "Ups", "Uis", "Tdo", "_do", "Avo", "Cv2",
];

impl CommonPart {
    /// Returns the alias: the stored one, or the name up to its suffix.
    pub fn alias(&self) -> String {
        let name = || self.name.as_deref().unwrap_or_default().split('#').next().unwrap_or_default().to_owned();
        self.alias.clone().unwrap_or_else(name)
    }

    /// Returns the layers, converted to the 16 bits that program versions since 2011 store.
    pub fn layers(&self) -> u16 {
        // Program versions from before 2011 store 8 layers, and hide an object by clearing a bit of its object
        // property.
        let hidden = self.flags.has_object_property && self.flags.object_property & 4 == 0;
        if hidden && self.layer < 256 { self.layer << 8 } else { self.layer }
    }
}
