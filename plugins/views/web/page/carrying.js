// @ts-check
// What is being moved, whether by the mouse, by keys or by typed numbers: its exact poses, and how it gets to new ones.

import { newest } from "tatu/calls";
import { edit, named, together } from "tatu/edits";
import { moved } from "tatu/geometry";
import { call, on } from "tatu/net";
import { groups } from "tatu/objects";
import { scene, selection } from "tatu/store";
import { redraw } from "tatu/view";

/** @import { Pose } from "tatu/geometry" */
/** @typedef {{ world: Pose, local: Pose }} Place The pose of an object in the world, and in the frame of its parent. */

/** How long a pose of this page outlasts its edit, ms: frames that are older may still be on the way. */
const LATE = 200;
/** Poses that frames must not take back. @type {Map<number, Pose>} */
const held = new Map();

/**
 * Where an object is; frames round poses, so the program is asked.
 * @param {number} id
 * @returns {Promise<Place>}
 */
export async function placeOf(id) {
  const [[world], [local]] = await Promise.all([call("tatu.get", id, "object.world_pose"), call("tatu.get", id, "object.pose")]);
  return { world, local };
}

/** The selected objects that are below no other selected one: the others move with them. */
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

/** Objects that move together, from where they were when it began; all that it sends is one edit. */
export class Carry {
  #merge = together();
  #label;
  #places;
  #send;
  /** Where they are to be. @type {Map<number, Pose>} */
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
   * Takes up objects.
   * @param {string} verb
   * @param {number[]} ids
   */
  static async take(verb, ids) {
    const places = await Promise.all(ids.map(placeOf));
    return new Carry(verb, new Map(ids.map((id, i) => [id, /** @type {Place} */ (places[i])])));
  }

  /**
   * Where an object was when it began.
   * @param {number} id
   */
  from(id) {
    return this.#places.get(id);
  }

  /**
   * Puts all objects to where a motion of the world brings them from where they were when it began; settled once the
   * program has them there. Of what is put while an earlier one is on the way, only the last fails.
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
   * Lets frames show objects again, unless they have been put elsewhere.
   * @param {Map<number, Pose>} poses
   */
  #release(poses) {
    for (const [id, pose] of poses) if (held.get(id) === pose) held.delete(id);
  }
}
