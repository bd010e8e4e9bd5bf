"""Environments for Gymnasium, described by the table `[env]` of a scene.

    import tatu_sim.gym

    env = tatu_sim.gym.make_env("learn/avoid_walls.toml")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

- `Env`: one world; `VectorEnv`: many worlds, stepped together on all cores, with results bit-identical to `Env`.
- `docs/guide/learning.md` describes the table, and how a dict replaces its keys.

Importing this module registers `Tatu-v0`: `gymnasium.make("tatu_sim.gym:Tatu-v0", scene=...)`.
"""

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

try:
    import gymnasium
except ImportError as e:
    raise ImportError('tatu_sim.gym requires Gymnasium 1.1 or later; run `pip install "tatu-sim[gym]"`') from e

from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ._episodes import Episodes
from ._world import PathLike

__all__ = ["Env", "VectorEnv", "make_env", "make_vec"]

RENDER_MODES = ["rgb_array"]


def _spaces(episodes: Episodes) -> Tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
    """Return the spaces of observations and actions of a single world."""
    dtype = episodes.dtype
    low, high = episodes.observe_bounds
    observe = gymnasium.spaces.Box(low, high, dtype=dtype)
    return observe, gymnasium.spaces.Box(episodes.act_low.astype(dtype), episodes.act_high.astype(dtype), dtype=dtype)


def _metadata(episodes: Episodes) -> Dict[str, Any]:
    return {"render_modes": RENDER_MODES, "render_fps": max(1, round(1 / episodes.dt))}


def _check_render_mode(render_mode: Optional[str]) -> Optional[str]:
    if render_mode is not None and render_mode not in RENDER_MODES:
        raise ValueError(f"there is no render mode {render_mode!r}; expected None or 'rgb_array'")
    return render_mode


def _changes(options: Optional[Mapping[str, Any]]) -> Optional[Mapping[str, Any]]:
    """Return the changes to the scene for one episode, from the options of a reset."""
    for key in options or {}:
        if key not in ("set", "reset_mask"):
            raise ValueError(f"unknown option {key!r} of `reset`; expected 'set' (a dict of changes) or 'reset_mask'")
    return (options or {}).get("set")


class Env(gymnasium.Env):
    """An environment with one world.

    `reset` draws the seed of the world, and then the changes of `[env.random]`, from `np_random`, and returns both as
    `info["seed"]` and `info["random"]`. Its option `set` makes further changes for one episode. `env.batch` is the
    underlying `tatu_sim.Batch` of one world.

    Args:
        scene: A scene file, or the name of a scene that comes with the package.
        text, folder: The text of a scene file, instead of `scene`, and the folder to which its paths are relative.
        env: Keys that replace those of the scene's table `[env]`; the value None removes a key.
        set: Changes to the scene: `{"/Robot/leftMotor.max_force_nm": 2.0}`.
        reward: A function of observations, actions and watched values, `f(obs, act, watch)`, all with one row per
            world; it returns an array with one number per world, which is added to the terms of the table.
        end: A function with the same arguments, which returns whether the episode ends.
        render_mode: `"rgb_array"`, or None.
        camera, size: The camera for `render`, by default the scene's first camera; columns and rows of a picture.
        dtype: Type of observations and actions.
        threads, scripts, allow, languages, plugins, files, quiet: As for `tatu_sim.Batch`.

    Raises:
        ValueError: The description is invalid. The message states the location, and what was expected.
        tatu_sim.Error: The scene is invalid.
    """

    metadata = {"render_modes": RENDER_MODES}

    def __init__(
        self,
        scene: Optional[PathLike] = None,
        *,
        render_mode: Optional[str] = None,
        camera: Optional[str] = None,
        size: Tuple[int, int] = (640, 480),
        threads: int = 1,
        **description: Any,
    ):
        self.render_mode = _check_render_mode(render_mode)
        self._camera, self._size = camera, size
        self._episodes = Episodes(1, scene, threads=threads, **description)
        self.batch = self._episodes.batch
        self.metadata = _metadata(self._episodes)
        self.observation_space, self.action_space = _spaces(self._episodes)
        self._begun = False

    @property
    def dt(self) -> float:
        """Length of a step of the environment, s of simulated time."""
        return self._episodes.dt

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[np.ndarray, Dict[str, Any]]:
        """Start an episode; return the first observation and the info."""
        super().reset(seed=seed)
        infos = self._episodes.begin([0], [self.np_random], _changes(options))
        self._begun = True
        return self._episodes.observe()[0], infos[0]

    def step(self, action: Any) -> Tuple[np.ndarray, float, bool, bool, Dict[str, Any]]:
        """Run a step. The action is clipped to the bounds of its space."""
        if not self._begun:
            raise ResetNeeded("no episode has been started: call `reset` before `step`")
        observations, rewards, ended, cut = self._episodes.advance(action)
        return observations[0], float(rewards[0]), bool(ended[0]), bool(cut[0]), {}

    def render(self) -> Optional[np.ndarray]:
        """Render a picture: rows, columns and RGB (`uint8`). Return None without a render mode."""
        return self._episodes.picture(0, self._camera, self._size) if self.render_mode else None

    def close(self) -> None:
        """End the world."""
        self._episodes.close()


class VectorEnv(gymnasium.vector.VectorEnv):
    """An environment with many worlds, stepped together on all cores.

    Results are bit-identical to those of `gymnasium.vector.SyncVectorEnv` with `Env`s, for any number of threads.

    Args:
        scene: As for `Env`.
        num_envs: Number of worlds.
        autoreset_mode: When worlds whose episode is over are reset: in the next step, in the same step, or not
            automatically (`AutoresetMode.DISABLED`), but by `reset(options={"reset_mask": mask})`.
        threads: Number of threads; by default the number of cores.
        render_mode, camera, size: As for `Env`; `render` returns one picture for each world.
        description: All other arguments of `Env`.
    """

    metadata = {"render_modes": RENDER_MODES}

    def __init__(
        self,
        scene: Optional[PathLike] = None,
        num_envs: int = 1,
        *,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        render_mode: Optional[str] = None,
        camera: Optional[str] = None,
        size: Tuple[int, int] = (640, 480),
        threads: Optional[int] = None,
        **description: Any,
    ):
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.render_mode = _check_render_mode(render_mode)
        self._camera, self._size = camera, size
        self._episodes = Episodes(num_envs, scene, threads=threads, **description)
        self.batch = self._episodes.batch
        self.metadata = {**_metadata(self._episodes), "autoreset_mode": self.autoreset_mode}
        self.single_observation_space, self.single_action_space = _spaces(self._episodes)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._randoms: List[Optional[np.random.Generator]] = [None] * num_envs
        self._seeds: List[Optional[int]] = [None] * num_envs
        self._begun = np.zeros(num_envs, dtype=bool)
        #: Mask of the worlds whose episode is over.
        self._over = np.zeros(num_envs, dtype=bool)

    @property
    def dt(self) -> float:
        """Length of a step of the environment, s of simulated time."""
        return self._episodes.dt

    @property
    def np_random(self) -> Tuple[np.random.Generator, ...]:
        """The random number generators of the worlds."""
        return tuple(self._random(world) for world in range(self.num_envs))

    @property
    def np_random_seed(self) -> Tuple[int, ...]:
        """The seeds of the generators."""
        _ = self.np_random
        return tuple(self._seeds)

    def _random(self, world: int) -> np.random.Generator:
        if self._randoms[world] is None:
            self._randoms[world], self._seeds[world] = seeding.np_random()
        return self._randoms[world]

    def reset(
        self,
        *,
        seed: Union[None, int, Sequence[Optional[int]]] = None,
        options: Optional[Dict[str, Any]] = None,
    ) -> Tuple[np.ndarray, Dict[str, Any]]:
        """Start an episode in all worlds, or in those that the option `reset_mask` selects.

        An integer sets the seeds of the worlds to `seed`, `seed + 1` and so on; a list sets the seed of each world.
        """
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + world for world in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds were given for {self.num_envs} worlds; expected one for each")
        worlds = np.arange(self.num_envs)
        if options is not None and "reset_mask" in options:
            mask = options["reset_mask"]
            fits = isinstance(mask, np.ndarray) and mask.dtype == bool and mask.shape == (self.num_envs,)
            if not fits or not mask.any():
                expected = f"an array of {self.num_envs} bools, not all False"
                raise ValueError(f"`reset_mask` must be {expected}; found {mask!r}")
            worlds = np.flatnonzero(mask)
        for world in worlds:
            if seeds[world] is not None:
                self._randoms[world], self._seeds[world] = seeding.np_random(seeds[world])
        infos = self._begin(worlds, {}, _changes(options))
        return self._episodes.observe(), infos

    def step(self, actions: Any) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Dict[str, Any]]:
        """Run a step in all worlds. Actions are clipped to the bounds of their space.

        In the mode `NEXT_STEP`, a world whose episode is over is reset instead of being stepped.
        """
        if not self._begun.all():
            world = int(np.argmin(self._begun))
            raise ResetNeeded(f"no episode has been started in world {world}: call `reset` before `step`")
        infos: Dict[str, Any] = {}
        if not self._over.any():
            return self._step(actions, None, infos)
        over = np.flatnonzero(self._over)
        if self.autoreset_mode is AutoresetMode.DISABLED:
            raise ResetNeeded(
                f"the episode of world {over[0]} is over, and `autoreset_mode` is DISABLED: reset it by "
                '`reset(options={"reset_mask": terminated | truncated})`'
            )
        stepped = ~self._over
        if stepped.any():
            _, rewards, ended, cut, _ = self._step(actions, stepped, infos)
        else:
            rewards, ended, cut = np.zeros(self.num_envs), *np.zeros((2, self.num_envs), dtype=bool)
        self._begin(over, infos)
        return self._episodes.observe(), rewards, ended, cut, infos

    def _step(self, actions, worlds, infos):
        observations, rewards, ended, cut = self._episodes.advance(actions, worlds)
        self._over = ended | cut
        if self.autoreset_mode is AutoresetMode.SAME_STEP and self._over.any():
            over = np.flatnonzero(self._over)
            for world in over:
                self._add_info(infos, {"final_obs": observations[world].copy(), "final_info": {}}, world)
            self._begin(over, infos)
            observations = self._episodes.observe()
        return observations, rewards, ended, cut, infos

    def _begin(self, worlds: np.ndarray, infos: Dict[str, Any], changes: Optional[Mapping[str, Any]] = None):
        """Start an episode in each of these worlds, and add its info to `infos`."""
        began = self._episodes.begin([int(w) for w in worlds], [self._random(w) for w in worlds], changes)
        for world, info in zip(worlds, began):
            infos = self._add_info(infos, info, world)
        self._begun[worlds] = True
        self._over[worlds] = False
        return infos

    def render(self) -> Optional[Tuple[np.ndarray, ...]]:
        """Render a picture of each world: rows, columns and RGB (`uint8`). Return None without a render mode."""
        if not self.render_mode:
            return None
        return tuple(self._episodes.picture(world, self._camera, self._size) for world in range(self.num_envs))

    def close_extras(self, **_: Any) -> None:
        """End all worlds."""
        if hasattr(self, "_episodes"):
            self._episodes.close()


def make_env(scene: Optional[PathLike] = None, **arguments: Any) -> Env:
    """Create an environment with one world; the arguments are those of `Env`."""
    return Env(scene, **arguments)


def make_vec(scene: Optional[PathLike] = None, num_envs: int = 1, **arguments: Any) -> VectorEnv:
    """Create an environment with many worlds; the arguments are those of `VectorEnv`."""
    return VectorEnv(scene, num_envs, **arguments)


if "Tatu-v0" not in gymnasium.registry:
    gymnasium.register("Tatu-v0", entry_point="tatu_sim.gym:Env", vector_entry_point="tatu_sim.gym:VectorEnv")
