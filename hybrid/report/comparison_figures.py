"""Figures of a comparison of recordings: MAC, coordinate MAC, stabilisation, spectra, backbones, responses."""

from fe_models.recordings import Dataset
from hybrid.identification.comparison_pictures import draw_backbones, draw_spectra
from hybrid.identification.frequency_response import FrequencyResponse
from hybrid.identification.frequency_response_report import draw_responses
from hybrid.identification.recording_comparison import Compared
from hybrid.identification.shape_pictures import draw_coordinate_mac, draw_mac
from hybrid.identification.stabilisation_picture import draw_stabilisation
from hybrid.report.drawings import drawn
from hybrid.report.page import Figure


def figures_of(compared: Compared, dataset: Dataset, extended: Compared | None = None) -> list[Figure]:
    """Return the figures of what was ``compared``; with ``extended``, MAC beside the structure with what was found."""
    names = ", ".join(own.name for own in compared.recordings)
    found = [
        drawn(
            lambda path: draw_mac(path, compared),
            "mac",
            "Modal assurance criterion (MAC) of the drawn structure's modes with the identified ones, at the sensors."
            " Framed: taken for one mode.",
            f"Matrices of MAC values of the drawn structure's modes with one another and with those of {names}.",
        )
    ]
    if extended is not None:
        found.append(
            drawn(
                lambda path: draw_mac(path, extended),
                "mac-extended",
                "The same for the structure with all that was found, also what acts in some recordings alone.",
                f"Matrices of MAC values of the extended structure's modes with one another and with those of {names}.",
            )
        )
    both = ((compared, "comac", "the drawn structure"), (extended, "comac-extended", "that with what was found"))
    for own, name, what in both:
        if own is not None and any(own.pairs(observed) for observed in own.recordings):
            found.append(_coordinates(own, name, what))
    found += [_stabilisation(compared, dataset), _spectra(compared, dataset)]
    if compared.followed and any(own.backbones for own in compared.recordings):
        found.append(_backbones(compared, dataset))
    return found


def _coordinates(compared: Compared, name: str, what: str) -> Figure:
    return drawn(
        lambda path: draw_coordinate_mac(path, compared),
        name,
        f"Coordinate MAC (CoMAC) of {what}: 1 where a sensor moves as it should in all paired modes. It says where"
        " shapes differ, which need not be where the structure does.",
        f"The coordinate MAC of each sensor with {what}, a marker a recording.",
    )


def _stabilisation(compared: Compared, dataset: Dataset) -> Figure:
    return drawn(
        lambda path: draw_stabilisation(path, dataset, compared),
        "stabilisation",
        "Stabilisation diagrams: poles of systems of rising order, over the spectrum; those that stay where they are"
        " stand for modes.",
        "A panel a recording: frequencies of poles over the order of the identified system, and the modes chosen.",
    )


def _spectra(compared: Compared, dataset: Dataset) -> Figure:
    return drawn(
        lambda path: draw_spectra(path, dataset, compared),
        "spectra",
        "Power of all channels together, over its largest value; dotted: natural frequencies of the drawn structure.",
        "A panel a recording: power over frequency.",
    )


def _backbones(compared: Compared, dataset: Dataset) -> Figure:
    return drawn(
        lambda path: draw_backbones(path, dataset, compared),
        "backbones",
        "Frequency against amplitude while the motion decays (backbone curves); bars: two standard deviations. A linear"
        " structure has level lines.",
        "Curves of natural frequency over amplitude of the strongest modes.",
    )


def response_figure(found: FrequencyResponse) -> Figure:
    """Return the frequency response functions beside those of the drawn structure, and of an extended one."""
    return drawn(
        lambda path: draw_responses(path, found),
        "responses",
        "Frequency response functions: measured, of the drawn structure (nominal), and with what was found (extended);"
        " behind: coherence, 1 where the loads explain a sensor linearly.",
        f"Curves over frequency for inputs {', '.join(found.inputs)} and sensors {', '.join(found.sensors)}.",
    )
