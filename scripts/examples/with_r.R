# Opens a pipeline folder with R, prints the outcomes and draws two figures of the report.
#
#     Rscript scripts/examples/with_r.R out/pipeline out/figures
#
# Needs the package jsonlite. This script was written without an R at hand and has not been run.

library(jsonlite)

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) != 2) stop("usage: Rscript with_r.R PIPELINE_FOLDER OUT")
source_folder <- arguments[1]
out <- arguments[2]
dir.create(out, recursive = TRUE, showWarnings = FALSE)

# One JSON file of the folder, of the schema that this script was written for.
read_document <- function(file, schema) {
  path <- file.path(source_folder, file)
  if (!file.exists(path)) stop("there is no ", path)
  document <- fromJSON(path)
  if (document$schema != schema) stop(path, " has schema ", document$schema, ", not ", schema)
  document
}

outcomes <- read_document("7-evaluate/outcomes.json", "outcomes/2")
if (length(outcomes$methods) > 0) {
  measured <- outcomes$methods$rows[[1]]
  means <- sapply(outcomes$methods$rows, function(rows) rows$simulated$mean)
  table <- rbind(t(means), measured$actual$mean)
  dimnames(table) <- list(c(outcomes$methods$label, "measured"), measured$metric)
  print(round(table, 1))
}

measured_colour <- "#0072B2"
twin_colour <- "#D55E00"

# The ambulatory glucose profile. A slot without a sample is NA: a line leaves a gap, a
# band bridges it.
agp <- read_document("7-evaluate/agp.json", "agp/1")
band <- function(low, high, alpha) {
  known <- !is.na(low) & !is.na(high)
  polygon(c(agp$hour[known], rev(agp$hour[known])), c(low[known], rev(high[known])),
          col = adjustcolor(measured_colour, alpha), border = NA)
}
png(file.path(out, "agp.png"), width = 1200, height = 675, res = 130)
plot(agp$hour, agp$observed$p50, type = "n", xlim = c(0, 24), xaxt = "n",
     ylim = range(agp$observed, agp$twin, na.rm = TRUE),
     xlab = "time of day, h", ylab = "glucose, mg/dL",
     main = paste("Ambulatory glucose profile,", agp$windows, "held-out windows of five hours"))
axis(1, at = seq(0, 24, 3))
rect(0, 70, 24, 180, col = "grey93", border = NA)
band(agp$observed$p05, agp$observed$p95, 0.15)
band(agp$observed$p25, agp$observed$p75, 0.30)
lines(agp$hour, agp$observed$p50, col = measured_colour, lwd = 2)
styles <- c(p05 = 3, p25 = 2, p50 = 1, p75 = 2, p95 = 3)
for (percentile in names(styles)) {
  lines(agp$hour, agp$twin[[percentile]], col = twin_colour, lty = styles[[percentile]])
}
legend("topleft", c("sensor", "twin"), col = c(measured_colour, twin_colour), lwd = c(2, 1),
       bty = "n")
invisible(dev.off())

# Mean error of free runs by part of the day, with simultaneous intervals.
cells <- read_document("8-diagnose/diagnosis.json", "diagnosis/3")$where
hours <- if (is.data.frame(cells)) which(cells$factor == "hour") else integer(0)
if (length(hours) == 0) {
  message("the diagnosis has no errors by hour: too few people, days or runs")
} else {
  errors <- cells[hours, ]
  errors <- errors[order(errors$level), ]
  png(file.path(out, "errors_by_hour.png"), width = 1200, height = 600, res = 130)
  at <- seq_len(nrow(errors))
  plot(at, errors$mean_error_mg_dl, pch = 19, col = measured_colour, xaxt = "n",
       ylim = range(errors$lower, errors$upper), xlab = "time of day, h",
       ylab = "measured minus predicted, mg/dL",
       main = paste("Error of the plant after", errors$horizon_minutes[1], "min, by time of day"))
  axis(1, at = at, labels = errors$level)
  abline(h = 0, col = "grey50")
  arrows(at, errors$lower, at, errors$upper, angle = 90, code = 3, length = 0.05,
         col = measured_colour)
  invisible(dev.off())
}
