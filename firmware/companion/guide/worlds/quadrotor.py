#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A quadrotor in "X" as a physics program for ArduPilot's JSON interface (SIM_JSON): numpy, and nothing else.

Usage: quadrotor.py PORT [--wind N,E,D] [--turbulence S] [--seed I] [--drag K] [--rotor-lag T] [--mass M]

Copy it to connect another simulator: World.step() is the only part that knows physics. Frames are the interface's own:
north-east-down, and forward-right-down in the body.
"""
import argparse
import json
import socket
import struct

import numpy as np

GRAVITY = 9.8066  # m/s^2
SERVO = struct.Struct("<HHI16H")  # magic, frame rate [1/s], frame count, pulse widths [us]
MAGIC = 18458

# Rotors in ArduPilot's order: front right, rear left (counter-clockwise), front left, rear right (clockwise).
ARM = 0.325 / np.sqrt(2.0)  # m, forward and sideways: 0.65 m across the diagonal, as published for the M100
ROTOR_X = ARM * np.array([1.0, -1.0, 1.0, -1.0])
ROTOR_Y = ARM * np.array([1.0, -1.0, -1.0, 1.0])
TURNS = np.array([1.0, 1.0, -1.0, -1.0])  # the torque on the body about z, down: a rotor pushes the body the other way
TORQUE_PER_THRUST = 0.02  # m, a 13 inch propeller
FULL_THRUST = 21.0  # N for each rotor
INERTIA = np.array([0.062, 0.068, 0.112])  # kg m^2: four arms and motors of 0.19 kg, a box of 0.30 x 0.25 x 0.20 m


def cross(a, b):
    """numpy's own cross product takes ten times as long for single vectors."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def rotation(q):
    """The matrix that turns body vectors into world vectors, of a quaternion (w, x, y, z)."""
    w, x, y, z = q.tolist()
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Air:
    """A mean wind, and turbulence as Dryden's longitudinal form on all three axes."""

    LENGTH = 2.0  # m

    def __init__(self, mean, sigma, seed):
        self.mean, self.sigma = mean, sigma
        self.random = np.random.default_rng(seed)
        self.gust = np.zeros(3)

    def step(self, dt):
        if self.sigma > 0.0:
            keep = np.exp(-dt * max(1.0, np.sqrt(self.mean @ self.mean)) / self.LENGTH)
            self.gust = keep * self.gust + self.sigma * np.sqrt(1.0 - keep * keep) * self.random.standard_normal(3)
        return self.mean + self.gust


class World:
    """Six degrees of freedom, four rotors with lag, rotor drag, wind, and a ground at height 0."""

    def __init__(self, options):
        self.options = options
        self.reset()

    def reset(self):
        self.time = 0.0
        self.air = Air(np.array(self.options.wind), self.options.turbulence, self.options.seed)
        self.position, self.velocity = np.zeros(3), np.zeros(3)
        self.attitude, self.rate = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
        self.rotors = np.zeros(4)  # speed, as a share of full speed
        self.force = np.array([0.0, 0.0, -GRAVITY])  # specific force in the body

    def step(self, pulses, dt):
        """One time step with these pulse widths: 1000 us stops a rotor, 2000 us is full speed."""
        command = np.clip((np.array(pulses[:4]) - 1000.0) / 1000.0, 0.0, 1.0)
        self.rotors += (1.0 - np.exp(-dt / self.options.rotor_lag)) * (command - self.rotors)
        thrust = FULL_THRUST * self.rotors * self.rotors
        # Forces act in the middle of the step, or the motion would lag the attitude by half a step: 1 ms looks like drag.
        to_world = rotation(self.turned(self.rate, 0.5 * dt))
        # Rotor drag: against the air's motion across the rotors, in proportion to their speed; K at hover.
        hover = np.sqrt(self.options.mass * GRAVITY / (4.0 * FULL_THRUST))
        through_air = to_world.T @ (self.velocity - self.air.step(dt))
        drag = -self.options.drag * float(self.rotors.sum()) / (4.0 * hover) * through_air
        force = np.array([drag[0], drag[1], -float(thrust.sum()) / self.options.mass])
        torque = np.array([-(ROTOR_Y @ thrust), ROTOR_X @ thrust, TORQUE_PER_THRUST * (TURNS @ thrust)])

        turned = 0.5 * dt * (torque - cross(self.rate, INERTIA * self.rate)) / INERTIA
        self.attitude = self.turned(self.rate + turned, dt)
        self.rate = self.rate + 2.0 * turned
        acceleration = to_world @ force
        acceleration[2] += GRAVITY
        before = self.position
        self.position = self.position + dt * self.velocity + 0.5 * dt * dt * acceleration
        self.velocity = self.velocity + dt * acceleration
        self.time += dt
        self.force = force
        if self.position[2] >= 0.0:
            self.stand(before)

    def turned(self, rate, dt):
        """The attitude after a turn at this rate."""
        w, x, y, z = self.attitude.tolist()
        p, q, r = (0.5 * dt * rate).tolist()
        out = np.array([w - p * x - q * y - r * z, x + p * w + r * y - q * z,
                        y + q * w - r * x + p * z, z + r * w + q * x - p * y])
        return out / np.sqrt(out @ out)

    def stand(self, before):
        """The ground carries it where it was before, level, with its heading kept."""
        w, _, _, z = self.attitude.tolist()
        self.attitude = np.array([w, 0.0, 0.0, z]) / np.hypot(w, z)
        self.position = before * np.array([1.0, 1.0, 0.0])
        self.velocity, self.rate = np.zeros(3), np.zeros(3)
        self.force = np.array([0.0, 0.0, -GRAVITY])

    def answer(self):
        return json.dumps({"timestamp": self.time,
                           "imu": {"gyro": self.rate.tolist(), "accel_body": self.force.tolist()},
                           "position": self.position.tolist(), "velocity": self.velocity.tolist(),
                           "quaternion": self.attitude.tolist(),
                           "velocity_wind": (self.air.mean + self.air.gust).tolist()})


def serve(world, port):
    """Answers every servo packet with the state one step later. A frame count that goes back is a restart."""
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.bind(("127.0.0.1", port))
    last = -1
    while True:
        packet, sender = line.recvfrom(256)
        if len(packet) != SERVO.size:
            continue
        magic, rate, frame, *pulses = SERVO.unpack(packet)
        if magic != MAGIC or rate == 0:
            continue
        if frame < last:
            world.reset()
        if frame != last:  # the same count again: the answer was lost, and is sent once more
            world.step(pulses, 1.0 / rate)
        last = frame
        line.sendto(("\n" + world.answer() + "\n").encode(), sender)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("port", type=int)
    words.add_argument("--wind", type=lambda text: [float(word) for word in text.split(",")], default=[0.0, 0.0, 0.0],
                       metavar="N,E,D", help="velocity of the air [m/s]")
    words.add_argument("--turbulence", type=float, default=0.0, help="standard deviation on each axis [m/s]")
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--drag", type=float, default=0.3, help="rotor drag at hover [1/s]")
    words.add_argument("--rotor-lag", type=float, default=0.025, help="time constant of the rotors' speed [s]")
    words.add_argument("--mass", type=float, default=3.3, help="[kg]; the paper's aircraft")
    options = words.parse_args()
    serve(World(options), options.port)


if __name__ == "__main__":
    main()
