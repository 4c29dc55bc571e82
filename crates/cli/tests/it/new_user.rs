//! What a new user stumbled over, and the tests that hold each mend.

use std::fs;
use std::path::Path;

/// What was found, and the tests: file and function.
type Finding = (&'static str, &'static [(&'static str, &'static str)]);

const REPORT: &str = "crates/report/tests/report";
const CLI: &str = "crates/cli/tests/it";

const FINDINGS: [Finding; 9] = [
    (
        "1. The verdict and the tables say the same, by one rule of what is found",
        &[
            (
                "crates/contract/src/diagnosis/found.rs",
                "one_rule_says_what_is_found_for_one_person_and_for_many",
            ),
            ("REPORT/diagnosis.rs", "what_is_not_found_is_called_suspected_everywhere"),
            ("REPORT/diagnosis.rs", "a_probability_says_what_it_is_conditional_on"),
            ("REPORT/diagnosis.rs", "every_verdict_has_its_words"),
        ],
    ),
    (
        "2. How far stands beside the evidence, a wrong floor is not shown, and where is always answered",
        &[
            ("REPORT/diagnosis.rs", "a_floor_above_the_measured_error_is_not_shown"),
            ("REPORT/diagnosis.rs", "a_change_that_could_be_none_is_called_that"),
            ("REPORT/diagnosis.rs", "the_first_screen_has_four_tiles_and_who_is_in_use"),
            ("REPORT/diagnosis.rs", "a_name_that_is_doubted_is_doubted_in_the_verdict"),
            ("REPORT/maps.rs", "cells_print_their_sign_and_show_their_interval_under_a_pointer"),
            (
                "crates/gap/src/questioned.rs",
                "a_name_is_doubted_without_size_and_where_no_error_shrinks",
            ),
        ],
    ),
    (
        "3. The truth of a made cohort stands beside the answer and does not reach it",
        &[
            ("REPORT/people.rs", "truth_stands_beside_the_answer"),
            (
                "crates/pipeline/src/stated_truth.rs",
                "a_diagnosis_is_the_same_with_and_without_the_truth_beside_it",
            ),
        ],
    ),
    (
        "4. Who is left out is named with the reason",
        &[
            ("CLI/people_in_use.rs", "every_stage_leaves_the_same_people_out"),
            (
                "CLI/people_in_use.rs",
                "a_twin_of_people_without_basal_insulin_is_left_out_by_name_and_reason",
            ),
            ("REPORT/people.rs", "checks_stand_in_one_table_by_person"),
        ],
    ),
    (
        "5. A spreadsheet is guessed in one go; one person is judged",
        &[
            (
                "CLI/command_line.rs",
                "tables_are_guessed_and_imported_and_faults_of_a_folder_listed",
            ),
            (
                "crates/cohort/tests/it/downloads.rs",
                "dexcom_leaves_out_what_is_no_reading_and_says_so",
            ),
            (
                "crates/cohort/tests/it/downloads.rs",
                "a_spreadsheet_is_found_out_and_the_guess_maps_it",
            ),
            ("CLI/tutorial.rs", "every_command_of_the_tutorial_works_as_printed"),
            (
                "CLI/people_in_use.rs",
                "one_person_is_judged_and_told_why_there_is_no_table_of_outcomes",
            ),
        ],
    ),
    (
        "6. Figures and tables fit phone, page and paper; doses are in units; configuration is folded; no path leaks",
        &[
            ("REPORT/browser.rs", "a_page_fits_its_window_and_can_be_read"),
            ("REPORT/browser.rs", "faults_are_seen"),
            ("REPORT/page.rs", "a_full_run_has_every_section_and_figure"),
            ("REPORT/people.rs", "folders_of_the_machine_do_not_leak"),
        ],
    ),
    (
        "7. A twin on another's record warns; links, foreign files and names of devices are refused in words; \
         simulate has minutes",
        &[
            ("CLI/results.rs", "a_twin_on_the_record_of_another_person_is_said"),
            ("crates/pipeline/src/output.rs", "a_link_is_followed_and_stays_a_link"),
            ("CLI/command_line.rs", "missing_and_wrong_inputs_are_refused_in_words"),
            ("CLI/malformed/mod.rs", "every_malformed_input_is_refused_in_words"),
            ("CLI/command_line.rs", "simulate_says_its_minutes_in_few_digits"),
        ],
    ),
    (
        "8. The documents say what a thing does first; what they print is what a command prints",
        &[
            ("CLI/tutorial.rs", "every_command_of_the_tutorial_works_as_printed"),
            ("crates/contract/src/schemas.rs", "the_page_of_outputs_lists_every_key"),
            ("CLI/next_step.rs", "every_command_that_writes_ends_with_what_comes_next"),
        ],
    ),
    (
        "9. What was good stays: resumption, whole folders, Ctrl-C, messages, dark mode, examples in the help",
        &[
            (
                "CLI/pipeline.rs",
                "the_embedded_cohort_ends_in_a_report_and_a_second_run_keeps_every_stage",
            ),
            ("CLI/killed.rs", "a_pipeline_that_is_killed_ends_with_the_same_bytes"),
            ("CLI/blind_check.rs", "an_interrupted_check_leaves_nothing_and_no_process"),
            ("crates/pipeline/src/output.rs", "the_folder_appears_only_when_finished"),
            ("CLI/command_line.rs", "faulty_cohorts_name_row_and_column"),
            ("REPORT/browser.rs", "a_page_fits_its_window_and_can_be_read"),
            ("CLI/command_line.rs", "every_command_has_an_example_in_its_help"),
        ],
    ),
];

#[test]
fn every_finding_is_held_by_tests_that_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (finding, tests) in FINDINGS {
        assert!(!tests.is_empty(), "{finding}");
        for (file, test) in tests {
            let file = file.replace("REPORT", REPORT).replace("CLI", CLI);
            let source = fs::read_to_string(root.join(&file)).unwrap_or_default();
            let held = source
                .split("#[test]")
                .skip(1)
                .any(|after| after.trim_start().starts_with(&format!("fn {test}(")));
            assert!(held, "{finding}: there is no test '{test}' in {file}");
        }
    }
}
