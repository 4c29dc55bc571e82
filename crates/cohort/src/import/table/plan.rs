//! Which columns an import looks for.

use super::layout::same;
use super::options::{Role, TableOptions};
use crate::text_table::TextTable;

/// Where a table has a column of the plan: whether that is only nearly called so, and its index.
pub(super) type Found = Option<(bool, usize)>;

/// What a format's tables hold, or what the user says of a table.
#[derive(Default)]
pub(in crate::import) struct Plan {
    /// Name of the format.
    pub(in crate::import) format: &'static str,
    /// Columns, units, clock and marks.
    pub(in crate::import) options: TableOptions,
    /// Columns that number the rows: rows that differ in nothing else are the same.
    pub(in crate::import) numbering: &'static [&'static str],
    /// Columns whose sum is the dose where the dose's own column is empty.
    pub(in crate::import) bolus_parts: &'static [&'static str],
    /// Names of columns in other languages, and the name by which the plan calls them.
    pub(in crate::import) names: &'static [(&'static str, &'static str)],
    /// Columns whose cells are counted in the report, and what it says of them.
    pub(in crate::import) counted: &'static [(&'static str, &'static str)],
}

impl Plan {
    /// Whether a role has a column.
    pub(super) fn has(&self, role: Role) -> bool {
        self.options.columns.iter().any(|(of, _)| *of == role)
    }

    /// The columns of a role, for messages.
    pub(super) fn names(&self, role: Role) -> Option<String> {
        let of_role = self.options.columns.iter().filter(|(of, _)| *of == role);
        let names: Vec<&str> = of_role.map(|(_, name)| name.as_str()).collect();
        (!names.is_empty()).then(|| names.join("' or '"))
    }

    /// Columns whose sum stands for the role's own.
    pub(super) fn parts(&self, role: Role) -> &'static [&'static str] {
        if role == Role::Bolus { self.bolus_parts } else { &[] }
    }

    /// The names by which the header of a file is known.
    pub(super) fn wanted(&self, files: &[String]) -> Vec<&str> {
        let names = self.options.columns.iter();
        names
            .map(|(_, name)| in_file(name, files).map_or(name.as_str(), |(_, name)| name))
            .chain(self.names.iter().map(|(other, _)| *other))
            .collect()
    }

    /// Whether a column of a file is the one that the plan calls `name`, in any language.
    pub(super) fn is(&self, name: &str, column: &str) -> bool {
        let others = self.names.iter().filter(|(_, of)| *of == name);
        same(name, column) || others.into_iter().any(|(other, _)| same(other, column))
    }

    /// Whether the user said which columns there are.
    pub(super) fn is_users(&self) -> bool {
        self.format == "table"
    }

    /// Index of the column that the plan calls `name`.
    pub(super) fn find(&self, name: &str, table: &TextTable) -> Option<usize> {
        table.header().iter().position(|column| self.is(name, column))
    }

    /// Where a table of the file `stem` has each column of the plan.
    pub(super) fn found(&self, table: &TextTable, stem: &str, files: &[String]) -> Vec<Found> {
        let found = |(_, name): &(Role, String)| {
            let name: &str = match in_file(name, files) {
                Some((file, _)) if file != table.file() && file != stem => return None,
                Some((_, name)) => name,
                None => name,
            };
            let exact = table.header().iter().position(|column| column == name);
            let near = || Some((true, self.find(name, table)?));
            exact.map(|index| (false, index)).or_else(near)
        };
        self.options.columns.iter().map(found).collect()
    }

    /// Indices of the columns of a role: those that are called exactly so before those that nearly are.
    pub(super) fn columns(&self, role: Role, found: &[Found]) -> Vec<usize> {
        let of_plan = self.options.columns.iter().zip(found);
        let of_role = of_plan.filter(|((of, _), _)| *of == role);
        let mut found: Vec<(bool, usize)> = of_role.filter_map(|(_, found)| *found).collect();
        found.sort_by_key(|(near, _)| *near);
        let mut indices: Vec<usize> = Vec::new();
        for (_, index) in found {
            if !indices.contains(&index) {
                indices.push(index);
            }
        }
        indices
    }
}

/// `FILE:COLUMN` where the file is one of those that are read.
fn in_file<'a>(name: &'a str, files: &[String]) -> Option<(&'a str, &'a str)> {
    let (file, column) = name.split_once(':')?;
    let stem = |name: &str| std::path::Path::new(name).file_stem().map(|s| s.to_owned());
    let known =
        |one: &String| one == file || stem(one).is_some_and(|stem| stem.to_string_lossy() == file);
    files.iter().any(known).then_some((file, column))
}
