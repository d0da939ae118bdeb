"""Engines: what turns the flight of a sample into machine code and flies chunks of samples with it.

xla    JAX's compiler, the default; on every device, and for gradients
llvm   LLVM assembly from the flight's jaxpr, for the CPU; the same bits on every processor
"""
