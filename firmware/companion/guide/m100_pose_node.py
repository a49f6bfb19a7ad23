#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A ROS 1 node: geometry_msgs/PoseStamped, ENU, to m100 fly --pose-port udp:127.0.0.1:14560 --pose-from 1:240; publishes its state."""
import math
import rospy
from geometry_msgs.msg import PoseStamped
from pymavlink import mavutil

rospy.init_node("m100_pose")
link = mavutil.mavlink_connection("udpout:127.0.0.1:14560", source_system=1, source_component=240, dialect="common")
state = rospy.Publisher("m100/pose", PoseStamped, queue_size=10)

def to_ned(q):
    """ENU, forward left up -> NED, forward right down."""
    s = math.sqrt(0.5)
    return [s * (q.w + q.z), s * (q.x + q.y), s * (q.x - q.y), s * (q.w - q.z)]

def on_pose(message):
    p = message.pose.position
    usec = message.header.stamp.to_nsec() // 1000
    link.mav.att_pos_mocap_send(usec, to_ned(message.pose.orientation), p.y, p.x, -p.z)

def listen(_):
    while True:
        message = link.recv_match(blocking=False)
        if message is None:
            return
        if message.get_type() == "TIMESYNC" and message.tc1 == 0:
            link.mav.timesync_send(rospy.Time.now().to_nsec(), message.ts1)
        elif message.get_type() == "LOCAL_POSITION_NED":
            out = PoseStamped()
            out.header.stamp = rospy.Time.now()
            out.pose.position.x, out.pose.position.y, out.pose.position.z = message.y, message.x, -message.z
            out.pose.orientation.w = 1.0
            state.publish(out)

rospy.Subscriber("pose", PoseStamped, on_pose, queue_size=1)
rospy.Timer(rospy.Duration(0.01), listen)
rospy.spin()
