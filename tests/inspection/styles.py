"""One recording of a six-axis arm, written in the styles of a dozen tools, with the truth of every column."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from pyident.sweep.studies.log_checks.swings import Motion, recorded, six_axes  # pyright: ignore[reportMissingImports]

from flexmodels.robot import Robot

N = 6
DEG = 180 / np.pi


@dataclass(frozen=True)
class Style:
    """file or folder; truth: column -> our name, unit, sign, offset in the unit; None: no signal of a log."""

    path: Path
    truth: Mapping[str, tuple[str, str, int, float] | None]
    asked: tuple[str, ...] = ()


def arm() -> Robot:
    return six_axes()


def sound(seconds: float = 8.0) -> pd.DataFrame:
    """time, q1.., dq1.., tau1.., r1.. in SI."""
    frame = recorded(six_axes(), Motion(duration=seconds), 21)
    rng = np.random.default_rng(0)
    out = {"time": frame["time"].to_numpy()}
    for k in range(1, N + 1):
        q = frame[f"joint{k}.e"].to_numpy()
        out[f"q{k}"], out[f"tau{k}"] = q, frame[f"joint{k}.tau"].to_numpy()
        out[f"dq{k}"] = np.gradient(q, out["time"])
        out[f"r{k}"] = q + 2e-3 * np.sin(out["time"] + k) + 1e-5 * rng.normal(size=len(q))
    return pd.DataFrame(out)


def _truth(pattern: str, name: str, unit: str, sign: int = 1, offset: float = 0.0, first: int = 1):
    return {pattern.format(k - 1 + first): (name.format(k), unit, sign, offset) for k in range(1, N + 1)}


def _nothing(pattern: str, first: int = 1):
    return {pattern.format(k - 1 + first): None for k in range(1, N + 1)}


def plain_csv(f: pd.DataFrame, folder: Path) -> Style:
    named = {f"{a}{k}": f"{a}_{k}" for a in ("q", "dq", "tau") for k in range(1, N + 1)}
    f[["time", *named]].rename(columns=named).to_csv(folder / "plain.csv", index=False)  # pyright: ignore[reportCallIssue]
    truth = {"time": ("time", "s", 1, 0.0)} | _truth("q_{}", "joint{}.e", "rad") | _nothing("dq_{}")
    return Style(folder / "plain.csv", truth | _truth("tau_{}", "joint{}.tau", "N.m"))


def german_csv(f: pd.DataFrame, folder: Path) -> Style:
    out = {"Zeit [s]": f["time"]}
    for text, a, factor in (("Winkel A{} [°]", "q", DEG), ("Drehzahl A{} [1/min]", "dq", 30 / np.pi),
                            ("Moment A{} [Nm]", "tau", 1)):  # fmt: skip
        out |= {text.format(k): factor * f[f"{a}{k}"] for k in range(1, N + 1)}
    path = folder / "deutsch.csv"
    pd.DataFrame(out).to_csv(path, sep=";", decimal=",", index=False, encoding="utf-8")
    truth = {"Zeit": ("time", "s", 1, 0.0)} | _truth("Winkel A{}", "joint{}.e", "deg")
    return Style(path, truth | _nothing("Drehzahl A{}") | _truth("Moment A{}", "joint{}.tau", "N.m"))


def no_header(f: pd.DataFrame, folder: Path) -> Style:
    q, dq, tau = ([f"{a}{k}" for k in range(1, N + 1)] for a in ("q", "dq", "tau"))
    blocks = [1e3 * f[["time"]], DEG * f[q], DEG * f[dq], f[tau]]
    pd.concat(blocks, axis=1).to_csv(folder / "bare.txt", sep="\t", index=False, header=False)
    truth = (
        {"1": ("time", "ms", 1, 0.0)} | _truth("{}", "joint{}.e", "deg", first=2) | _nothing("{}", first=8)
    )
    return Style(folder / "bare.txt", truth | _truth("{}", "joint{}.tau", "N.m", first=14))


def units_row(f: pd.DataFrame, folder: Path) -> Style:
    names = ["t", *(f"pos_axis{k}" for k in range(1, N + 1)), *(f"trq_axis{k}" for k in range(1, N + 1))]
    units = ["us", *["deg"] * N, *["mN m"] * N]
    data = np.column_stack([1e6 * f["time"], *(DEG * f[f"q{k}"] for k in range(1, N + 1)),
                            *(1e3 * f[f"tau{k}"] for k in range(1, N + 1))])  # fmt: skip
    lines = ["# recorded by a controller", ",".join(names), ",".join(units)]
    lines += [",".join(f"{v:.10g}" for v in row) for row in data]
    (folder / "units.csv").write_text("\n".join(lines) + "\n")
    truth = {"t": ("time", "us", 1, 0.0)} | _truth("pos_axis{}", "joint{}.e", "deg")
    return Style(folder / "units.csv", truth | _truth("trq_axis{}", "joint{}.tau", "mN.m"))  # pyright: ignore[reportArgumentType]


def cells_of_lists(f: pd.DataFrame, folder: Path) -> Style:
    out = {"timestamp": f["time"]}
    for name, a in (("position", "q"), ("velocity", "dq"), ("effort", "tau"), ("goal_position", "r")):
        out[name] = [str(row) for row in f[[f"{a}{k}" for k in range(1, N + 1)]].to_numpy().tolist()]
    pd.DataFrame(out).to_csv(folder / "lists.csv", index=False)
    truth = {"timestamp": ("time", "s", 1, 0.0)} | _truth("position[{}]", "joint{}.e", "rad")
    truth |= _nothing("velocity[{}]") | _truth("effort[{}]", "joint{}.tau", "N.m")
    return Style(folder / "lists.csv", truth | _truth("goal_position[{}]", "joint{}.r", "rad"))


def shuffled_parquet(f: pd.DataFrame, folder: Path) -> Style:
    out = {"time_ms": 1e3 * f["time"], "temperature_1": 40.0 + 0 * f["time"], "status": 0 * f["time"]}
    out |= {f"ActualPosition{k}": f[f"q{k}"] for k in range(1, N + 1)}
    out |= {f"TargetPosition{k}": f[f"r{k}"] for k in range(1, N + 1)}
    out |= {f"ActualTorque{k}": 1e-3 * f[f"tau{k}"] for k in range(1, N + 1)}
    order = np.random.default_rng(3).permutation(list(out))
    pd.DataFrame(out)[list(order)].to_parquet(folder / "shuffled.parquet")
    truth = {"time_ms": ("time", "ms", 1, 0.0), "temperature_1": None, "status": None}
    truth |= _truth("ActualPosition{}", "joint{}.e", "rad") | _truth("TargetPosition{}", "joint{}.r", "rad")
    return Style(folder / "shuffled.parquet", truth | _truth("ActualTorque{}", "joint{}.tau", "kN.m"))


def mat_struct(f: pd.DataFrame, folder: Path) -> Style:
    from scipy.io import savemat

    q = DEG * f[[f"q{k}" for k in range(1, N + 1)]].to_numpy().T
    tau = f[[f"tau{k}" for k in range(1, N + 1)]].to_numpy().T
    q[1] -= 90.0  # the zero of axis 2
    savemat(folder / "rec.mat", {"rec": {"t": f["time"].to_numpy(), "act_pos_deg": q, "act_torque_nm": tau}})
    truth = {"rec.t": ("time", "s", 1, 0.0)} | _truth("rec.act_pos_deg[{}]", "joint{}.e", "deg")
    truth["rec.act_pos_deg[2]"] = ("joint2.e", "deg", 1, 90.0)
    return Style(folder / "rec.mat", truth | _truth("rec.act_torque_nm[{}]", "joint{}.tau", "N.m"))  # pyright: ignore[reportArgumentType]


def mat_7_3(f: pd.DataFrame, folder: Path) -> Style:
    import h5py

    path = folder / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["Time"] = f[["time"]].to_numpy().T
        file["data/q"] = f[[f"q{k}" for k in range(1, N + 1)]].to_numpy().T
        file["data/qd"] = f[[f"dq{k}" for k in range(1, N + 1)]].to_numpy().T
        file["data/tau"] = f[[f"tau{k}" for k in range(1, N + 1)]].to_numpy().T
    head = b"MATLAB 7.3 MAT-file".ljust(124) + (0x0200).to_bytes(2, "little") + b"IM"
    with path.open("r+b") as file:
        file.write(head)
    truth = (
        {"Time": ("time", "s", 1, 0.0)} | _truth("data.q[{}]", "joint{}.e", "rad") | _nothing("data.qd[{}]")
    )
    return Style(path, truth | _truth("data.tau[{}]", "joint{}.tau", "N.m"))


def hdf5_two_rates(f: pd.DataFrame, folder: Path) -> Style:
    import h5py

    path = folder / "rates.h5"
    with h5py.File(path, "w") as file:
        file["encoder/time"] = f["time"].to_numpy()
        file["encoder/position"] = DEG * f[[f"q{k}" for k in range(1, N + 1)]].to_numpy()
        file["encoder/position"].attrs["unit"] = "deg"
        slow = f.iloc[::2]
        file["drive/time"] = slow["time"].to_numpy()
        file["drive/torque"] = 100 * slow[[f"tau{k}" for k in range(1, N + 1)]].to_numpy()
        file["drive/torque"].attrs["unit"] = "N cm"
    truth = {"encoder/time": ("time", "s", 1, 0.0), "drive/time": None}
    truth |= _truth("encoder/position[{}]", "joint{}.e", "deg")
    return Style(path, truth | _truth("drive/torque[{}]", "joint{}.tau", "N.cm"))


def mcap(f: pd.DataFrame, folder: Path) -> Style:
    from rosbags import rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    State, Header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    Time = store.types["builtin_interfaces/msg/Time"]
    names = [f"joint_{k}" for k in (3, 1, 2, 6, 4, 5)]
    with rosbag2.Writer(folder / "bag", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for _, row in f.iterrows():
            ns = round(1e9 * row["time"])  # pyright: ignore[reportArgumentType]
            header = Header(stamp=Time(sec=5 + ns // 10**9, nanosec=ns % 10**9), frame_id="")
            q, dq, tau = (np.array([row[f"{a}{n[-1]}"] for n in names]) for a in ("q", "dq", "tau"))
            message = State(header=header, name=names, position=q, velocity=dq, effort=-tau)
            writer.write(topic, ns, store.serialize_cdr(message, "sensor_msgs/msg/JointState"))  # pyright: ignore[reportArgumentType]
    truth = {"time": ("time", "s", 1, 0.0)} | _truth("joint_{}.position", "joint{}.e", "rad")
    truth |= _nothing("joint_{}.velocity") | _truth("joint_{}.effort", "joint{}.tau", "N.m", -1)
    return Style(next((folder / "bag").glob("*.mcap")), truth)


def lerobot(f: pd.DataFrame, folder: Path) -> Style:
    import json

    root, names = folder / "set", [f"joint_{k}.pos" for k in range(1, N + 1)]
    (root / "meta").mkdir(parents=True)
    (root / "data" / "chunk-000").mkdir(parents=True)
    features = {
        key: {"dtype": "float32", "shape": [N], "names": names} for key in ("action", "observation.state")
    }
    features["observation.current"] = {"names": [f"joint_{k}.current" for k in range(1, N + 1)]}
    (root / "meta" / "info.json").write_text(
        json.dumps({"codebase_version": "v2.1", "fps": 250, "features": features})
    )
    out = {
        "action": list(DEG * f[[f"r{k}" for k in range(1, N + 1)]].to_numpy()),
        "observation.state": list(DEG * f[[f"q{k}" for k in range(1, N + 1)]].to_numpy()),
        "observation.current": list(f[[f"tau{k}" for k in range(1, N + 1)]].to_numpy() / 7),
        "timestamp": f["time"], "frame_index": np.arange(len(f)), "index": np.arange(len(f)),
        "episode_index": 0, "task_index": 0,
    }  # fmt: skip
    pd.DataFrame(out).to_parquet(root / "data" / "chunk-000" / "episode_000000.parquet")
    truth = {"timestamp": ("time", "s", 1, 0.0)}
    truth |= dict.fromkeys(("frame_index", "episode_index", "index", "task_index"))
    truth |= _truth("observation.state.joint_{}.pos", "joint{}.e", "deg") | _truth(
        "action.joint_{}.pos", "joint{}.r", "deg"
    )
    currents = _truth("observation.current.joint_{}.current", "joint{}.tau", "1")
    return Style(root, truth | currents, tuple(currents))


def swapped_signs(f: pd.DataFrame, folder: Path) -> Style:
    """Space-separated; torques 1 and 4 with the other sign, all 20 ms late; numbered from 0."""
    late = f.copy()
    for k in range(1, N + 1):
        late[f"tau{k}"] = (-1 if k in (1, 4) else 1) * np.roll(f[f"tau{k}"], 5)
    late = late.iloc[10:]
    named = {f"q{k}": f"theta_{k - 1}" for k in range(1, N + 1)} | {
        f"tau{k}": f"load_{k - 1}_Nm" for k in range(1, N + 1)
    }
    late[["time", *named]].rename(columns=named).to_csv(folder / "space.dat", sep=" ", index=False)
    truth = {"time": ("time", "s", 1, 0.0)} | _truth("theta_{}", "joint{}.e", "rad", first=0)
    for k in range(1, N + 1):
        truth[f"load_{k - 1}_Nm"] = (f"joint{k}.tau", "N.m", -1 if k in (1, 4) else 1, 0.0)
    return Style(folder / "space.dat", truth)  # pyright: ignore[reportArgumentType]


STYLES: tuple[Callable[[pd.DataFrame, Path], Style], ...] = (
    plain_csv, german_csv, no_header, units_row, cells_of_lists, shuffled_parquet, mat_struct, mat_7_3,
    hdf5_two_rates, mcap, lerobot, swapped_signs,
)  # fmt: skip
