#python
# Turns to the red ball in the camera's image, and follows it at a distance. At the end, saves two pictures in the
# working folder: the ways of robot and ball, and the last image with the ball marked.
#
# Needs: pip install opencv-python-headless matplotlib

import cv2
import matplotlib.pyplot as plt
import numpy as np

CRUISE = 4.0  # rad/s of the wheels
TURN = 3.0  # rad/s, if the ball is at the edge of the image
BALL = 0.15  # m, its radius
DISTANCE = 0.7  # m


def sysCall_init():
    sim = require("sim")
    self.robot = sim.getObject("..")
    self.ball = sim.getObject("/ball")
    self.camera = sim.getObject("./camera")
    self.wheels = [sim.getObject("./Pioneer_p3dx_%sMotor" % side) for side in ("left", "right")]
    self.image = self.circle = None
    self.ways = []


def find_ball():
    """Returns column, row and radius of the ball in the image, in pixels, or None."""
    data, (columns, rows) = sim.getVisionSensorImg(self.camera)
    # The lowest row of the image comes first, and its pixels are red, green, blue; OpenCV expects blue, green, red.
    image = np.frombuffer(data, np.uint8).reshape(rows, columns, 3)
    self.image = cv2.cvtColor(cv2.flip(image, 0), cv2.COLOR_RGB2BGR)
    hue, saturation, value = cv2.split(cv2.cvtColor(self.image, cv2.COLOR_BGR2HSV))
    red = ((hue < 8) | (hue > 172)) & (saturation > 150) & (value > 40)
    found, _ = cv2.findContours(red.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    if not found:
        return None
    (column, row), radius = cv2.minEnclosingCircle(max(found, key=cv2.contourArea))
    return (column, row, radius) if radius > 2 else None


def sysCall_sensing():
    self.circle = find_ball()
    self.ways.append(sim.getObjectPosition(self.robot)[:2] + sim.getObjectPosition(self.ball)[:2])


def sysCall_actuation():
    ahead, turn = 0.0, TURN / 2  # looks around
    if self.circle:
        column, _, radius = self.circle
        half = self.image.shape[1] / 2
        focal = half / np.tan(np.radians(57) / 2)
        ahead = np.clip(8 * (focal * BALL / radius - DISTANCE), -CRUISE, CRUISE)
        turn = TURN * (column - half) / half
    left, right = self.wheels
    sim.setJointTargetVelocity(left, ahead + turn)
    sim.setJointTargetVelocity(right, ahead - turn)


def sysCall_cleanup():
    ways = np.array(self.ways)
    plt.figure(figsize=(5, 5))
    plt.plot(ways[:, 0], ways[:, 1], label="robot")
    plt.plot(ways[:, 2], ways[:, 3], "r--", label="ball")
    plt.axis("equal")
    plt.xlabel("x, m")
    plt.ylabel("y, m")
    plt.legend()
    plt.savefig("followed.png")
    if self.circle:
        column, row, radius = self.circle
        cv2.circle(self.image, (round(column), round(row)), round(radius), (0, 255, 255), 1)
    cv2.imwrite("seen.png", self.image)
    print("the ball is %.2f m away" % np.linalg.norm(ways[-1, :2] - ways[-1, 2:]))
