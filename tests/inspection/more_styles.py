"""Four more habits: a German spreadsheet, a bag of a named arm, nested groups, counts without a header."""

from pathlib import Path

import numpy as np
import pandas as pd
from inspection.styles import DEG, N, Style, _truth

EVERY = range(1, N + 1)


def spreadsheet(f: pd.DataFrame, folder: Path) -> Style:
    """Semicolons, decimal commas, a row of units, compound words, torques of the other sign."""
    q, r, tau = (f[[f"{a}{k}" for k in EVERY]] for a in ("q", "r", "tau"))
    words = {"Istposition": DEG * q, "Sollposition": DEG * r, "Drehmoment": -tau}
    names = ["Uhrzeit", *(f"Achse{k}_{word}" for word in words for k in EVERY)]
    units = ["ms", *["Grad"] * (2 * N), *["Nm"] * N]
    rows = np.column_stack([1e3 * f["time"], *words.values()])
    lines = [";".join(names), ";".join(units)]
    lines += [";".join(f"{v:.8f}".replace(".", ",") for v in row) for row in rows]
    path = folder / "tabelle.csv"
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    truth = {"Uhrzeit": ("time", "ms", 1, 0.0)} | _truth("Achse{}_Istposition", "joint{}.e", "deg")
    truth |= _truth("Achse{}_Sollposition", "joint{}.r", "deg")
    return Style(path, truth | _truth("Achse{}_Drehmoment", "joint{}.tau", "N.m", -1))


def named_arm(f: pd.DataFrame, folder: Path) -> Style:
    """Three joints have numbers of their own, which are not those of the arm; commands come half as often."""
    from rosbags import rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {"state": "sensor_msgs/msg/JointState", "command": "std_msgs/msg/Float64MultiArray"}
    State, Command = (store.types[kind] for kind in kinds.values())
    Header, Layout = store.types["std_msgs/msg/Header"], store.types["std_msgs/msg/MultiArrayLayout"]
    Time = store.types["builtin_interfaces/msg/Time"]
    names = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
    with rosbag2.Writer(folder / "named", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        topics = {
            what: writer.add_connection(topic, kinds[what], typestore=store)
            for what, topic in (("state", "/arm/joint_states"), ("command", "/arm/streamed"))
        }
        for i, row in enumerate(f.to_dict("records")):
            ns = round(1e9 * row["time"])
            header = Header(stamp=Time(sec=5 + ns // 10**9, nanosec=ns % 10**9), frame_id="")
            q, dq, tau, r = (np.array([row[f"{a}{k}"] for k in EVERY]) for a in ("q", "dq", "tau", "r"))
            state = State(header=header, name=names, position=q, velocity=dq, effort=tau)
            messages = {"state": state}
            if i % 2 == 0:
                messages["command"] = Command(layout=Layout(dim=[], data_offset=0), data=r)
            for what, message in messages.items():
                writer.write(topics[what], ns, store.serialize_cdr(message, kinds[what]))  # pyright: ignore[reportArgumentType]
    truth = {"time": ("time", "s", 1, 0.0), "/arm/streamed/layout.data_offset": None}
    truth |= {f"{name}.position": (f"joint{k}.e", "rad", 1, 0.0) for k, name in enumerate(names, start=1)}
    truth |= {f"{name}.effort": (f"joint{k}.tau", "N.m", 1, 0.0) for k, name in enumerate(names, start=1)}
    truth |= {f"{name}.velocity": None for name in names}
    return Style(
        next((folder / "named").glob("*.mcap")), truth | _truth("/arm/streamed/data[{}]", "joint{}.r", "rad")
    )


def nested_groups(f: pd.DataFrame, folder: Path) -> Style:
    """A group per axis; axis 3 turns the other way, and its current with it; no unit anywhere."""
    import h5py

    path = folder / "nested.hdf5"
    with h5py.File(path, "w") as file:
        for k in EVERY:
            axis, sign = file.create_group(f"robot/axes/axis_{k}"), -1 if k == 3 else 1
            axis["measured/angle"] = sign * DEG * f[f"q{k}"].to_numpy()
            axis["measured/current"] = sign * f[f"tau{k}"].to_numpy() / 5
            axis["command/angle"] = sign * DEG * f[f"r{k}"].to_numpy()
        file["robot/t"] = f["time"].to_numpy()
    axis = "robot/axes/axis_{}/"
    truth = {"robot/t": ("time", "s", 1, 0.0)} | _truth(axis + "measured/angle", "joint{}.e", "deg")
    truth |= _truth(axis + "command/angle", "joint{}.r", "deg") | _truth(
        axis + "measured/current", "joint{}.tau", "1"
    )
    for what, name, unit in (
        ("measured/angle", "e", "deg"),
        ("command/angle", "r", "deg"),
        ("measured/current", "tau", "1"),
    ):
        truth[axis.format(3) + what] = (f"joint3.{name}", unit, -1, 0.0)
    return Style(path, truth, tuple(axis.format(k) + "measured/current" for k in EVERY))


def counts(f: pd.DataFrame, folder: Path) -> Style:
    """No header, columns in no order, positions in counts of an encoder behind a gear."""
    columns = {"time": f["time"]} | {f"tau{k}": f[f"tau{k}"] for k in EVERY}
    columns |= {f"q{k}": np.round(f[f"q{k}"] / (2 * np.pi) * 4096 * 100) for k in EVERY}
    order = [str(name) for name in np.random.default_rng(5).permutation(list(columns))]
    pd.DataFrame(columns)[order].to_csv(folder / "counts.csv", index=False, header=False)
    known = {"time": ("time", "s", 1, 0.0)}
    truth = {str(i): known.get(name, (name, "?", 1, 0.0)) for i, name in enumerate(order, start=1)}
    return Style(folder / "counts.csv", truth, tuple(i for i, said in truth.items() if said[0] != "time"))
