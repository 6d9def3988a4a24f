//! Options whose value is one of a table of names.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use seatrial_app::file_form::FileForm;
use seatrial_core::Axis;

/// Takes one of these values by its name; help says what each is.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str, &'static str)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<_> = all.into_iter().collect();
    let shown = |&(_, name, about): &(T, &'static str, &'static str)| match about {
        "" => PossibleValue::new(name),
        about => PossibleValue::new(name).help(about),
    };
    let names: Vec<PossibleValue> = all.iter().map(shown).collect();
    PossibleValuesParser::new(names).try_map(move |name| {
        let found = all.iter().find(|(_, of_value, _)| *of_value == name);
        found.map(|(value, ..)| *value).ok_or("no such name")
    })
}

/// Takes a form of files by its name.
pub fn form_of<F: FileForm + Send + Sync>() -> impl TypedValueParser<Value = F> {
    let forms = F::ALL.iter();
    one_of(forms.map(|row| (row.form, row.name, row.about)))
}

/// The values of `--axis`.
pub const AXES: [(Axis, &str, &str); 2] = [
    (Axis::Yaw, "yaw", "Heading under the rudder"),
    (Axis::Pitch, "pitch", "Pitch under the elevator"),
];
