"""Changes of single channels and of rows that kinds of wrong logs are made of."""

import numpy as np


def changed(frame, name, change):
    return frame.assign(**{name: change(frame[name].to_numpy(float).copy())})


def every(frame, names, change):
    for name in names:
        frame = changed(frame, name, change)
    return frame


def remade(frame, rows):
    """Some rows, under an even clock."""
    return frame.iloc[rows].reset_index(drop=True).assign(time=frame["time"].to_numpy()[: len(rows)])


def fastest(x, width=200):
    """Where a channel moves most."""
    speed = np.convolve(np.abs(np.diff(x)), np.ones(width), "same")
    return int(np.argmax(speed[width:-width])) + width
