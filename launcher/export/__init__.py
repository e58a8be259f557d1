"""Files for other supervisors, made from a plan: systemd, Kubernetes, Compose, Podman."""
