// The messages of the page and the program, generated from plugins/views/web/src/protocol/ by
// `TATU_BLESS=page cargo test -p tatu-views-web protocol`.

/**
 * What a request to run does.
 */
export type Action = "start" | "pause" | "stop" | "step" | "quit";

/**
 * A body that forces move.
 */
export type BodyMark = { id: number,
/**
 * Its centre of mass, in its frame, m.
 */
com: [number, number, number],
/**
 * kg.
 */
mass: number,
/**
 * Its inertia about the centre of mass, in its frame, by rows, kg m^2.
 */
inertia: [number, number, number, number, number, number, number, number, number],
/**
 * In the world, m/s.
 */
velocity: [number, number, number], };

/**
 * A command, for completion.
 */
export type Command = { name: string,
/**
 * Its parameters, joined by commas.
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
 * Where they touch, in the world, m.
 */
point: [number, number, number],
/**
 * The force on the second shape, N.
 */
force: [number, number, number], };

/**
 * What a script draws.
 */
export type Drawing = { form: string,
/**
 * The size of points and lines in pixels, of bodies in m.
 */
size: number, color: Array<number>,
/**
 * The numbers of all items, and how many each has.
 */
items: Array<number>, stride: number, };

/**
 * A request to the program.
 */
export type FromPage = { "type": "run", action: Action, } | { "type": "speed", speed: number, } | { "type": "key", key: string, } | { "type": "drop", id: number, file: string, part: string, last: boolean,
/**
 * The folder to which it goes: the answer to `folder`.
 */
folder?: string, } | { "type": "folder", id: number, name: string, } | { "type": "save_script", id: number, script: number, text: string, version: number, } | { "type": "open", id: number, file: string, } | { "type": "picture", scene: string, png: string, } | { "type": "call", id: number, name: string, args: Array<unknown>, } | { "type": "details", object: number, } | { "type": "script", script: number, } | { "type": "data", object: number, } | { "type": "images", objects: Array<number>, } | { "type": "graphs", objects: Array<number>, } | { "type": "watch", of: number, values: Array<Watched>, } | { "type": "overlays", contacts: boolean, bodies: boolean, } | { "type": "film", id: number, on: boolean, } | { "type": "commands", } | { "type": "files", };

/**
 * How a joint moves.
 */
export type Joint = {
/**
 * revolute, prismatic or spherical.
 */
type: string,
/**
 * The way of a screw per turn, m.
 */
lead: number,
/**
 * Its lowest and highest position, rad or m, if it has limits.
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
 * Its pose in the frame of its object.
 */
pose: [number, number, number, number, number, number, number],
/**
 * Red, green and blue, 0 to 1.
 */
color: [number, number, number],
/**
 * Its size along its axes, m.
 */
size?: Array<number>,
/**
 * The image on it.
 */
texture?: Texture,
/**
 * The checksum of its mesh, which is a message of its own.
 */
mesh?: string, };

/**
 * A reading.
 */
export type Reading = { "schema": "proximity", detected: boolean, distance?: number,
/**
 * The detected point, in the sensor's frame.
 */
point?: Array<number>, } | { "schema": "range_scan",
/**
 * The distance of each beam, m; null: it meets nothing.
 */
distance: Array<number | null>,
/**
 * The angle of each beam about +y from +z, rad.
 */
angle: Array<number>,
/**
 * The elevation of each beam towards +y, rad; missing: 0.
 */
elevation?: Array<number>,
/**
 * The greatest distance that the sensor can tell, m; missing: there is none.
 */
range?: number, } | { "schema": "gps",
/**
 * In the frame of the world.
 */
position: Array<number>, } | { "schema": "fields", fields: { [key in string]: Array<number | null> }, };

/**
 * A property of an object.
 */
export type Row = { key: string,
/**
 * Its type, one of the numbers `TATU_*`, and how many values it has; 0: any number.
 */
type: number, count: number, unit: string, text: string, settable: boolean, choices: Array<string>,
/**
 * The least value, if one is declared.
 */
min?: number,
/**
 * The greatest value, if one is declared.
 */
max?: number, value: unknown, };

export type RunState = "stopped" | "running" | "paused";

/**
 * What is watched, after a step.
 */
export type Sample = {
/**
 * Simulation time, s.
 */
time: number,
/**
 * The numbers of each value in the order of the request; empty if it cannot be read. Numbers that are not finite
 * are null.
 */
values: Array<Array<number | null>>, };

/**
 * A scene that can be opened.
 */
export type SceneFile = { in: Section,
/**
 * The name by which it is opened.
 */
file: string,
/**
 * The first paragraph of its comment.
 */
about: string,
/**
 * What its comment says to try in the page.
 */
try: string,
/**
 * A PNG in base64.
 */
picture: string | null, };

/**
 * An object of the scene.
 */
export type SceneObject = {
/**
 * Its handle.
 */
id: number,
/**
 * The handle of its parent; 0: none. Children of a joint are attached to its moved frame.
 */
parent: number, alias: string, kind: string,
/**
 * Position and quaternion (x y z w) in the parent's frame.
 */
pose: [number, number, number, number, number, number, number], visible: boolean, layer: number,
/**
 * Whether it is the base of a model.
 */
model: boolean,
/**
 * The parts of a shape.
 */
parts?: Array<Part>,
/**
 * Whether a shape collides; missing: no.
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
 * How far and how wide a sensor detects.
 */
volume?: Volume,
/**
 * The poses of a path, seven numbers each.
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
 * Another number if its text is another.
 */
version: number, };

/**
 * Where a scene is from.
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
 * The image on a part, and how it is projected.
 */
export type Texture = {
/**
 * The hash of the image, which is a message of its own.
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
 * Whether it repeats to the right, and up.
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
 * Whether the client may act.
 */
acts: boolean,
/**
 * A view-only address for other clients.
 */
look?: string, speed: number, } | { "type": "scene", file: string,
/**
 * The number of the scene among those that the program has opened: the same file may be opened again.
 */
opened: number, dt: number, objects: Array<SceneObject>, scripts: Array<Script>,
/**
 * What was noted when the scene was read, such as what an importer left out.
 */
notes: Array<string>, } | { "type": "objects", objects: Array<SceneObject>, } | { "type": "state", state: RunState, speed: number, dt: number,
/**
 * What the next undo and redo do, in words.
 */
undo: string | null, redo: string | null,
/**
 * Whether the scene differs from its file.
 */
unsaved: boolean,
/**
 * The file of the scene, and whether it is there.
 */
file: string, on_disk: boolean,
/**
 * When a program that ended unexpectedly wrote a copy of unsaved edits, Unix time in s.
 */
recovery: number | null, } | { "type": "event", name: string, payload: any, } | { "type": "readings", readings: { [key in number]: Reading | null }, } | { "type": "drawings", drawings: Array<Drawing>, } | { "type": "streams", graph: number, streams: Array<Stream>, } | { "type": "values", of: number, samples: Array<Sample>, } | { "type": "data", object: number, data: { [key in string]: string }, } | { "type": "overlays", contacts: Array<ContactMark>, bodies: Array<BodyMark>, } | { "type": "details", object: number, rows: Array<Row>, } | { "type": "script", script: number, text: string, version: number, } | { "type": "commands", commands: Array<Command>, } | { "type": "files", files: Array<SceneFile>,
/**
 * The name of the working folder.
 */
folder: string, } | { "type": "result", of: number, results: Array<any>, } | { "type": "error", error: string, help?: string, of?: number, };

/**
 * The volume in which a sensor detects; lengths in m, angles in rad. Infinite numbers are left out.
 */
export type Volume = {
/**
 * ray, cone, pyramid, cylinder or disc.
 */
volume?: string, range?: number, near?: number, angle?: number, height?: number, radius_near?: number, radius_far?: number, size_near?: [number, number], size_far?: [number, number], };

/**
 * What is watched of an object: the key of a property, or the name of a field of its readings.
 */
export type Watched = { object: number, key: string, };
