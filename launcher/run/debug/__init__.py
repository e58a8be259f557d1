"""The verb `debug`: starts a process under debugpy."""
