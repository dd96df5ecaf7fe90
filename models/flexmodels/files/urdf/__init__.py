"""URDF: in and out."""
