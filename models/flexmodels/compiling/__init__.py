"""The C compiler of this machine, and what it made before."""
