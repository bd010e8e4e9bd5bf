// @ts-check
// Moves objects that the user drags, nudges or positions by typed numbers: reads their exact poses, and sends new poses
// to the program.

import { moved } from "tatu/lib/poses";
import { newest } from "tatu/net/calls";
import { call, on } from "tatu/net/connection";
import { edit, named, together } from "tatu/scene/edits";
import { scene, selection } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { redraw } from "tatu/view/renderer";

/** @import { Pose } from "tatu/lib/poses" */
/** @typedef {{ world: Pose, local: Pose }} Place The pose of an object in the world frame and in its parent's frame. */

/** Time for which frames are ignored after an edit of a pose, ms, because older frames may still be in flight. */
const LATE = 200;
/** Poses that frames must not overwrite, by object. @type {Map<number, Pose>} */
const held = new Map();

/**
 * Requests the exact pose of an object from the program, because poses in frames are rounded.
 * @param {number} id
 * @returns {Promise<Place>}
 */
export async function placeOf(id) {
  const [[world], [local]] = await Promise.all([call("tatu.get", id, "object.world_pose"), call("tatu.get", id, "object.pose")]);
  return { world, local };
}

/** Returns the selected objects, except those below another selected object, which move with that object. */
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
 * Shows an object at a pose in its parent's frame.
 * @param {number} id
 * @param {Pose} pose
 */
function show(id, pose) {
  const group = groups.get(id);
  group?.position.fromArray(pose);
  group?.quaternion.fromArray(pose, 3);
}

on("frame", () => held.forEach((pose, id) => show(id, pose)));

/** Objects that are moved together from their initial poses. All their motions form a single edit. */
export class Carry {
  #merge = together();
  #label;
  #places;
  #send;
  /** The target poses in the frames of the parents. @type {Map<number, Pose>} */
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
   * Requests the exact poses of objects, and starts to move them.
   * @param {string} verb "Move" or "Turn"
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
   * Applies a motion in the world frame to the initial poses of all objects. The promise is settled when the program
   * has applied the motion. If several motions are queued, only the last one can fail.
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
   * Lets frames update objects again, except those that have been moved again in the meantime.
   * @param {Map<number, Pose>} poses
   */
  #release(poses) {
    for (const [id, pose] of poses) if (held.get(id) === pose) held.delete(id);
  }
}
