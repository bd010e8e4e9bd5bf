"""A small scene with an environment."""

# A sled on a rail in front of a wall, to which a noisy beam measures the distance. The motor is weak, so that the mass
# of the sled matters.
SLED = """
format = 1

[env]
seconds = 1.5
observe = [
  { object = "/rail/joint/sled/beam", field = "proximity.distance", zero = 3.0, low = 0.0, high = 3.0, scale = 0.5 },
  { object = "/rail/joint", field = "joint.velocity", low = -5.0, high = 5.0 },
  { object = "/rail/joint/sled", field = "object.world_pose", index = [0, 2], low = -2.0, high = 2.0 },
  { object = "/rail/joint/sled", field = "object.world_pose", reduce = "norm", low = 0.0, high = 4.0 },
]
act = [{ object = "/rail/joint", field = "joint.target_velocity", low = -3.0, high = 3.0 }]
reward = [
  { object = "/rail/joint", field = "joint.velocity", weight = 0.7 },
  { object = "/rail/joint/sled/beam", field = "proximity.distance", below = 0.3, weight = -1.5 },
  { object = "/rail/joint/sled", field = "object.world_pose", reduce = "mean", weight = 0.1 },
  { action = "norm", weight = -0.01 },
  { constant = 0.1 },
]
end = [
  { object = "/rail/joint", field = "joint.position", above = 0.7 },
  { object = "/rail/joint", field = "joint.position", below = -0.7 },
]

[env.watch]
position = { object = "/rail/joint", field = "joint.position" }

[env.random]
"/rail/joint/sled.mass_kg" = { log_uniform = [0.5, 5.0] }
"/rail/joint.max_force_n" = { normal = [8.0, 3.0], low = 2.0 }
"/wall.position_m" = { uniform = [[1.2, -0.1, 0.3], [1.6, 0.1, 0.3]] }
"/wall.color" = { choice = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }

[[object]]
kind = "shape"
alias = "rail"
size_m = [2.0, 0.05, 0.05]
position_m = [0.0, 0.0, 0.3]
detectable = false

[[object]]
kind = "joint"
alias = "joint"
parent = "/rail"
type = "prismatic"
control = "velocity"
orientation_deg = [0.0, 90.0, 0.0]
max_force_n = 8.0
limits_m = [-0.9, 0.9]

[[object]]
kind = "shape"
alias = "sled"
parent = "/rail/joint"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1.0
dynamic = true
detectable = false

[[object]]
kind = "sensor"
sensor = "proximity"
alias = "beam"
parent = "/rail/joint/sled"
range_m = 2.0
noise = { distance = { sigma = 0.02 } }

[[object]]
kind = "shape"
alias = "wall"
size_m = [0.1, 1.0, 1.0]
position_m = [1.4, 0.0, 0.3]
"""
