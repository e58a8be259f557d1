"""What the nodes decide and exchange, without rclpy: unit tests need no DDS."""
