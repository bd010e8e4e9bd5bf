// @ts-check
// Moves objects that the user drags, moves by keys or positions by typed numbers: reads their exact poses, and sends
// new poses to the program.

import { movedPose } from "tatu/lib/poses";
import { sendLatest } from "tatu/net/calls";
import { call, on } from "tatu/net/connection";
import { describeObjects, edit, newMergeKey } from "tatu/scene/edits";
import { topmost } from "tatu/scene/hierarchy";
import { selection } from "tatu/scene/store";
import { groups } from "tatu/view/objects";
import { redraw } from "tatu/view/renderer";

/** @import { Pose } from "tatu/lib/poses" */
/** @typedef {{ world: Pose, local: Pose }} ObjectPoses The pose of an object in the world frame and in its parent's frame. */

/** Time for which frames are ignored after an edit of a pose, ms, because older frames may still be in flight. */
const LATE_FRAMES_TIME = 200;
/** Poses that frames must not overwrite, by object. @type {Map<number, Pose>} */
const pendingPoses = new Map();

/**
 * Requests the exact pose of an object from the program, because poses in frames are rounded.
 * @param {number} id
 * @returns {Promise<ObjectPoses>}
 */
export async function posesOf(id) {
  const [[world], [local]] = await Promise.all([call("tatu.get", id, "object.world_pose"), call("tatu.get", id, "object.pose")]);
  return { world, local };
}

/** Returns the selected objects, except those below another selected object, which move with that object. */
export function movedObjects() {
  return topmost(selection());
}

/**
 * Shows an object at a pose in its parent's frame.
 * @param {number} id
 * @param {Pose} pose
 */
function showPose(id, pose) {
  const group = groups.get(id);
  group?.position.fromArray(pose);
  group?.quaternion.fromArray(pose, 3);
}

on("frame", () => pendingPoses.forEach((pose, id) => showPose(id, pose)));

/** Objects that are moved together from their initial poses. All their motions form a single edit. */
export class PoseEdit {
  #merge = newMergeKey();
  #label;
  #initialPoses;
  #send;
  /** The target poses in the frames of the parents. @type {Map<number, Pose>} */
  #poses = new Map();

  /**
   * @param {string} verb "Move" or "Turn"
   * @param {Map<number, ObjectPoses>} initialPoses
   */
  constructor(verb, initialPoses) {
    this.#label = `${verb} ${describeObjects([...initialPoses.keys()])}`;
    this.#initialPoses = initialPoses;
    this.#send = sendLatest((/** @type {Map<number, Pose>} */ poses) => {
      return edit(this.#label, [...poses].map(([id, pose]) => ["tatu.set", id, "object.pose", pose]), this.#merge);
    });
  }

  /**
   * Requests the exact poses of objects, and starts to move them.
   * @param {string} verb "Move" or "Turn"
   * @param {number[]} ids
   */
  static async begin(verb, ids) {
    const initialPoses = await Promise.all(ids.map(posesOf));
    return new PoseEdit(verb, new Map(ids.map((id, i) => [id, /** @type {ObjectPoses} */ (initialPoses[i])])));
  }

  /**
   * Returns the initial poses of an object.
   * @param {number} id
   */
  initialPoses(id) {
    return this.#initialPoses.get(id);
  }

  /**
   * Applies a motion in the world frame to the initial poses of all objects. The promise is settled when the program
   * has applied the motion. If several motions are queued, only the last one can fail.
   * @param {Pose} motion
   */
  async apply(motion) {
    /** @type {Map<number, Pose>} */
    const poses = new Map();
    for (const [id, initial] of this.#initialPoses) poses.set(id, movedPose(motion, initial));
    this.#poses = poses;
    for (const [id, pose] of poses) {
      pendingPoses.set(id, pose);
      showPose(id, pose);
    }
    redraw();
    try {
      await this.#send(poses);
      setTimeout(() => this.#release(poses), LATE_FRAMES_TIME);
    } catch (e) {
      if (this.#poses !== poses) return;
      this.#release(poses);
      for (const [id, { local }] of this.#initialPoses) showPose(id, local);
      redraw();
      throw e;
    }
  }

  /**
   * Lets frames update objects again, except those that have been moved again in the meantime.
   * @param {Map<number, Pose>} poses
   */
  #release(poses) {
    for (const [id, pose] of poses) if (pendingPoses.get(id) === pose) pendingPoses.delete(id);
  }
}
