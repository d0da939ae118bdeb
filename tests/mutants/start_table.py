"""Mutants of the start: frames, what is at rest, the docking axis, the audit of a start."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

FRAMES, START, MODEL = "simulation/start_frames.py", "campaign/start.py", "campaign/model.py"
READ_BACK = "execution/audit_readback.py"
ABSOLUTE = "physics/test_start_frames.py::test_the_absolute_state_is_that_of_the_oracle"
ALONG = "physics/test_start_frames.py::test_the_port_axis_turns_the_frame_of_the_port"
ANY = "physics/test_start_frames.py::test_any_attitude_in_lvlh_becomes_that_of_the_target"
HOLD = "physics/test_start_frames.py::test_hold_points_are_where_their_names_say"
V_BAR = "physics/test_start_frames.py::test_at_rest_on_v_bar_nothing_drifts"
R_BAR = "physics/test_start_frames.py::test_at_rest_on_r_bar_it_drifts_as_clohessy_and_wiltshire_say"
STAYS = "physics/test_start_frames.py::test_at_rest_relative_to_the_port_it_stays_before_the_target"
BAD = "spec/test_bad_files.py::test_bad_file"
FORMS = "campaign/test_start.py::test_each_form_is_read_by_its_keys"
NAMED = "campaign/test_start.py::test_a_motion_that_is_not_that_of_the_table_is_named"
READ = "campaign/test_start.py::test_every_draw_of_a_start_is_read_back_and_acts"
CORRIDOR = "campaign/test_start.py::test_a_corridor_needs_a_docking_axis"

CARRIED = "cross(rest, away) + cross(rest - target.w, port)"
ORBITAL = "cross(target.r, target.v) / dot(target.r, target.r)"
MEAN_SPEED = "_unit(cross(target.r, target.v)) * np.sqrt(dot(target.v, target.v) / dot(target.r, target.r))"
ATTITUDE = "_product(_of_mrp(given.attitude), _of_rotation(axes))"

MUTANTS = (
    # LVLH
    Mutant(
        "LVLH: y along the orbit normal", FRAMES, "-_unit(cross(target.r, target.v))", "_unit(cross(target.r, target.v))", HOLD
    ),
    Mutant("LVLH: z away from the Earth", FRAMES, "z, y = -_unit(target.r)", "z, y = _unit(target.r)", R_BAR),
    Mutant("LVLH: x along the velocity", FRAMES, "Rotation(cross(y, z), y, z)", "Rotation(_unit(target.v), y, z)", ABSOLUTE),
    Mutant("LVLH: the rate of a circular orbit", FRAMES, ORBITAL, MEAN_SPEED, ABSOLUTE),
    Mutant("LVLH: the rate backward", FRAMES, ORBITAL, f"-{ORBITAL}", V_BAR),
    Mutant("LVLH: from the docking point", FRAMES, '(port if frame == "lvlh" else port * 0.0)', "port * 0.0", ABSOLUTE),
    Mutant(
        "LVLH: the attitude from the wrong side",
        FRAMES,
        ATTITUDE,
        "_product(_of_rotation(axes), _of_mrp(given.attitude))",
        ABSOLUTE,
    ),
    Mutant("LVLH: the attitude transposed", FRAMES, "_of_mrp(given.attitude)", "_of_mrp(-given.attitude)", ABSOLUTE),
    Mutant(
        "quaternions: the other order", FRAMES, "a[1] * b[0] - cross(a[1], b[1])", "a[1] * b[0] + cross(a[1], b[1])", ABSOLUTE
    ),
    Mutant("quaternions: from the trace alone", FRAMES, "larger = row[index] > most", "larger = row[index] > most + 9.0", ANY),
    Mutant("the longer turn", FRAMES, "np.copysign(1.0, q[0]) / (1.0 + np.abs(q[0]))", "1.0 / (1.0 + q[0])", ABSOLUTE),
    # velocities and rates
    Mutant("no ω×d", FRAMES, CARRIED, "cross(rest - target.w, port)", STAYS),
    Mutant("no ω×δ", FRAMES, CARRIED, "cross(rest, away)", ABSOLUTE),
    Mutant("ω×δ of the frame alone", FRAMES, "cross(rest - target.w, port)", "cross(rest, port)", ABSOLUTE),
    Mutant(
        "a velocity in transposed axes", FRAMES, "rotate_back(axes, given.velocity)", "rotate(axes, given.velocity)", ABSOLUTE
    ),
    Mutant(
        "a position in transposed axes", FRAMES, "rotate_back(axes, given.position)", "rotate(axes, given.position)", ABSOLUTE
    ),
    Mutant("a velocity in T", FRAMES, "nu=rotate(turn, rotate_back(axes", "nu=rotate_back(turn, rotate_back(axes", ABSOLUTE),
    Mutant(
        "a rate that the target does not share",
        FRAMES,
        "given.rate + rotate(turn, rest - target.w)",
        "given.rate - rotate(turn, target.w)",
        ABSOLUTE,
    ),
    Mutant(
        "a rate in the axes of T",
        FRAMES,
        "given.rate + rotate(turn, rest - target.w)",
        "rotate(turn, given.rate + rest - target.w)",
        ABSOLUTE,
    ),
    # port
    Mutant("port: a mirrored axis", FRAMES, "Vector(-n.y, 1.0 - ", "Vector(n.y, 1.0 - ", ABSOLUTE),
    Mutant("port: 1/(1 + n_x) near −x", FRAMES, "back = n.x < 0.0", "back = n.x < -2.0", ALONG),
    Mutant("port: half a turn about y", FRAMES, "((n.y, 1.0), (n.z, 0.0))", "((n.y, 0.0), (n.z, 1.0))", ALONG),
    Mutant("port_axis: of any length", FRAMES, "for part in unit(given)", "for part in given", ALONG),
    Mutant(
        "port_axis: not in the frame",
        "simulation/draws.py",
        "docking_axis(problem.spec.target.port_axis, port)",
        "docking_axis(None, port)",
        ALONG,
    ),
    Mutant(
        "port_axis: not in the cone",
        "simulation/draws.py",
        "docking_axis(spec.target.port_axis, port)\n    return",
        "docking_axis(None, port)\n    return",
        ALONG,
    ),
    Mutant("port_axis: not for a corridor", MODEL, "self.port_axis is not None or self.port_m", "self.port_m", CORRIDOR),
    # the campaign
    Mutant("another default of relative_to", START, '"pursuer": "port"}', '"pursuer": "lvlh"}', FORMS),
    Mutant("relative_to lvlh without an orbit", START, 'if word == "lvlh"]', 'if word == "lvlh" and key == "frame"]', BAD),
    Mutant("frame port without a port", START, 'if self.frame == "port" and not docking_axis', "if False", BAD),
    Mutant("an orbit that nobody stated", MODEL, '"orbit" in target.model_fields_set', "True", BAD),
    Mutant("an unknown key without both forms", START, "_both_forms() if key in _keys(Start) else ", "", BAD),
    # the audit
    Mutant("an attitude compared with itself", READ_BACK, "tuple(seen.T)", "tuple(turn.reshape(-1, 9).T)", NAMED),
    Mutant("the audit without the docking axis", READ_BACK, "if target.port_axis is not None:", "if False:", READ),
    Mutant("the audit without ω×p", READ_BACK, " + np.cross(rest, place)", "", READ),
)
