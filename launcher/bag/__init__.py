"""Bags: recordings of topics in the formats of rosbag2, read and written without ROS.

A bag is a folder with `metadata.yaml` and storage files: MCAP, or SQLite for reading.
"""
