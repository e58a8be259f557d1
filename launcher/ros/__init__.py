"""The ROS graph: who talks to whom. The only part of the launcher that imports rclpy.

Never imported by the supervisor: rclpy brings threads and signal handlers.
"""
