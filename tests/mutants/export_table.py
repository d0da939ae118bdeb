"""Mutants of exports: frames, units, names, digits."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

INERTIAL, CCSDS, DOCUMENTS, EXPORTING = "export/inertial.py", "export/ccsds.py", "export/documents.py", "execution/exporting.py"
PLACES, TURNS = "export/test_ccsds.py::test_positions_and_velocities", "export/test_ccsds.py::test_attitudes_and_rates"
HEAD = "export/test_ccsds.py::test_the_head_says_frames_epoch_and_object"
FIELDS, CSV, JSON = (
    "export/test_documents.py::test_mat",
    "export/test_documents.py::test_csv",
    "export/test_documents.py::test_json",
)

MUTANTS = (
    Mutant("the pursuer from the target's centre", INERTIAL, "away = port + _back", "away = _back", PLACES),
    Mutant("a port that does not swing", INERTIAL, "np.cross(w, port)", "0.0", PLACES),
    Mutant("components that stay in the pursuer's frame", INERTIAL, 'np.einsum("tij,ti->tj"', 'np.einsum("tij,tj->ti"', PLACES),
    Mutant("an orbit plane that tilts the other way", INERTIAL, "[0.0, cos, -sin], [0.0, sin, cos]", "[0.0, cos, sin], [0.0, -sin, cos]", PLACES),
    Mutant("an ellipse without its radial speed", INERTIAL, "radial * (1.0 - cos) - mean", "0.0 * (1.0 - cos) - mean", PLACES),
    Mutant("a target that does not turn at the start", INERTIAL, "plane @ rotation(attitude_mrp[None])[0].T", "plane", PLACES),
    Mutant("metres in the place of kilometres", CCSDS, "axis=1) / 1000.0", "axis=1)", PLACES),
    Mutant("the inverse quaternion", INERTIAL, "pairs[:, i, 3] = pairs[:, 3, i] = m[:, j, k] - m[:, k, j]", "pairs[:, i, 3] = pairs[:, 3, i] = m[:, k, j] - m[:, j, k]", TURNS),
    Mutant("a quaternion that jumps to the other side", INERTIAL, "q[1:] *= np.cumprod(turns)[:, None]", "pass", TURNS),
    Mutant("a rate relative to the target", INERTIAL, ' + np.einsum("tij,tj->ti", relative, w)', "", TURNS),
    Mutant("rates in radians", CCSDS, "np.degrees(motion.rate)", "motion.rate", TURNS),
    Mutant("a day of more than 24 hours", CCSDS, "timedelta(seconds=whole)", "timedelta(seconds=0)", HEAD),
    Mutant("one object in two messages", EXPORTING, 'f"{spec.name.upper()}-{body.upper()}"', "spec.name.upper()", HEAD),
    Mutant("NaN in a message", EXPORTING, "np.isfinite(numbers).all(axis=1)", "np.ones(len(numbers), dtype=bool)", "export/test_ccsds.py::test_a_flight_that_diverged_ends_before"),
    Mutant("names cut to 31 letters by SciPy's error", DOCUMENTS, "long_field_names=True", "long_field_names=False", FIELDS),
    Mutant("two columns in one field", DOCUMENTS, "while field in taken:", "while False:", "export/test_documents.py::test_names_of_fields_are_valid_and_different"),
    Mutant("infinity that is no number", DOCUMENTS, '"Infinity" if value > 0 else "-Infinity"', "None", JSON),
    Mutant("rounded digits", DOCUMENTS, "table.frame.to_csv(index=False)", 'table.frame.to_csv(index=False, float_format="%.12g")', CSV),
)  # fmt: skip
