"""Eight more habits: controllers' recorders, motors on a bus, messages in cells, units that nobody names."""

from pathlib import Path

import numpy as np
import pandas as pd
from inspection.styles import DEG, N, Style, _nothing, _truth

EVERY = range(1, N + 1)
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


def _columns(pattern: str, f: pd.DataFrame, signal: str, factor: float = 1.0, first: int = 1):
    return {pattern.format(k - 1 + first): factor * f[f"{signal}{k}"] for k in EVERY}


def rtde(f: pd.DataFrame, folder: Path) -> Style:
    """Blanks between the columns; targets beside what is measured; poses and states that are no joints."""
    out = {"timestamp": 1234.5 + f["time"]} | _columns("target_q_{}", f, "r", first=0)
    out |= _columns("target_current_{}", f, "tau", 0.11, 0) | _columns("actual_q_{}", f, "q", first=0)
    out |= _columns("actual_qd_{}", f, "dq", first=0) | _columns("actual_current_{}", f, "tau", 0.1, 0)
    out |= {f"actual_TCP_pose_{k - 1}": np.sin(f[f"q{k}"]) for k in EVERY}
    out |= {f"joint_temperatures_{k - 1}": 30.0 + 0 * f["time"] for k in EVERY}
    out |= {"robot_mode": 7 + 0 * f["time"], "runtime_state": 2 + 0 * f["time"]}
    pd.DataFrame(out).to_csv(folder / "rtde.csv", sep=" ", index=False)
    truth = {"timestamp": ("time", "s", 1, 0.0), "robot_mode": None, "runtime_state": None}
    truth |= _truth("actual_q_{}", "joint{}.e", "rad", first=0) | _nothing("actual_qd_{}", first=0)
    truth |= _truth("target_q_{}", "joint{}.r", "rad", first=0) | _nothing("target_current_{}", first=0)
    currents = _truth("actual_current_{}", "joint{}.tau", "1", first=0)
    truth |= _nothing("actual_TCP_pose_{}", first=0) | _nothing("joint_temperatures_{}", first=0)
    return Style(folder / "rtde.csv", truth | currents, tuple(currents))


def motors_on_a_bus(f: pd.DataFrame, folder: Path) -> Style:
    """The m of m1_pos_deg is no moment; degrees, turns a minute, milliamperes and a duty."""
    out = {"t_us": 1e6 * f["time"]}
    for k in EVERY:
        q, dq, tau, r = (f[f"{a}{k}"] for a in ("q", "dq", "tau", "r"))
        out |= {f"m{k}_pos_deg": np.round(DEG * q, 3), f"m{k}_vel_rpm": dq * 30 / np.pi}
        out |= {f"m{k}_cur_mA": np.round(1e3 * tau / 9, 1), f"m{k}_pwm": np.round(3 * tau + 20 * dq)}
        out |= {f"m{k}_cmd_deg": np.round(DEG * r, 3)}
    pd.DataFrame(out).to_csv(folder / "bus.csv", index=False)
    truth = {"t_us": ("time", "us", 1, 0.0)} | _truth("m{}_pos_deg", "joint{}.e", "deg")
    truth |= _nothing("m{}_vel_rpm") | _nothing("m{}_pwm") | _truth("m{}_cmd_deg", "joint{}.r", "deg")
    currents = _truth("m{}_cur_mA", "joint{}.tau", "mA")
    return Style(folder / "bus.csv", truth | currents, tuple(currents))


def turns(f: pd.DataFrame, folder: Path) -> Style:
    """Positions in turns, and nothing says so but the robot's weight."""
    from scipy.io import savemat

    axes = {
        f"axis{k}": {
            "ActPos": f[f"q{k}"].to_numpy() / (2 * np.pi),
            "SetPos": f[f"r{k}"].to_numpy() / (2 * np.pi),
            "ActTrq": f[f"tau{k}"].to_numpy(),
        }
        for k in EVERY
    }
    savemat(folder / "turns.mat", {"trace": axes | {"t": f["time"].to_numpy()}})
    truth = {"trace.t": ("time", "s", 1, 0.0)} | _truth("trace.axis{}.ActPos", "joint{}.e", "rev")
    truth |= _truth("trace.axis{}.SetPos", "joint{}.r", "rev")
    return Style(folder / "turns.mat", truth | _truth("trace.axis{}.ActTrq", "joint{}.tau", "N.m"))


def thousandths(f: pd.DataFrame, folder: Path) -> Style:
    """Milliradians and millinewton metres, without a word."""
    from scipy.io import savemat

    q, tau, r = (1e3 * f[[f"{a}{k}" for k in EVERY]].to_numpy() for a in ("q", "tau", "r"))
    out = {
        "theta": q,
        "theta_dot": 1e3 * f[[f"dq{k}" for k in EVERY]].to_numpy(),
        "theta_ref": r,
        "tau_meas": tau,
    }
    savemat(folder / "milli.mat", {"tout": f["time"].to_numpy()[:, None], "yout": out})
    truth = {"tout": ("time", "s", 1, 0.0)} | _truth("yout.theta[{}]", "joint{}.e", "mrad")
    truth |= _truth("yout.theta_ref[{}]", "joint{}.r", "mrad") | _nothing("yout.theta_dot[{}]")
    return Style(folder / "milli.mat", truth | _truth("yout.tau_meas[{}]", "joint{}.tau", "mN.m"))


def message_cells(f: pd.DataFrame, folder: Path) -> Style:
    """A message per row: stamps in two parts, names in a cell, lists in Python's and NumPy's writing."""
    order = [2, 1, 0, 3, 4, 5]
    lists = {
        word: f[[f"{a}{k + 1}" for k in order]].to_numpy()
        for word, a in (("position", "q"), ("velocity", "dq"), ("effort", "tau"))
    }
    time = f["time"].to_numpy()
    out = {"header.stamp.sec": 1_700_000_000 + np.floor(time).astype(int)}
    out |= {"header.stamp.nanosec": np.round((time % 1) * 1e9).astype(int)}
    out |= {"name": [str([JOINTS[k] for k in order])] * len(f)}
    out |= {word: [str(row) for row in rows.tolist()] for word, rows in lists.items()}
    out["velocity"] = [np.array2string(row) for row in lists["velocity"]]
    pd.DataFrame(out).to_csv(folder / "messages.csv", index=False)
    places = {f"{JOINTS[k]}.{word}": k + 1 for k in order for word in lists}
    truth = {"header.stamp": ("time", "s", 1, 0.0)}
    truth |= {n: None for n in places if n.endswith("velocity")}
    truth |= {n: (f"joint{k}.e", "rad", 1, 0.0) for n, k in places.items() if n.endswith("position")}
    truth |= {n: (f"joint{k}.tau", "N.m", 1, 0.0) for n, k in places.items() if n.endswith("effort")}
    return Style(folder / "messages.csv", truth)


def desired_and_external(f: pd.DataFrame, folder: Path) -> Style:
    """O_T_EE beside q, dq and tau_J; what was desired, and what acts from outside."""
    rng = np.random.default_rng(1)

    def cells(x: np.ndarray) -> list[str]:
        return [str(row) for row in x.tolist()]

    q, dq, tau, r = (f[[f"{a}{k}" for k in EVERY]].to_numpy() for a in ("q", "dq", "tau", "r"))
    out = {"time": f["time"], "O_T_EE": cells(np.hstack([np.sin(q), np.cos(q), q[:, :4]])), "q": cells(q)}
    out |= {"q_d": cells(r), "dq": cells(dq), "tau_J": cells(tau), "tau_J_d": cells(0.98 * tau)}
    out |= {"elbow": cells(q[:, :2]), "tau_ext_hat_filtered": cells(rng.normal(size=q.shape))}
    pd.DataFrame(out).to_csv(folder / "desired.csv", index=False)
    truth = {"time": ("time", "s", 1, 0.0)} | _truth("q[{}]", "joint{}.e", "rad") | _nothing("dq[{}]")
    truth |= (
        _truth("q_d[{}]", "joint{}.r", "rad") | _nothing("tau_J_d[{}]") | _nothing("tau_ext_hat_filtered[{}]")
    )
    return Style(folder / "desired.csv", truth | _truth("tau_J[{}]", "joint{}.tau", "N.m"))


def shuffled_limbs(f: pd.DataFrame, folder: Path) -> Style:
    """Joints have names that the robot file does not have, and every signal has its own order."""
    limbs = [f"{side}_{part}" for side in ("FR", "FL") for part in ("hip", "thigh", "calf")]
    out, truth = {"stamp_ns": np.round(1e9 * f["time"])}, {"stamp_ns": ("time", "ns", 1, 0.0)}
    for k, limb in enumerate(limbs, start=1):
        out |= {f"{limb}.q": f[f"q{k}"], f"{limb}.tauEst": f[f"tau{k}"], f"{limb}.q_des": f[f"r{k}"]}
        out |= {f"{limb}.kp": 20.0 + 0 * f["time"]}
        truth |= {f"{limb}.q": (f"joint{k}.e", "rad", 1, 0.0), f"{limb}.kp": None}
        truth |= {
            f"{limb}.tauEst": (f"joint{k}.tau", "N.m", 1, 0.0),
            f"{limb}.q_des": (f"joint{k}.r", "rad", 1, 0.0),
        }
    order = [str(name) for name in np.random.default_rng(0).permutation(list(out))]
    pd.DataFrame(out)[order].to_parquet(folder / "limbs.parquet")
    return Style(folder / "limbs.parquet", truth)


def rated_torques(f: pd.DataFrame, folder: Path) -> Style:
    """Dates as time; torques in thousandths of what each motor is rated for, which is asked."""
    rated = (300, 300, 200, 50, 50, 20)
    out = {
        "Timestamp": pd.to_datetime("2026-03-01T10:00:00") + pd.to_timedelta(f["time"].to_numpy(), unit="s")
    }
    out |= _columns("Axis{}.ActualPosition", f, "q", DEG)
    out |= {f"Axis{k}.ActualTorque": 1e3 * f[f"tau{k}"] / rated[k - 1] for k in EVERY}
    out |= {f"Axis{k}.FollowingError": DEG * (f[f"r{k}"] - f[f"q{k}"]) for k in EVERY}
    pd.DataFrame(out).to_csv(folder / "rated.csv", index=False)
    truth = {"Timestamp": ("time", "s", 1, 0.0)} | _truth("Axis{}.ActualPosition", "joint{}.e", "deg")
    torques = tuple(f"Axis{k}.ActualTorque" for k in EVERY)
    return Style(folder / "rated.csv", truth | _nothing("Axis{}.FollowingError"), torques)


TOOLS = (rtde, motors_on_a_bus, turns, thousandths, message_cells, desired_and_external, shuffled_limbs,
         rated_torques)  # fmt: skip
