"""A running ROS graph: reading, drawing, testing and using it. The only package that imports rclpy.

Never imported by the supervisor: rclpy brings threads and signal handlers.
"""
