"""Figures of a comparison of recordings: MAC, coordinate MAC, stabilisation, spectra, backbones, responses."""

from fe_models.recordings import Dataset
from hybrid.figures import NO_SHEETS, Sheet, Sheets
from hybrid.identification.comparison_pictures import draw_backbones, draw_spectra
from hybrid.identification.frequency_response import FrequencyResponse
from hybrid.identification.frequency_response_report import draw_responses
from hybrid.identification.recording_comparison import Compared
from hybrid.identification.shape_pictures import draw_coordinate_mac, draw_mac
from hybrid.identification.stabilisation_picture import draw_stabilisation
from hybrid.report.drawings import drawn
from hybrid.report.page import Figure
from hybrid.result_sets import BACKBONES, COORDINATE_MAC, MAC, RESPONSES, SPECTRA, STABILISATION


def figures_of(
    compared: Compared, dataset: Dataset, extended: Compared | None = None, sheets: Sheets = NO_SHEETS
) -> list[Figure]:
    """Return the figures of what was ``compared``; with ``extended``, MAC beside the structure with what was found.

    ``sheets``: those of the dataset's own structure that are drawn already.
    """
    names = ", ".join(own.name for own in compared.recordings)
    found = [
        drawn(
            sheets.get(MAC) or draw_mac(compared),
            "mac",
            "Modal assurance criterion (MAC) of the drawn structure's modes with the identified ones, at the sensors."
            " Framed: taken for one mode.",
            f"Matrices of MAC values of the drawn structure's modes with one another and with those of {names}.",
        )
    ]
    if extended is not None:
        found.append(
            drawn(
                draw_mac(extended),
                "mac-extended",
                "The same for the structure with all that was found, also what acts in some recordings alone.",
                f"Matrices of MAC values of the extended structure's modes with one another and with those of {names}.",
            )
        )
    if _has_pairs(compared):
        sheet = sheets.get(COORDINATE_MAC) or draw_coordinate_mac(compared)
        found.append(_coordinates(sheet, "comac", "the drawn structure"))
    if extended is not None and _has_pairs(extended):
        found.append(_coordinates(draw_coordinate_mac(extended), "comac-extended", "that with what was found"))
    found.append(_stabilisation(sheets.get(STABILISATION) or draw_stabilisation(dataset, compared)))
    found.append(_spectra(sheets.get(SPECTRA) or draw_spectra(dataset, compared)))
    if compared.followed and any(own.backbones for own in compared.recordings):
        found.append(_backbones(sheets.get(BACKBONES) or draw_backbones(dataset, compared)))
    return found


def _has_pairs(compared: Compared) -> bool:
    return any(compared.pairs(observed) for observed in compared.recordings)


def _coordinates(sheet: Sheet, name: str, what: str) -> Figure:
    return drawn(
        sheet,
        name,
        f"Coordinate MAC (CoMAC) of {what}: 1 where a sensor moves as it should in all paired modes. It says where"
        " shapes differ, which need not be where the structure does.",
        f"The coordinate MAC of each sensor with {what}, a marker a recording.",
    )


def _stabilisation(sheet: Sheet) -> Figure:
    return drawn(
        sheet,
        "stabilisation",
        "Stabilisation diagrams: poles of systems of rising order, over the spectrum; those that stay where they are"
        " stand for modes.",
        "A panel a recording: frequencies of poles over the order of the identified system, and the modes chosen.",
    )


def _spectra(sheet: Sheet) -> Figure:
    return drawn(
        sheet,
        "spectra",
        "Power of all channels together, over its largest value; dotted: natural frequencies of the drawn structure.",
        "A panel a recording: power over frequency.",
    )


def _backbones(sheet: Sheet) -> Figure:
    return drawn(
        sheet,
        "backbones",
        "Frequency against amplitude while the motion decays (backbone curves); bars: two standard deviations. A linear"
        " structure has level lines.",
        "Curves of natural frequency over amplitude of the strongest modes.",
    )


def response_figure(found: FrequencyResponse, sheets: Sheets = NO_SHEETS) -> Figure:
    """Return the frequency response functions beside those of the drawn structure, and of an extended one.

    ``sheets``: those that are drawn already.
    """
    return drawn(
        sheets.get(RESPONSES) or draw_responses(found),
        "responses",
        "Frequency response functions: measured, of the drawn structure (nominal), and with what was found (extended);"
        " behind: coherence, 1 where the loads explain a sensor linearly.",
        f"Curves over frequency for inputs {', '.join(found.inputs)} and sensors {', '.join(found.sensors)}.",
    )
