"""The starter campaign that `rvjax init` writes."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from rvjax.components.manual import campaign_schema
from rvjax.errors import UsageError
from rvjax.run_folder import atomic_files

CAMPAIGN = "campaign.yaml"
SCHEMA = "campaign.schema.json"


def write(folder: Path) -> tuple[Path, Path]:
    """Writes the campaign and its schema into a folder; returns both paths. UsageError where that cannot be done."""
    campaign, schema = folder / CAMPAIGN, folder / SCHEMA
    atomic_files.check_folder(folder)
    atomic_files.check_file(schema)  # before the campaign, which a second try would refuse to write over
    try:
        with campaign.open("x", encoding="utf-8") as file:
            file.write(files("rvjax.cli").joinpath("starter.yaml").read_text(encoding="utf-8"))
        schema.write_text(json.dumps(campaign_schema(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    except FileExistsError as error:
        raise UsageError(f"{error.filename}: is there already; accepted: a folder without it") from error
    except OSError as error:
        raise UsageError(f"{error.filename}: cannot be written ({error.strerror}); accepted: a folder that can") from error
    return campaign, schema
