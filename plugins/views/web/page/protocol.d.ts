// The messages of the page and the program, generated from plugins/views/web/src/protocol/ by
// `TATU_BLESS=page cargo test -p tatu-views-web protocol`.

/**
 * A dynamic shape, for overlays.
 */
export type BodyMark = { id: number,
/**
 * The centre of mass in the frame of the shape, m.
 */
com: [number, number, number],
/**
 * The mass, kg.
 */
mass: number,
/**
 * The inertia matrix about the centre of mass, in the frame of the shape, in row-major order, kg m^2.
 */
inertia: [number, number, number, number, number, number, number, number, number],
/**
 * The linear velocity in the world frame, m/s.
 */
velocity: [number, number, number], };

/**
 * A command, for completion in the editor.
 */
export type Command = { name: string,
/**
 * The parameters, separated by commas.
 */
params: string, text: string, };

/**
 * A contact in the last step.
 */
export type ContactMark = {
/**
 * The handles of the two shapes. If only one of them can move, it is the second.
 */
pair: [number, number],
/**
 * The contact point in the world frame, m.
 */
point: [number, number, number],
/**
 * The force on the second shape in the world frame, N.
 */
force: [number, number, number], };

/**
 * A curve that a graph declares, with its newest points: one stream over another.
 */
export type CurvePoints = { name: string, unit: string, color: [number, number, number] | null,
/**
 * The coordinates of the points. Here and in `y`, non-finite values are null.
 */
x: Array<number | null>, y: Array<number | null>, };

/**
 * A drawing object of a script.
 */
export type Drawing = { form: string,
/**
 * Size of each item: pixels for points and lines, m for solids.
 */
size: number, color: Array<number>,
/**
 * The values of all items, consecutively; each item has `stride` values.
 */
items: Array<number>, stride: number, };

/**
 * A request to the program.
 */
export type FromPage = { "type": "run", action: RunAction, } | { "type": "speed", speed: number, } | { "type": "key", key: string, } | { "type": "drop", id: number, file: string, part: string, last: boolean,
/**
 * The folder for the file: the answer to a `folder` request. Omitted if the file was dropped alone.
 */
folder?: string, } | { "type": "folder", id: number, name: string, } | { "type": "save_script", id: number, script: number, text: string, version: number, } | { "type": "open", id: number, file: string, } | { "type": "picture", scene: string, png: string, } | { "type": "model_picture", id: number, model: string, } | { "type": "call", id: number, name: string, args: Array<unknown>, } | { "type": "details", object: number, follow?: boolean, } | { "type": "script", script: number, } | { "type": "data", object: number, } | { "type": "images", objects: Array<number>, depths?: Array<number>, } | { "type": "graphs", objects: Array<number>, } | { "type": "watch", of: number, values: Array<WatchedValue>, } | { "type": "overlays", contacts: boolean, bodies: boolean, } | { "type": "film", id: number, on: boolean, } | { "type": "commands", } | { "type": "files", };

/**
 * The section of the gallery: recently opened scenes, those in the working folder, or those of the program.
 */
export type GallerySection = "recent" | "own" | "program";

/**
 * The type, lead and limits of a joint.
 */
export type Joint = {
/**
 * The type: `revolute`, `prismatic` or `spherical`.
 */
type: string,
/**
 * Translation of a screw joint per revolution, m.
 */
lead: number,
/**
 * Minimum and maximum position, rad or m; omitted if the joint has no limits.
 */
limits?: [number, number], };

/**
 * A model without a parent that equals an earlier one in the message, apart from what is stated here.
 */
export type ModelCopy = {
/**
 * The handle of the root of the earlier model.
 */
copy_of: number,
/**
 * The alias of the root.
 */
alias: string,
/**
 * The handles of all objects, in the order of those of the earlier model.
 */
ids: Array<number>,
/**
 * The poses that differ from those of the earlier model, by the index of the object.
 */
poses: { [key in number]: [number, number, number, number, number, number, number] },
/**
 * The scripts of all objects, in their order.
 */
scripts: Array<Script>, };

/**
 * An event with output of the simulation.
 */
export type OutputLine = {
/**
 * The name of the event.
 */
name: string, payload: any, };

/**
 * A property of an object, or a field of its last reading that has at most 16 elements.
 */
export type PropertyRow = { key: string,
/**
 * The type of the value, one of the constants `TATU_*`; `count` is its number of elements, or 0 for any number.
 */
type: number, count: number, unit: string, text: string, settable: boolean, choices: Array<string>,
/**
 * The minimum value, if one is declared.
 */
min?: number,
/**
 * The maximum value, if one is declared.
 */
max?: number, value: unknown, };

/**
 * The last reading of a sensor. The variant depends on the schema of the reading.
 */
export type Reading = { "schema": "proximity", detected: boolean, distance?: number,
/**
 * The detected point in the sensor's frame, m.
 */
point?: Array<number>, } | { "schema": "range_scan",
/**
 * The distance measured along each beam, m; null if the beam hits nothing.
 */
distance: Array<number | null>,
/**
 * The angle of each beam about the +y axis, measured from the +z axis, rad.
 */
angle: Array<number>,
/**
 * The elevation of each beam towards the +y axis, rad; omitted if all beams have elevation 0.
 */
elevation?: Array<number>,
/**
 * The maximum distance that the sensor measures, m; omitted if it is unlimited.
 */
range?: number, } | { "schema": "gps",
/**
 * Position in the world frame, m.
 */
position: Array<number>, } | { "schema": "fields", fields: { [key in string]: Array<number | null> }, };

/**
 * A schema of sensor readings that the page can show.
 */
export type ReadingSchema = "proximity" | "range_scan" | "image" | "gps" | "fields";

/**
 * The action of a `run` request.
 */
export type RunAction = "start" | "pause" | "stop" | "step" | "quit";

export type RunState = "stopped" | "running" | "paused";

/**
 * An object, or a model that equals an earlier one.
 */
export type SceneEntry = SceneObject | ModelCopy;

/**
 * A scene that can be opened.
 */
export type SceneFile = { in: GallerySection,
/**
 * The path by which an `open` request opens the scene.
 */
file: string,
/**
 * The first paragraph of the comment at the beginning of the file, up to "Try:".
 */
about: string,
/**
 * The suggestion in that comment: the text after "Try:".
 */
try: string,
/**
 * A picture of the scene as a PNG in base64.
 */
picture: string | null, };

/**
 * An object of the scene, as the page shows it.
 */
export type SceneObject = {
/**
 * The handle of the object.
 */
id: number,
/**
 * The handle of the parent, or 0. Children of a joint are attached to the frame that the joint moves.
 */
parent: number, alias: string, kind: string,
/**
 * Position (m) and quaternion (x y z w) in the parent's frame.
 */
pose: [number, number, number, number, number, number, number], visible: boolean, layer: number,
/**
 * Whether the object is the base of a model.
 */
model: boolean,
/**
 * The visible parts of a shape.
 */
parts?: Array<VisiblePart>,
/**
 * Whether a shape is respondable, that is, collides with others. Omitted if false.
 */
collides?: boolean, joint?: Joint,
/**
 * The kind of a sensor, such as `proximity`.
 */
sensor?: string,
/**
 * The schema of a sensor's readings; omitted if the readings have no fields.
 */
schema?: ReadingSchema,
/**
 * Whether a sensor with images measures both colors and depths. Omitted if false.
 */
depth?: boolean,
/**
 * The detection volume of a sensor.
 */
volume?: SensorVolume,
/**
 * The poses of a path, seven values each: position (m) and quaternion (x y z w).
 */
points?: Array<number>, closed?: boolean, scripts?: Array<Script>, };

/**
 * A script of an object or of the scene.
 */
export type Script = { id: number, name: string, kind: string, language: string,
/**
 * A hash of the script's source.
 */
version: number, };

/**
 * The detection volume of a sensor; lengths in m, angles in rad. Infinite values, and values that do not exist for the
 * kind of sensor, are omitted.
 */
export type SensorVolume = {
/**
 * The form of the volume: `ray`, `cone`, `pyramid`, `cylinder` or `disc`.
 */
volume?: string, range?: number, near?: number, angle?: number, height?: number, radius_near?: number, radius_far?: number, size_near?: [number, number], size_far?: [number, number], };

/**
 * A stream of a graph with its newest samples.
 */
export type StreamSamples = { name: string, unit: string, color: [number, number, number] | null,
/**
 * The simulation times of the samples, s. Here and in `values`, non-finite values are null.
 */
times: Array<number | null>, values: Array<number | null>, };

/**
 * A texture: an image, and its projection onto a part.
 */
export type Texture = {
/**
 * The hash of the image, which is sent in a separate message.
 */
image: string,
/**
 * The kind of projection: `plane`, `cylinder`, `sphere`, `box`, or `mesh` for the texture coordinates of a mesh.
 */
mapping: string,
/**
 * Width and height of the image on the surface, m. For `cylinder` and `sphere`, the width is in revolutions; for
 * `sphere`, the height is in half revolutions; for `mesh`, both are in texture coordinates.
 */
size: [number, number],
/**
 * Pose of the projection in the frame of the part: position (m) and quaternion (x y z w).
 */
pose: [number, number, number, number, number, number, number],
/**
 * Whether the image is repeated horizontally, and vertically.
 */
repeat: [boolean, boolean],
/**
 * Whether colors are interpolated between pixels.
 */
smooth: boolean,
/**
 * How the image is combined with the color of the part: `modulate`, `decal` or `add`.
 */
blend: string, };

/**
 * A message to the page.
 */
export type ToPage = { "type": "hello", version: number,
/**
 * Whether the client has control rights.
 */
acts: boolean,
/**
 * An address that grants view rights, for the user to share; sent only to clients with control rights.
 */
look?: string,
/**
 * The working folder, to which relative paths of scenes refer; sent only to clients with control rights.
 */
folder?: string, speed: number, } | { "type": "scene", file: string,
/**
 * Number of the scene among those opened so far. It differs if the same file is opened again.
 */
opened: number, dt: number, objects: Array<SceneEntry>, scripts: Array<Script>,
/**
 * Notes from loading the scene, such as the features that an importer does not support.
 */
notes: Array<string>,
/**
 * The description of the scene in the first comment of its file.
 */
about: string,
/**
 * The suggestion of what to try, from the same comment.
 */
try: string, } | { "type": "objects", objects: Array<SceneObject>, } | { "type": "state", state: RunState, speed: number, dt: number,
/**
 * Label of the edit that the next undo reverts; `redo` is that of the edit that the next redo applies.
 */
undo: string | null, redo: string | null,
/**
 * Whether the scene has changes that are not saved in its file.
 */
unsaved: boolean,
/**
 * Path of the scene's file; `on_disk` is whether the file exists and may be overwritten.
 */
file: string, on_disk: boolean,
/**
 * Unix time, s, of a copy of unsaved edits that a crashed program has left; null if there is none.
 */
recovery: number | null, } | { "type": "event", name: string, payload: any, } | { "type": "output", lines: Array<OutputLine>, } | { "type": "readings", readings: { [key in number]: Reading | null }, } | { "type": "drawings", drawings: Array<Drawing>, } | { "type": "streams", graph: number, streams: Array<StreamSamples>,
/**
 * The curves that the graph declares, each a stream over another.
 */
curves: Array<CurvePoints>, } | { "type": "values", of: number, samples: Array<WatchSample>, } | { "type": "data", object: number, data: { [key in string]: string }, } | { "type": "overlays", contacts: Array<ContactMark>, bodies: Array<BodyMark>, } | { "type": "details", object: number, rows: Array<PropertyRow>, } | { "type": "script", script: number, text: string, version: number, } | { "type": "commands", commands: Array<Command>, } | { "type": "files", files: Array<SceneFile>,
/**
 * The name of the working folder.
 */
folder: string, } | { "type": "result", of: number, results: Array<any>, } | { "type": "error", error: string, help?: string, of?: number, };

/**
 * A visible part of a shape.
 */
export type VisiblePart = {
/**
 * The form: `plane`, `box`, `sphere`, `cylinder`, `capsule` or `mesh`.
 */
form: string,
/**
 * Pose of the part in the frame of its object: position (m) and quaternion (x y z w).
 */
pose: [number, number, number, number, number, number, number],
/**
 * Red, green and blue components, 0 to 1.
 */
color: [number, number, number],
/**
 * Opacity, from 0 (invisible) to 1; omitted if 1.
 */
opacity?: number,
/**
 * Size of the part along its axes, m; omitted for a mesh.
 */
size?: Array<number>,
/**
 * The texture of the part, if it has one.
 */
texture?: Texture,
/**
 * The hash of the mesh, which is sent in a separate message; omitted for other forms.
 */
mesh?: string, };

/**
 * The watched values at the end of a step.
 */
export type WatchSample = {
/**
 * Simulation time, s.
 */
time: number,
/**
 * The elements of each watched value, in the order of the request; empty if the value cannot be read. Non-finite
 * elements are null.
 */
values: Array<Array<number | null>>, };

/**
 * A watched value of an object: a property, or a field of its readings.
 */
export type WatchedValue = { object: number, key: string, };
