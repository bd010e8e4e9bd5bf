// The messages of the page and the program, generated from plugins/views/web/src/protocol/ by
// `TATU_BLESS=page cargo test -p tatu-views-web protocol`.

/**
 * The action of a `run` request.
 */
export type Action = "start" | "pause" | "stop" | "step" | "quit";

/**
 * A dynamic body.
 */
export type BodyMark = { id: number,
/**
 * The centre of mass in the frame of the body, m.
 */
com: [number, number, number],
/**
 * The mass, kg.
 */
mass: number,
/**
 * The inertia matrix about the centre of mass, in the frame of the body, by rows, kg m^2.
 */
inertia: [number, number, number, number, number, number, number, number, number],
/**
 * The velocity in the world frame, m/s.
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
 * A contact of the last step.
 */
export type ContactMark = {
/**
 * The two shapes; the second one can move if one of them can.
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
 * A drawing object of a script.
 */
export type Drawing = { form: string,
/**
 * Size of points and lines in pixels, or of solids in m.
 */
size: number, color: Array<number>,
/**
 * The values of all items, consecutively, and the number of values per item.
 */
items: Array<number>, stride: number, };

/**
 * A request to the program.
 */
export type FromPage = { "type": "run", action: Action, } | { "type": "speed", speed: number, } | { "type": "key", key: string, } | { "type": "drop", id: number, file: string, part: string, last: boolean,
/**
 * The folder for the file, as returned by `folder`.
 */
folder?: string, } | { "type": "folder", id: number, name: string, } | { "type": "save_script", id: number, script: number, text: string, version: number, } | { "type": "open", id: number, file: string, } | { "type": "picture", scene: string, png: string, } | { "type": "call", id: number, name: string, args: Array<unknown>, } | { "type": "details", object: number, } | { "type": "script", script: number, } | { "type": "data", object: number, } | { "type": "images", objects: Array<number>, } | { "type": "graphs", objects: Array<number>, } | { "type": "watch", of: number, values: Array<Watched>, } | { "type": "overlays", contacts: boolean, bodies: boolean, } | { "type": "film", id: number, on: boolean, } | { "type": "commands", } | { "type": "files", };

/**
 * The type, lead and limits of a joint.
 */
export type Joint = {
/**
 * revolute, prismatic or spherical.
 */
type: string,
/**
 * Translation of a screw joint per turn, m.
 */
lead: number,
/**
 * Minimum and maximum position, rad or m, if the joint has limits.
 */
limits?: [number, number], };

/**
 * A visible part of a shape.
 */
export type Part = {
/**
 * plane, box, sphere, cylinder, capsule or mesh.
 */
form: string,
/**
 * Pose of the part in the frame of its object.
 */
pose: [number, number, number, number, number, number, number],
/**
 * Red, green and blue, 0 to 1.
 */
color: [number, number, number],
/**
 * Size of the part along its axes, m.
 */
size?: Array<number>,
/**
 * The texture of the part.
 */
texture?: Texture,
/**
 * The hash of the mesh, which is sent as a separate message.
 */
mesh?: string, };

/**
 * The reading of a sensor.
 */
export type Reading = { "schema": "proximity", detected: boolean, distance?: number,
/**
 * The detected point, in the sensor's frame.
 */
point?: Array<number>, } | { "schema": "range_scan",
/**
 * The distance along each beam, m; null if it hits nothing.
 */
distance: Array<number | null>,
/**
 * The angle of each beam about +y from +z, rad.
 */
angle: Array<number>,
/**
 * The elevation of each beam towards +y, rad; 0 if it is missing.
 */
elevation?: Array<number>,
/**
 * The maximum distance that the sensor measures, m; unlimited if it is missing.
 */
range?: number, } | { "schema": "gps",
/**
 * Position in the world frame, m.
 */
position: Array<number>, } | { "schema": "fields", fields: { [key in string]: Array<number | null> }, };

/**
 * A property of an object.
 */
export type Row = { key: string,
/**
 * The type of the value, one of the constants `TATU_*`, and its number of elements; 0 means any number.
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

export type RunState = "stopped" | "running" | "paused";

/**
 * The watched values after a step.
 */
export type Sample = {
/**
 * Simulation time, s.
 */
time: number,
/**
 * The elements of each value, in the order of the request; empty if the value cannot be read. Elements that are
 * not finite are null.
 */
values: Array<Array<number | null>>, };

/**
 * A scene that can be opened.
 */
export type SceneFile = { in: Section,
/**
 * The name by which the scene is opened.
 */
file: string,
/**
 * The first paragraph of the comment at the beginning of the file.
 */
about: string,
/**
 * The part of that comment after "Try:".
 */
try: string,
/**
 * A picture of the scene, a PNG in base64.
 */
picture: string | null, };

/**
 * An object of the scene.
 */
export type SceneObject = {
/**
 * The handle of the object.
 */
id: number,
/**
 * The handle of the parent; 0 if there is none. Children of a joint are attached to its moved frame.
 */
parent: number, alias: string, kind: string,
/**
 * Position and quaternion (x y z w) in the parent's frame.
 */
pose: [number, number, number, number, number, number, number], visible: boolean, layer: number,
/**
 * Whether the object is the base of a model.
 */
model: boolean,
/**
 * The parts of a shape.
 */
parts?: Array<Part>,
/**
 * Whether a shape collides; false if it is missing.
 */
collides?: boolean, joint?: Joint,
/**
 * The kind of a sensor.
 */
sensor?: string,
/**
 * The schema of a sensor's readings, if the page shows it.
 */
schema?: Schema,
/**
 * The detection volume of a sensor.
 */
volume?: Volume,
/**
 * The poses of a path, seven numbers each: position (m) and quaternion (x y z w).
 */
points?: Array<number>, closed?: boolean, scripts?: Array<Script>, };

/**
 * A schema of readings that the page shows.
 */
export type Schema = "proximity" | "range_scan" | "image" | "gps" | "fields";

/**
 * A script of an object or of the scene.
 */
export type Script = { id: number, name: string, kind: string, language: string,
/**
 * A number that differs for different texts of the script.
 */
version: number, };

/**
 * The source of a scene: recently opened, in the working folder, or part of the program.
 */
export type Section = "recent" | "own" | "program";

/**
 * A stream of a graph, with its newest samples.
 */
export type Stream = { name: string, unit: string, color: [number, number, number] | null,
/**
 * Samples that are not finite are null.
 */
times: Array<number | null>, values: Array<number | null>, };

/**
 * A texture: an image on a part, and its projection.
 */
export type Texture = {
/**
 * The hash of the image, which is sent as a separate message.
 */
image: string,
/**
 * plane, cylinder, sphere or box.
 */
mapping: string,
/**
 * Width and height of the image on the surface, m.
 */
size: [number, number],
/**
 * Pose of the projection in the frame of the part.
 */
pose: [number, number, number, number, number, number, number],
/**
 * Whether the image repeats to the right, and upwards.
 */
repeat: [boolean, boolean],
/**
 * Whether colors between pixels are interpolated.
 */
smooth: boolean,
/**
 * modulate, decal or add.
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
 * A view-only address for other clients.
 */
look?: string, speed: number, } | { "type": "scene", file: string,
/**
 * Serial number of the scene among those opened so far, since the same file may be opened again.
 */
opened: number, dt: number, objects: Array<SceneObject>, scripts: Array<Script>,
/**
 * Notes from loading the scene, such as features that an importer does not support.
 */
notes: Array<string>, } | { "type": "objects", objects: Array<SceneObject>, } | { "type": "state", state: RunState, speed: number, dt: number,
/**
 * Descriptions of the next undo and redo.
 */
undo: string | null, redo: string | null,
/**
 * Whether the scene differs from its file.
 */
unsaved: boolean,
/**
 * The file of the scene, and whether it exists.
 */
file: string, on_disk: boolean,
/**
 * Time of the copy of unsaved edits that a crashed program left, Unix time in s.
 */
recovery: number | null, } | { "type": "event", name: string, payload: any, } | { "type": "readings", readings: { [key in number]: Reading | null }, } | { "type": "drawings", drawings: Array<Drawing>, } | { "type": "streams", graph: number, streams: Array<Stream>, } | { "type": "values", of: number, samples: Array<Sample>, } | { "type": "data", object: number, data: { [key in string]: string }, } | { "type": "overlays", contacts: Array<ContactMark>, bodies: Array<BodyMark>, } | { "type": "details", object: number, rows: Array<Row>, } | { "type": "script", script: number, text: string, version: number, } | { "type": "commands", commands: Array<Command>, } | { "type": "files", files: Array<SceneFile>,
/**
 * The name of the working folder.
 */
folder: string, } | { "type": "result", of: number, results: Array<any>, } | { "type": "error", error: string, help?: string, of?: number, };

/**
 * The detection volume of a sensor; lengths in m, angles in rad. Infinite values are omitted.
 */
export type Volume = {
/**
 * ray, cone, pyramid, cylinder or disc.
 */
volume?: string, range?: number, near?: number, angle?: number, height?: number, radius_near?: number, radius_far?: number, size_near?: [number, number], size_far?: [number, number], };

/**
 * A watched value of an object: the key of a property, or the name of a field of its readings.
 */
export type Watched = { object: number, key: string, };
