"""Force laws that a structure has before any is looked for."""

from fe_models.causes import LawWithMemory, MemorylessLaw
from fe_models.causes.laws import force_laws
from fe_models.errors import raise_faults
from fe_models.structure import Structure


def own_laws(structure: Structure) -> tuple[MemorylessLaw, ...]:
    """Return the force laws of a structure; `InputError` with those that a diagnosis cannot take along."""
    laws, faults = force_laws(structure), list[str]()
    for law in laws:
        if law.timed:
            faults.append(f"model: its own {law.kind} depends on time, which no recording shows")
        if isinstance(law, LawWithMemory):
            faults.append(f"model: its own {law.kind} has a memory, which a diagnosis does not take along")
    raise_faults(f"{fault}; the diagnosis looks for it: take it out" for fault in faults)
    return tuple(law for law in laws if isinstance(law, MemorylessLaw))
