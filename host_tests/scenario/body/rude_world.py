#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The guide's quadrotor with bad manners, from a stated frame on. Usage: rude_world.py PORT MANNER FRAME GUIDE_WORLDS"""
import os
import socket
import sys
import types


def main():
    port, manner, first = int(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    sys.path.insert(0, sys.argv[4])
    sys.dont_write_bytecode = True
    import quadrotor  # found by the path above
    world = quadrotor.World(types.SimpleNamespace(wind=[0.0, 0.0, 0.0], turbulence=0.0, seed=1, drag=0.3, rotor_lag=0.025,
                                                  mass=3.3))
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.bind(("127.0.0.1", port))
    last, before = -1, ""
    while True:
        packet, sender = line.recvfrom(256)
        _, rate, frame, *pulses = quadrotor.SERVO.unpack(packet)
        again, last = frame == last, frame
        rude = frame >= first
        once = frame == first and not again
        if not again:
            world.step(pulses, (0.02 if rude and manner == "slow_rate" else 1.0 / rate))
        if rude and manner == "restarts":
            world.time -= 1000.0 if once else 0.0
        text = world.answer()
        if rude and manner == "dies":
            os._exit(3)
        if rude and manner == "hangs" or once and manner == "loses":
            continue
        if rude and manner == "malformed":
            text = text[:100]
        if rude and manner == "not_a_number":
            text = text.replace(str(world.position.tolist()[2]), "NaN")
        if rude and manner == "no_velocity":
            text = text.replace("velocity", "speed")
        if rude and manner == "late" and before:
            line.sendto(before.encode(), sender)  # the answer to the frame before comes once more, ahead of this one
        if rude and manner == "stands_still":
            text = before
        before = text if not (rude and manner == "stands_still") else before
        for _ in range(2 if rude and manner == "doubles" else 1):
            line.sendto(("\n" + text + "\n").encode(), sender)


main()
