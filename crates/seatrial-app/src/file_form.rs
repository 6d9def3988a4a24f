//! Forms that files are written in, by their names.

/// What is said of a form.
#[derive(Clone, Copy, Debug)]
pub struct Row<F> {
    /// The form.
    pub form: F,
    /// Its name as options take it.
    pub name: &'static str,
    /// How the names of its files end; no two forms of a vehicle end alike.
    pub extension: &'static str,
    /// What a button says.
    pub label: &'static str,
    /// What it is.
    pub about: &'static str,
}

/// A form that a file is written in.
pub trait FileForm: Copy + PartialEq + 'static {
    /// Every form.
    const ALL: &[Row<Self>];

    /// The form of a name.
    fn named(name: &str) -> Option<Self> {
        let mut forms = Self::ALL.iter();
        forms.find_map(|row| (row.name == name).then_some(row.form))
    }

    /// Its row of [`ALL`](Self::ALL).
    fn row(self) -> &'static Row<Self> {
        let mut forms = Self::ALL.iter();
        let of_it = forms.find(|row| row.form == self);
        of_it.expect("each form has a row")
    }
}
