"""The result of a worst-case search as a campaign that replays it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rvjax.campaign.export import campaign_text
from rvjax.components.samplers.uniforms_table import columns_of
from rvjax.run_folder import atomic_files
from rvjax.search.worst_case import Worst, WorstCaseSearch

CAMPAIGN, POINTS = "worst.yaml", "worst.csv"


def check(folder: Path, search: WorstCaseSearch) -> None:
    """UsageError where `export` cannot write. Changes nothing."""
    atomic_files.check_folder(folder)
    if folder.is_dir():
        for name in (CAMPAIGN, POINTS, *search.problem.spec.source.inputs):
            atomic_files.check_file(folder / name)


def export(search: WorstCaseSearch, result: Worst, folder: Path, overrides: Sequence[str] = ()) -> Path:
    """Writes the worst case and the most probable failure as a campaign, with the numbers that decide their draws; returns its
    path. With noise in flight only the worst case, which is sample 0, keeps its noise; so it is written alone."""
    spec = search.problem.spec
    noisy = any(part.noisy for part in (*search.problem.disturbances, *search.problem.navigation))
    noisy |= any(part.schedule is not None for part in search.problem.faults)  # whose lots are those of a sample
    cases = [result.worst]
    if result.likeliest is not None and result.likeliest.margin != result.worst.margin and not noisy:
        cases.append(result.likeliest)
    numbers = search.numbers(np.array([case.z for case in cases]))
    table = {column: block[:, k] for name, block in numbers.items() for k, column in enumerate(columns_of(name, block.shape[1]))}
    lines = [",".join(table), *(",".join(repr(float(values[row])) for values in table.values()) for row in range(len(cases)))]
    with atomic_files.explained(folder):
        folder.mkdir(parents=True, exist_ok=True)
    points = POINTS
    while points in spec.source.inputs:
        points = f"found-{points}"
    atomic_files.replace(folder / points, ("\n".join(lines) + "\n").encode())
    for name, content in spec.source.inputs.items():
        atomic_files.replace(folder / name, content)
    drawn = sorted({name.partition(".")[0] for name in numbers})  # a single flight cannot prove that a draw acts
    sets = [
        *overrides,
        f"audit={{allow: [{', '.join(drawn)}]}}",
        f"samples={len(cases)}",
        f"sampler={{use: points, csv: {points}}}",
        "keep={all: true}",
    ]
    sentence = f"the worst flight of {result.flights} that `rvjax worst` flew is sample 0, its margin {result.worst.margin:.6g}"
    comment = f"{result.requirement}: {sentence}."
    text = campaign_text(spec, sets, ("require", "laws", "tune", "baselines"), "-worst", comment)
    path = folder / CAMPAIGN
    atomic_files.replace(path, text.encode())
    return path
