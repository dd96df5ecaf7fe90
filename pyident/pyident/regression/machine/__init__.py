"""This machine: compiled C and all of its cores."""
