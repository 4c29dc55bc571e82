//! Self-contained HTML reports from the pipeline's JSON outputs
