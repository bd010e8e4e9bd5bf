//! A whole file: its sections, in any order.

use super::{
    common::{self, CommonPart},
    cursor::{ByteSpan, Cursor, ReadError, ReadResult},
    data::{self, CustomData},
    header::FileHeader,
    huffman,
    joint::{self, Joint},
    material::{self, Material},
    others::{self, Camera, Dummy, Graph, Light, Path},
    pool::{self, ArrayPool},
    registered::{self, Collection, EntityPair, IkGroup, Window},
    script::{self, FileScript},
    section::{self, ElementTag, EndMarker, object, tags},
    sensor::{self, ForcePart, ProximityPart, VisionPart},
    settings::{self, SceneSettings},
    shape::{self, Shape},
    texture::{self, Texture},
    unknown::UnknownElements,
};

/// Maximum number of objects of a file; real files have hundreds, the largest ones thousands.
const MAX_OBJECTS: usize = 200_000;

/// The kind of an object.
#[derive(Debug, Clone)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum ObjectKind {
    Shape(Box<Shape>),
    Joint(Box<Joint>),
    Proximity(Box<ProximityPart>),
    Vision(Box<VisionPart>),
    Force(ForcePart),
    Dummy(Dummy),
    Path(Path),
    Graph(Graph),
    Camera(Camera),
    Light(Light),
    Script,
    /// Any other kind, by its name. Only the common part is read.
    Other(&'static str),
}

/// An object of the scene.
#[derive(Debug, Clone)]
pub struct FileObject {
    /// The elements that all objects have.
    pub common: CommonPart,
    /// The part specific to its kind.
    pub kind: ObjectKind,
    /// Section of the object in the unpacked data.
    pub section: ByteSpan,
}

impl FileObject {
    /// Returns the name of the object's kind.
    pub fn kind_name(&self) -> &'static str {
        match &self.kind {
            ObjectKind::Shape(_) => "shape",
            ObjectKind::Joint(_) => "joint",
            ObjectKind::Proximity(_) => "proximitySensor",
            ObjectKind::Vision(_) => "visionSensor",
            ObjectKind::Force(_) => "forceSensor",
            ObjectKind::Dummy(_) => "dummy",
            ObjectKind::Path(_) => "path",
            ObjectKind::Graph(_) => "graph",
            ObjectKind::Camera(_) => "camera",
            ObjectKind::Light(_) => "light",
            ObjectKind::Script => "script",
            ObjectKind::Other(word) => word,
        }
    }
}

/// The content of a file.
#[derive(Default)]
pub struct VrepFile {
    /// The decoded header of the file.
    pub header: FileHeader,
    /// The unpacked data, to which spans refer.
    pub data: Vec<u8>,
    /// Objects, in the order of the file.
    pub objects: Vec<FileObject>,
    /// Scripts: first those in separate sections, then those in script objects.
    pub scripts: Vec<FileScript>,
    /// Images that shapes use as textures.
    pub textures: Vec<Texture>,
    /// Materials, in files from before 3.4.
    pub materials: Vec<Material>,
    /// Arrays of vertices and indices that meshes share.
    pub pool: ArrayPool,
    /// Settings of the scene; for a model, the defaults.
    pub settings: SceneSettings,
    /// Custom data of the scene.
    pub scene_data: CustomData,
    /// Collections: named sets of objects.
    pub collections: Vec<Collection>,
    /// Collision objects of old versions.
    pub collisions: Vec<EntityPair>,
    /// Distance objects of old versions.
    pub distances: Vec<EntityPair>,
    /// Groups for inverse kinematics of old versions.
    pub ik_groups: Vec<IkGroup>,
    /// Windows of buttons of old versions.
    pub windows: Vec<Window>,
    /// Elements that are unknown to the reader.
    pub unknown: UnknownElements,
    held: Vec<FileScript>,
}

/// Reads the common part, then the specific part by the table `tags`.
fn read_object<T: Default>(
    f: &mut VrepFile,
    c: &mut Cursor<'_>,
    u: &mut UnknownElements,
    (tags, ignored): (&[ElementTag<T>], &[&str]),
    kind: fn(T) -> ObjectKind,
) -> ReadResult {
    let section = ByteSpan { at: c.at(), len: c.remaining() };
    if f.objects.len() >= MAX_OBJECTS {
        return Err(c.error(format!("the file has more than {MAX_OBJECTS} objects")));
    }
    let mut common = CommonPart::default();
    let end = object(c, common::TAGS, common::IGNORED, &mut common, u)?;
    let mut own = T::default();
    if end == EndMarker::Next {
        object(c, tags, ignored, &mut own, u)?;
    }
    f.objects.push(FileObject { common, kind: kind(own), section });
    Ok(())
}

/// Reads an object of which only the common part is used.
fn read_other_object(f: &mut VrepFile, c: &mut Cursor<'_>, u: &mut UnknownElements, word: &'static str) -> ReadResult {
    let section = ByteSpan { at: c.at(), len: c.remaining() };
    if f.objects.len() >= MAX_OBJECTS {
        return Err(c.error(format!("the file has more than {MAX_OBJECTS} objects")));
    }
    let mut common = CommonPart::default();
    object(c, common::TAGS, common::IGNORED, &mut common, u)?;
    f.objects.push(FileObject { common, kind: ObjectKind::Other(word), section });
    Ok(())
}

/// The specific part of a script object: its script.
const SCRIPT: &[ElementTag<Vec<FileScript>>] = tags!(Vec<FileScript> {
    "Soo" => |s, c, u| Ok(s.push(script::read(c, u)?)),
});

fn script_object(f: &mut VrepFile, c: &mut Cursor<'_>, u: &mut UnknownElements) -> ReadResult {
    let section = ByteSpan { at: c.at(), len: c.remaining() };
    let mut common = CommonPart::default();
    let end = object(c, common::TAGS, common::IGNORED, &mut common, u)?;
    let mut own = Vec::new();
    if end == EndMarker::Next {
        object(c, SCRIPT, others::SCRIPT_IGNORED, &mut own, u)?;
    }
    for script in own {
        f.held.push(FileScript { holder: Some(common.id), ..script });
    }
    f.objects.push(FileObject { common, kind: ObjectKind::Script, section });
    Ok(())
}

/// The sections of a file.
const SECTIONS: &[ElementTag<VrepFile>] = tags!(VrepFile {
    "TEX" => |f, c, u| Ok(f.textures.push(texture::read(c, u)?)),
    "DMA" => |f, c, u| Ok(f.materials.push(material::read(c, u)?)),
    "VIN" => |f, c, u| pool::read(&mut f.pool, c, u),
    "SHP" => |f, c, u| read_object(f, c, u, (shape::TAGS, shape::IGNORED), |s| ObjectKind::Shape(Box::new(s))),
    "JNT" => |f, c, u| read_object(f, c, u, (joint::TAGS, joint::IGNORED), |j| ObjectKind::Joint(Box::new(j))),
    "DMY" => |f, c, u| read_object(f, c, u, (others::DUMMY, others::DUMMY_IGNORED), ObjectKind::Dummy),
    "GRH" => |f, c, u| read_object(f, c, u, (others::GRAPH, others::GRAPH_IGNORED), ObjectKind::Graph),
    "PAT" => |f, c, u| read_object(f, c, u, (others::PATH, others::PATH_IGNORED), ObjectKind::Path),
    "SNR" => |f, c, u| {
        read_object(f, c, u, (sensor::PROXIMITY, sensor::PROXIMITY_IGNORED), |s| ObjectKind::Proximity(Box::new(s)))
    },
    "RSN" => |f, c, u| {
        read_object(f, c, u, (sensor::VISION, sensor::VISION_IGNORED), |s| ObjectKind::Vision(Box::new(s)))
    },
    "FSE" => |f, c, u| read_object(f, c, u, (sensor::FORCE, sensor::FORCE_IGNORED), ObjectKind::Force),
    "SCT" => |f, c, u| script_object(f, c, u),
    "CMA" => |f, c, u| read_object(f, c, u, (others::CAMERA, others::CAMERA_IGNORED), ObjectKind::Camera),
    "LGT" => |f, c, u| read_object(f, c, u, (others::LIGHT, others::LIGHT_IGNORED), ObjectKind::Light),
    "MIL" => |f, c, u| read_other_object(f, c, u, "mill"),
    "MIR" => |f, c, u| read_other_object(f, c, u, "mirror"),
    "OCT" => |f, c, u| read_other_object(f, c, u, "octree"),
    "PTC" => |f, c, u| read_other_object(f, c, u, "pointCloud"),
    "MKR" => |f, c, u| read_other_object(f, c, u, "marker"),
    "CSO" => |f, c, u| read_other_object(f, c, u, "customSceneObject"),
    "LST" => |f, c, u| Ok(f.scripts.push(script::read(c, u)?)),
    "GRP" => |f, c, u| Ok(f.collections.push(registered::collection(c, u)?)),
    "COL" => |f, c, u| Ok(f.collisions.push(registered::collision(c, u)?)),
    "DST" => |f, c, u| Ok(f.distances.push(registered::distance(c, u)?)),
    "IKO" => |f, c, u| Ok(f.ik_groups.push(registered::ik_group(c, u)?)),
    "BBK" => |f, c, u| Ok(f.windows.push(registered::window(c, u)?)),
    "SIM" => |f, c, u| settings::simulation(&mut f.settings, c, u),
    "DYN" => |f, c, u| settings::dynamics(&mut f.settings, c, u),
    "ENV" => |f, c, u| settings::environment(&mut f.settings, c, u),
    "SET" => |f, c, u| settings::main(&mut f.settings, c, u),
    "CDA" => |f, c, u| data::tagged(&mut f.scene_data, c, u),
    "CDS" => |f, c, u| data::numbered(&mut f.scene_data, c, u),
});

/// Known sections that are not used: thumbnails, user interface, data of other programs.
const IGNORED: &[&str] = &["BBC", "MTC", "ORD", "GHO", "PPL", "GCO", "MPL", "COB", "VEW"];

impl VrepFile {
    /// Returns whether the file contains a model, not a scene. Older files do not store this, but models have no
    /// settings.
    pub fn is_model(&self) -> bool {
        match self.header.file_type {
            1 => false,
            2 => true,
            _ => !self.settings.is_present,
        }
    }

    /// Parses a file. Any input, however malformed, quickly yields a file or an error.
    pub fn read(bytes: &[u8]) -> ReadResult<VrepFile> {
        let header = FileHeader::read(bytes)?;
        let payload = &bytes[header.payload..];
        let data = match header.packed {
            true => huffman::unpack(payload, header.unpacked)?,
            false => payload[..header.unpacked].to_vec(),
        };
        let mut file = VrepFile { header, ..Default::default() };
        file.sections(&data)?;
        file.data = data;
        let held = std::mem::take(&mut file.held);
        file.scripts.extend(held);
        file.check()?;
        Ok(file)
    }

    fn sections(&mut self, data: &[u8]) -> ReadResult {
        let mut c = Cursor::new(data);
        let mut unknown = UnknownElements::default();
        loop {
            let mut section = match section::next(&mut c)? {
                Ok(section) => section,
                Err(EndMarker::File) => break,
                Err(_) => return Err(c.error("the file ends without `EOF`")),
            };
            let tag = section.tag.as_str();
            if let Some(row) = SECTIONS.iter().find(|row| row.single == tag) {
                unknown.enter(tag);
                let done = (row.read)(self, &mut section.body, &mut unknown);
                unknown.leave();
                done.map_err(|e| e.within(tag))?;
            } else if !IGNORED.contains(&tag) {
                let span = ByteSpan { at: section.body.at(), len: section.body.remaining() };
                unknown.add(tag, span);
                // For an object of a newer, unknown kind, read the common part, so that it keeps its position in the
                // tree.
                let (signature, bytes) = common::SIGNATURE;
                let head = [signature.as_bytes(), &(bytes.len() as i32).to_le_bytes(), bytes].concat();
                if span.of(data).starts_with(&head) {
                    unknown.enter(tag);
                    let done = read_other_object(self, &mut section.body, &mut unknown, "unknown");
                    unknown.leave();
                    done.map_err(|e| e.within(tag))?;
                }
            }
        }
        self.unknown = unknown;
        Ok(())
    }

    /// Checks for errors that involve several sections: duplicate handles, and cycles of parents.
    fn check(&mut self) -> ReadResult {
        let mut places = std::collections::BTreeMap::new();
        for (i, o) in self.objects.iter().enumerate() {
            if places.insert(o.common.id, i).is_some() {
                let text = format!("two objects have the handle {}", o.common.id);
                return Err(ReadError::new(o.section.at, text));
            }
        }
        // Objects that cannot be reached from the root are part of a cycle or are below a cycle.
        let parents: Vec<Option<usize>> = self.objects.iter().map(|o| places.get(&o.common.parent).copied()).collect();
        let mut state = vec![0_u8; parents.len()];
        for start in 0..parents.len() {
            let mut walk = Vec::new();
            let mut at = Some(start);
            while let Some(i) = at.filter(|i| state[*i] == 0) {
                state[i] = 1;
                walk.push(i);
                at = parents[i];
            }
            if let Some(i) = at.filter(|i| state[*i] == 1) {
                let o = &self.objects[i];
                let text = format!("the object with handle {} is its own ancestor", o.common.id);
                return Err(ReadError::new(o.section.at, text));
            }
            walk.iter().for_each(|i| state[*i] = 2);
        }
        Ok(())
    }
}
