"""The engine `llvm`: the jaxpr of a flight → scalar program → LLVM assembly on vectors of lanes → machine code.

    from_jaxpr                       equation by equation, with the tables of
    elementwise, arrays, control     numbers, arrays, and what holds further jaxprs
    program                          the scalar program
    text, machine_code               assembly, and a function that this process can call
    engine                           chunks of samples in flight

The arithmetic is strict IEEE 754 of single operations in a fixed order. So the bits of a flight depend on its numbers and its
program only: not on the number of lanes, the width of vectors, the processor, the operating system or the version of LLVM.
"""
