"""The process on a host that runs what a launcher elsewhere tells it to (engine `ssh`)."""
