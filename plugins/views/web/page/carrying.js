// @ts-check
// Moving objects by the mouse, by keys or by typed numbers: their exact poses, and sending new ones to the program.

import { newest } from "tatu/calls";
import { edit, named, together } from "tatu/edits";
import { moved } from "tatu/geometry";
import { call, on } from "tatu/net";
import { groups } from "tatu/objects";
import { scene, selection } from "tatu/store";
import { redraw } from "tatu/view";

/** @import { Pose } from "tatu/geometry" */
/** @typedef {{ world: Pose, local: Pose }} Place The pose of an object in the world, and in the frame of its parent. */

/** Time for which a pose set by this page is shown after its edit, ms, because older frames may still be in flight. */
const LATE = 200;
/** Poses that frames must not overwrite, by object. @type {Map<number, Pose>} */
const held = new Map();

/**
 * Requests the exact pose of an object from the program, since poses in frames are rounded.
 * @param {number} id
 * @returns {Promise<Place>}
 */
export async function placeOf(id) {
  const [[world], [local]] = await Promise.all([call("tatu.get", id, "object.world_pose"), call("tatu.get", id, "object.pose")]);
  return { world, local };
}

/** Returns the selected objects without those below another selected one, which move with it. */
export function carried() {
  const all = new Set(selection());
  return [...all].filter((id) => {
    for (let o = scene.objects.get(scene.objects.get(id)?.parent ?? 0); o; o = scene.objects.get(o.parent)) {
      if (all.has(o.id)) return false;
    }
    return scene.objects.has(id);
  });
}

/**
 * @param {number} id
 * @param {Pose} pose
 */
function show(id, pose) {
  const group = groups.get(id);
  group?.position.fromArray(pose);
  group?.quaternion.fromArray(pose, 3);
}

on("frame", () => held.forEach((pose, id) => show(id, pose)));

/** Objects that are moved together from their initial poses; all changes form a single edit. */
export class Carry {
  #merge = together();
  #label;
  #places;
  #send;
  /** The target poses. @type {Map<number, Pose>} */
  #poses = new Map();

  /**
   * @param {string} verb "Move" or "Turn"
   * @param {Map<number, Place>} places
   */
  constructor(verb, places) {
    this.#label = `${verb} ${named([...places.keys()])}`;
    this.#places = places;
    this.#send = newest((/** @type {Map<number, Pose>} */ poses) => {
      return edit(this.#label, [...poses].map(([id, pose]) => ["tatu.set", id, "object.pose", pose]), this.#merge);
    });
  }

  /**
   * Starts to move objects.
   * @param {string} verb
   * @param {number[]} ids
   */
  static async take(verb, ids) {
    const places = await Promise.all(ids.map(placeOf));
    return new Carry(verb, new Map(ids.map((id, i) => [id, /** @type {Place} */ (places[i])])));
  }

  /**
   * Returns the initial pose of an object.
   * @param {number} id
   */
  from(id) {
    return this.#places.get(id);
  }

  /**
   * Applies a motion in the world frame to the initial poses of all objects; settled once the program has applied it.
   * If several motions are queued, only the last one can fail.
   * @param {Pose} motion
   */
  async put(motion) {
    /** @type {Map<number, Pose>} */
    const poses = new Map();
    for (const [id, place] of this.#places) poses.set(id, moved(motion, place));
    this.#poses = poses;
    for (const [id, pose] of poses) {
      held.set(id, pose);
      show(id, pose);
    }
    redraw();
    try {
      await this.#send(poses);
      setTimeout(() => this.#release(poses), LATE);
    } catch (e) {
      if (this.#poses !== poses) return;
      this.#release(poses);
      for (const [id, { local }] of this.#places) show(id, local);
      redraw();
      throw e;
    }
  }

  /**
   * Lets frames update objects again, unless they have been moved again in the meantime.
   * @param {Map<number, Pose>} poses
   */
  #release(poses) {
    for (const [id, pose] of poses) if (held.get(id) === pose) held.delete(id);
  }
}
