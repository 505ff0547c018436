"""The machine: which Mitsuba variant and which LLVM work here, found by trial."""
