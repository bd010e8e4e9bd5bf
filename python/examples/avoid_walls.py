"""A Pioneer learns to avoid walls, by the cross-entropy method in NumPy alone.

    python avoid_walls.py                   five minutes
    python avoid_walls.py --seconds 30      a shorter try

The policy is linear: the closeness that 16 sonars report, times weights, plus a bias, gives the speeds of both wheels.
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
#: Vectors of weights in a generation, worlds in which each of them drives, and the number of the best of them.
CANDIDATES, WORLDS, ELITE = 32, 2, 6
#: Steps of the environment, of 0.1 s, that the first and the last generation drive.
STEPS = 150, 300
#: Seeds of the arenas of the comparison; those of training are below 1,000,000.
UNSEEN = [1_000_000 + n for n in range(20)]


class Policy:
    """Linear policies, one for each world."""

    def __init__(self, env, weights: np.ndarray):
        inputs, outputs = env.single_observation_space.shape[0], env.single_action_space.shape[0]
        low, high = env.single_action_space.low, env.single_action_space.high
        self.middle, self.half = (low + high) / 2, (high - low) / 2
        self.weights = weights.reshape(-1, outputs, inputs + 1)

    @staticmethod
    def size(env) -> int:
        """Number of weights."""
        return (env.single_observation_space.shape[0] + 1) * env.single_action_space.shape[0]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        x = np.einsum("noi,ni->no", self.weights[:, :, :-1], observations) + self.weights[:, :, -1]
        return self.middle + self.half * np.tanh(x)


def returns(env, policy: Policy, seed: int, steps: int) -> np.ndarray:
    """What each world earns in a fixed time. A world whose robot has collided begins anew, and goes on earning."""
    observations, _ = env.reset(seed=seed)
    total = np.zeros(env.num_envs)
    for _ in range(steps):
        observations, rewards, *_ = env.step(policy(observations))
        total += rewards
    return total


def compare(env, weights: np.ndarray):
    """Seconds until the first collision, and metres driven until then, in arenas that training has not seen."""
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
    """The mean of the distribution after training for a time of the clock."""
    random = np.random.default_rng(0)
    mean, deviation = np.zeros(Policy.size(env)), np.ones(Policy.size(env))
    begin = last = time.monotonic()
    generation, spent = 0, 0.0
    print("generation   steps    mean   elite    best   deviation   env steps/s")
    # No generation is begun that would probably end too late.
    while last - begin + spent < seconds:
        steps = round(STEPS[0] + (STEPS[1] - STEPS[0]) * (last - begin) / seconds)
        weights = mean + deviation * random.normal(size=(CANDIDATES, mean.size))
        policy = Policy(env, np.repeat(weights, WORLDS, axis=0))
        earned = returns(env, policy, generation * env.num_envs, steps).reshape(CANDIDATES, WORLDS).mean(axis=1)
        best = np.argsort(-earned)[:ELITE]
        mean += 0.7 * (weights[best].mean(axis=0) - mean)
        # More than the deviation of the best, above all at first: the distribution must not become narrow too soon.
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
    parser.add_argument("--seconds", type=float, default=300.0, help="how long it trains, by the clock (default: 300)")
    parser.add_argument("--save", metavar="FILE", help="write the trained weights, as a file of NumPy")
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
