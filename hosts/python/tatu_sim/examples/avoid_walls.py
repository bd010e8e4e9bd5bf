"""A Pioneer learns to avoid walls, by the cross-entropy method in NumPy alone.

    python -m tatu_sim.examples.avoid_walls                   five minutes
    python -m tatu_sim.examples.avoid_walls --seconds 30      a shorter run

The policy is linear up to saturation: the closeness that 16 sonars report, times weights, plus a bias, limited by tanh,
gives the speeds of both wheels.
The method draws 32 vectors of weights from a normal distribution, lets each drive in two worlds for a while, and moves
the distribution towards the best of them. The untrained policy is the mean of the first distribution: all weights are
0, and the robot drives straight ahead at its mean speed.

The table at the end compares both on 20 arenas that training has not seen: the time until the first collision, at most
60 s, and the distance driven until then.
"""

import argparse
import time

import numpy as np

from tatu_sim.gym import make_vec

SCENE = "learn/avoid_walls.toml"
ROBOT = "/Pioneer_p3dx"
#: Number of weight vectors per generation, of worlds that evaluate each, and of the best ones that are selected.
CANDIDATES, WORLDS, ELITE = 32, 2, 6
#: Number of environment steps, of 0.1 s each, for the first and the last generation.
STEPS = 150, 300
#: Seeds of the arenas of the comparison; those of training are below 1,000,000.
UNSEEN = [1_000_000 + n for n in range(20)]


class Policy:
    """Linear policies with saturated outputs, one for each world."""

    def __init__(self, env, weights: np.ndarray):
        inputs, outputs = env.single_observation_space.shape[0], env.single_action_space.shape[0]
        low, high = env.single_action_space.low, env.single_action_space.high
        self.middle, self.half = (low + high) / 2, (high - low) / 2
        self.weights = weights.reshape(-1, outputs, inputs + 1)

    @staticmethod
    def size(env) -> int:
        """Return the number of weights of a policy for one world of `env`."""
        return (env.single_observation_space.shape[0] + 1) * env.single_action_space.shape[0]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        x = np.einsum("noi,ni->no", self.weights[:, :, :-1], observations) + self.weights[:, :, -1]
        return self.middle + self.half * np.tanh(x)


def returns(env, policy: Policy, seed: int, steps: int) -> np.ndarray:
    """Return the total reward of each world in a fixed time. A world whose robot has collided is reset and
    continues."""
    observations, _ = env.reset(seed=seed)
    total = np.zeros(env.num_envs)
    for _ in range(steps):
        observations, rewards, *_ = env.step(policy(observations))
        total += rewards
    return total


def compare(env, weights: np.ndarray):
    """Return the time until the first collision, s, and the distance driven until then, m, in unseen arenas."""
    policy = Policy(env, np.tile(weights, (env.num_envs, 1)))
    observations, _ = env.reset(seed=UNSEEN)
    first = np.ones(env.num_envs, dtype=bool)
    seconds, metres = np.zeros(env.num_envs), np.zeros(env.num_envs)
    before = env.batch.get(ROBOT, "object.position")
    while first.any():
        observations, _, collided, cut, _ = env.step(policy(observations))
        after = env.batch.get(ROBOT, "object.position")
        seconds[first] += env.dt
        metres += np.where(first, np.linalg.norm(after - before, axis=1), 0.0)
        before = after
        first &= ~(collided | cut)
    return seconds, metres


def learn(env, seconds: float) -> np.ndarray:
    """Return the mean of the distribution after training for a time, in seconds of real time."""
    random = np.random.default_rng(0)
    mean, deviation = np.zeros(Policy.size(env)), np.ones(Policy.size(env))
    begin = last = time.monotonic()
    generation, spent = 0, 0.0
    print("generation   steps    mean   elite    best   deviation   env steps/s")
    # A generation is not started if it would probably exceed the training time.
    while last - begin + spent < seconds:
        steps = round(STEPS[0] + (STEPS[1] - STEPS[0]) * (last - begin) / seconds)
        weights = mean + deviation * random.normal(size=(CANDIDATES, mean.size))
        policy = Policy(env, np.repeat(weights, WORLDS, axis=0))
        earned = returns(env, policy, generation * env.num_envs, steps).reshape(CANDIDATES, WORLDS).mean(axis=1)
        best = np.argsort(-earned)[:ELITE]
        mean += 0.7 * (weights[best].mean(axis=0) - mean)
        # The deviation is increased, mostly at first, so that the distribution does not become narrow too early.
        deviation = weights[best].std(axis=0) + 0.05 + 0.3 * 0.9**generation
        now = time.monotonic()
        spent, last = now - last, now
        print(
            f"{generation:10}   {steps:5}  {earned.mean():6.1f}  {earned[best].mean():6.1f}  {earned.max():6.1f}"
            f"   {deviation.mean():9.3f}   {env.num_envs * steps / spent:11.0f}",
            flush=True,
        )
        generation += 1
    return mean


def main() -> None:
    parser = argparse.ArgumentParser(description="A Pioneer learns to avoid walls.")
    parser.add_argument("--seconds", type=float, default=300.0, help="training time, s of real time (default: 300)")
    parser.add_argument("--save", metavar="FILE", help="write the trained weights to a NumPy file")
    args = parser.parse_args()

    env = make_vec(SCENE, CANDIDATES * WORLDS)
    untrained = np.zeros(Policy.size(env))
    trained = learn(env, args.seconds)
    env.close()
    if args.save:
        np.save(args.save, trained)

    unseen = make_vec(SCENE, len(UNSEEN))
    before, after = compare(unseen, untrained), compare(unseen, trained)
    unseen.close()
    print(f"\n{len(UNSEEN)} unseen arenas   until the first collision (at most 60 s)")
    print("            mean s   median s   least s   mean m")
    for name, (seconds, metres) in (("untrained", before), ("trained", after)):
        row = f"{seconds.mean():6.1f}   {np.median(seconds):8.1f}   {seconds.min():7.1f}   {metres.mean():6.2f}"
        print(f"{name:10}  {row}")
    print(f"ratio       {after[0].mean() / before[0].mean():6.2f}")


if __name__ == "__main__":
    main()
