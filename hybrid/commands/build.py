"""The sub-command `build`: matrices, natural modes and their pictures."""

from hybrid.commands.console import command_line
from hybrid.commands.options import Model, Modes, Out, Pictures, Quiet, Refine


def build(
    model: Model, out: Out, refine: Refine = None, modes: Modes = None, pictures: Pictures = True, quiet: Quiet = False
) -> None:
    """Build a finite element model: matrices, natural modes and their pictures.

    \b
    OUT/model.npz       M, K and C over the free degrees of freedom (in sparse parts where large), dof_node and
                        dof_direction of their rows, frequencies (Hz), damping_ratio, and mode_shapes over all
                        degrees of freedom
    OUT/structure.toml  the structure, to edit and build again
    OUT/structure.png   the structure with the numbers of its nodes and elements, dashpots and effects
    OUT/mode*.png       the mode shapes

    \b
    Examples:
      hybrid-modal build bridge --out runs/bridge
      hybrid-modal build frame.toml --out runs/frame --refine 4 --modes 6
    """
    from hybrid.commands.models import model_in, open_model, write_model

    with command_line(quiet) as result:
        results = model_in(out)
        write_model(model, open_model(model, refine, [results]), results, modes, pictures)
        result(out / "model.npz")
