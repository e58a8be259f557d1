"""What only the operating system makes necessary: the reactor, spawning, limits, /proc."""
