"""The certificate as a page in Markdown: rates with intervals, calibration and times; no seeds and no single cases."""

from collections.abc import Iterable, Sequence

from benchmarks.blind.cases import CERTIFICATE_SEED, NOTHING
from benchmarks.blind.rates import Share
from benchmarks.blind.reliability import Bin
from benchmarks.blind_cases import BlindConfig
from benchmarks.certificate.counts import Certificate, ColumnCounts
from benchmarks.certificate.plan import Column
from fe_models.recordings import TOLERANCE

HOW = """\
Something is hidden in simulated recordings, by chance in kind, place and size. The recordings are diagnosed, and only
then is the answer held against the truth. {cases}

"Exact": the structure given to the diagnosis is that of the recordings. "Off": every spring, mass, cable, deck and
tower is off by 1 %, every damping ratio by 10 %, all at once. All recordings have {noise:.0f} % noise. Those of the
bridge come from a richer model than the diagnosis has: geometrically exact, on a mesh twice as fine, every part a
little beside the drawing. Of a drawing that is nearly right about one case in seven hides nothing, as many something
outside the program's list, all others one cause of the list; elsewhere cases hide what can be told there, and, under
ambient vibration of an exact drawing, known forces and base motion, nothing now and then. Two causes at once are not
part of this page.

"Far": deck, towers and pairs of cables are off by 20 %, masses by 10 %, damping by 40 %, and the dataset still says
1, 1 and 10 %; what is hidden has a linear effect. "In one recording": the cause acts in the last one to fit alone.

Recordings are free vibration where a column says nothing else. "Ambient vibration": ten minutes each under coloured
forces on deck and towers that nobody recorded, diagnosed by modes. "Known forces": a shaker's and a hammer's, recorded.
"Base motion": like an earthquake's, recorded.

The seeds of these cases ({seed:,} and up) are for this page alone. What is missed is counted, never looked into, so
that the rates stay an honest measure: nothing in the program was chosen to suit these cases.
"""
READING = """\
In brackets: right of how many, and the 95 % interval of the true rate (Wilson). Lines that count parameters take these
as independent. A case without a report counts as wrong wherever it is counted.

- *Causes that forecasts need*: without them the calibrated model does not forecast to within {material:.0f} % of the
  noise floor. Of weaker ones the right answer is "nothing is wrong".
- *Wrong name at >= 0.9*: a cause that is not there is named with a probability of 0.9 or more.
- *Outside the list*: a stiffness that drifts or swings to and fro, or a spring that creeps, for which the program has
  no name. It must say that something is left unexplained.
- *Noise floor*: the error of a perfect forecast, which noise alone leaves. The *extended forecast* is that of the
  structure with what was named built in, for recordings that were never fitted.
"""
UNCOMMITTED = "**With changes that are not committed** (SHA-256 `{}`): nobody else can repeat it."


def page(found: Certificate) -> str:
    """Return the page."""
    return "\n".join(
        [
            "# Certificate: how often a diagnosis is right",
            "",
            *_head(found),
            "",
            _how(found),
            "## Rates",
            "",
            READING.format(material=100 * TOLERANCE),
            *[line for title, columns in sections(found) for line in _section(title, columns)],
            "## Probabilities: is what is named at 0.9 right in nine of ten cases?",
            "",
            *_calibration(found),
            "",
            "## Time of a diagnosis",
            "",
            *_seconds(found.columns),
            "",
            *[f"Cases ran {words}." for words in found.machines],
            "",
        ]
    )


def _head(found: Certificate) -> list[str]:
    lines = [f"Code: commit `{found.code.commit}`" + _days(found.days) + "."]
    if found.code.changes:
        lines += ["", UNCOMMITTED.format(found.code.changes[:16])]
    if found.done < found.planned:
        parts = ", ".join(f"{own.done} of {own.column.count} ({own.column.name})" for own in found.columns)
        lines += ["", f"**Not complete: {found.done} of {found.planned} cases so far**: {parts}."]
    lines += ["", "Made by `hybrid-modal benchmark --certificate`. The same numbers for programs: `certificate.json`."]
    return lines


def _days(days: Sequence[str]) -> str:
    return f", {days[0]}" + (f" to {days[-1]}" if len(days) > 1 else "") if days else ""


def _how(found: Certificate) -> str:
    sizes = dict[str, None]()
    for column in (own.column for own in found.columns):
        size, name = column.config.campaign, "chain of four masses" if column.structure == "four_dof" else "bridge"
        under = " under ambient vibration" if column.excitation == "ambient" else ""
        sizes[f"{size.train} and {size.test} of {size.samples} samples for the {name}{under}"] = None
    cases = f"Recordings to fit and to test:\n{'; '.join(sizes)}."
    return HOW.format(cases=cases, noise=100 * BlindConfig().noise, seed=CERTIFICATE_SEED)


def sections(found: Certificate) -> list[tuple[str, list[ColumnCounts]]]:
    """Return the columns in the parts of the page, each with its title."""

    def part_of(column: Column) -> str:
        if column.excitation != "free":
            return "Ambient vibration, known forces, base motion"
        far = column.tier == "far" or column.acts == "one"
        return "Far from the drawing, or changed before one recording" if far else "A drawing that is nearly right"

    titles = dict.fromkeys(part_of(own.column) for own in found.columns)
    return [(title, [own for own in found.columns if part_of(own.column) == title]) for title in titles]


def _section(title: str, columns: Sequence[ColumnCounts]) -> list[str]:
    """Return rates and counts by what was hidden, of the cases that forecasts need, of some columns."""
    counted = ["Right answers by what was hidden, of the cases that forecasts need:", "", *_hidden(columns), ""]
    return [f"### {title}", "", *rates_table(columns), "", *counted]


def rates_table(columns: Sequence[ColumnCounts]) -> list[str]:
    """Return the lines of the table of rates: columns with the same aims beside each other, then their aim."""
    every = dict.fromkeys(own.column.aims for own in columns)
    groups = [[own for own in columns if own.column.aims == aims] for aims in every]
    heads, aims = [""], [[rate for own in group for rate in own.rates] for group in groups]
    for group in groups:
        heads += [*(own.column.name for own in group), *(["aim"] if group else [])]
    rows = []
    for what in dict.fromkeys(rate.what for own in columns for rate in own.rates):
        if not any(_measured(own, what).count for own in columns):
            continue
        row = [what]
        for group, listed in zip(groups, aims, strict=True):
            row += [_share(_measured(own, what)) for own in group]
            row += [next((rate.aim for rate in listed if rate.what == what), "")] if group else []
        rows.append(row)
    return table(heads, rows)


def _measured(own: ColumnCounts, what: str) -> Share:
    shares = (rate.measured for rate in own.rates if rate.what == what)
    return next((item for item in shares if isinstance(item, Share)), Share(0, 0))


def _share(item: Share) -> str:
    if item.value is None:
        return "-"
    low, high = item.interval
    return f"{100 * item.value:.1f} % ({item.hits}/{item.count}; {100 * low:.1f} to {100 * high:.1f})"


def _calibration(found: Certificate) -> list[str]:
    if not found.calibration:
        return ["Nothing has been named yet."]
    parts = [(title, [one for own in columns for one in own.calibration]) for title, columns in sections(found)]
    heads = ["named at", "on average", "right", *(title[0].lower() + title[1:] for title, _ in parts)]
    rows = [
        [f"{item.low:.2f} to {item.high:.2f}", f"{100 * item.promised:.1f} %", _share(item.right)]
        + [_count(bins, item.low) for _, bins in parts]
        for item in found.calibration
    ]
    return table(heads, rows)


def _count(bins: Iterable[Bin], low: float) -> str:
    own = [item.right for item in bins if item.low == low]
    hits, count = sum(item.hits for item in own), sum(item.count for item in own)
    return f"{hits}/{count}" if count else "-"


def _hidden(columns: Sequence[ColumnCounts]) -> list[str]:
    words = dict.fromkeys(word for own in columns for word in own.hidden)
    rows = []
    for word in words:
        shares = [own.hidden.get(word, Share(0, 0)) for own in columns]
        cells = [f"{item.hits}/{item.count}" if item.count else "-" for item in shares]
        rows.append(["nothing (a clean case)" if word == NOTHING else word.replace("_", " "), *cells])
    return table(["hidden", *(own.column.name for own in columns)], rows)


def _seconds(columns: Sequence[ColumnCounts]) -> list[str]:
    heads = ["seconds of one core", "median", "99th percentile", "longest", "aim", "no report"]
    rows = []
    for own in columns:
        took, times = own.seconds, ["-"] * 4
        if took is not None:
            times = [f"{value:.1f}" for value in (took.median, took.percentile, took.longest)] + [f"< {took.aim:.0f}"]
        failures = ", ".join(f"{name} ({count})" for name, count in own.failures.items()) or "none"
        rows.append([own.column.name, *times, failures])
    return table(heads, rows)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table in Markdown."""
    return ["| " + " | ".join(row) + " |" for row in (heads, ["---"] * len(heads), *rows)]
