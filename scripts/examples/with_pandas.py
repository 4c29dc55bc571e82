"""Opens a pipeline folder with pandas, prints the outcomes and draws two figures of the report.

    python scripts/examples/with_pandas.py out/pipeline out/figures

Needs pandas and matplotlib.
"""

import pandas as pd

from figures import PERCENTILES, draw_errors, draw_profile, folders, read


def main() -> None:
    source, out = folders()

    outcomes = read(source, "7-evaluate/outcomes.json", "outcomes/2")
    if outcomes["methods"]:
        rows = pd.json_normalize(outcomes["methods"], "rows", ["label"])
        table = rows.pivot(index="label", columns="metric", values="simulated.mean")
        table.loc["measured"] = rows.groupby("metric")["actual.mean"].first()
        print(table[["tir", "tar", "tbr", "lbgi", "hbgi", "mg"]].round(1).to_string())

    agp = read(source, "7-evaluate/agp.json", "agp/1")
    profile = pd.DataFrame({"hour": agp["hour"]})
    for of in ["observed", "twin"]:
        for percentile in PERCENTILES:
            profile[f"{of}_{percentile}"] = pd.Series(agp[of][percentile], dtype=float)
    draw_profile(profile, agp["windows"], out / "agp.png")

    diagnosis = read(source, "8-diagnose/diagnosis.json", "diagnosis/3")
    hours = [cell for cell in diagnosis["where"] if cell["factor"] == "hour"]
    if hours:
        errors = pd.json_normalize(hours).sort_values("level")
        draw_errors(errors, errors["horizon_minutes"].iloc[0], out / "errors_by_hour.png")
    else:
        print("the diagnosis has no errors by hour: too few people, days or runs")


if __name__ == "__main__":
    main()
