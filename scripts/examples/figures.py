"""Two figures of the report, from columns that pandas and polars frames both have.

`profile` has a row for each half hour: `hour` (h), and the columns `observed_p05` to `observed_p95`
and `twin_p05` to `twin_p95` (mg/dL). `errors` has a row for each part of the day: `level`,
`mean_error_mg_dl`, `lower` and `upper` (mg/dL).
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Okabe and Ito's colours, which survive colour blindness; line styles survive greyscale.
MEASURED, SIMULATED = "#0072B2", "#D55E00"
PERCENTILES = ["p05", "p25", "p50", "p75", "p95"]


def read(folder: Path, file: str, schema: str) -> dict:
    """One JSON file of a pipeline folder, of the schema that this script was written for."""
    path = folder / file
    if not path.is_file():
        sys.exit(f"there is no {path}; give the output folder of `cargo xtask pipeline`")
    document = json.loads(path.read_text(encoding="utf-8"))
    if document["schema"] != schema:
        sys.exit(f"{path} has schema {document['schema']}; this script reads {schema}")
    return document


def draw_profile(profile, windows: int, path: Path) -> None:
    """The ambulatory glucose profile: median, 25 to 75 % and 5 to 95 % by time of day."""
    figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
    axes.axhspan(70, 180, color="0.93", zorder=0, label="70 to 180 mg/dL")
    hour = profile["hour"]
    axes.fill_between(
        hour, profile["observed_p05"], profile["observed_p95"], color=MEASURED, alpha=0.15, lw=0
    )
    axes.fill_between(
        hour, profile["observed_p25"], profile["observed_p75"], color=MEASURED, alpha=0.30, lw=0
    )
    axes.plot(hour, profile["observed_p50"], color=MEASURED, lw=2, label="sensor")
    for percentile, style, label in [
        ("p05", ":", None),
        ("p25", "--", None),
        ("p50", "-", "twin"),
        ("p75", "--", None),
        ("p95", ":", None),
    ]:
        axes.plot(
            hour, profile[f"twin_{percentile}"], color=SIMULATED, ls=style, lw=1.3, label=label
        )
    axes.set(
        xlabel="time of day, h",
        ylabel="glucose, mg/dL",
        xlim=(0, 24),
        xticks=range(0, 25, 3),
        title=f"Ambulatory glucose profile, {windows} held-out windows of five hours\n"
        "median, 25 to 75 % (inner band, dashed), 5 to 95 % (outer band, dotted)",
    )
    axes.legend(loc="upper left", frameon=False)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def draw_errors(errors, minutes: int, path: Path) -> None:
    """Mean error of free runs by part of the day, with simultaneous intervals."""
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    mean, low, high = (list(errors[name]) for name in ("mean_error_mg_dl", "lower", "upper"))
    below = [m - l for m, l in zip(mean, low)]
    above = [h - m for m, h in zip(mean, high)]
    axes.axhline(0, color="0.5", lw=1)
    axes.errorbar(list(errors["level"]), mean, [below, above], fmt="o", color=MEASURED, capsize=4)
    axes.set(
        xlabel="time of day, h",
        ylabel="measured minus predicted, mg/dL",
        title=f"Error of the plant after {minutes} min, by time of day\n"
        "above 0: the plant predicts too low; bars: simultaneous intervals",
    )
    figure.savefig(path, dpi=150)
    plt.close(figure)


def folders() -> tuple[Path, Path]:
    """The pipeline folder and the folder for figures, from the command line."""
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} PIPELINE_FOLDER OUT")
    source, out = Path(sys.argv[1]), Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    return source, out
