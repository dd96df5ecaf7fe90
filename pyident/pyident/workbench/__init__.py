"""The workbench: the loop of compare, diagnose and add in a browser, on one folder of files.

Everything it shows and changes are files that the command line reads and writes. It calls the front door of
pyident and nothing deeper. Needs the extra `flexident[workbench]`.
"""
