"""Mistakes in the engines: primitives, arrays, loops, machine code, and which engine flies."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

ROWS = "simulation/engines/llvm/elementwise.py"
ARRAYS = "simulation/engines/llvm/arrays.py"
CONTROL = "simulation/engines/llvm/control.py"
PROGRAM = "simulation/engines/llvm/program.py"
TEXT = "simulation/engines/llvm/text.py"
STRUCTURES = "simulation/engines/llvm/structures.py"
INSTRUCTIONS = "simulation/engines/llvm/instructions.py"
MACHINE = "simulation/engines/llvm/machine_code.py"
ENGINE = "simulation/engines/llvm/engine.py"
BATCH = "simulation/batch.py"
ROW = "engines/test_primitives.py::test_a_row_is_that_of_numpy_and_jax"
MOVES = "engines/test_arrays.py::test_moved_numbers_are_those_of_jax"
SUMS = "engines/test_arrays.py::test_sums_are_those_of_jax_to_rounding"
TURN = "engines/test_arrays.py::test_sums_take_their_terms_in_turn"

INTERPRETED = "engines/test_flights.py::test_a_flight_is_that_of_the_interpreter"
MODE = "engines/test_flights.py::test_the_mode_of_the_thread_changes_no_bit"

MUTANTS = (
    Mutant("a maximum that hides NaN", ROWS, 'to.emit("fcmp uno", BOOL, first, first), first, best)', 'to.emit("fcmp uno", BOOL, first, first), best, best)', ROW),
    Mutant("a minimum for a maximum", ROWS, '"max": extreme("ogt", "?gt", "or")', '"max": extreme("olt", "?lt", "and")', ROW),
    Mutant("the sign of zero is 1", ROWS, 'apply(to, "gt", BOOL, x, zero), one', 'apply(to, "ge", BOOL, x, zero), one', ROW),
    Mutant("powers from the highest bit", ROWS, "        left >>= 1\n", "        left >>= 2\n", ROW),
    Mutant("halves to the even neighbour everywhere", ROWS, '"rint" if even else "round"', '"rint"', ROW),
    Mutant("a shift by the width", ROWS, "number is not None and 0 <= int(number) < width", "number is not None", ROW),
    Mutant("unsigned numbers are signed", ROWS, '"s" if kind.kind == "i" else "u")', '"s")', ROW),
    Mutant("an integer division by zero", ROWS, 'return to.emit("select", kind, none, by_zero, result)', "return result", ROW),
    Mutant("infinity is finite", ROWS, 'to.emit("fcmp olt", kind, to.emit("fabs"', 'to.emit("fcmp ole", kind, to.emit("fabs"', ROW),
    Mutant("a select with its cases exchanged", ROWS, "which, cases[1], cases[0])", "which, cases[0], cases[1])", ROW),
    Mutant("NaN is not equal to a number that is less", ROWS, '"ne": compare("une", "ne")', '"ne": compare("one", "ne")', ROW),
    Mutant("a total order that ends at zero", ROWS, 'below = to.emit("ashr", whole, bits', 'below = to.emit("lshr", whole, bits', ROW),
    Mutant("a slice without its steps", ARRAYS, "slice(*ends) for ends in zip(params[\"start_indices\"], params[\"limit_indices\"], steps", "slice(*ends) for ends in zip(params[\"start_indices\"], params[\"limit_indices\"], (1,) * x.ndim", MOVES),
    Mutant("an index outside is not moved", ARRAYS, 'inside = apply(to, "clamp", kind, to.constant(0, kind), wide, to.constant(most, kind))', "inside = wide", MOVES),
    Mutant("a filling that is the nearest entry", ARRAYS, "result[index] = value if not _fills(params)", "result[index] = value if True", MOVES),
    Mutant("the last of equal extremes", ARRAYS, 'better = apply(to, name, BOOL, value, best)\n', 'better = apply(to, {"gt": "ge", "lt": "le"}[name], BOOL, value, best)\n', "engines/test_arrays.py::test_the_first_of_equal_extremes_is_found"),
    Mutant("terms from the last to the first", ARRAYS, "    for term in terms[1:]:", "    for term in terms[:0:-1]:", TURN),
    Mutant("rows of a loop in the wrong order", CONTROL, "for i in reversed(range(length)) if params[\"reverse\"] else range(length):", "for i in range(length):", MOVES),
    Mutant("a loop without its last iteration", STRUCTURES, "icmp slt i32 {following}, {operation.detail}", "icmp slt i32 {following}, {operation.detail - 1}", "engines/test_arrays.py::test_a_short_loop_is_unrolled"),
    Mutant("a loop that ends with the first lane", STRUCTURES, "llvm.vector.reduce.or.", "llvm.vector.reduce.and.", SUMS),
    Mutant("a lane that goes on after its end", CONTROL, 'results = [to.emit("select", kind, goes, new, old) for kind, new, old in rows]', "results = [new for _, new, _ in rows]", SUMS),
    Mutant("a table that is read in the first lane", STRUCTURES, "{writer.name(index)}, i32 {lane}\")", "{writer.name(index)}, i32 0\")", MOVES),
    Mutant("both sides of every choice", CONTROL, "if not to.program.uniform[first]:", "if True:", "engines/test_arrays.py::test_what_is_the_same_in_all_lanes_is_a_branch"),
    Mutant("constants folded in another type", PROGRAM, "return self.constant(FOLDED[code](*numbers), kind)", "return self.constant(FOLDED[code](*map(np.float32, numbers)) if kind.kind == \"f\" else FOLDED[code](*numbers), kind)", MOVES),
    Mutant("products and sums are contracted", INSTRUCTIONS, "{code} {vector} {', '.join(texts)}", "{code}{' contract' if code[0] == 'f' and code[:4] != 'fcmp' else ''} {vector} {', '.join(texts)}", INTERPRETED),
    Mutant("a flight in the mode of its thread", TEXT, '"  call void @llvm.x86.sse.ldmxcsr(ptr %wanted)",', "", MODE),
    Mutant("a mode that is not put back", TEXT, '("  call void @llvm.x86.sse.ldmxcsr(ptr %mode)",),', "(),", MODE),
    Mutant("lanes of another group", MACHINE, "whole.reshape(leaves, groups, lanes).transpose(1, 0, 2)", "whole.reshape(leaves, lanes, groups).transpose(2, 0, 1)", INTERPRETED),
    Mutant("flights that last are not optimised", ENGINE, "max(self._announced, self._begun) >= PAYS", "max(self._announced, self._begun) < 0", "engines/test_flights.py::test_optimised_code_flies_the_same_bits"),
    Mutant("every flight is optimised", ENGINE, "max(self._announced, self._begun) >= PAYS", "max(self._announced, self._begun) >= 0", "engines/test_flights.py::test_optimised_code_flies_the_same_bits"),
    Mutant("groups that no thread flies", ENGINE, "self._groups * part // parts", "self._groups // parts * part", "engines/test_flights.py::test_threads_change_no_bit"),
    Mutant("a step that is compiled at its first flight only", ENGINE, "        Thread(target=compile_step).start()", "        Thread(target=int).start()", "engines/test_flights.py::test_the_step_is_compiled_ahead"),
    Mutant("a chunk on all threads beside another", BATCH, "self._available // max(1, self._flying)", "self._available", "engines/test_flights.py::test_chunks_share_the_threads"),
    Mutant("a chunk that stays in flight after its end", BATCH, "self._flying -= 1", "self._flying -= 0", "engines/test_flights.py::test_chunks_share_the_threads"),
    Mutant("a phase with the phases inside it", "timings.py", "+= whole - self.inside", "+= whole", "run/test_timings.py::test_a_phase_does_not_count_the_phases_inside_it"),
    Mutant("phases of other threads in the main thread", "timings.py", "(_main if current_thread() is main_thread() else _threads)", "_main", "run/test_timings.py::test_other_threads_are_counted_apart"),
    Mutant("sums that end at any line end", "run_folder/checksums.py", 'text.split("\\n")', "text.splitlines()", "results/test_run_folder.py::test_only_a_line_feed_ends_a_line_of_the_sums"),
    Mutant("a first chunk that waits for others", "execution/executors/threads.py", "begin(1 if first_alone else 2 * streams())", "begin(2 * streams())", "run/test_timings.py::test_the_first_item_may_fly_alone"),
    Mutant("a program compiled for each chunk", ENGINE, "            if (name, level) not in self._compiled:\n", "            if True:\n", "run/test_compiling.py::test_machine_code_is_made_once"),
)  # fmt: skip
