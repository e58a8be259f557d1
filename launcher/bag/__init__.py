"""Bags: recordings of topics in the formats of rosbag2, read and written without ROS.

A bag is a folder with `metadata.yaml` and storage files: MCAP, or SQLite for reading. May import
the core and `ros`; only `ros/` below needs rclpy.

Doors:

* `verbs/`: `bag record`, `play`, `info`, `check`, `convert`, `compare`.
* `reader` and `writer`: bags as messages in order of time; `bag_model` is their data, `metadata`
  the file of that name. `decode` turns messages into values (by `cdr`), `snapshot_folder` makes a
  folder about the last seconds of a run: bag, logs, events and plan. `transforms` is for `tf`.
* `flight/`: the part of a run with `--record`; `ros/flight` is its process, the flight recorder.
  `comparing/topic_traits`: what is typical of a topic, also for smoke.

Files: `mcap/` and `sqlite_file` read storage files, `compression` what they compress; `check` says
what is wrong with them, and mends it.

What is known of a bag: `info`, with `topic_course` (rates, gaps) and calls of services;
`topic_selection` of topics; `agreement` is what of a topic has one type, also as other recorders
write it; `quantity_texts` are numbers as rosbag2 prints them.

Folders: `converting/` (`convert` writes what `merged_bags` gives of several bags, `text_tables` CSV
and JSON lines, `output_options` reads the YAML file of rosbag2), `comparing/` (`compare`, with
`topic_traits`: what is typical of one, and `field_difference`: contents), `flight/`, `ros/`.
"""
