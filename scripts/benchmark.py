"""Run the diagnosis on blind cases with fresh seeds and print how often it is right."""

from typing import Annotated

import typer
from tqdm import tqdm

from fe_models.blind import KINDS, BlindConfig, blind_case
from fe_models.errors import bad_input_exits
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.judging import describe_rates, judge

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    blind: Annotated[int, typer.Option(min=1, help="Number of cases.")] = 15,
    seed: Annotated[int, typer.Option(min=0, help="Of the first case; each further one takes the next.")] = 0,
    off: Annotated[bool, typer.Option("--off", help="Structures off by their uncertainty everywhere.")] = False,
    noise: Annotated[float, typer.Option(min=0.0, help="Its standard deviation over each channel's.")] = 0.03,
    kinds: Annotated[
        str, typer.Option(help="What to hide, one after the other: words by commas, 'a+b' for two, 'nothing'.")
    ] = ",".join(KINDS),
    changed: Annotated[int, typer.Option(min=0, help="Recordings made before the effect came.")] = 0,
) -> None:
    """Hide effects in simulated recordings of the chain, diagnose them, open the truth, and print the rates."""
    with bad_input_exits():
        names = kinds.split(",")
        judgements = []
        for number in tqdm(range(blind), desc="blind cases"):
            word = names[number % len(names)]
            hidden = () if word == "nothing" else tuple(word.split("+"))
            case = blind_case(seed + number, BlindConfig(hidden, off=off, noise=noise, changed=changed))
            judgements.append(judge(case, diagnose(case.dataset)))
            if not judgements[-1].first:
                tqdm.write(f"seed {seed + number}: {case.truth}{case.outside}: {judgements[-1].named}")
        print(describe_rates(judgements))


if __name__ == "__main__":
    app()
