"""Mutants of what the program says: output, messages, proposals, numbers and words, what it reads, plans, help."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

STREAMS, OUTPUT = "cli/_streams.py", "cli/_output.py"
PLAIN, PLAUSIBLE = "campaign/plain_values.py", "simulation/plausibility.py"
NUMBERS, RANKS = "report/number_format.py", "report/sections/worst.py"
KEYS, INERTIA, MEANS, EXACT = "components/manual_keys.py", "campaign/inertia.py", "stats/means.py", "stats/paired_exact.py"
ZERO, CSV, CORRELATION = "campaign/zero_width.py", "campaign/csv_text.py", "campaign/correlation.py"
SIZES, PERCENTAGES = "analysis/sample_size.py", "analysis/percentages.py"
TABLES, HELP, COMPLETION = "cli/_tables.py", "cli/_help.py", "cli/_completion.py"

SPELLINGS = "cli/test_streams.py::test_spellings"
RIGHT = "campaign/test_plausibility.py::test_a_warning_names_the_numbers_and_what_would_be_right"
AS_WRITTEN = "report/test_wording.py::test_numbers_read_as_written"
MISTAKE = "campaign/test_inertia_notation.py::test_a_mistake_names_entry_order_and_sign"
OTHER = "campaign/test_zero_width.py::test_width_zero_hides_no_other_mistake"
NO_COVARIANCE = "campaign/test_correlation.py::test_a_covariance_that_is_none"
REFUSED = "cli/test_plan.py::test_shares_out_of_range_are_refused"
WIDTHS = "cli/test_narrow.py::test_widths"

MUTANTS = (
    # output: encodings, a closed pipe, a full disk
    Mutant(
        "JSON with spellings in it",
        OUTPUT,
        "ensure_ascii=not is_unicode(sys.stdout)",
        "ensure_ascii=False",
        "cli/test_streams.py::test_json_is_the_same_in_every_encoding",
    ),
    Mutant("a mark at each digit of an exponent", STREAMS, 'mark = "" if form == before else "^"', 'mark = "^"', SPELLINGS),
    Mutant("a letter of a name taken for a symbol", STREAMS, "ord(character) > _LATIN_1 and plain[1:]", "plain[1:]", SPELLINGS),
    Mutant(
        "a full disk taken for a closed pipe",
        STREAMS,
        "if any(isinstance(failure, BrokenPipeError) for failure in failures):",
        "if failures:",
        "cli/test_streams.py::test_a_full_disk_is_4_and_one_message",
    ),
    Mutant(
        "a stop that a closed pipe hides",
        STREAMS,
        "if not failures or code in _INTERRUPTED:",
        "if not failures:",
        "cli/test_streams.py::test_a_stop_keeps_its_code_without_readers",
    ),
    Mutant(
        "a lost connection that ends as a failed requirement",
        "cli/_app.py",
        "code = _unexpected(lost) if isinstance(lost, OSError) else ended.code",
        "code = ended.code",
        "cli/test_streams.py::test_a_connection_that_breaks_is_no_verdict",
    ),
    Mutant(
        "a file in the encoding of the terminal",
        "pytest_plugin.py",
        '"commands": []}), encoding="utf-8")',
        '"commands": []}))',
        "cli/test_streams.py::test_every_text_file_names_its_encoding",
    ),
    # proposals
    Mutant(
        "a number of six digits in a proposal",
        PLAIN,
        'repr(float(value)).removesuffix(".0")',
        'f"{value:g}"',
        "cli/test_proposals.py::test_a_number_is_read_as_it_was",
    ),
    Mutant(
        "a short number that is not accepted",
        PLAIN,
        "        if accepted(rounded):",
        "        if abs(rounded - value) <= 1e-6 * abs(value):",
        "cli/test_proposals.py::test_the_shortest_number",
    ),
    Mutant(
        "all digits where fewer are accepted",
        PLAIN,
        "for digits in range(1, 17):",
        "for digits in range(12, 17):",
        "cli/test_proposals.py::test_the_shortest_number",
    ),
    Mutant(
        "a limit that is rounded up",
        PLAUSIBLE,
        "return _to_three_digits(value, ROUND_FLOOR)",
        "return _to_three_digits(value, ROUND_CEILING)",
        RIGHT,
    ),
    Mutant("0.599 for a limit of 0.6", PLAUSIBLE, "number = Decimal(repr(value))", "number = Decimal(value)", RIGHT),
    Mutant(
        "the upper end of products that are too low",
        PLAUSIBLE,
        "_at_least(max(most, most if low else -least))",
        "_at_least(most)",
        RIGHT,
    ),
    # numbers in the report
    Mutant(
        "a lower end that is rounded to nearest",
        NUMBERS,
        "_digits(low, decimals, ROUND_FLOOR,",
        "_digits(low, decimals, ROUND_HALF_EVEN,",
        AS_WRITTEN,
    ),
    Mutant(
        "ends that seem to share the power of ten of their value",
        NUMBERS,
        'if "×" in text and not symbol.startswith("×"):',
        "if False:",
        AS_WRITTEN,
    ),
    Mutant(
        "the decimals of the largest number for all three",
        NUMBERS,
        "places = max(decimals, 1 - exact.adjusted())",
        "places = decimals",
        "report/test_wording.py::test_a_value_and_its_bounds_keep_their_digits",
    ),
    Mutant(
        "bounds of a fixed number of samples claimed of a mean",
        "report/sections/verdicts.py",
        "for requirement in requirements if not requirement.mean}",
        "for requirement in requirements}",
        "report/test_sections.py::test_captions_say_how_each_requirement_is_judged",
    ),
    Mutant(
        "a rank without the ties",
        RANKS,
        "return float(below + behind) / (2 * x.size)",
        "return float(behind) / x.size",
        "report/test_sections.py::test_a_draw_stands_out_by_its_rank_among_the_first",
    ),
    Mutant(
        "a fault that is over taken for one that acts at the end",
        "report/fault_severity.py",
        "(onset < end_s) & (onset + duration >= end_s)",
        "onset < end_s",
        "report/test_sections.py::test_severity_is_what_the_faults_have_taken_by_the_end",
    ),
    Mutant(
        "outside of the corridor for longer than the flight",
        "components/metrics/approach.py",
        "jnp.minimum(acc.outside, context.duration_s)",
        "acc.outside",
        "physics/test_metric_members.py::test_no_time_is_longer_than_the_flight",
    ),
    # words: the manual, inertia, means and margins
    Mutant(
        "a unit in the meaning of a key too",
        KEYS,
        "return declaration.doc if declaration",
        'return f"{declaration.doc} [{declaration.symbol}]" if declaration',
        "cli/test_explain.py::test_a_unit_stands_once_as_a_symbol",
    ),
    Mutant(
        "only the first of several things with a name",
        "components/manual_lookup.py",
        "return [page for make in known[spelling] for page in make()]",
        "return known[spelling][0]()",
        "cli/test_explain.py::test_a_name_of_several_things_lists_them",
    ),
    Mutant(
        "an example of a hull without that of the other spacecraft",
        "components/manual_lookup.py",
        "for other, keys in _WITH.get((section, key), {}).items()",
        'for other, keys in _WITH.get((section, f"{key}_"), {}).items()',
        "cli/test_explain.py::test_examples_say_what_else_is_needed",
    ),
    Mutant(
        "products of a matrix in the order of its rows",
        INERTIA,
        '"products": [rows[i][j] for i, j in PRODUCTS.values()]',
        '"products": [rows[0][1], rows[0][2], rows[1][2]]',
        "campaign/test_inertia_notation.py::test_every_notation_is_the_body",
    ),
    Mutant(
        "a law below the diagonal that is not read",
        INERTIA,
        "        if rows[i][j] != rows[j][i]:",
        "        if is_number(rows[i][j]) and is_number(rows[j][i]) and rows[i][j] != rows[j][i]:",
        MISTAKE,
    ),
    Mutant(
        "a refusal that hides the order of the products",
        INERTIA,
        'order = "" if products is None else f"; {ORDER}"',
        'order = ""',
        MISTAKE,
    ),
    Mutant(
        "a corrected bootstrap that is only claimed",
        MEANS,
        'f"{kind} {method.format(resamples)}"',
        'f"BCa {method.format(resamples)}"',
        "stats/test_means.py::test_bootstrap_of_degenerate_data",
    ),
    Mutant(
        "lost samples that raise the lower bound of a mean",
        MEANS,
        "x = _bounded(values, low, high, worst=low)",
        "x = _bounded(values, low, high, worst=high)",
        "stats/test_means.py::test_what_is_not_finite_widens_the_interval",
    ),
    Mutant(
        "a margin that the other design has not",
        EXACT,
        "min((q + margin) / (1.0 - q), 1.0)",
        "min(q / (1.0 - q), 1.0)",
        "stats/test_paired_exact.py::test_pairs_without_a_difference_need_as_many_samples_as_all_successes",
    ),
    # what is read: width zero, CSV, correlation
    Mutant("a mean outside of its ends", ZERO, "if sd == 0.0 and low <= mean <= high else", "if sd == 0.0 else", OTHER),
    Mutant("a median of 0 without a spread", ZERO, '"log_normal": _median', '"log_normal": _spread', OTHER),
    Mutant(
        "a triangle that refuses its width zero",
        ZERO,
        "return low if low == mode == high else None",
        "return None",
        "campaign/test_zero_width.py::test_a_law_of_width_zero_is_its_number",
    ),
    Mutant(
        "sep= taken for the names",
        CSV,
        "        next(filled, None)",
        "        pass",
        "spec/test_csv_text.py::test_every_spelling_is_the_same_table",
    ),
    Mutant(
        "points and decimal commas in one file",
        CSV,
        '_lines_with(rows, ".", FLOAT)',
        '_lines_with(rows, ".", _DECIMAL_COMMA)',
        "spec/test_csv_text.py::test_a_mistake_has_its_file_line_and_separator",
    ),
    Mutant(
        "any unit in brackets for the right one",
        "campaign/csv_columns.py",
        "if parts[2].strip() in (suffix, unit.symbol) and (short",
        "if (short",
        "spec/test_csv_text.py::test_another_unit_in_brackets_is_refused",
    ),
    Mutant(
        "a tie whose sign is not looked at",
        CORRELATION,
        "if abs(entry - sign * matrix[leader][j]) > ROUNDING:",
        "if abs(abs(entry) - abs(matrix[leader][j])) > ROUNDING:",
        "campaign/test_correlation.py::test_ties_that_contradict_each_other",
    ),
    Mutant(
        "a variance compared with the standard deviation",
        CORRELATION,
        "elif abs(variance - law.sd**2) > AGREEMENT * law.sd**2:",
        "elif abs(variance - law.sd) > AGREEMENT * law.sd:",
        NO_COVARIANCE,
    ),
    Mutant(
        "2 sin(πr/6) of a covariance",
        CORRELATION,
        "if ranks else correlations(self.covariance or ()))",
        "if ranks else normal_correlation(correlations(self.covariance or ())))",
        "campaign/test_correlation.py::test_a_covariance_makes_the_draws_jointly_normal",
    ),
    # plans
    Mutant(
        "true shares of bad samples taken for good ones",
        SIZES,
        "1.0 - limit, [1.0 - share for share in trues],",
        "1.0 - limit, list(trues),",
        "cli/test_plan.py::test_a_plan_for_a_share_of_bad_samples",
    ),
    Mutant(
        "default shares of bad samples as those of good ones",
        SIZES,
        "(tuple(part * stated for part in PARTS) if bad else shown)",
        "shown",
        "cli/test_plan.py::test_default_shares_of_bad_samples_are_parts_of_the_limit",
    ),
    Mutant(
        "a better share on the wrong side",
        SIZES,
        "if bad and not 0.0 < share < limit:",
        "if bad and not 0.0 < share < 1.0:",
        REFUSED,
    ),
    Mutant(
        "a limit of six digits in a refusal",
        SIZES,
        "a share above the {exact(limit)} that is required",
        "a share above the {limit:g} that is required",
        REFUSED,
    ),
    Mutant(
        "columns headed 100 %",
        "cli/plan.py",
        '[f"{chosen(share)} %" for share in sizes.trues]',
        '[f"{100 * share:.6g} %" for share in sizes.trues]',
        "cli/test_plan.py::test_columns_say_their_shares",
    ),
    Mutant(
        "100 % of a share below 1",
        PERCENTAGES,
        "if result in (-100, 0, 100) and (apart := abs(value - result)):",
        "if result in (-100, 0) and (apart := abs(value - result)):",
        "stats/test_percentages.py::test_a_percentage_is_0_or_100_only_for_0_or_1",
    ),
    Mutant(
        "digits counted from the point",
        PERCENTAGES,
        "min(nearest.adjusted() + 1 - KEPT, -2)",
        "-KEPT",
        "stats/test_percentages.py::test_computed_shares_have_six_digits",
    ),
    # help and completion
    Mutant(
        "help that is 50 columns wide at least",
        HELP,
        "get_terminal_size().columns, _WIDEST) - 2, 20)",
        "get_terminal_size().columns, _WIDEST) - 2, 50)",
        "cli/test_narrow.py::test_every_line_of_help_fits",
    ),
    Mutant(
        "a summary that is cut",
        HELP,
        "command.get_short_help_str(_UNCUT)",
        "command.get_short_help_str()",
        "cli/test_narrow.py::test_a_summary_is_one_line_of_80_columns",
    ),
    Mutant("a number that is broken", TABLES, "if widths[k] > least[k]]", "if widths[k] > 1]", WIDTHS),
    Mutant(
        "a gap too many between columns",
        TABLES,
        "_EDGES + _BETWEEN * (len(columns) - 1)",
        "_EDGES + _BETWEEN * len(columns)",
        WIDTHS,
    ),
    Mutant(
        "two entries of a list with the same name",
        COMPLETION,
        'yield (use if uses.count(use) == 1 else f"{use}-{uses.count(use)}") if use else str(number)',
        "yield use or str(number)",
        "cli/test_completion.py::test_places_of_set_are_those_of_the_campaign",
    ),
    Mutant(
        "the word before an option that is lost",
        COMPLETION,
        ' + [word for word in ctx.args if word[:1] != "-"]',
        "",
        "cli/test_completion.py::test_what_a_tab_offers",
    ),
    Mutant(
        "a Tab that waits for the manual",
        COMPLETION,
        "from importlib.metadata import entry_points\n",
        "from importlib.metadata import entry_points\n\nfrom rvjax.components import manual\n",
        "cli/test_completion.py::test_a_tab_imports_nothing_heavy",
    ),
)
