"""Fixed inputs that do nothing: what a campaign says, the name of the input, the key that is blamed, and words of the finding."""

from __future__ import annotations

BASE = """\
rvjax: 1
name: fixed
samples: 8
horizon: {duration_s: 10, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {moments: [20, 21, 22]}}
start: {rho_m: [{uniform: [1, 2]}, 0.5, 0]}
capture: {window_s: 5}
actuators: {upper: 3, lower: 3}
saturation: {use: hard-clip}
controller: {use: pd-plus}
"""
"""A flight of 100 steps of 0.1 s. RK4 evaluates it every 0.05 s. It begins in the plane of the orbit and stays there."""

LINES = BASE.count("\n")

UNIX = "[[1700000000, 0, 0, 0, 0, 0, 0], [1700000010, 1, 0, 0, 0, 0, 0], [1700000060, 0, 0, 0, 0, 0, 0]]"
GLITCH = "[[1.02, 0, 0, 0, 0, 0, 0], [1.05, 1, 0, 0, 0, 0, 0], [1.08, 0, 0, 0, 0, 0, 0]]"

DEAD = {
    "table-unix-time": (
        "disturbances: [{use: table, rows: ROWS}]".replace("ROWS", UNIX),
        "disturbances.table",
        "rows",
        "1700000060 s",
    ),
    "table-between-steps": (
        "disturbances: [{use: table, rows: ROWS}]".replace("ROWS", GLITCH),
        "disturbances.table",
        "rows",
        "between two steps",
    ),
    "table-of-zeros": (
        "disturbances: [{use: table, rows: [[0, 0, 0, 0, 0, 0, 0], [9, 0, 0, 0, 0, 0, 0]]}]",
        "disturbances.table",
        "rows",
        "every row of the table is 0",
    ),
    "table-drawn-shift": (
        "disturbances: [{use: table, rows: ROWS, shift_s: {uniform: [0, 5]}}]".replace("ROWS", UNIX),
        "disturbances.table",
        "rows",
        "before a shift of 0 s to 5 s",
    ),
    "table-scale": (
        "disturbances: [{use: table, rows: ROWS, scale: 0}]".replace("ROWS", GLITCH),
        "disturbances.table",
        "{",
        "scale is 0",
    ),
    "pulse-between-steps": (
        "disturbances: [{use: plume-pulse, force_N: 1, first_s: 2.01, width_s: 0.01, edge_s: 0.02}]",
        "disturbances.plume-pulse",
        "width_s",
        "every pulse of 0.03 s, edge included, lies between two instants",
    ),
    "pulses-between-steps": (
        "disturbances: [{use: plume-pulse, force_N: 1, first_s: 2.01, width_s: 0.01, edge_s: 0.02, period_s: 0.2}]",
        "disturbances.plume-pulse",
        "width_s",
        "lies between two instants",
    ),
    "pulse-after-the-end": (
        "disturbances: [{use: plume-pulse, force_N: 1, first_s: 10, width_s: 1}]",
        "disturbances.plume-pulse",
        "first_s",
        "not before the end of the flight",
    ),
    "constant-zero": ("disturbances: [{use: constant}]", "disturbances.constant", "{", "force_N and torque_Nm are 0"),
    "sinusoid-zero": ("disturbances: [{use: sinusoid, force_N: 0, rate_rad_s: 1}]", "disturbances.sinusoid", "{", "are 0"),
    "drag-without-air": (
        "disturbances: [{use: differential-drag, density_kg_m3: 0, pursuer_m2_kg: 1, target_m2_kg: 1}]",
        "disturbances.differential-drag",
        "{",
        "density_kg_m3 is 0",
    ),
    "effectiveness-one": (
        "faults: [{use: effectiveness, onset_s: 1, remaining: 1.0}]",
        "faults.effectiveness",
        "remaining",
        "remaining is 1",
    ),
    "bias-zero": ("faults: [{use: bias, onset_s: 1, share: 0}]", "faults.bias", "share", "share is 0"),
    "drift-of-nothing": ("faults: [{use: drift, onset_s: 1, growth: 1, most: 0}]", "faults.drift", "most", "most is 0"),
    "onset-after-the-end": (
        "faults: [{use: float, onset_s: {uniform: [10, 20]}}]",
        "faults.float",
        "onset_s",
        "the earliest onset of 10 s is not before the end",
    ),
    "fault-between-steps": (
        "faults: [{use: float, onset_s: 1.01, duration_s: 0.03}]",
        "faults.float",
        "duration_s",
        "acts for 0.03 s at a time, between two instants",
    ),
    "duty-between-steps": (
        "faults: [{use: float, onset_s: 1.01, period_s: 0.2, duty: 0.1}]",
        "faults.float",
        "duty",
        "acts for 0.02 s at a time",
    ),
    "listed-channel": (
        "faults: [{use: float, onset_s: [1, 99, 1, 1, 1, 1], channels: [fx, fy]}]",
        "faults.float.channels.fy",
        "fy]",
        "on fy, the earliest onset of 99 s",
    ),
    "schedule-count": (
        "faults: [{use: float, onset_s: 1, schedule: {count: 0.4}}]",
        "faults.float",
        "count",
        "a count of at most 0.4 picks no channel",
    ),
    "schedule-probability": (
        "faults: [{use: float, onset_s: 1, schedule: {probability: 0}}]",
        "faults.float",
        "probability",
        "a probability of 0 picks no channel",
    ),
    "schedule-group": (
        "faults: [{use: float, onset_s: {uniform: [1, 2]}, channels: [fx, fy], schedule: {count: 1, groups: [[fx, tz]]}}]",
        "faults.float.schedule.groups.0",
        "[fx, tz]",
        "of this group only fx may fail",
    ),
    "noise-of-nothing": ("navigation: [{use: noise}]", "navigation.noise", "{", "are 0 or left out in every sample"),
    "navigation-bias-zero": (
        "navigation: [{use: bias, attitude_deg: 0}]",
        "navigation.bias",
        "{",
        "attitude_deg and rate_deg_s are 0 or left out",
    ),
    "gyro-drift-zero": ("navigation: [{use: gyro-drift, walk_deg_s: 0}]", "navigation.gyro-drift", "{", "walk_deg_s are 0"),
    "noise-that-does-not-grow": (
        "navigation: [{use: noise, position_m_per_m: 0}]",
        "navigation.noise",
        "{",
        "rate_deg_s_per_m are 0 or left out",
    ),
    "dropouts-never": (
        "navigation: [{use: dropouts}]",
        "navigation.dropouts",
        "{",
        "probability and mean_interval_s are 0 or left out",
    ),
    "target-known-exactly": (
        "navigation: [{use: target-knowledge, port_m: 0}]",
        "navigation.target-knowledge",
        "{",
        "rate_deg_s, attitude_deg and port_m are 0 or left out",
    ),
    "target-noise-zero": ("navigation: [{use: target-noise, rate_deg_s: 0}]", "navigation.target-noise", "{", "rate_deg_s is 0"),
    "outage-after-the-end": (
        "navigation: [{use: outage, start_s: 10, duration_s: 1}]",
        "navigation.outage",
        "start_s",
        "begins at 10 s at the earliest, not before the end",
    ),
    "outage-between-steps": (
        "navigation: [{use: outage, start_s: 1.06, duration_s: 0.05}]",
        "navigation.outage",
        "duration_s",
        "an outage of 0.05 s ends at the step at which it begins",
    ),
    "class-without-samples": (
        "require: [{metric: captured, at_least: 0.5, where: {pursuer.mass_kg: {below: 90}}}]",
        "require.0.where.pursuer.mass_kg",
        "pursuer.mass_kg",
        "no draw is < 90, the draws are 90 to 110",
    ),
}
"""A line of a campaign, the name of the input that does nothing, the key or text at its place, words of the reason."""
