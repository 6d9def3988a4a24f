//! Forms that files are written in, by their names.

/// A form, its name as options take it, how the names of its files end, and what it is.
pub type Row<F> = (F, &'static str, &'static str, &'static str);

/// A form that a file is written in.
pub trait FileForm: Copy + PartialEq + 'static {
    /// Every form.
    const ALL: &[Row<Self>];

    /// The form of a name.
    fn named(name: &str) -> Option<Self> {
        let mut forms = Self::ALL.iter();
        forms.find_map(|(form, of_form, ..)| (*of_form == name).then_some(*form))
    }

    /// Its name.
    fn name(self) -> &'static str {
        self.row().1
    }

    /// How the name of its file ends.
    fn extension(self) -> &'static str {
        self.row().2
    }

    /// Its row of [`ALL`](Self::ALL).
    fn row(self) -> &'static Row<Self> {
        let mut forms = Self::ALL.iter();
        let of_it = forms.find(|(form, ..)| *form == self);
        of_it.expect("each form has a row")
    }
}
