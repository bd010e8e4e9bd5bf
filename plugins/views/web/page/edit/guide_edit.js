// @ts-check
// Moves an object by the joints above it, as one guides an arm by its hand: the object goes where the user drags it, as
// far as the joints allow.

import { t } from "tatu/lib/language";
import { movedPose } from "tatu/lib/poses";
import { failure, sendLatest } from "tatu/net/calls";
import { call } from "tatu/net/connection";
import { describeObjects, edit, newMergeKey } from "tatu/scene/edits";
import { callsToMoveJoint } from "tatu/edit/joint_moves";
import { posesOf } from "tatu/edit/pose_edit";

/** @import { Pose } from "tatu/lib/poses" */
/** @import { ObjectPoses } from "tatu/edit/pose_edit" */

/** Number of joints with which an arm can reach poses; with fewer joints, only the position follows the user. */
const POSE_JOINTS = 6;

/** An object that is moved by its joints. All its motions form a single edit. */
export class GuideEdit {
  #merge = newMergeKey();
  #id;
  #initial;
  /** What shall follow the user: "pose" or "position". */
  #what;
  #send;

  /**
   * @param {number} id
   * @param {ObjectPoses} initial
   * @param {string} what
   */
  constructor(id, initial, what) {
    this.#id = id;
    this.#initial = initial;
    this.#what = what;
    const label = t`Guide ${describeObjects([id])}`;
    this.#send = sendLatest(async (/** @type {Pose} */ goal) => {
      const [positions, joints, refusal] = await this.#solve(goal);
      const to = positions ?? refusal.nearest;
      const calls = await Promise.all(joints.map((/** @type {number} */ joint, /** @type {number} */ i) => callsToMoveJoint(joint, to[i])));
      await edit(label, calls.flat(), this.#merge);
      if (!positions) throw { error: refusal.text };
    });
  }

  /**
   * Requests the pose of an object, and starts to guide it.
   * @param {number} id
   */
  static async begin(id) {
    const initial = await posesOf(id);
    const [, joints] = await call("tatu.kin.ik", id, initial.world).catch((thrown) => {
      const { error, help } = failure(thrown);
      throw { error: t`the object cannot be guided: ${error}`, help };
    });
    return new GuideEdit(id, initial, joints.length < POSE_JOINTS ? "position" : "pose");
  }

  /**
   * Returns the initial poses of the object.
   * @param {number} id
   */
  initialPoses(id) {
    return id === this.#id ? this.#initial : undefined;
  }

  /**
   * Moves the joints so that the object follows a motion in the world frame from its initial pose. If it cannot, the
   * joints move as near as they can, and the error says what stops them.
   * @param {Pose} motion
   */
  async apply(motion) {
    await this.#send(movedPose(motion, { world: this.#initial.world, local: this.#initial.world }));
  }

  /** @param {Pose} goal in the world frame */
  async #solve(goal) {
    const target = this.#what === "pose" ? goal : goal.slice(0, 3);
    // Without restarts the joints stay near where they are.
    return call("tatu.kin.ik", this.#id, target, { what: this.#what, restarts: 0 });
  }
}
