"""Opens a pipeline folder with polars, prints the outcomes and draws two figures of the report.

    python scripts/examples/with_polars.py out/pipeline out/figures

Needs polars and matplotlib.
"""

import polars as pl

from figures import PERCENTILES, draw_errors, draw_profile, folders, read


def main() -> None:
    source, out = folders()

    outcomes = read(source, "7-evaluate/outcomes.json", "outcomes/2")
    rows = [
        {"label": label, "metric": row["metric"], "mean": row[of]["mean"]}
        for method in outcomes["methods"]
        for row in method["rows"]
        for label, of in [("measured", "actual"), (method["label"], "simulated")]
    ]
    if rows:
        table = pl.DataFrame(rows).unique(["label", "metric"], maintain_order=True)
        table = table.pivot("metric", index="label", values="mean")
        with pl.Config(tbl_rows=-1, tbl_hide_dataframe_shape=True, float_precision=1):
            print(table.select("label", "tir", "tar", "tbr", "lbgi", "hbgi", "mg"))

    agp = read(source, "7-evaluate/agp.json", "agp/1")
    profile = pl.DataFrame({"hour": agp["hour"]}).with_columns(
        pl.Series(f"{of}_{percentile}", agp[of][percentile], dtype=pl.Float64)
        for of in ["observed", "twin"]
        for percentile in PERCENTILES
    )
    # A slot without a sample is null; matplotlib leaves a gap where a value is not a number.
    draw_profile(profile.fill_null(float("nan")), agp["windows"], out / "agp.png")

    diagnosis = read(source, "8-diagnose/diagnosis.json", "diagnosis/3")
    hours = [cell for cell in diagnosis["where"] if cell["factor"] == "hour"]
    if hours:
        errors = pl.DataFrame(hours, infer_schema_length=None).sort("level")
        draw_errors(errors, errors["horizon_minutes"][0], out / "errors_by_hour.png")
    else:
        print("the diagnosis has no errors by hour: too few people, days or runs")


if __name__ == "__main__":
    main()
