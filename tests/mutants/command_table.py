"""Mutants of what commands do beside flying: progress, extras, waits, promised files, refusals, pytest, tuning, baselines."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

PROGRESS, DISPLAY, REFUSALS = "execution/progress.py", "execution/progress_display.py", "run_folder/refusals.py"
EXTRAS, WAITING, DASK = "components/extras.py", "execution/executors/waiting.py", "execution/executors/dask_client.py"
OUTPUTS, FILES, GRID = "cli/_ci_outputs.py", "run_folder/atomic_files.py", "components/search_methods/grid.py"
PLUGIN, EVALUATION = "pytest_plugin.py", "search/tuning/evaluation.py"
BASELINE, AGAINST = "analysis/baseline_file.py", "analysis/baseline.py"

UNDER_WAY = "run/test_progress.py::test_the_share_counts_steps_under_way"
TOO_OLD = "extras/test_extras.py::test_a_package_that_is_too_old"
NEVER = "reliability/test_waiting.py::test_a_call_that_never_returns_ends_with_its_reason"
SILENT = "reliability/test_waiting.py::test_workers_that_do_not_say_what_they_would_fly"
ENDS = "ci/test_promised_files.py::test_whatever_ends_a_flight_is_in_the_junit_xml"
STAYS = "cli/test_refused_before.py::test_what_stays_of_a_folder"
APART = "ci/test_pytest_plugin.py::test_names_are_taken_apart_by_no_tool"
KEPT = "ci/test_pytest_plugin.py::test_kept_verdicts_that_are_damaged_are_not_used"
WINNER = "tuning/test_unmet.py::test_the_winner_meets_what_is_required_not_what_is_asked_for"
EDITED = "ci/test_against.py::test_an_edited_baseline_is_refused_with_its_place"
LISTED = "ci/test_against.py::test_every_mistake_of_a_baseline_is_listed"

MUTANTS = (
    # progress
    Mutant("steps that count twice", PROGRESS, "        self._counted += self._steps\n", "", UNDER_WAY),
    Mutant(
        "a chunk that goes from nothing to all",
        PROGRESS,
        "flown = self._done + left * min(1.0, chunks / max(1, math.ceil(left / self._lanes)))",
        "flown = self._done",
        UNDER_WAY,
    ),
    Mutant(
        "a chunk of a few flights that is over after a few steps",
        PROGRESS,
        "max(1, math.ceil(left / self._lanes))",
        "max(1e-9, left / self._lanes)",
        UNDER_WAY,
    ),
    Mutant(
        "compile time in the speed",
        DISPLAY,
        "elif self._flown.share == self._first.share:",
        "elif False:",
        "run/test_progress.py::test_the_lines_of_a_log",
    ),
    Mutant(
        "a line every few seconds for a week",
        DISPLAY,
        "progress.seconds + max(LINES_S, 0.02 * progress.seconds)",
        "progress.seconds + LINES_S",
        "run/test_progress.py::test_a_long_run_has_a_short_log",
    ),
    Mutant(
        "a folder without a flight after an error in a law",
        REFUSALS,
        "    except IncompleteError:\n",
        "    except (IncompleteError, TypeError, RuntimeError):\n",
        "run/test_progress.py::test_a_law_that_cannot_be_traced_leaves_no_folder",
    ),
    # extras
    Mutant(
        "versions compared as text",
        EXTRAS,
        "not bounds[package].contains(installed, prereleases=True)",
        'installed < str(bounds[package]).removeprefix(">=")',
        TOO_OLD,
    ),
    Mutant(
        "a package that is there however old it is",
        EXTRAS,
        "    if package in bounds and not",
        "    if package not in bounds and not",
        TOO_OLD,
    ),
    Mutant(
        "one of two missing packages",
        DASK,
        'lacking("dask", "distributed")',
        'lacking("dask")',
        "extras/test_extras.py::test_dask_is_missing",
    ),
    # waits
    Mutant("a wait without a word", WAITING, '            say(f"waiting: {silence}")\n', "", NEVER),
    Mutant(
        "an error that is lost in its thread",
        WAITING,
        "            answers.put((False, error))",
        "            del error",
        NEVER,
    ),
    Mutant(
        "giving up at the first refusal",
        WAITING,
        "            if time.monotonic() >= end:\n",
        "            if isinstance(error, ConnectionRefusedError):\n",
        "reliability/test_waiting.py::test_a_scheduler_that_starts_a_moment_later_is_waited_for",
    ),
    Mutant(
        "workers that died of the question",
        DASK,
        "if gone and len(gone) == len(asked):",
        "if not asked:",
        SILENT,
    ),
    Mutant(
        "a scheduler of another version",
        "execution/executors/dask_connection.py",
        'others = {"the scheduler": found["scheduler"], **found["workers"]}',
        'others = found["workers"]',
        "reliability/test_waiting.py::test_another_version_of_dask_is_refused_before_it_is_sent_anything",
    ),
    Mutant(
        "a message at every look",
        PLUGIN,
        "                said = True\n",
        "",
        "ci/test_pytest_plugin.py::test_another_pytest_is_not_waited_for_without_end",
    ),
    # promised files
    Mutant("a signal without a JUnit file", OUTPUTS, "except BaseException as error:", "except Exception as error:", ENDS),
    Mutant(
        "no JUnit file while the campaign flies",
        OUTPUTS,
        "        if early:\n            self._begin(name)\n",
        "        if early:\n            pass\n",
        ENDS,
    ),
    Mutant(
        "a suite without a name",
        OUTPUTS,
        "isinstance(stated, str) and stated.strip() else",
        "isinstance(stated, str) else",
        "ci/test_promised_files.py::test_a_campaign_without_a_name_is_known_by_its_file",
    ),
    Mutant(
        "a campaign that is written over through a link",
        OUTPUTS,
        "what = read.get(os.path.realpath(path))",
        "what = read.get(os.path.abspath(path))",
        "ci/test_promised_files.py::test_what_is_read_is_not_written_over",
    ),
    Mutant(
        "a folder without the right to write in it",
        FILES,
        "elif os.access(here, os.W_OK | os.X_OK):",
        "elif os.path.isdir(here):",
        "ci/test_promised_files.py::test_a_disk_that_refuses_is_told_apart",
    ),
    Mutant(
        "--out behind a double dash",
        "cli/_resuming.py",
        'end = words.index("--") if "--" in words else len(words)',
        "end = len(words)",
        "ci/test_promised_files.py::test_a_double_dash_ends_the_options",
    ),
    # what validate accepts and the command refuses
    Mutant(
        "thousands in a budget",
        GRID,
        'f"a budget of {points} candidates"',
        'f"a budget of {points:,} candidates"',
        "cli/test_refused_before.py::test_a_grid_that_is_larger_than_its_budget",
    ),
    Mutant(
        "a root that is rounded up",
        GRID,
        "return levels if levels**smooth <= room else levels - 1",
        "return levels",
        "cli/test_refused_before.py::test_the_most_levels_of_a_grid",
    ),
    Mutant("a run that can be resumed removed", REFUSALS, "    except IncompleteError:\n        raise\n", "", STAYS),
    Mutant(
        "somebody's files removed",
        REFUSALS,
        "empty = bool(absent) or not any(_names(place))",
        "empty = True",
        STAYS,
    ),
    Mutant("folders above that stay", REFUSALS, "for path in absent:", "for path in absent[:1]:", STAYS),
    Mutant(
        "requirements of a baseline compared after the flights",
        AGAINST,
        '    _refuse(path, _other_names("requirements", before.requirements, _titles(judged)))\n',
        "    del judged\n",
        "cli/test_refused_before.py::test_a_baseline_of_another_campaign",
    ),
    Mutant(
        "validate without the audit of the baselines",
        "cli/validate.py",
        "    prove_baselines(problem)\n",
        "",
        "cli/test_refused_before.py::test_a_draw_of_a_baseline_that_does_nothing",
    ),
    # the plugin of pytest
    Mutant("a name with brackets", PLUGIN, ".translate(_BRACKETS)", "", APART),
    Mutant("a name with two colons", PLUGIN, 're.sub("::+", ":", " ".join(', 're.sub("::", ":", " ".join(', APART),
    Mutant(
        "a number in every name",
        PLUGIN,
        "counted = (plain if count == 1 else",
        'counted = (f"{len(names) + 1}. {plain}" if count == 1 else',
        "ci/test_pytest_plugin.py::test_names_stay_when_a_requirement_is_inserted",
    ),
    Mutant(
        "a folder that depends on the place of the clone",
        PLUGIN,
        "hashlib.sha256(os.fsencode(shown))",
        "hashlib.sha256(os.fsencode(campaign))",
        "ci/test_pytest_plugin.py::test_no_two_campaigns_have_the_same_folder",
    ),
    Mutant(
        "a campaign known by its first line",
        PLUGIN,
        """?rvjax[\\"']?\\s*:", re.MULTILINE)""",
        """?rvjax[\\"']?\\s*:")""",
        "ci/test_pytest_plugin.py::test_a_campaign_is_known_by_its_key",
    ),
    Mutant(
        "half a file of verdicts",
        PLUGIN,
        "except (OSError, ValueError):\n        return {}",
        "except OSError:\n        return {}",
        KEPT,
    ),
    Mutant("a list for verdicts", PLUGIN, "return found if isinstance(found, dict) else {}", "return found", KEPT),
    Mutant(
        "an output folder behind a double dash",
        PLUGIN,
        '        if word == "--":\n            return [*words, word, *rest]\n',
        "",
        "ci/test_pytest_plugin.py::test_the_output_folder_becomes_one_word",
    ),
    # nobody meets the requirements
    Mutant(
        "the first in order or nobody",
        EVALUATION,
        "for candidate in dict.fromkeys((self.best, *ordered(whole, self.judge.goal))))",
        "for candidate in (self.best,))",
        WINNER,
    ),
    Mutant(
        "a winner that meets nothing",
        EVALUATION,
        "if not self.judge.missed(self.table(one))), None)",
        "if not self.judge.missed(self.table(one))), self.best)",
        WINNER,
    ),
    Mutant(
        "the first that flew of those that meet the requirements",
        EVALUATION,
        "dict.fromkeys((self.best, *ordered(whole, self.judge.goal)))",
        "dict.fromkeys((self.best, *sorted(whole)))",
        WINNER,
    ),
    Mutant(
        "exit code 0 where nobody meets the requirements",
        "cli/tune.py",
        "if record.missed or overall(record)[0]",
        "if overall(record)[0]",
        "tuning/test_unmet.py::test_the_exit_code_is_that_of_the_winner",
    ),
    Mutant(
        "nothing for a default",
        "analysis/compare.py",
        "given[key] if key in given else default(spec, key)",
        "given.get(key)",
        "tuning/test_unmet.py::test_compare_knows_the_defaults",
    ),
    # baseline files
    Mutant("numbers as text", BASELINE, "ConfigDict(strict=True,", "ConfigDict(strict=False,", EDITED),
    Mutant("keys that nobody knows", BASELINE, 'extra="forbid"', 'extra="ignore"', EDITED),
    Mutant("infinite numbers of a draw", BASELINE, "Field(allow_inf_nan=False)", "Field(allow_inf_nan=True)", EDITED),
    Mutant(
        "marks of another number of samples",
        BASELINE,
        'parts = [(f"requirements.{name}", len(marks)) for name, marks in file.requirements.items()]',
        "parts = list[tuple[str, int]]()",
        EDITED,
    ),
    Mutant(
        "the first mistake only",
        BASELINE,
        "for mistake in error.errors(include_url=False)])",
        "for mistake in error.errors(include_url=False)[:1]])",
        LISTED,
    ),
    Mutant(
        "the last of two keys",
        BASELINE,
        "        if key in known:\n",
        "        if key in known and known[key] != value:\n",
        LISTED,
    ),
    Mutant(
        "better for worse",
        AGAINST,
        'float(mcnemar(worse, better, better="a"))',
        'float(mcnemar(worse, better, better="b"))',
        "ci/test_against.py::test_a_requirement_is_worse_where_samples_no_longer_comply",
    ),
    # folding at the workers
    Mutant(
        "a segment with other chunks than were committed",
        "execution/executors/dask_worker.py",
        "return totals.encode() if list(totals.totals.chunks) == list(chunks) else None",
        "return totals.encode()",
        "reliability/test_folding.py::test_a_chunk_that_is_not_asked_for_is_not_in_the_totals",
    ),
    Mutant(
        "waiting for the totals of a dead worker",
        "execution/executors/dask_folding.py",
        ", allow_other_workers=True",
        "",
        "reliability/test_folding.py::test_segments_of_all_workers_are_merged_and_the_client_reads_nothing",
    ),
    Mutant(
        "a chunk that is added again where it flies again",
        "execution/executors/dask_worker.py",
        "            if chunk in self._totals:",
        "            if False:",
        "reliability/test_folding.py::test_a_chunk_that_flies_twice_at_a_worker_is_added_once",
    ),
)
