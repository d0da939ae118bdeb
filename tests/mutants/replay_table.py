"""Mutants of the replay and the linked plots of the report: coding, motion, frames, selection, interval, policy."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

BLOCKS, FLIGHTS = "report/interactive/data_blocks.py", "report/interactive/flights.py"
TRACE_FRAMES = "analysis/trace_frames.py"
SCENE, PARTS, SAMPLES = "report/interactive/scene.py", "report/interactive/page_parts.py", "report/interactive/samples.py"
SCRIPTS = "report/interactive/scripts/"

BACK = "report/test_page_parts.py::test_numbers_come_back_to_half_a_quantum"
WHOLE = "report/test_page_parts.py::test_whole_numbers_and_large_steps_come_back_exactly"
MOTION = "report/test_page_parts.py::test_the_motion_is_that_of_the_trace"
ZONES = "report/test_page_parts.py::test_violations_are_those_of_their_definition"
FAULTS = "report/test_page_parts.py::test_faults_and_limits_are_those_of_the_sample"
LARGE = "report/test_page_parts.py::test_a_large_run_shows_every_failure"
POLICY = "report/test_page_parts.py::test_the_policy_names_every_script_and_nothing_else"
HOSTILE = "report/test_report.py::test_hostile_texts_inject_nothing"
DRAWN = "report/test_replay.py::test_places_and_attitudes_are_those_of_the_trace"
FRAMES = "report/test_replay.py::test_frames_are_those_of_port_and_orbit"
COUNTS = "report/test_replay.py::test_a_brush_counts_what_pandas_counts"
INTERVAL = "report/test_replay.py::test_the_interval_is_exact"
KEYS = "report/test_replay.py::test_keys_play_step_and_change_the_speed"
TOGETHER = "report/test_replay.py::test_scrubbing_moves_scene_signals_and_table_together"

MUTANTS = (
    Mutant("block: codes are rounded down", BLOCKS, "np.rint(values[usable]", "np.floor(values[usable]", BACK),
    Mutant("block: a quantum for all 65,536 codes", BLOCKS, "MOST = 65532", "MOST = 65535", BACK),
    Mutant("block: zero between two codes", BLOCKS, "if not low < 0.0 <= high:", "if True:", "report/test_page_parts.py::test_zero_comes_back_as_zero"),
    Mutant("block: low bytes first", BLOCKS, "(zigzag >> 8)", "(zigzag << 0)", WHOLE),
    Mutant("replay: quaternions jump with the MRP", TRACE_FRAMES, "np.where(along < 0.0, -1.0, 1.0)", "np.where(along < 0.0, 1.0, 1.0)", MOTION),
    Mutant("replay: vectors turned the other way", TRACE_FRAMES, "v) + q[:, 3:] * v)", "v) - q[:, 3:] * v)", MOTION),
    Mutant("replay: LVLH has turned twice", FLIGHTS, "(rate[1:] + rate[:-1]) / 2)", "(rate[1:] + rate[:-1]))", MOTION),
    Mutant("replay: H-bar along the orbit normal", TRACE_FRAMES, "-h / np.linalg.norm(h, axis=1, keep", "h / np.linalg.norm(h, axis=1, keep", MOTION),
    Mutant("replay: an interval of violation is an instant too long", FLIGHTS, "int(behind) - 1)", "int(behind))", ZONES),
    Mutant("replay: a corridor without its radius", SCENE, "axis * (corridor.radius_m / ", "axis * (0.0 / ", ZONES),
    Mutant("replay: nominal limits", SCENE, "value * factor for value", "value for value", FAULTS),
    Mutant("replay: faults that never begin", FLIGHTS, "        if onset < end\n", "", FAULTS),
    Mutant("brush: failures of the first samples only", SAMPLES, "[head.iloc[MOST:], run.totals.failures]", "[head.iloc[MOST:]]", LARGE),
    Mutant("brush: chosen failures count", SAMPLES, "ignore_index=True), len(first))", "ignore_index=True), run.flown)", LARGE),
    Mutant(
        "totals: failures are lost in a record",
        "analysis/run_totals.py",
        'totals._keep_failures([record.part("failures").frame()])',
        "pass",
        LARGE,
    ),
    Mutant("page: a hash of another text", PARTS, 'hashlib.sha256(text.encode("utf-8"))', 'hashlib.sha256(text.encode("utf-16"))', POLICY),
    Mutant("page: JSON that can end its element", PARTS, 'for sign in "<>&":', 'for sign in "":', HOSTILE),
    Mutant("script: bytes in the other order", SCRIPTS + "blocks.js", "data[begin + i] * 256 + ", "data[begin + i] + 256 * ", DRAWN),
    Mutant("script: the long way round", SCRIPTS + "vectors.js", "const sign = along < 0 ? -1 : 1;", "const sign = -1;", DRAWN),
    Mutant("script: the row before", SCRIPTS + "flight.js", "if (this.t[middle] <= t) low", "if (this.t[middle] < t - 1) low", DRAWN),
    Mutant("script: LVLH is not turned back", SCRIPTS + "flight.js", "const rows = v.transposed(v.of", "const rows = (v.of", FRAMES),
    Mutant("script: the orbit turns the other way", SCRIPTS + "flight.js", "s = Math.sin(turn);", "s = -Math.sin(turn);", FRAMES),
    Mutant("script: a brush without its upper end", SCRIPTS + "samples.js", " && values[i] <= high", "", COUNTS),
    Mutant("script: the interval of one side", SCRIPTS + "statistics.js", "(1 - confidence) / 2", "1 - confidence", INTERVAL),
    Mutant("script: the tail of the other side", SCRIPTS + "statistics.js", "betaQuantile(n - k, k + 1, tail)", "betaQuantile(n - k + 1, k, tail)", INTERVAL),
    Mutant("script: any speed", SCRIPTS + "replay.js", "Math.max(this.speed * factor, 1), 64)", "Math.max(this.speed * factor, 1), 1e9)", KEYS),
    Mutant("script: signals stand still", SCRIPTS + "controls.js", "this.signals.move(replay.t);", "", TOGETHER),
)  # fmt: skip
