"""Mutants of exports: frames, units, names, digits."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

INERTIAL, CCSDS, DOCUMENTS, EXPORTING = "export/inertial.py", "export/ccsds.py", "export/documents.py", "execution/exporting.py"
TRACE_FRAMES = "analysis/trace_frames.py"
MATLAB = "export/matlab.py"
KINDS, IN_PARTS = "export/test_matlab.py::test_every_kind_of_value", "export/test_matlab.py::test_rows_are_written_in_parts"
PLACES, TURNS = "export/test_ccsds.py::test_positions_and_velocities", "export/test_ccsds.py::test_attitudes_and_rates"
HEAD = "export/test_ccsds.py::test_the_head_says_frames_epoch_and_object"
FIELDS, CSV, JSON = (
    "export/test_documents.py::test_mat",
    "export/test_documents.py::test_csv",
    "export/test_documents.py::test_json",
)

WAYS, FIXED, DRAWS = "report/sections/trajectories.py", "campaign/fixed_values.py", "report/sections/which_draws.py"
ORBIT, PORT = "report/test_trajectories.py::test_the_orbital_frame", "report/test_trajectories.py::test_the_port_frame"
DEFAULTS = "report/test_fixed_values.py::test_defaults_of_the_controller_are_among_them"
TRACED = "report/test_fixed_values.py::test_requirements_say_where_they_come_from"
VIEW = "report/test_plots.py::test_view_opens_the_report"

MUTANTS = (
    # the report's figures and tables
    Mutant("H-bar in the place of R-bar", WAYS, "x, _, z = np.einsum", "x, z, _ = np.einsum", ORBIT),
    Mutant("a way from the target's centre in the port's frame", WAYS, "way.place - np.array(port(run.spec, way.row))).T", "way.place).T", PORT),
    Mutant("a port frame that turns the other way", WAYS, "[-n[1], 1.0 - k", "[n[1], 1.0 - k", PORT),
    Mutant("a zone about the port", WAYS, "frame[[0, side]], -delta)", "frame[[0, side]], 0.0 * delta)", "report/test_trajectories.py::test_silhouettes"),
    Mutant("drawn values among the fixed", FIXED, "if isinstance(part, Fixed)}", "}", DEFAULTS),
    Mutant("the correlation with another result", DRAWS, "known[result][draw])", "known[[*known][-1]][draw])", "report/test_which_draws.py::test_rank_correlations_stand_beside_xi"),
    Mutant("a requirement that loses its origin", "campaign/requirement.py", "if (text := getattr(self, name)) is not None", "if (text := getattr(self, name)) is None", TRACED),
    Mutant("two requirements of one id", "campaign/requirement.py", "name in ids[:index]]", "name in ids[:0]]", "campaign/test_campaign.py::test_bad_file"),
    Mutant("a browser that is only asked to print", "cli/view.py", "not only_print and webbrowser.open", "webbrowser.open", VIEW),
    Mutant("a browser that is believed", "report/pdf.py", 'if not target.exists() or not (data := target.read_bytes()).startswith(b"%PDF"):', "if (data := b'') is None:", "report/test_plots.py::test_pdf_without_a_browser_is_refused_at_once"),
    Mutant("a line for each batch in a notebook", "execution/progress_display.py", "        if self._handle is None:\n", "        if True:\n", "run/test_progress.py::test_a_search_shows_its_lines"),
    # exports
    Mutant("the pursuer from the target's centre", INERTIAL, "away = port + _back", "away = _back", PLACES),
    Mutant("a port that does not swing", INERTIAL, "np.cross(w, port)", "0.0", PLACES),
    Mutant("components that stay in the pursuer's frame", INERTIAL, 'np.einsum("tij,ti->tj"', 'np.einsum("tij,tj->ti"', PLACES),
    Mutant("an orbit plane that tilts the other way", INERTIAL, "[0.0, cos, -sin], [0.0, sin, cos]", "[0.0, cos, sin], [0.0, -sin, cos]", PLACES),
    Mutant("an ellipse without its radial speed", INERTIAL, "radial * (1.0 - cos) - mean", "0.0 * (1.0 - cos) - mean", PLACES),
    Mutant("a target that does not turn at the start", INERTIAL, "plane @ rotation(attitude_mrp[None])[0].T", "plane", PLACES),
    Mutant("metres in the place of kilometres", CCSDS, "axis=1) / 1000.0", "axis=1)", PLACES),
    Mutant("the inverse quaternion", TRACE_FRAMES, "pairs[:, i, 3] = pairs[:, 3, i] = m[:, j, k] - m[:, k, j]", "pairs[:, i, 3] = pairs[:, 3, i] = m[:, k, j] - m[:, j, k]", TURNS),
    Mutant("a quaternion that jumps to the other side", TRACE_FRAMES, "    return _continuous(q)\n\n\ndef turned", "    return q\n\n\ndef turned", TURNS),
    Mutant("a rate relative to the target", INERTIAL, ' + np.einsum("tij,tj->ti", relative, w)', "", TURNS),
    Mutant("rates in radians", CCSDS, "np.degrees(motion.rate)", "motion.rate", TURNS),
    Mutant("a day of more than 24 hours", CCSDS, "timedelta(seconds=whole)", "timedelta(seconds=0)", HEAD),
    Mutant("one object in two messages", EXPORTING, 'f"{spec.name.upper()}-{body.upper()}"', "spec.name.upper()", HEAD),
    Mutant("NaN in a message", EXPORTING, "np.isfinite(motion).all(axis=1)", "np.ones(len(motion), dtype=bool)", "export/test_ccsds.py::test_a_flight_that_diverged_ends_before"),
    Mutant("names that are cut to 31 letters", MATLAB, ".ljust(LONGEST + 1,", "[:31].ljust(LONGEST + 1,", FIELDS),
    Mutant("texts of MATLAB with a byte a letter", MATLAB, 'value.encode("utf-16-le")', 'value.encode("latin-1", "replace")', KINDS),
    Mutant("an empty text of one row", MATLAB, "if data else (0, 0)", "if True else (0, 0)", KINDS),
    Mutant("large numbers below zero", MATLAB, "if value < 2**63 else", "if value < 0 else", KINDS),
    Mutant("texts that are written twice", MATLAB, "codes[begin : begin + ROWS]", "codes[begin:]", IN_PARTS),
    Mutant("a header in each part", DOCUMENTS, "header=not begin", "header=True", IN_PARTS),
    Mutant("a table that is too large for MATLAB", DOCUMENTS, "> matlab.LARGEST:", "> 1e99:", "export/test_matlab.py::test_a_table_that_is_too_large_is_refused"),
    Mutant("two columns in one field", DOCUMENTS, "while field in taken:", "while False:", "export/test_documents.py::test_names_of_fields_are_valid_and_different"),
    Mutant("infinity that is no number", DOCUMENTS, '"Infinity" if value > 0 else "-Infinity"', "None", JSON),
    Mutant("rounded digits", DOCUMENTS, "to_csv(index=False, header", 'to_csv(index=False, float_format="%.12g", header', CSV),
)  # fmt: skip
